#!/usr/bin/env python3
"""Holds mode `declared` against Mitsuba 3 itself, on Mitsuba's own scene files.

    python3 -m venv venv && venv/bin/pip install mitsuba numpy
    venv/bin/python tests/mitsuba/compare.py target/release/iorect [SCENE.xml ...]

Each scene (all of this folder if none is named) is rendered a few times by both programs with other random numbers. Blocks of 8x8 pixels are
compared: their difference over its standard error should be that of noise. Printed are the mean of both images, and the root mean square of
that quotient, which is about 1 where only noise tells the images apart. Not run in CI: nothing of the project depends on Mitsuba.
"""

import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

RUNS = 6
SPP = 256
BLOCK = 8
# Of the root mean square; blocks are not quite independent of each other.
MOST = 1.5

mi.set_variant("scalar_rgb")


def by_mitsuba(path, seed):
    scene = mi.load_file(str(path))
    # Absorption needs volpath; the deepest paths count.
    integrator = mi.load_dict({"type": "volpath", "max_depth": 200, "rr_depth": 200})
    return np.array(mi.render(scene, integrator=integrator, spp=SPP, seed=seed))[:, :, :3]


def by_iorect(program, path, seed, size, folder):
    picture = folder / "picture.exr"
    width, height = size
    command = [program, "render", path, "--mode", "declared", "--spp", SPP, "--seed", seed, "--size", f"{width}x{height}",
               "--estimator", "path", "--sampler", "independent", "-o", picture]
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return np.array(mi.Bitmap(str(picture)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32))


def blocks(image):
    height, width, channels = image.shape
    height, width = height // BLOCK * BLOCK, width // BLOCK * BLOCK
    image = image[:height, :width].astype(np.float64)
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean((1, 3))


def main():
    program, *paths = sys.argv[1:]
    folder = pathlib.Path(__file__).parent
    paths = [pathlib.Path(path) for path in paths] or sorted(folder.glob("*.xml"))
    is_right = True
    for path in paths:
        theirs = np.stack([by_mitsuba(path, seed) for seed in range(RUNS)])
        size = theirs.shape[2], theirs.shape[1]
        with tempfile.TemporaryDirectory() as temporary:
            ours = np.stack([by_iorect(program, path, seed, size, pathlib.Path(temporary)) for seed in range(RUNS)])
        a, b = (np.stack([blocks(image) for image in images]) for images in (ours, theirs))
        error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / RUNS)
        # Where nothing is noisy, rounding is.
        error = np.maximum(error, 1e-4 * b.mean())
        quotient = (a.mean(0) - b.mean(0)) / error
        rms = np.sqrt((quotient ** 2).mean())
        is_right &= rms < MOST
        print(f"{path.stem}: mean {a.mean():.5f} by iorect, {b.mean():.5f} by Mitsuba; rms of difference over its standard error {rms:.2f}, "
              f"largest {np.abs(quotient).max():.1f}{'' if rms < MOST else '  <- apart'}")
    sys.exit(0 if is_right else 1)


if __name__ == "__main__":
    main()
