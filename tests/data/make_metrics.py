#!/usr/bin/env python3
"""Makes metrics.json: figures of small images by implementations that are not iorect's.

FLIP and HDR-FLIP by NVIDIA's own package, flip-evaluator 1.7; MSE, relMSE and sMAPE by numpy. The images are those of
`tests/library/measure.rs`, number for number: integer hashes and products of halves, which any language rounds alike.

    pip install flip-evaluator==1.7 numpy && python3 make_metrics.py > metrics.json
"""
import json

import flip_evaluator
import numpy as np

WIDTH, HEIGHT = 56, 40


def noise(seed):
    """Uniform in [0, 1): one number for each component of each pixel, row by row."""
    h = np.arange(WIDTH * HEIGHT * 3, dtype=np.uint64) + np.uint64(seed * 1_000_003)
    mask = np.uint64(0xFFFFFFFF)
    h = (h * np.uint64(0x9E3779B1)) & mask
    h ^= h >> np.uint64(15)
    h = (h * np.uint64(0x85EBCA77)) & mask
    h ^= h >> np.uint64(13)
    h = (h * np.uint64(0xC2B2AE3D)) & mask
    h ^= h >> np.uint64(16)
    return (h.astype(np.float64) / 2.0**32).reshape(HEIGHT, WIDTH, 3)


def picture():
    """A ramp in each colour, stripes, and a disc, in [0, 1]."""
    y, x, c = np.meshgrid(np.arange(HEIGHT), np.arange(WIDTH), np.arange(3), indexing="ij")
    ramp = ((x * (c + 1) * 5 + y * (3 - c) * 7) % 256) / 256.0
    disc = (x - 20) ** 2 + (y - 18) ** 2 < 150
    stripes = (x // 3 + c) % 2 == 0
    value = 0.25 + 0.5 * ramp + np.where(stripes & (y > 28), 0.25, 0.0)
    return np.where(disc, 0.5 * value + np.where(c == 0, 0.5, 0.0), value)


def images():
    """Pairs of a test image and a reference, by name."""
    reference = picture()
    noisy = np.clip(reference + 0.25 * (noise(1) - 0.5), 0.0, 1.0)
    moved = np.roll(reference, 2, axis=1)
    # Radiance over eight decades, with a few fireflies in the test image and a black corner in both.
    scale = np.where(noise(2)[:, :, :1] < 0.02, 1024.0, 1.0) * np.where(np.arange(WIDTH)[None, :, None] < 9, 0.0009765625, 1.0)
    hdr = reference * reference * scale
    hdr[:6, :6] = 0.0
    hdr_noisy = hdr * (0.5 + noise(3))
    hdr_noisy[30, 11] = 5000.0
    return {
        "noisy": (noisy, reference, "LDR"),
        "moved": (moved, reference, "LDR"),
        "radiance": (hdr_noisy, hdr, "HDR"),
    }


def figures(test, reference):
    """NUMERICS: relMSE = mean (x − r)²/(r² + 0.01), sMAPE = mean 2|x − r|/(|x| + |r| + 0.01)."""
    x, r = test.astype(np.float64), reference.astype(np.float64)
    relative = ((x - r) ** 2 / (r**2 + 0.01)).mean(axis=2).ravel()
    kept = len(relative) - len(relative) // 1000
    return {
        "mse": np.mean((x - r) ** 2),
        "relmse": np.mean(relative),
        "relmse_trimmed": np.mean(np.sort(relative)[:kept]),
        "mean_abs": np.mean(np.abs(x - r)),
        "smape": np.mean(2.0 * np.abs(x - r) / (np.abs(x) + np.abs(r) + 0.01)),
    }


def main():
    cases = []
    for name, (test, reference, dynamic_range) in images().items():
        test, reference = test.astype(np.float32), reference.astype(np.float32)
        for ppd in (67.0206, 20.0):
            error, mean, _ = flip_evaluator.evaluate(
                reference, test, dynamic_range, applyMagma=False, parameters={"ppd": ppd}
            )
            error = np.asarray(error, dtype=np.float64).reshape(HEIGHT, WIDTH)
            cases.append(
                {
                    "name": name,
                    "dynamic_range": dynamic_range,
                    "pixels_per_degree": ppd,
                    "mean": float(mean),
                    "figures": figures(test, reference),
                    "error": [round(float(e), 5) for e in error.ravel()],
                }
            )
    text = json.dumps({"made_by": "make_metrics.py: flip-evaluator 1.7, numpy", "cases": cases})
    print(text.replace('{"name"', '\n{"name"'))


main()
