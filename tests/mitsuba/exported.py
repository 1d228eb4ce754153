"""Holds exported scenes against Mitsuba 3: it renders what `iorect export --to mitsuba` writes, with its own path tracer and the exported interfaces.

    pip install mitsuba numpy OpenEXR
    python3 tests/mitsuba/exported.py target/release/iorect [SCENE...] [--spp 64]

For each scene both programs render two images with seeds of their own. The mean of (a1 - b1)(a2 - b2)/(b² + 0.01) over all channels is 0 on average
where only noise differs; it is printed for pixels and for means over 8x8 of them, with the same of two halves of one program's noise for scale. Interpolated normals are switched off
in copies of the scenes: at grazing incidence Mitsuba lets light go where the surface is not, iorect does not.

Exit code 1 where the means over blocks differ by more than noise.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import mitsuba
import numpy
import OpenEXR

SIDE = 128
BLOCK = 8
SCENES = ["iced-water", "camera-in-water", "half-submerged", "nested-spheres", "tests/data/reference/s2.toml"]
# Of the mean over blocks: some three times what noise leaves at 64 samples.
LIMIT = 2e-4


def flat(root, scene):
    """The text of a scene without interpolated normals, its files named from the root of the disk."""
    path = root / scene
    if path.suffix != ".toml":
        path = root / "assets" / "scenes" / (scene + ".toml")
    text = path.read_text().replace("smooth = true", "smooth = false")
    name = lambda found: f'{found[1]} = "{(path.parent / found[2]).resolve()}"'
    return re.sub(r'\b(image|mesh) = "([^"]+)"', name, text)


def read(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return numpy.stack([channels[c].pixels for c in "RGB"], -1).astype(numpy.float64)


def blocks(image):
    n = SIDE // BLOCK
    return image.reshape(n, BLOCK, n, BLOCK, 3).mean((1, 3))


def common(a, b):
    truth = (b[0] + b[1]) / 2
    return float(((a[0] - b[0]) * (a[1] - b[1]) / (truth**2 + 0.01)).mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("iorect", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--spp", type=int, default=64)
    arguments = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parents[2]
    mitsuba.set_variant("scalar_rgb")
    is_fine = True
    for scene in arguments.scenes:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            toml = folder / "scene.toml"
            toml.write_text(flat(root, scene))
            run = lambda *words: subprocess.run([arguments.iorect, *map(str, words)], check=True, stdout=subprocess.DEVNULL)
            run("export", toml, "--to", "mitsuba", "-o", folder / "out", "--size", f"{SIDE}x{SIDE}")
            exported = mitsuba.load_file(str(folder / "out" / "scene.xml"))
            ours, theirs = [], []
            for seed in (1, 2):
                image = folder / f"{seed}.exr"
                run("render", toml, "--size", f"{SIDE}x{SIDE}", "--spp", arguments.spp, "--seed", seed, "--estimator", "path", "--backend", "cpu", "-o", image)
                ours.append(read(image))
                rendered = numpy.array(mitsuba.render(exported, spp=arguments.spp, seed=seed), dtype=numpy.float64)
                theirs.append(rendered[..., :3])
        pixels = common(ours, theirs)
        of_blocks = common([blocks(i) for i in ours], [blocks(i) for i in theirs])
        ratio = sum(i.mean() for i in ours) / sum(i.mean() for i in theirs)
        verdict = abs(of_blocks) < LIMIT
        is_fine &= verdict
        print(f"{scene}: ratio of means {ratio:.5f}, pixels {pixels:+.1e}, blocks {of_blocks:+.1e}: {'agrees' if verdict else 'DIFFERS'}")
    return 0 if is_fine else 1


if __name__ == "__main__":
    sys.exit(main())
