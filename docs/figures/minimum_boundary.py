#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the figures of docs/methods/minimum-boundary.md from generated shapes.

    docs/figures/minimum_boundary.py OUT_DIR --surfaced build/release/surfaced \\
        --tool build/release/minimum_boundary_figures --renderer RENDERER [FIGURE ...]

RENDERER draws a mesh or a cloud: RENDERER FILE OUT.png --size N --view AZIMUTH,ELEVATION --up z [--wire].
All random numbers have fixed seeds. Every figure prints the statistics that the page quotes.
"""
import argparse
import functools
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

TILE = 300


# Shapes ---------------------------------------------------------------------------------------------------------

def ellipsoid(p, centre, radii, tilt=0.0):
    """Distance to an ellipsoid, about right near it; tilted about the y axis."""
    x, y, z = (a - b for a, b in zip(p, centre))
    c, s = math.cos(tilt), math.sin(tilt)
    x, z = c * x - s * z, s * x + c * z
    k0 = math.sqrt((x / radii[0]) ** 2 + (y / radii[1]) ** 2 + (z / radii[2]) ** 2)
    k1 = math.sqrt((x / radii[0] ** 2) ** 2 + (y / radii[1] ** 2) ** 2 + (z / radii[2] ** 2) ** 2)
    return k0 * (k0 - 1) / k1 if k1 > 0 else -min(radii)


RABBIT = [  # centre, radii, tilt
    ((0, 0, 0.62), (0.62, 0.46, 0.5), 0.25),
    ((0.55, 0, 1.12), (0.33, 0.27, 0.29), 0.0),
    ((0.36, 0.17, 1.62), (0.1, 0.07, 0.42), 0.25),
    ((0.36, -0.17, 1.62), (0.1, 0.07, 0.42), 0.25),
    ((0.45, 0.22, 0.13), (0.3, 0.12, 0.13), 0.0),
    ((0.45, -0.22, 0.13), (0.3, 0.12, 0.13), 0.0),
    ((-0.2, 0.33, 0.22), (0.4, 0.17, 0.24), 0.0),
    ((-0.2, -0.33, 0.22), (0.4, 0.17, 0.24), 0.0),
    ((-0.66, 0, 0.5), (0.14, 0.14, 0.14), 0.0),
]


def rabbit(p):
    blend = 0.05
    return -blend * math.log(sum(math.exp(-ellipsoid(p, *part) / blend) for part in RABBIT))


def project(f, p):
    h = 1e-4
    for _ in range(4):
        d = f(p)
        g = [(f(tuple(p[j] + (h if j == k else 0) for j in range(3))) - d) / h for k in range(3)]
        n = sum(x * x for x in g)
        p = tuple(x - d * y / n for x, y in zip(p, g))
    return p if abs(f(p)) < 1e-4 else None


def sample(f, n, low, high, seed):
    """About even: of several random candidates the one farthest from all points so far."""
    rng = random.Random(seed)
    pool = []
    while len(pool) < 3 * n:
        p = tuple(rng.uniform(a, b) for a, b in zip(low, high))
        if abs(f(p)) > 0.06:
            continue
        p = project(f, p)
        if p is not None:
            pool.append(p)
    cell = math.sqrt(3.0 / n)
    grid, points = {}, []
    for radius in (0.8 * cell, 0.6 * cell, 0.45 * cell, 0.3 * cell, 0.0):
        for p in pool:
            if len(points) == n:
                return points
            key = tuple(int(x // cell) for x in p)
            near = (q for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1)
                    for q in grid.get((key[0] + dx, key[1] + dy, key[2] + dz), ()))
            if all(math.dist(p, q) > radius for q in near):
                grid.setdefault(key, []).append(p)
                points.append(p)
    return points


def chain(n, seed):
    """Random points of three linked rings of one body: genus 3."""
    rng = random.Random(seed)
    centres = (-1.5, 0.0, 1.5)

    def inside(p, k):
        x, y, z = p
        return (math.hypot(x - centres[k], y) - 0.8) ** 2 + z * z < 0.22 ** 2

    points = []
    while len(points) < n:
        k = rng.randrange(3)
        u, v = rng.uniform(0, 2 * math.pi), rng.uniform(0, 2 * math.pi)
        r = 0.8 + 0.22 * math.cos(v)
        p = (centres[k] + r * math.cos(u), r * math.sin(u), 0.22 * math.sin(v))
        if not any(j != k and inside(p, j) for j in range(3)):
            points.append(p)
    return points


def vase(n, twist, seed):
    """A cup whose open rim runs up and down."""
    rng = random.Random(seed)
    points = []
    while len(points) < n:
        u = rng.uniform(0, 2 * math.pi)
        z = rng.uniform(-1, 1.0)
        if z > twist * math.cos(3 * u):
            continue
        r = math.sqrt(max(0.0, 1 - min(z, 0) ** 2)) * (1 + 0.25 * max(z, 0))
        if rng.random() < r / 1.3:
            points.append((r * math.cos(u), r * math.sin(u), z))
    return points


def bipyramid():
    """Gyroelongated square bipyramid: 10 points, 16 equilateral triangles."""
    r, h = 1 / math.sqrt(2), math.sqrt(math.sqrt(2)) / 4 * math.sqrt(2)
    points = [(r * math.cos(k * math.pi / 2), r * math.sin(k * math.pi / 2), h / math.sqrt(2)) for k in range(4)]
    points += [(r * math.cos((k + 0.5) * math.pi / 2), r * math.sin((k + 0.5) * math.pi / 2), -h / math.sqrt(2))
               for k in range(4)]
    top = h / math.sqrt(2) + r
    return points + [(0, 0, top), (0, 0, -top)]


def noisy(points, share, seed):
    rng = random.Random(seed)
    extent = max(p[2] for p in points) - min(p[2] for p in points)
    return [tuple(x + share * extent * rng.uniform(-1, 1) for x in p) for p in points]


@functools.cache
def rabbit_points(n):
    return sample(rabbit, n, (-1, -0.6, -0.1), (1, 0.6, 2.1), 1)


def subset(points, n, seed=1):
    return random.Random(seed).sample(points, n)


# Files ----------------------------------------------------------------------------------------------------------

def write_cloud(path, points):
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property double {a}\n" for a in "xyz") + "end_header\n"
    path.write_bytes(header.encode() + b"".join(struct.pack("<3d", *p) for p in points))


def read_png(path):
    """Rows of RGB bytes of an 8-bit RGB or RGBA PNG without interlacing."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            if depth != 8 or colour not in (2, 6):
                sys.exit(f"{path}: depth {depth}, colour type {colour}; 8 and 2 or 6 can be read")
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    n = 3 if colour == 2 else 4
    raw, rows, before = zlib.decompress(packed), [], bytes(width * n)
    for y in range(height):
        kind = raw[y * (width * n + 1)]
        row = bytearray(raw[y * (width * n + 1) + 1:(y + 1) * (width * n + 1)])
        for i in range(len(row) if kind else 0):
            a, b, c = (row[i - n] if i >= n else 0), before[i], (before[i - n] if i >= n else 0)
            if kind == 4:
                p = a + b - c
                d = sorted(((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c)))[0][2]
            else:
                d = (0, a, b, (a + b) // 2)[kind]
            row[i] = (row[i] + d) & 255
        before = bytes(row)
        rows.append(before if n == 3 else b"".join(before[i:i + 3] for i in range(0, len(before), n)))
    return rows


def write_png(path, rows):
    def part(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    raw = b"".join(b"\0" + row for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", header) + part(b"IDAT", zlib.compress(raw, 9)) + part(b"IEND", b""))


# Figures --------------------------------------------------------------------------------------------------------

class Studio:
    def __init__(self, options, scratch):
        self.options, self.scratch, self.count = options, scratch, 0

    def path(self, suffix):
        self.count += 1
        return self.scratch / f"{self.count}{suffix}"

    def mesh(self, points, label="", **parameters):
        cloud, mesh, report = self.path(".ply"), self.path(".ply"), self.path(".json")
        write_cloud(cloud, points)
        command = [self.options.surfaced, "reconstruct", cloud, "-o", mesh, "--report", report]
        for name, value in parameters.items():
            command += ["--param", f"{name}={value}"]
        subprocess.run(command, check=True)
        found = json.loads(report.read_text())
        s = next(v for v in found.values() if isinstance(v, dict) and "delaunay_cells" in v)
        warnings = [w.split(":")[0] for w in found["warnings"]]
        print(f"  {label or parameters}: {len(points)} points, genus {s['genus']}, components {s['components']}, "
              f"inside {s['interior_vertices']}, sum {s['sum_of_longest_edges']:.4g}, {warnings}")
        return mesh

    def tool(self, points, what):
        cloud, mesh = self.path(".ply"), self.path(".ply")
        write_cloud(cloud, points)
        print(f"  {what}: ", end="", flush=True)
        subprocess.run([self.options.tool, cloud, what, mesh], check=True)
        print()
        return mesh

    def cloud(self, points):
        path = self.path(".ply")
        write_cloud(path, points)
        return path

    def draw(self, file, view, *flags):
        out = self.path(".png")
        subprocess.run([self.options.renderer, file, out, "--size", str(TILE), "--view", view, "--up", "z", *flags],
                       check=True, stdout=subprocess.DEVNULL)
        return read_png(out)

    def sheet(self, name, tiles):
        rows = []
        for line in tiles:
            rows += [b"".join(parts) for parts in zip(*line)]
        path = self.options.out / f"minimum-boundary-{name}.png"
        write_png(path, rows)
        print(f"  {path}: {path.stat().st_size} bytes")


SIDE = "60,15"


def criteria(s):
    points = rabbit_points(500)
    names = ("area", "inradius", "circumradius", "aspect-ratio", "perimeter", "longest-edge")
    drawn = [s.draw(s.tool(points, name), SIDE, "--wire") for name in names]
    s.sheet("criteria", [drawn[:3], drawn[3:]])


def sculpting(s):
    points = subset(rabbit_points(4000), 1500)
    meshes = [s.tool(points, "hull-start"), s.tool(points, "bc-start"), s.mesh(points, variant="best")]
    s.sheet("sculpting", [[s.draw(m, SIDE) for m in meshes], [s.draw(m, "60,-25") for m in meshes]])


def polyhedra(s):
    tetrahedron = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    cube = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    s.sheet("polyhedra", [[s.draw(s.mesh(p, label), "25,20", "--wire") for p, label in
                           ((tetrahedron, "tetrahedron"), (cube, "cube"), (bipyramid(), "bipyramid"))]])


def sparse(s):
    points = rabbit_points(4000)
    counts = (4000, 1000, 300, 150, 75, 33)
    drawn = [s.draw(s.mesh(subset(points, n), str(n)), SIDE, *(["--wire"] if n <= 1000 else [])) for n in counts]
    s.sheet("sparse", [drawn[:3], drawn[3:]])


def noise(s):
    points = rabbit_points(4000)
    s.sheet("noise", [[s.draw(s.mesh(noisy(points, share, 1), f"noise {share}"), SIDE) for share in
                       (0, 0.01, 0.02, 0.04)]])


def twisted(s):
    points = vase(1200, 0.6, 1)
    meshes = [s.mesh(points, variant="paper"), s.mesh(points, lids="mincut"), s.mesh(points, variant="best")]
    s.sheet("twisted", [[s.draw(s.cloud(points), "20,35"), *(s.draw(f, "20,35", "--wire") for f in meshes)]])


def variants(s):
    tiles = []
    for points, view in ((subset(rabbit_points(4000), 800), SIDE), (chain(450, 2), "10,60")):
        meshes = [s.mesh(points, variant=v) for v in ("best", "fast", "paper")]
        tiles.append([s.draw(f, view) for f in [s.cloud(points), *meshes]])
    s.sheet("variants", tiles)


FIGURES = {f.__name__: f for f in (criteria, sculpting, polyhedra, sparse, noise, twisted, variants)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("figures", nargs="*", metavar="FIGURE", help=", ".join(FIGURES))
    parser.add_argument("--surfaced", required=True)
    parser.add_argument("--tool", help="minimum_boundary_figures, for criteria and sculpting")
    parser.add_argument("--renderer", required=True)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        for name in options.figures or FIGURES:
            print(name)
            FIGURES[name](Studio(options, Path(scratch)))


if __name__ == "__main__":
    main()
