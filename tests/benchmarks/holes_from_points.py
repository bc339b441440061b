# SPDX-License-Identifier: GPL-3.0-or-later
"""How near, how dense and how well shaped filled holes are, from points, on surfaces that are known.

    python3 tests/benchmarks/holes_from_points.py build/release/surfaced METHOD FIRST_SEED LAST_SEED [PARAMETER=VALUE...]

From every cloud the points within a ball are cut, whose diameter is 5 or 10 % of the shape's; the rest is reconstructed with
fill_holes=all. A line a case: mean distance of the new vertices to the surface by the shape's diameter, new vertices by
points cut, and of the triangles with a new vertex the 5th percentiles of r/L and l/R by those of the others.
"""
import json
import math
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

TURN = 2 * math.pi
RING = 0.4


def on_sphere(random_):
    v = [random_.gauss(0, 1) for _ in range(3)]
    return tuple(x / math.hypot(*v) for x in v)


def bump(u):
    return 1 + 0.1 * math.sin(3 * u[0] + 0.5) * math.sin(3 * u[1] + 1) * math.sin(3 * u[2] + 2)


def from_sphere(p):
    return abs(math.hypot(*p) - 1)


def from_torus(p):
    return abs(math.hypot(math.hypot(p[0], p[1]) - 1, p[2]) - RING)


def from_bumpy(p):
    """To first order: the function that vanishes on the surface by its gradient."""
    def f(q):
        r = math.hypot(*q)
        return r - bump([x / r for x in q])
    h = 1e-5
    slope = [(f([x + h * (i == k) for i, x in enumerate(p)]) - f([x - h * (i == k) for i, x in enumerate(p)])) / (2 * h) for k in range(3)]
    return abs(f(p)) / math.hypot(*slope)


def random_on(shape, random_, points):
    cloud = []
    while len(cloud) < points:
        if shape == "torus":
            a, b = TURN * random_.random(), TURN * random_.random()
            if random_.random() * (1 + RING) < 1 + RING * math.cos(b):
                cloud.append(((1 + RING * math.cos(b)) * math.cos(a), (1 + RING * math.cos(b)) * math.sin(a), RING * math.sin(b)))
        else:
            u = on_sphere(random_)
            s = bump(u) if shape == "bumpy" else 1
            cloud.append(tuple(s * x for x in u))
    return cloud


def spread(shape, random_, points):
    """Dart throwing: no two points nearer than 0.75 of the spacing of a square grid."""
    area = 4 * math.pi if shape != "torus" else 4 * math.pi ** 2 * RING
    least = 0.75 * math.sqrt(area / points)
    cells, cloud, misses = {}, [], 0
    while misses < 400:
        for p in random_on(shape, random_, 100):
            at = tuple(int(x // least) for x in p)
            near = (q for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) for q in cells.get((at[0] + i, at[1] + j, at[2] + k), ()))
            if any(math.dist(p, q) < least for q in near):
                misses += 1
            else:
                misses = 0
                cells.setdefault(at, []).append(p)
                cloud.append(p)
    return cloud


SHAPES = {"sphere": from_sphere, "torus": from_torus, "bumpy": from_bumpy}


def read_mesh(data):
    start = data.index(b"end_header\n") + 11
    lines = [line.split() for line in data[:start].decode().split("\n")]
    first_face = next(i for i, line in enumerate(lines) if line[:2] == ["element", "face"])
    vertex = "<" + "".join({"float": "f", "double": "d", "uchar": "B"}[line[1]] for line in lines[:first_face] if line[:1] == ["property"])
    counts = {line[1]: int(line[2]) for line in lines if line[:1] == ["element"]}
    size = struct.calcsize(vertex)
    positions = [struct.unpack_from(vertex, data, start + i * size)[:3] for i in range(counts["vertex"])]
    start += counts["vertex"] * size
    return positions, [struct.unpack_from("<3i", data, start + 13 * i + 1) for i in range(counts["face"])]


def shape_of(a, b, c):
    l = sorted((math.dist(a, b), math.dist(b, c), math.dist(c, a)))
    s = sum(l) / 2
    area = math.sqrt(max(0, s * (s - l[0]) * (s - l[1]) * (s - l[2])))
    if area == 0:
        return 0, 0
    return area / s / l[2], l[0] / (l[0] * l[1] * l[2] / (4 * area))


def tried(program, method, folder, shape, sampling, share_of_diameter, points, seed, more):
    random_ = random.Random(f"{shape} {sampling} {share_of_diameter} {points} {seed}")
    cloud = (random_on if sampling == "random" else spread)(shape, random_, points)
    diameter = 2 if shape != "torus" else 2 * (1 + RING)
    centre = random_on(shape, random_, 1)[0]
    radius = share_of_diameter * diameter / 2
    rest = [p for p in cloud if math.dist(p, centre) > radius]
    source, mesh, report = folder / "cloud.ply", folder / "mesh.ply", folder / "report.json"
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rest)}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    source.write_bytes(head.encode() + b"".join(struct.pack("<3f", *p) for p in rest))
    known = {struct.unpack("<3f", struct.pack("<3f", *p)) for p in rest}
    command = [program, "reconstruct", source, "-o", mesh, "--method", method, "--report", report, "--param", "fill_holes=all"]
    for each in more:
        command += ["--param", each]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    report = json.loads(report.read_text())
    positions, triangles = read_mesh(mesh.read_bytes())
    new = [p not in known for p in positions]
    off = [SHAPES[shape](p) / diameter for p, is_new in zip(positions, new) if is_new]
    patch, others = [], []
    for t in triangles:
        (patch if any(new[v] for v in t) else others).append(shape_of(*(positions[v] for v in t)))
    lost = len(cloud) - len(rest)
    inside = sum(1 for p, is_new in zip(positions, new) if is_new and math.dist(p, centre) <= radius)
    low = lambda k, of: sorted(q[k] for q in of)[len(of) // 20] if of else float("nan")
    return (f"{shape:6} {sampling:6} {share_of_diameter:4.2f} {points:5} lost {lost:3} new {inside:3} elsewhere {len(off) - inside:2} "
            f"density {inside / lost:4.2f} mean {sum(off) / len(off) if off else math.nan:.5f} worst {max(off, default=math.nan):.5f} "
            f"r/L {low(0, patch) / low(0, others):4.2f} l/R {low(1, patch) / low(1, others):4.2f} closed {report['mesh']['closed']} "
            f"crossings {report['quality']['self_intersections']}")


def main(program, method, first, last, more):
    with tempfile.TemporaryDirectory() as name:
        for seed in range(first, last + 1):
            for shape in SHAPES:
                for sampling in ("spread", "random"):
                    for points in (10000, 40000):
                        for part in (0.05, 0.1):
                            print(tried(program, method, pathlib.Path(name), shape, sampling, part, points, seed, more), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5:])
