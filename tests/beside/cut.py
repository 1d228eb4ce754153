"""Cuts a scene's surfaces apart for renderers that must be told the IOR on both sides of each.

iorect scenes give the inside of closed objects only. Here every face gets both its media, by means that share nothing with iorect's:
faces that cross another refractor's are cut along the lines where they meet; what contains a piece is decided by generalised winding numbers
(Jacobson et al. 2013; solid angles by van Oosterom and Strackee 1983), once for all whole faces that hang together; of the containers the
highest priority counts, then the smaller volume, then the later one. Pieces with one IOR on both sides are no interface and are dropped. The
rest is written as one binary PLY for each pair of IORs. Surfaces must not coincide: let them overlap.

It reads what the comparison needs and no more: meshes in PLY, IORs as numbers, diffuse solids of one colour, an environment of one colour.
"""

import hashlib
import json
import math
import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# In coordinates (u, v) of a face, whose corners are:
TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
# What is nearer than this touches.
SHORTEST = 1e-9


class SceneError(Exception):
    """What is wrong with a scene, or is in it and cannot be read here."""


@dataclass
class Refractor:
    name: str
    ior: float
    priority: int
    corners: np.ndarray  # (faces, 3, 3), turned outward
    volume: float


def cut(scene_path, cache):
    """Cuts the scene into a folder under `cache`, unless it is there; returns the folder."""
    scene_path = Path(scene_path)
    try:
        text = scene_path.read_bytes()
        scene = tomllib.loads(text.decode())
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise SceneError(f"{scene_path}: {error}") from error
    refuse_unknown(scene, scene_path)
    key = hashlib.sha256(text + Path(__file__).read_bytes())
    objects = scene.get("refractor", []) + scene.get("solid", [])
    for item in objects:
        key.update(mesh_path(scene_path, item).read_bytes())
    folder = Path(cache) / f"{scene_path.stem}-cut-{key.hexdigest()[:16]}"
    if (folder / "scene.json").exists():
        return folder

    media = {medium["name"]: medium["ior"] for medium in scene.get("medium", [])}
    refractors = [refractor(scene_path, item, media) for item in scene.get("refractor", [])]
    camera = {"up": [0.0, 1.0, 0.0], "vertical_fov": 40.0, **scene["camera"]}
    groups = resolve(refractors, scene.get("world", {}).get("ior", 1.0))

    building = folder.with_suffix(".building")
    shutil.rmtree(building, ignore_errors=True)
    building.mkdir(parents=True)
    interfaces = []
    for (outside, inside), corners in sorted(groups.items()):
        file = f"{outside}-{inside}.ply"
        write_ply(building / file, corners)
        interfaces.append({"file": file, "ext_ior": outside, "int_ior": inside, "faces": len(corners)})
    solids = []
    for index, item in enumerate(scene.get("solid", [])):
        corners, is_two_sided = facing(read_mesh(scene_path, item), refractors, camera)
        file = f"solid-{index}.ply"
        write_ply(building / file, corners)
        solids.append({"file": file, "color": item["color"], "two_sided": is_two_sided})
    description = {
        "camera": {key: camera[key] for key in ("position", "target", "up", "vertical_fov")},
        "environment": scene["environment"]["color"],
        "interfaces": interfaces,
        "solids": solids,
    }
    (building / "scene.json").write_text(json.dumps(description, indent=2))
    building.rename(folder)
    return folder


def refuse_unknown(scene, path):
    """Refuses what the cut scene would silently lack."""
    known = {
        "camera": {"position", "target", "up", "vertical_fov"},
        "world": {"ior"},
        "environment": {"color"},
        "medium": {"name", "ior"},
        "refractor": {"name", "medium", "shape", "priority"},
        "solid": {"name", "shape", "color"},
    }
    for section, content in scene.items():
        if section == "name":
            continue
        if section not in known:
            raise SceneError(f"{path}: [{section}] cannot be read here")
        for table in content if isinstance(content, list) else [content]:
            for extra in sorted(set(table) - known[section]):
                raise SceneError(f"{path}: `{extra}` of [{section}] cannot be read here")
            if not isinstance(table.get("ior", 1.0), (int, float)):
                raise SceneError(f"{path}: only IORs that are numbers can be read here")
    for section, needed in (("camera", {"position", "target"}), ("environment", {"color"})):
        for lacking in sorted(needed - set(scene.get(section, {}))):
            raise SceneError(f"{path}: [{section}] lacks `{lacking}`")
    for item in scene.get("solid", []):
        if "color" not in item:
            raise SceneError(f"{path}: solid {item['name']} lacks `color`")


def mesh_path(scene_path, item):
    shape = item.get("shape", {})
    if set(shape) != {"mesh"} or not shape["mesh"].endswith(".ply"):
        raise SceneError(f"{scene_path}: {item.get('name')}: only shapes that are meshes in PLY can be read here")
    return scene_path.parent / shape["mesh"]


def read_mesh(scene_path, item):
    """Corners of the item's triangles, (faces, 3, 3)."""
    path = mesh_path(scene_path, item)
    try:
        vertices, faces = read_ply(path)
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise SceneError(f"{path}: {error}") from error
    return vertices[faces]


def refractor(scene_path, item, media):
    if item.get("medium") not in media:
        raise SceneError(f"{scene_path}: no medium is called {item.get('medium')}")
    corners = read_mesh(scene_path, item)
    volume = float(np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
    if volume < 0:
        corners = corners[:, ::-1]
    return Refractor(item["name"], float(media[item["medium"]]), item.get("priority", 0), corners, abs(volume))


def facing(corners, refractors, camera):
    """Corners of a solid turned towards camera and refractors, and whether it must be two-sided because they lie on both sides."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    others = [np.array([camera["position"]])] + [r.corners.reshape(-1, 3) for r in refractors]
    others = np.concatenate(others)
    bounds = np.array(np.meshgrid(*zip(others.min(0), others.max(0)))).reshape(3, -1)
    heights = normals @ bounds - np.einsum("fi,fi->f", normals, corners[:, 0])[:, None]
    if (heights >= 0).all():
        return corners, False
    if (heights <= 0).all():
        return corners[:, ::-1], False
    return corners, True


# Cutting


def resolve(refractors, world_ior):
    """Faces of all interfaces, by (IOR outside, IOR inside)."""
    clusters = [Clusters(r.corners) for r in refractors]
    groups = {}
    for index, own in enumerate(refractors):
        others = [i for i in range(len(refractors)) if i != index]
        pieces, is_touched = divide(own.corners, [clusters[i] for i in others])
        outside = np.full(len(pieces), float(world_ior))
        inside = outside.copy()
        # From the lowest rank to the highest: the last that contains a place fills it.
        for i in sorted(range(len(refractors)), key=lambda i: (refractors[i].priority, -refractors[i].volume, i)):
            if i == index:
                inside[:] = own.ior
            else:
                held = contained(pieces, is_touched, own.name, refractors[i])
                outside[held] = inside[held] = refractors[i].ior
        for pair in np.unique(np.stack([outside, inside], 1), axis=0):
            if pair[0] != pair[1]:
                chosen = (outside == pair[0]) & (inside == pair[1])
                groups.setdefault(tuple(map(float, pair)), []).append(pieces[chosen])
    return {pair: np.concatenate(parts) for pair, parts in groups.items()}


def divide(corners, others):
    """Pieces of the faces that no triangle of `others` crosses, and for each whether its face was touched by any."""
    lines = {}
    for other in others:
        faces, triangles = other.near(corners)
        met, starts, ends = intersections(corners[faces], other.corners[triangles])
        for face, start, end in zip(faces[met], starts, ends):
            if passes_through(start, end, TRIANGLE, SHORTEST):
                lines.setdefault(int(face), []).append((start, end))
    clear = np.ones(len(corners), bool)
    clear[list(lines)] = False
    parts = [corners[clear]]
    for face, segments in lines.items():
        a, b, c = corners[face]
        for u, v in divide_triangle(segments):
            fan = a + u[:, None] * (b - a) + v[:, None] * (c - a)
            parts.append(np.stack([np.repeat(fan[:1], len(fan) - 2, 0), fan[1:-1], fan[2:]], 1))
    pieces = np.concatenate(parts)
    return pieces, np.arange(len(pieces)) >= clear.sum()


class Clusters:
    """A mesh's triangles in boxes of some 32 along a space-filling curve, to find quickly those near others."""

    SIZE = 32

    def __init__(self, corners):
        middle = corners.mean(1)
        extent = np.ptp(middle, axis=0)
        grid = ((middle - middle.min(0)) / np.where(extent > 0, extent, 1) * 1023).astype(np.uint64)
        code = sum(
            ((grid[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
            for axis in range(3)
            for bit in range(10)
        )
        self.corners = corners[np.argsort(code)]
        self.low, self.high = self.corners.min(1), self.corners.max(1)
        starts = np.arange(0, len(corners), self.SIZE)
        self.box_low = np.minimum.reduceat(self.low, starts)
        self.box_high = np.maximum.reduceat(self.high, starts)

    def near(self, faces):
        """All pairs (face, triangle of this mesh) whose bounds overlap."""
        pairs = []
        for start in range(0, len(faces), 4096):
            part = faces[start:start + 4096]
            low, high = part.min(1), part.max(1)
            face, box = np.nonzero(overlap(low[:, None], high[:, None], self.box_low, self.box_high))
            triangle = (box[:, None] * self.SIZE + np.arange(self.SIZE)).ravel()
            face = np.repeat(face, self.SIZE)
            face, triangle = face[triangle < len(self.corners)], triangle[triangle < len(self.corners)]
            close = overlap(low[face], high[face], self.low[triangle], self.high[triangle])
            pairs.append((start + face[close], triangle[close]))
        return tuple(np.concatenate(side) for side in zip(*pairs))


def overlap(low, high, other_low, other_high):
    return ((low <= other_high) & (high >= other_low)).all(-1)


def intersections(faces, triangles):
    """Where each triangle meets the plane of its face, in coordinates (u, v) of the face (a + u (b - a) + v (c - a)).

    Returns the rows that do, and starts and ends of their segments. A corner in the plane counts as above it: of two triangles that meet
    at an edge in the plane, one on each side, just one has the edge as its segment.
    """
    a, edge_u, edge_v = faces[:, 0], faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]
    normal = np.cross(edge_u, edge_v)
    height = np.einsum("nki,ni->nk", triangles - a[:, None], normal)
    above = height >= 0
    met = np.flatnonzero(above.any(1) & ~above.all(1))
    a, edge_u, edge_v, normal, height, above = (x[met] for x in (a, edge_u, edge_v, normal, height, above))
    rows = np.arange(len(met))
    # The corner alone on its side: the plane is met on both edges that leave it.
    lone = np.where(above.sum(1) == 1, above.argmax(1), (~above).argmax(1))
    corner, its_height = triangles[met, lone], height[rows, lone]
    square = (normal**2).sum(1)
    segments = []
    for turn in (1, 2):
        other = (lone + turn) % 3
        share = its_height / (its_height - height[rows, other])
        point = corner + share[:, None] * (triangles[met, other] - corner) - a
        u = np.einsum("ni,ni->n", np.cross(point, edge_v), normal) / square
        v = np.einsum("ni,ni->n", np.cross(edge_u, point), normal) / square
        segments.append(np.stack([u, v], 1))
    return met, *segments


def passes_through(start, end, polygon, slack):
    """Whether part of the segment is inside the convex polygon (counter-clockwise), grown by `slack` or, below 0, shrunk."""
    enter, leave = 0.0, 1.0
    for i, (x, y) in enumerate(polygon):
        next_x, next_y = polygon[(i + 1) % len(polygon)]
        dx, dy = next_x - x, next_y - y
        grow = slack * math.hypot(dx, dy)
        s = dx * (start[1] - y) - dy * (start[0] - x) + grow
        e = dx * (end[1] - y) - dy * (end[0] - x) + grow
        if s < 0 and e < 0:
            return False
        if s < 0:
            enter = max(enter, s / (s - e))
        elif e < 0:
            leave = min(leave, s / (s - e))
    return enter < leave


def divide_triangle(segments):
    """The convex pieces, each as (u, v), into which the lines of the segments divide the triangle where they pass through."""
    pieces = [TRIANGLE]
    for start, end in segments:
        after = []
        for piece in pieces:
            if not passes_through(start, end, piece, -SHORTEST):
                after.append(piece)
                continue
            (x, y), (dx, dy) = start, end - start
            side = dx * (piece[:, 1] - y) - dy * (piece[:, 0] - x)
            side[np.abs(side) < SHORTEST * math.hypot(dx, dy)] = 0.0
            halves = ([], [])
            for i, corner in enumerate(piece):
                j = (i + 1) % len(piece)
                if side[i] >= 0:
                    halves[0].append(corner)
                if side[i] <= 0:
                    halves[1].append(corner)
                if side[i] * side[j] < 0:
                    point = corner + side[i] / (side[i] - side[j]) * (piece[j] - corner)
                    halves[0].append(point)
                    halves[1].append(point)
            after.extend(np.array(half) for half in halves if len(half) > 2)
        pieces = after
    return [piece.T for piece in pieces]


# Containment


def contained(pieces, is_touched, name, other):
    """For each piece whether it lies in `other`. Faces that nothing touches and that share a vertex lie on the same side."""
    middle = pieces.mean(1)
    result = np.zeros(len(pieces), bool)
    clear, touched = np.flatnonzero(~is_touched), np.flatnonzero(is_touched)
    if len(clear):
        label = components(weld(pieces[clear]))
        _, first, member = np.unique(label, return_index=True, return_inverse=True)
        result[clear] = is_inside(middle[clear[first]], name, other)[member]
    result[touched] = is_inside(middle[touched], name, other)
    return result


def is_inside(points, name, other):
    numbers = winding_numbers(points, other.corners)
    if (np.abs(numbers - np.round(numbers)) > 0.1).any():
        raise SceneError(f"{other.name} is not closed, or {name} coincides with it: neither can be cut here")
    return numbers > 0.5


def weld(pieces):
    """Number of the vertex at each corner, (pieces, 3), by bit-equal positions."""
    _, vertex_of = np.unique(pieces.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    return vertex_of.reshape(-1, 3)


def components(vertex_of):
    """A label for each face, equal for faces connected over vertices."""
    label = np.arange(vertex_of.max() + 1)
    while True:
        least = label[vertex_of].min(1)
        lower = label.copy()
        np.minimum.at(lower, vertex_of.ravel(), np.repeat(least, 3))
        lower = lower[lower]
        if (lower == label).all():
            return label[vertex_of[:, 0]]
        label = lower


def winding_numbers(points, corners):
    """Generalised winding number of the triangles about each point."""
    flat, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 3).T
    a, b, c = corners.transpose(1, 0, 2)
    plane = (np.cross(a, b) + np.cross(b, c) + np.cross(c, a)).T
    constant = np.einsum("fi,fi->f", a, np.cross(b, c))
    squares = [((u - v) ** 2).sum(1) for u, v in ((a, b), (b, c), (c, a))]
    numbers = np.empty(len(points))
    chunk = max(1, 1_000_000 // len(corners))
    for start in range(0, len(points), chunk):
        p = points[start:start + chunk]
        distance = np.linalg.norm(flat[None] - p[:, None], axis=2)
        da, db, dc = (distance[:, i] for i in index)
        dot_ab, dot_bc, dot_ca = (
            (u * u + v * v - s) / 2 for u, v, s in zip((da, db, dc), (db, dc, da), squares))
        solid_angle = np.arctan2(constant - p @ plane, da * db * dc + dot_ab * dc + dot_bc * da + dot_ca * db)
        numbers[start:start + chunk] = solid_angle.sum(1) / (2 * math.pi)
    return numbers


# PLY

TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
         "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


def read_ply(path):
    """Vertices (n, 3) as float64 and triangles (m, 3)."""
    data = path.read_bytes()
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise ValueError("is not a PLY file")
    body = data[data.index(b"\n", end) + 1:]
    kind, elements = None, []
    for words in (line.split() for line in data[:end].decode("latin-1").splitlines()):
        if words[:1] == ["format"]:
            kind = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if [name for name, _, _ in elements] != ["vertex", "face"] or len(elements[1][2]) != 1:
        raise ValueError("only PLY files of vertices and then faces of indices alone can be read here")
    (_, vertex_count, properties), (_, face_count, ((_, count_type, index_type, _),)) = elements
    if kind == "ascii":
        numbers = np.array(body.split(), dtype=np.float64)
        names = [words[-1] for words in properties]
        split = vertex_count * len(names)
        table = dict(zip(names, numbers[:split].reshape(vertex_count, -1).T))
        faces = numbers[split:split + 4 * face_count].reshape(face_count, 4).astype(np.int64)
        counts, indices = faces[:, 0], faces[:, 1:]
    elif kind in ("binary_little_endian", "binary_big_endian"):
        order = "<" if kind == "binary_little_endian" else ">"
        row = np.dtype([(words[-1], order + TYPES[words[0]]) for words in properties])
        table = np.frombuffer(body, row, vertex_count)
        row = np.dtype([("count", order + TYPES[count_type]), ("indices", order + TYPES[index_type], 3)])
        faces = np.frombuffer(body, row, face_count, vertex_count * table.itemsize)
        counts, indices = faces["count"], faces["indices"].astype(np.int64)
    else:
        raise ValueError(f"format {kind} is unknown")
    if (counts != 3).any():
        raise ValueError("only triangles can be read here")
    return np.stack([table[axis] for axis in "xyz"], 1).astype(np.float64), indices


def write_ply(path, corners):
    vertices, faces = np.unique(corners.reshape(-1, 3).astype(np.float32) + np.float32(0), axis=0, return_inverse=True)
    rows = np.empty(len(corners), np.dtype([("count", "u1"), ("indices", "<i4", 3)]))
    rows["count"], rows["indices"] = 3, faces.reshape(-1, 3)
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())
