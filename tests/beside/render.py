"""Renders a scene that cut.py has cut, with Mitsuba 3: what with_mitsuba.py starts and times as a whole process.

It does what a user's script would do and nothing else: no comparison, no numpy. Prints the samples per pixel really taken.
"""

import argparse
import json
from pathlib import Path

parser = argparse.ArgumentParser(description="One picture by Mitsuba 3 of a scene cut apart.")
parser.add_argument("folder", type=Path)
parser.add_argument("--variant", required=True)
parser.add_argument("--sampler", required=True)
parser.add_argument("--spp", type=int, required=True)
parser.add_argument("--seed", type=int, required=True)
parser.add_argument("--size", type=int, required=True)
parser.add_argument("--max-depth", type=int, required=True)
parser.add_argument("--rr-depth", type=int, required=True)
parser.add_argument("--threads", type=int, required=True)
parser.add_argument("-o", "--output", required=True)
arguments = parser.parse_args()

import drjit as dr  # noqa: E402  (wrong arguments should not cost a second)
import mitsuba as mi  # noqa: E402

dr.set_thread_count(arguments.threads)
mi.set_variant(arguments.variant)
mi.set_log_level(mi.LogLevel.Error)
cut = json.loads((arguments.folder / "scene.json").read_text())
camera = cut["camera"]
scene = {
    "type": "scene",
    # Both programs count segments: the camera's is the first.
    "integrator": {"type": "path", "max_depth": arguments.max_depth, "rr_depth": arguments.rr_depth},
    "sensor": {
        "type": "perspective",
        "fov_axis": "y",
        "fov": camera["vertical_fov"],
        "to_world": mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["target"], up=camera["up"]),
        "film": {
            "type": "hdrfilm",
            "width": arguments.size,
            "height": arguments.size,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": arguments.sampler, "sample_count": arguments.spp},
    },
    "environment": {"type": "constant", "radiance": {"type": "rgb", "value": cut["environment"]}},
}
for interface in cut["interfaces"]:
    scene[f"interface {len(scene)}"] = {
        "type": "ply",
        "filename": str(arguments.folder / interface["file"]),
        "face_normals": True,
        "bsdf": {"type": "dielectric", "int_ior": interface["int_ior"], "ext_ior": interface["ext_ior"]},
    }
for solid in cut["solids"]:
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": solid["color"]}}
    scene[f"solid {len(scene)}"] = {
        "type": "ply",
        "filename": str(arguments.folder / solid["file"]),
        "face_normals": True,
        "bsdf": {"type": "twosided", "bsdf": diffuse} if solid["two_sided"] else diffuse,
    }
loaded = mi.load_dict(scene)
picture = mi.render(loaded, seed=arguments.seed)
mi.Bitmap(picture).write(arguments.output)
print(json.dumps({"spp": loaded.sensors()[0].sampler().sample_count()}))
