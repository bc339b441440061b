# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether openings stay open, closed bodies close, terrains look up and rooms inwards, on generated clouds.

    python3 tests/benchmarks/openings_and_fronts.py build/release/surfaced METHOD FIRST_SEED LAST_SEED

An open case is right if the mesh has the loops of the shape, or more, and no edge longer than eight medians; a closed one
if it has no loop. A terrain is right if 97 % of its area looks up, a room if 97 % looks inwards. Prints what is wrong, and
how many are right of each kind.
"""
import collections
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

TURN = 2 * math.pi


def sphere(random_, points, keep=lambda p: True):
    cloud = []
    while len(cloud) < points:
        v = [random_.gauss(0, 1) for _ in range(3)]
        p = tuple(x / math.hypot(*v) for x in v)
        if keep(p):
            cloud.append(p)
    return cloud


def spiral(points, keep=lambda p: True):
    golden = math.pi * (3 - 5 ** 0.5)
    heights = [1 - 2 * (i + 0.5) / points for i in range(points)]
    cloud = [(math.sqrt(1 - z * z) * math.cos(golden * i), math.sqrt(1 - z * z) * math.sin(golden * i), z)
             for i, z in enumerate(heights)]
    return [p for p in cloud if keep(p)]


def over_area(random_, place, points, density):
    """Points place(u, v), as dense as `density` says, which is the area that the surface has at (u, v)."""
    most = max(density(i / 50, j / 50) for i in range(51) for j in range(51))
    cloud = []
    while len(cloud) < points:
        u, v = random_.random(), random_.random()
        if random_.random() * most <= density(u, v):
            cloud.append(place(u, v))
    return cloud


def grid(random_, place, columns, rows, around):
    """A grid whose points are moved by up to a third of its step, but along a rim."""
    def moved(i, count, free):
        return i + (random_.uniform(-0.3, 0.3) if free or 0 < i < count - 1 else 0)
    last = columns if around else columns - 1
    return [place(moved(i, columns, around) / last, moved(j, rows, False) / (rows - 1))
            for i in range(columns) for j in range(rows)]


def terrain(random_, points):
    waves = [(random_.uniform(0.3, 2), random_.uniform(0, TURN), random_.uniform(0.3, 2), random_.uniform(0, TURN),
              random_.uniform(0, 0.6)) for _ in range(4)]
    places = [(random_.uniform(0, 10), random_.uniform(0, 10)) for _ in range(points)]
    return [(x, y, sum(e * math.sin(a * x + b) * math.cos(c * y + d) for a, b, c, d, e in waves)) for x, y in places]


def room(random_, points, ceiling):
    sides = (random_.uniform(3, 8), random_.uniform(3, 8), random_.uniform(2.4, 4))
    walls = [(axis, end) for axis in range(3) for end in (0, 1)][:6 if ceiling else 5]
    areas = [sides[(axis + 1) % 3] * sides[(axis + 2) % 3] for axis, _ in walls]
    cloud, normals = [], []
    for axis, end in random_.choices(walls, areas, k=points):
        p = [random_.uniform(0, side) for side in sides]
        p[axis] = sides[axis] * end
        cloud.append(tuple(p))
        normals.append(tuple((1 - 2 * end) * (k == axis) for k in range(3)))
    return cloud, normals, tuple(side / 2 for side in sides)


def catenoid(u, v):
    radius = math.cosh(2 * v - 1)
    return radius * math.cos(TURN * u), radius * math.sin(TURN * u), 2 * v - 1


def torus(u, v):
    ring = 1 + 0.4 * math.cos(TURN * v)
    return ring * math.cos(TURN * u), ring * math.sin(TURN * u), 0.4 * math.sin(TURN * v)


def shapes(seed):
    """Name, cloud, loops of the surface."""
    r = random.Random(seed)
    points = r.choice((1000, 3000, 8000))
    length = r.uniform(2, 6)
    tube = lambda u, v: (math.cos(TURN * u), math.sin(TURN * u), length * v)
    vault = lambda u, v: (math.cos(math.pi * u), length * v, math.sin(math.pi * u))
    yield "hemisphere", sphere(r, points, lambda p: p[2] > 0), 1
    yield "hemisphere, even", spiral(2 * points, lambda p: p[2] > 0.02), 1
    yield "catenoid", over_area(r, catenoid, points, lambda u, v: math.cosh(2 * v - 1) ** 2), 2
    yield "tunnel", over_area(r, tube, points, lambda u, v: 1), 2
    around = int(math.sqrt(points * TURN / length))
    yield "tunnel, grid", grid(r, tube, around, max(4, points // around), True), 2
    yield "vault", over_area(r, vault, points, lambda u, v: 1), 1
    across = int(math.sqrt(points * math.pi / length))
    yield "vault, grid", grid(r, vault, across, max(4, points // across), False), 1
    land = terrain(r, points)
    yield "terrain", land, 1
    radius = r.uniform(4.5, 9) * 10 / math.sqrt(points)
    x, y = r.uniform(3, 7), r.uniform(3, 7)
    yield "terrain with a lake", [p for p in land if math.hypot(p[0] - x, p[1] - y) > radius], 2
    hole = math.cos(4.6 * math.sqrt(4 * math.pi / points))
    yield "sphere with a hole", sphere(r, points, lambda p: p[2] < hole), 1
    yield "sphere", sphere(r, points), 0
    yield "sphere, sparse side", [p for p in sphere(r, 2 * points) if p[0] < 0.3 or r.random() < 1 / 3], 0
    yield "sphere, even", spiral(points), 0
    yield "torus", over_area(r, torus, points, lambda u, v: 1 + 0.4 * math.cos(TURN * v)), 0
    cube, _, _ = room(r, points, True)
    yield "box", cube, 0
    top = max(p[2] for p in cube)
    yield "box, sparse top", [p for p in cube if p[2] < top or r.random() < 1 / 3], 0


class Tried:
    """One run of the command."""

    def __init__(self, program, method, folder, cloud, normals=None, viewpoint=None):
        source, mesh, report = folder / "cloud.pcd", folder / "mesh.ply", folder / "report.json"
        fields = "x y z" + (" normal_x normal_y normal_z" if normals else "")
        count = len(fields.split())
        head = ["VERSION .7", "FIELDS " + fields, "SIZE" + " 4" * count, "TYPE" + " F" * count, f"WIDTH {len(cloud)}", "HEIGHT 1",
                "VIEWPOINT %g %g %g 1 0 0 0" % (viewpoint or (0, 0, 0)), f"POINTS {len(cloud)}", "DATA ascii"]
        rows = [" ".join("%.7g" % x for x in p + (normals[i] if normals else ())) for i, p in enumerate(cloud)]
        source.write_text("\n".join(head + rows) + "\n")
        subprocess.run([program, "reconstruct", source, "-o", mesh, "--method", method, "--report", report], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.report = json.loads(report.read_text())
        self.read(mesh.read_bytes())

    def read(self, data):
        start = data.index(b"end_header\n") + 11
        lines = [line.split() for line in data[:start].decode().split("\n")]
        first_face = next(i for i, line in enumerate(lines) if line[:2] == ["element", "face"])
        vertex = "<" + "".join({"float": "f", "double": "d", "uchar": "B"}[line[1]] for line in lines[:first_face]
                               if line[:1] == ["property"])
        counts = {line[1]: int(line[2]) for line in lines if line[:1] == ["element"]}
        size = struct.calcsize(vertex)
        self.positions = [struct.unpack_from(vertex, data, start + i * size)[:3] for i in range(counts["vertex"])]
        start += counts["vertex"] * size
        self.triangles = [struct.unpack_from("<3i", data, start + 13 * i + 1) for i in range(counts["face"])]

    def longest_by_median(self):
        edges = sorted(math.dist(self.positions[t[k]], self.positions[t[k - 1]]) for t in self.triangles for k in range(3))
        return edges[-1] / edges[len(edges) // 2]

    def share_towards(self, direction):
        """Share of the area that faces direction(point)."""
        towards = total = 0
        for t in self.triangles:
            a, b, c = (self.positions[v] for v in t)
            u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
            n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            total += math.hypot(*n)
            towards += math.hypot(*n) * (sum(x * y for x, y in zip(n, direction(a))) > 0)
        return towards / total


def main(program, method, first, last):
    right, tried = collections.Counter(), collections.Counter()

    def count(kind, name, seed, good, what):
        tried[kind] += 1
        right[kind] += good
        if not good:
            print(f"seed {seed}: {name}: {what}", flush=True)

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for seed in range(first, last + 1):
            for shape, cloud, loops in shapes(seed):
                made = Tried(program, method, folder, cloud)
                found, longest = made.report["mesh"]["boundary_loops"], made.longest_by_median()
                good = found >= loops and longest < 8 if loops else found == 0
                count("open" if loops else "closed", shape, seed, good, f"{found} loops of {loops}, longest edge {longest:.1f} medians")
            r = random.Random(seed)
            share = Tried(program, method, folder, terrain(r, 1500)).share_towards(lambda p: (0, 0, 1))
            count("terrains up", "terrain", seed, share > 0.97, f"{100 * share:.0f} % look up")
            for told in ("normals", "viewpoint"):
                cloud, normals, centre = room(r, 2000, seed % 2 == 0)
                made = Tried(program, method, folder, cloud, normals if told == "normals" else None, centre if told == "viewpoint" else None)
                share = made.share_towards(lambda p: [c - x for c, x in zip(centre, p)])
                count("rooms inwards by " + told, "room", seed, share > 0.97, f"{100 * share:.0f} % look inwards")
    for kind in tried:
        print(f"{method}: {kind}: {right[kind]} of {tried[kind]}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
