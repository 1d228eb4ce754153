"""Corrects the indices of a Mitsuba 3 scene in place: every `dielectric` gets the `int_ior` and `ext_ior` that rectification finds on its two sides.

    python3 fix_mitsuba.py scene.xml [--world 1.0] [--write]

Without --write it only says what is wrong. What one pair of indices cannot say is cut into pieces beside the scene: a shape with several exteriors, or one
that is no interface somewhere. The pieces are right as they are, and are not closed any more: such a scene is not to be corrected again.
Shapes are triangles (`ply`, `obj`, `cube`, `rectangle`); an analytic sphere is taken as it is tessellated below.
"""

import argparse
import pathlib
import sys
import xml.etree.ElementTree as xml

import mitsuba
import numpy

import iorect


def icosphere(center, radius, halvings=4):
    """Vertices and faces of a sphere."""
    g = (1 + 5**0.5) / 2
    vertices = [v for a in (-1, 1) for b in (-g, g) for v in ((0, a, b), (a, b, 0), (b, 0, a))]
    vertices = [numpy.array(v) / numpy.linalg.norm(v) for v in vertices]
    faces = []
    edge = min(numpy.linalg.norm(vertices[0] - v) for v in vertices[1:])
    near = lambda i, j: i != j and numpy.linalg.norm(vertices[i] - vertices[j]) < 1.01 * edge
    for i in range(12):
        for j in range(i):
            for k in range(j):
                if near(i, j) and near(j, k) and near(k, i):
                    is_outward = numpy.dot(numpy.cross(vertices[j] - vertices[i], vertices[k] - vertices[i]), vertices[i]) > 0
                    faces.append((i, j, k) if is_outward else (i, k, j))
    for _ in range(halvings):
        middles = {}

        def middle(i, j):
            key = (min(i, j), max(i, j))
            if key not in middles:
                m = vertices[i] + vertices[j]
                middles[key] = len(vertices)
                vertices.append(m / numpy.linalg.norm(m))
            return middles[key]

        faces = [f for i, j, k in faces for a, b, c in [(middle(i, j), middle(j, k), middle(k, i))] for f in ((i, a, c), (j, b, a), (k, c, b), (a, b, c))]
    return numpy.asarray(center) + radius * numpy.array(vertices), numpy.array(faces)


def triangles(shape, folder):
    """Vertices and faces of a shape of the file, in the scene's coordinates."""
    element = xml.Element("scene", version="3.0.0")
    element.append(shape)
    text = xml.tostring(element, encoding="unicode")
    resolver = mitsuba.file_resolver()
    resolver.prepend(str(folder))
    (loaded,) = mitsuba.load_string(text).shapes()
    if isinstance(loaded, mitsuba.Mesh):
        parameters = mitsuba.traverse(loaded)
        return numpy.array(parameters["vertex_positions"]).reshape(-1, 3), numpy.array(parameters["faces"]).reshape(-1, 3)
    if shape.get("type") == "sphere":
        box = loaded.bbox()
        low, high = numpy.array(box.min).ravel(), numpy.array(box.max).ravel()
        return icosphere((low + high) / 2, (high - low)[0] / 2)
    return None


def area(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum() / 2


def number(element, name, default):
    found = element.find(f"./*[@name='{name}']")
    return default if found is None or found.tag != "float" else float(found.get("value"))


def put(element, name, value):
    found = element.find(f"./*[@name='{name}']")
    if found is not None:
        element.remove(found)
    xml.SubElement(element, "float", name=name, value=repr(float(value)))


def write_ply(path, vertices, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(f"{x:.9g}" for x in vertex) for vertex in vertices] + ["3 " + " ".join(map(str, face)) for face in faces]
    path.write_text(head + "\n".join(rows) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--world", type=float, default=1.0, help="index of what surrounds everything")
    parser.add_argument("--write", action="store_true", help="correct the file")
    arguments = parser.parse_args()
    mitsuba.set_variant("scalar_rgb")
    tree = xml.parse(arguments.scene)
    folder = arguments.scene.resolve().parent
    shapes, bodies, areas = {}, [], {}
    for shape in tree.getroot().findall("shape"):
        bsdf = shape.find("bsdf[@type='dielectric']")
        mesh = None if bsdf is None else triangles(shape, folder)
        if mesh is not None:
            name = shape.get("id") or f"shape {len(shapes) + 1}"
            shapes[name] = shape, bsdf
            areas[name] = area(*mesh)
            bodies.append(iorect.Body(name, *mesh, number(bsdf, "int_ior", 1.5046)))
    found = iorect.rectify(bodies, world_ior=arguments.world)
    for warning in found.warnings:
        print(f"{warning.severity}: {warning.place}: {warning.message}")
    pieces = {}
    for piece in found.pieces():
        pieces.setdefault(piece.name, []).append(piece)
    wrong = 0
    for name, (shape, bsdf) in shapes.items():
        sides = {(piece.inside, piece.outside) for piece in pieces.get(name, [])}
        declared = number(bsdf, "int_ior", 1.5046), number(bsdf, "ext_ior", 1.000277)
        right = sorted((found.iors[inside], found.iors[outside]) for inside, outside in sides)
        whole = sum(area(piece.vertices, piece.faces) for piece in pieces.get(name, [])) > (1 - 1e-5) * areas[name]
        if whole and len(right) == 1 and numpy.allclose(right[0], declared, atol=1e-6):
            continue
        wrong += 1
        found_there = " and ".join(f"{i:g} in {o:g}" for i, o in right) + ("" if whole else " and partly no interface")
        print(f"{name}: declares {declared[0]:g} in {declared[1]:g}, is {found_there}")
        if whole and len(right) == 1:
            put(bsdf, "int_ior", right[0][0])
            put(bsdf, "ext_ior", right[0][1])
            continue
        root = tree.getroot()
        place = list(root).index(shape)
        root.remove(shape)
        for k, piece in enumerate(pieces.get(name, [])):
            file = folder / f"{arguments.scene.stem}-{name.replace(' ', '-')}-{k}.ply"
            if arguments.write:
                write_ply(file, piece.vertices, piece.faces)
            new = xml.Element("shape", type="ply")
            xml.SubElement(new, "string", name="filename", value=file.name)
            xml.SubElement(new, "boolean", name="face_normals", value="true")
            inner = xml.SubElement(new, "bsdf", type="dielectric")
            put(inner, "int_ior", found.iors[piece.inside])
            put(inner, "ext_ior", found.iors[piece.outside])
            root.insert(place + k, new)
    if arguments.write and wrong:
        temporary = arguments.scene.with_suffix(".xml.part")
        tree.write(temporary, encoding="utf-8", xml_declaration=True)
        temporary.replace(arguments.scene)
        print(f"corrected {arguments.scene}")
    return 1 if wrong and not arguments.write else 0


if __name__ == "__main__":
    sys.exit(main())
