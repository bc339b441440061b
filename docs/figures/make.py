#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes every figure of the documentation from generated shapes: make.py OUT --build build/release [FIGURE ...]

`./dev figures` builds what it needs and runs it. All random numbers have fixed seeds; the renderer is tests/figures/draw.
"""
import argparse
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import minimum_boundary as sheets

HERE = Path(__file__).parent
SAMPLES = HERE.parent.parent / "client-examples/samples"


class Studio:
    def __init__(self, out, build, scratch):
        self.out, self.build, self.scratch = out, build, scratch

    def script(self, name, *words):
        subprocess.run([sys.executable, HERE / name, *map(str, words)], check=True)

    def mesh(self, cloud, name, method, **parameters):
        mesh = self.scratch / name
        command = [self.build / "surfaced", "reconstruct", cloud, "-o", mesh, "--method", method]
        for key, value in parameters.items():
            command += ["--param", f"{key}={value}"]
        subprocess.run(command, check=True)
        return mesh

    def draw(self, file, size, view, *flags):
        picture = self.scratch / "tile.png"
        subprocess.run([self.build / "draw", file, picture, "--size", str(size), "--view", view, "--up", "z", *flags], check=True)
        return sheets.read_png(picture)

    def row(self, name, tiles, top=0, bottom=None):
        """Tiles beside each other, their rows from top to bottom."""
        rows = [b"".join(parts) for parts in zip(*tiles)][top:bottom]
        path = self.out / f"{name}.png"
        sheets.write_png(path, rows)
        print(f"  {path}: {path.stat().st_size} bytes")


def knot(s):
    cloud = SAMPLES / "knot.ply"
    s.row("knot-points", [s.draw(cloud, 480, "20,75")])
    s.row("knot-mesh", [s.draw(s.mesh(cloud, "knot.glb", "minimum-boundary"), 480, "20,75")])


def sparse(s):
    """400 points of a figure of 4,000: what the README begins with."""
    cloud = s.scratch / "sparse.ply"
    sheets.write_cloud(cloud, sheets.subset(sheets.rabbit_points(4000), 400))
    s.row("sparse-points", [s.draw(cloud, 480, sheets.SIDE)])
    s.row("sparse-mesh", [s.draw(s.mesh(cloud, "sparse.glb", "minimum-boundary"), 480, sheets.SIDE, "--wire")])


def viewer(s):
    subprocess.run(["node", HERE / "viewer.mjs", s.build / "surfaced", s.out / "viewer.png"], check=True)
    print(f"  {s.out / 'viewer.png'}: {(s.out / 'viewer.png').stat().st_size} bytes")


def local_delaunay(s):
    for kind, count, holes, view, wire in (("paraboloid", 1500, "none", "40,25", ["--wire"]), ("bitorus", 3000, "small", "70,40", ["--wire"]),
                                           ("bumpy", 187644, "small", "30,20", [])):
        cloud = s.scratch / f"{kind}.ply"
        s.script("shapes.py", kind, count, cloud)
        mesh = s.mesh(cloud, f"{kind}.glb", "local-delaunay", fill_holes=holes)
        s.row(f"local-delaunay-{kind}", [s.draw(mesh, 420, view, *wire)])


def intrinsic_delaunay(s):
    s.script("points.py", s.scratch)

    def tile(name, view):
        return s.draw(s.mesh(s.scratch / f"{name}.ply", f"{name}-mesh.glb", "intrinsic-delaunay"), 360, view, "--wire")
    s.row("intrinsic-delaunay-table2", [tile("sphere", "30,20"), tile("torus", "30,40"), tile("knot", "30,50")])
    s.row("intrinsic-delaunay-patches", [tile("patch", "40,30"), tile("bowl", "40,35")])


def hole_filling(s):
    cloud = s.scratch / "hole.ply"
    s.script("tri_torus.py", 20000, cloud, 3.4, 0, 0.4, 0.45)
    meshes = [s.mesh(cloud, f"hole{k}.glb", "intrinsic-delaunay", **parameters) for k, parameters in
              enumerate(({"fill_holes": "none"}, {"fill_holes": "all", "rotation": "none"}, {"fill_holes": "all"}))]
    s.row("hole-filling", [s.draw(mesh, 420, "60,40") for mesh in meshes], 105, 315)


def upsampling(s):
    cloud = s.scratch / "tri.ply"
    s.script("tri_torus.py", 6401, cloud)
    meshes = [s.mesh(cloud, "before.glb", "intrinsic-delaunay"),
              s.mesh(cloud, "after.glb", "intrinsic-delaunay", upsample="jet", epsilon=0.072)]
    s.row("upsampling", [s.draw(mesh, 520, "90,80", "--wire") for mesh in meshes], 120, 400)


def random_torus(count):
    """Random points of a torus with radii 1 and 0.3, even over its area."""
    rng, points = random.Random(2), []
    while len(points) < count:
        u, v = rng.uniform(0, 2 * math.pi), rng.uniform(0, 2 * math.pi)
        r = 1 + 0.3 * math.cos(v)
        if rng.random() < r / 1.3:
            points.append((r * math.cos(u), r * math.sin(u), 0.3 * math.sin(v)))
    return points


def minimum_boundary_stages(s):
    tiles = []
    for count, parameters in ((1500, {"stop_after": "boundary-complex"}), (1500, {"stop_after": "inflated"}), (1500, {}), (150, {}), (60, {})):
        cloud = s.scratch / f"torus{count}.ply"
        sheets.write_cloud(cloud, random_torus(count))
        tiles.append(s.draw(s.mesh(cloud, "torus.ply", "minimum-boundary", **parameters), 300, "20,40", "--wire"))
    s.row("minimum-boundary-stages", tiles)


def minimum_boundary(s):
    s.script("minimum_boundary.py", s.out, "--surfaced", s.build / "surfaced", "--tool", s.build / "minimum_boundary_figures",
             "--renderer", s.build / "draw")


FIGURES = {each.__name__: each for each in (knot, sparse, local_delaunay, intrinsic_delaunay, hole_filling, upsampling, minimum_boundary_stages, minimum_boundary)}

# Wants a browser and `npm ci` in tests/viewer, so only by its name.
ON_REQUEST = {"viewer": viewer}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("figures", nargs="*", metavar="FIGURE", help=", ".join([*FIGURES, *ON_REQUEST]))
    parser.add_argument("--build", type=Path, default=HERE.parent.parent / "build/release")
    options = parser.parse_intermixed_args()
    known = {**FIGURES, **ON_REQUEST}
    if unknown := set(options.figures) - set(known):
        parser.error(f"{', '.join(sorted(unknown))}: there are {', '.join(known)}")
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.figures or FIGURES:
        print(name, flush=True)
        with tempfile.TemporaryDirectory() as scratch:
            known[name](Studio(options.out.resolve(), options.build.resolve(), Path(scratch)))


if __name__ == "__main__":
    main()
