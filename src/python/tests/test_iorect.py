"""Rectification from Python: python3 src/python/tests/test_iorect.py, with the module on PYTHONPATH."""

import itertools
import unittest

import numpy

import iorect

CUBE_FACES = [
    [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
    [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
]


def cube(low, high):
    low, high = numpy.broadcast_to(low, 3), numpy.broadcast_to(high, 3)
    corners = [[(low, high)[x][0], (low, high)[y][1], (low, high)[z][2]] for z, y, x in itertools.product((0, 1), repeat=3)]
    return numpy.array(corners), numpy.array(CUBE_FACES)


class Nested(unittest.TestCase):
    def setUp(self):
        self.found = iorect.rectify([
            iorect.Body("glass", *cube(-2, 2), 1.5),
            iorect.Body("water", *cube(-1, 1), 1.333, outside="world"),
        ], world_ior=1.1)

    def test_media_of_faces(self):
        glass, water = self.found["glass"], self.found["water"]
        name = self.found.media
        self.assertEqual(name, ["world", "vacuum", "glass", "water"])
        numpy.testing.assert_allclose(self.found.iors, [1.1, 1.0, 1.5, 1.333])
        self.assertEqual(len(glass), 12)
        self.assertTrue((glass.outside == 0).all() and (glass.inside == 2).all())
        self.assertTrue((water.outside == 2).all() and (water.inside == 3).all())
        self.assertEqual(water.outside.dtype, numpy.int32)
        self.assertTrue((water.confidence == 1).all() and (water.patch == 0).all() and not water.mixed.any())

    def test_declarations_are_checked(self):
        wrong = [warning for warning in self.found.warnings if warning.place.startswith("water")]
        self.assertTrue(wrong, self.found.warnings)
        self.assertIn("glass", wrong[0].message)

    def test_points(self):
        self.assertEqual([self.found.media[self.found.medium_at([x, 0, 0])] for x in (0, 1.5, 9)], ["water", "glass", "world"])

    def test_unknown_names(self):
        with self.assertRaises(KeyError):
            self.found["ice"]


class Crossing(unittest.TestCase):
    def test_pieces_of_what_floats(self):
        found = iorect.rectify([
            iorect.Body("water", *cube(-2, [2, 0, 2]), 1.333),
            iorect.Body("ice", *cube(-0.5, 0.5), 1.31, priority=1),
        ])
        self.assertTrue(found["ice"].mixed.any() and found["water"].mixed.any())
        area = {}
        for piece in found.pieces():
            a, b, c = (piece.vertices[piece.faces[:, k]] for k in range(3))
            sides = (piece.name, found.media[piece.outside], found.media[piece.inside])
            area[sides] = area.get(sides, 0) + numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum() / 2
        self.assertEqual(set(area), {("ice", "water", "ice"), ("ice", "world", "ice"), ("water", "world", "water")})
        # Half of the ice is under water; where it floats the water has no surface.
        self.assertAlmostEqual(area["ice", "water", "ice"], 3, places=5)
        self.assertAlmostEqual(area["ice", "world", "ice"], 3, places=5)
        self.assertAlmostEqual(area["water", "world", "water"], 2 * 16 + 4 * 8 - 1, places=4)


class Repaired(unittest.TestCase):
    def test_faces_keep_their_order(self):
        vertices, faces = cube(-1, 1)
        # One face twice, one the wrong way round, one without area.
        odd = numpy.concatenate([faces[:1], faces, [[0, 0, 1]]])
        odd[5] = odd[5][::-1]
        found = iorect.rectify([iorect.Body("glass", vertices, odd, 1.5)])["glass"]
        self.assertEqual(len(found), 14)
        self.assertEqual(found.outside[-1], -1)
        self.assertTrue((found.outside[:-1] == 0).all() and (found.inside[:-1] == 2).all(), found.outside)


class BadInput(unittest.TestCase):
    def test_errors_say_what(self):
        vertices, faces = cube(-1, 1)
        for message, make in [
            ("must be", lambda: iorect.Body("a", vertices[:, :2], faces, 1.5)),
            ("names vertex 8", lambda: iorect.Body("a", vertices, faces + 1, 1.5)),
            ("vertex 0 is not finite", lambda: iorect.Body("a", vertices * numpy.nan, faces, 1.5)),
            ("IOR", lambda: iorect.rectify([iorect.Body("a", vertices, faces, -1.0)])),
            ("two bodies", lambda: iorect.rectify([iorect.Body("a", vertices, faces, 1.5)] * 2)),
            ("two indices", lambda: iorect.rectify([iorect.Body(n, vertices, faces, i, medium="m") for n, i in (("a", 1.5), ("b", 1.4))])),
            ("no medium `oil`", lambda: iorect.rectify([iorect.Body("a", vertices, faces, 1.5, outside="oil")])),
            ("no name", lambda: iorect.rectify([iorect.Body("world", vertices, faces, 1.5)])),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                make()
        self.assertEqual(iorect.rectify([]).bodies, [])


if __name__ == "__main__":
    unittest.main()
