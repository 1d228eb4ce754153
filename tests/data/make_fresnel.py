#!/usr/bin/env python3
"""Writes fresnel.csv: unpolarised reflectance and transmittance by Fresnel's textbook equations in 60-digit arithmetic.

Needs mpmath (pip install mpmath). Columns: class, n1 - 1, n2 - 1, cos of the angle of incidence, R, T. The three inputs are f64
(the cosine an f32) and written exactly, so that whoever reads them computes with the same numbers.
"""
import csv
import os
import struct

import mpmath as mp

mp.mp.dps = 60


def f32(x):
    return struct.unpack("f", struct.pack("f", float(x)))[0]


def fresnel(m1, m2, c):
    n1, n2, c = 1 + mp.mpf(m1), 1 + mp.mpf(m2), mp.mpf(c)
    sin2_t = (n1 / n2) ** 2 * (1 - c * c)
    if sin2_t >= 1:
        return mp.mpf(1), mp.mpf(0)
    ct = mp.sqrt(1 - sin2_t)
    rs = (n1 * c - n2 * ct) / (n1 * c + n2 * ct)
    rp = (n2 * c - n1 * ct) / (n2 * c + n1 * ct)
    r = (rs * rs + rp * rp) / 2
    return r, 1 - r


CLASSES = {
    "typical entering": [(0.0, 0.31), (0.0, 0.333), (0.0, 0.5), (0.333, 0.5), (0.0, 1.417)],
    "typical exiting": [(0.5, 0.0), (0.333, 0.0), (0.5, 0.333), (1.417, 0.0)],
    "close entering": [(0.5, 0.500001), (0.333, 0.3331), (0.0, 0.000277), (0.31, 0.3103)],
    "close exiting": [(0.500001, 0.5), (0.3331, 0.333), (0.000277, 0.0), (0.3103, 0.31)],
    "high contrast entering": [(0.0, 9.0), (0.0, 99.0), (0.0, 9999.0)],
    "high contrast exiting": [(9.0, 0.0), (999.0, 0.0)],
    "below one": [(0.0, -0.5), (-0.5, 0.0), (-0.1, -0.2), (0.5, -0.3)],
}

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "fresnel.csv"), "w", newline="") as file:
    out = csv.writer(file, lineterminator="\n")
    for name, pairs in CLASSES.items():
        for m1, m2 in pairs:
            cosines = [1e-7, 1e-5, 1e-3, 0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 1 - 1e-7]
            ratio = (1 + mp.mpf(m2)) / (1 + mp.mpf(m1))
            if ratio < 1:
                critical = mp.sqrt(1 - ratio * ratio)
                cosines += [critical * (1 + s * mp.mpf(10) ** -k) for k in range(1, 7) for s in (1, -1)]
            for c in sorted({f32(c) for c in cosines if 0 < f32(c) <= 1}):
                r, t = fresnel(m1, m2, c)
                out.writerow([name, repr(m1), repr(m2), repr(c), mp.nstr(r, 20), mp.nstr(t, 20)])
