# SPDX-License-Identifier: GPL-3.0-or-later
"""Clouds of the figures and tables of docs/methods/local-delaunay.md.

python3 docs/figures/shapes.py paraboloid|bitorus|bumpy|torus POINTS OUT.ply
"""
import itertools
import math
import random
import struct
import sys


def paraboloid(n):
    """z = x^2 + y^2 over the unit disc, along a jittered golden spiral."""
    for i in range(n):
        at = i + 0.5 + random.uniform(-0.2, 0.2)
        r, a = math.sqrt(at / n), math.pi * (3 - math.sqrt(5)) * at
        x, y = r * math.cos(a), r * math.sin(a)
        yield x, y, x * x + y * y


def bumpy(n):
    """A sphere with bumps of two sizes, along a jittered golden spiral."""
    for i in range(n):
        at = i + 0.5 + random.uniform(-0.2, 0.2)
        z, a = 1 - 2 * at / n, math.pi * (3 - math.sqrt(5)) * at
        s = math.sqrt(max(0, 1 - z * z))
        x, y = s * math.cos(a), s * math.sin(a)
        r = 1 + 0.15 * math.sin(5 * x) * math.sin(4 * y) * math.sin(6 * z)
        r += 0.02 * math.sin(40 * x) * math.sin(40 * y) * math.sin(40 * z)
        yield r * x, r * y, r * z


def torus(n):
    """Random, even by area."""
    while n > 0:
        u, v = random.uniform(0, 2 * math.pi), random.uniform(0, 2 * math.pi)
        r = 1 + 0.4 * math.cos(v)
        if random.uniform(0, 1.4) > r:
            continue
        n -= 1
        yield r * math.cos(u), r * math.sin(u), 0.4 * math.sin(v)


def bitorus(n):
    """Genus 2: (x (x-1)^2 (x-2) + y^2)^2 + z^2 = 0.01; random points, none nearer to another than h."""
    area = 3.3  # about
    h = math.sqrt(area / n) * 0.7
    cells = {}
    while n > 0:
        p = [random.uniform(-0.2, 2.2), random.uniform(-0.8, 0.8), random.uniform(-0.12, 0.12)]
        for _ in range(20):  # Newton's steps onto the surface
            x, y, z = p
            a = x * (x - 1) ** 2 * (x - 2) + y * y
            g = (2 * a * ((x - 1) ** 2 * (x - 2) + 2 * x * (x - 1) * (x - 2) + x * (x - 1) ** 2), 4 * a * y, 2 * z)
            value, square = a * a + z * z - 0.01, sum(c * c for c in g)
            if abs(value) > 0.02 or square < 1e-12:
                break
            p = [c - value * d / square for c, d in zip(p, g)]
        key = tuple(math.floor(c / h) for c in p)
        near = itertools.product(*([k - 1, k, k + 1] for k in key))
        if abs(value) > 1e-9 or any(math.dist(p, q) < h for cell in near for q in cells.get(cell, ())):
            continue
        cells.setdefault(key, []).append(p)
        n -= 1
        yield p


random.seed(1)
kind, count, out = sys.argv[1], int(sys.argv[2]), sys.argv[3]
with open(out, "wb") as file:
    file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % count)
    file.write(b"property float x\nproperty float y\nproperty float z\nend_header\n")
    for point in globals()[kind](count):
        file.write(struct.pack("<3f", *point))
