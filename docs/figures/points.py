#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the points of paper 3's table 2 and figures 3 and 4 as PLY: points.py FOLDER"""
import math
import pathlib
import sys


def unit(p):
    length = math.sqrt(sum(x * x for x in p))
    return tuple(x / length for x in p)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def sphere():
    """An icosahedron split three times: 642 points."""
    g = (1 + math.sqrt(5)) / 2
    points = [unit(p) for p in [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
                                (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(3):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(tuple(points[a][i] + points[b][i] for i in range(3))))
            return middles[key]

        for a, b, c in faces:
            x, y, z = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, x, z), (b, y, x), (c, z, y), (x, y, z)]
        faces = finer
    return points


def torus():
    """Radii 1 and 0.3, a grid of 48 x 16."""
    grid = [(2 * math.pi * i / 48, 2 * math.pi * j / 16) for i in range(48) for j in range(16)]
    return [((1 + 0.3 * math.cos(v)) * math.cos(u), (1 + 0.3 * math.cos(v)) * math.sin(u), 0.3 * math.sin(v)) for u, v in grid]


def knot(along=160, around=8, tube=0.35):
    """A tube around a trefoil."""
    points = []
    for i in range(along):
        t = 2 * math.pi * i / along
        centre = (math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t))
        first = (math.cos(t) + 4 * math.cos(2 * t), -math.sin(t) + 4 * math.sin(2 * t), -3 * math.cos(3 * t))
        second = (-math.sin(t) - 8 * math.sin(2 * t), -math.cos(t) + 8 * math.cos(2 * t), 9 * math.sin(3 * t))
        binormal = unit(cross(first, second))
        normal = cross(binormal, unit(first))
        for j in range(around):
            a = 2 * math.pi * (j + 0.5 * (i % 2)) / around
            points.append(tuple(centre[k] + tube * (math.cos(a) * normal[k] + math.sin(a) * binormal[k]) for k in range(3)))
    return points


def patch(side=16):
    """Figure 3: (u, v, cos u sin v) on a grid of 16 x 16 over [0, pi/2]^2."""
    steps = [math.pi / 2 * i / (side - 1) for i in range(side)]
    return [(u, v, math.cos(u) * math.sin(v)) for u in steps for v in steps]


def bowl(side=32):
    """Figure 4: z = x^2 + y^2 over [-1, 1]^2."""
    steps = [-1 + 2 * i / (side - 1) for i in range(side)]
    return [(x, y, x * x + y * y) for x in steps for y in steps]


def main():
    folder = pathlib.Path(sys.argv[1])
    for shape in (sphere, torus, knot, patch, bowl):
        points = shape()
        lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", "property double x", "property double y",
                 "property double z", "end_header"] + ["%.17g %.17g %.17g" % p for p in points]
        (folder / f"{shape.__name__}.ply").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
