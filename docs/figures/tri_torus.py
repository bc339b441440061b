#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clouds for the figures of docs/methods: points on a smooth surface of genus 3, three tori in a row.

    docs/figures/tri_torus.py POINTS OUT.ply [X Y Z R]      without the points within R of (X, Y, Z)

Points are random, no two nearer than half their mean spacing. Mersenne's twister with a fixed seed: the same bytes
everywhere.
"""
import math
import random
import struct
import sys

CENTRES = (-2.4, 0.0, 2.4)
AREA = 41.0  # nearly


def field(x, y, z):
    total = 0.0
    for centre in CENTRES:
        ring = math.hypot(x - centre, y) - 1
        total += math.exp(-8 * (math.hypot(ring, z) - 0.4))
    return -math.log(total) / 8


def gradient(p, step=1e-5):
    result = []
    for axis in range(3):
        up, down = list(p), list(p)
        up[axis] += step
        down[axis] -= step
        result.append((field(*up) - field(*down)) / (2 * step))
    return result


def on_surface(p):
    for _ in range(12):
        g = gradient(p)
        share = field(*p) / sum(c * c for c in g)
        p = [c - share * d for c, d in zip(p, g)]
    return p if abs(field(*p)) < 1e-9 else None


def points(count):
    generator = random.Random(1)
    apart = 0.5 * math.sqrt(AREA / count)
    cells = {}
    result = []
    while len(result) < count:
        start = [generator.uniform(-4, 4), generator.uniform(-1.6, 1.6), generator.uniform(-0.6, 0.6)]
        if abs(field(*start)) > 0.2:
            continue
        p = on_surface(start)
        if p is None:
            continue
        cell = tuple(math.floor(c / apart) for c in p)
        near = (q for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)
                for q in cells.get((cell[0] + i, cell[1] + j, cell[2] + k), ()))
        if all(math.dist(p, q) >= apart for q in near):
            cells.setdefault(cell, []).append(p)
            result.append(p)
    return result


def main():
    count, out = int(sys.argv[1]), sys.argv[2]
    kept = points(count)
    if len(sys.argv) == 7:
        *centre, radius = map(float, sys.argv[3:])
        kept = [p for p in kept if math.dist(p, centre) > radius]
    with open(out, "wb") as file:
        header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(kept)}\n"
        file.write((header + "property float x\nproperty float y\nproperty float z\nend_header\n").encode())
        for p in kept:
            file.write(struct.pack("<3f", *p))


if __name__ == "__main__":
    main()
