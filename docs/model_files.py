# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the formats in which public models come, and writes what the tests look for: PLY, binary, float32.

Points are those of the source, in its order, rounded to float32; triangles too, turned outwards as a whole where they
enclose a negative volume. Not a reader of clouds in general: docs/data.json pins the bytes that go in and come out.
"""
import struct
from array import array

INT, FLOAT = "<i", "<f"


class Model:
    def __init__(self, points, triangles=(), colors=(), normals=()):
        self.points, self.triangles, self.colors, self.normals = points, list(triangles), colors, normals


def rounded(x):
    return struct.unpack(FLOAT, struct.pack(FLOAT, x))[0]


def fans(polygons):
    return [(face[0], face[i], face[i + 1]) for face in polygons for i in range(1, len(face) - 1)]


def read_off(data):
    words = (word for line in data.decode("ascii").splitlines() for word in line.split("#")[0].split())
    if next(words, "") != "OFF":
        raise ValueError("the file does not begin with OFF")
    vertices, faces = int(next(words)), int(next(words))
    next(words)
    points = [tuple(float(next(words)) for _ in range(3)) for _ in range(vertices)]
    return Model(points, fans([[int(next(words)) for _ in range(int(next(words)))] for _ in range(faces)]))


def read_obj(data):
    rows = [line.split() for line in data.decode("ascii").splitlines()]
    points = [tuple(map(float, row[1:4])) for row in rows if row[:1] == ["v"]]
    return Model(points, fans([[int(each.split("/")[0]) - 1 for each in row[1:]] for row in rows if row[:1] == ["f"]]))


def read_mesh(data):
    """Medit: the vertices and the surface triangles."""
    lines = data.decode("ascii").splitlines()

    def rows(name):
        at = lines.index(name)
        return [line.split() for line in lines[at + 2 : at + 2 + int(lines[at + 1])]]

    return Model([tuple(map(float, row[:3])) for row in rows("Vertices")],
                 [tuple(int(each) - 1 for each in row[:3]) for row in rows("Triangles")])


def read_xyz(data):
    return Model([tuple(map(float, line.split()[:3])) for line in data.decode("ascii").splitlines() if line.strip()])


def read_stl(data):
    """Binary: equal corners are one vertex; vertices by x, y, z."""
    count = struct.unpack_from("<I", data, 80)[0]
    corners = [struct.unpack_from("<3f", data, 84 + 50 * t + 12 + 12 * corner) for t in range(count) for corner in range(3)]
    points = sorted(set(corners))
    numbers = {point: number for number, point in enumerate(points)}
    return Model(points, [tuple(numbers[each] for each in corners[3 * t : 3 * t + 3]) for t in range(count)])


def read_splats(data):
    """Expe points: position, radius, normal, colour."""
    at = data.index(b"data\n") + len(b"data\n")
    rows = list(struct.iter_unpack("<3f4x3f4B", data[at:]))
    return Model([row[:3] for row in rows], colors=[row[6:9] for row in rows], normals=[row[3:6] for row in rows])


def lzf(data, size):
    """LibLZF's scheme: runs of bytes as they are, and copies of what was written before."""
    out, at = bytearray(), 0
    while at < len(data):
        head = data[at]
        at += 1
        if head < 32:
            out += data[at : at + head + 1]
            at += head + 1
            continue
        length = (head >> 5) + 2
        if length == 9:
            length += data[at]
            at += 1
        start = len(out) - ((head & 31) << 8) - data[at] - 1
        at += 1
        for i in range(length):
            out.append(out[start + i])
    if len(out) != size:
        raise ValueError(f"{len(out)} bytes were unpacked, the file says {size}")
    return bytes(out)


def read_pcd(data):
    """Fields x y z rgba, packed one field after the other."""
    at = data.index(b"DATA binary_compressed\n") + len(b"DATA binary_compressed\n")
    packed, size = struct.unpack_from("<2I", data, at)
    columns = lzf(data[at + 8 : at + 8 + packed], size)
    count = size // 16
    x, y, z = (array("f", columns[4 * count * axis : 4 * count * (axis + 1)]) for axis in range(3))
    colors = [(word >> 16 & 255, word >> 8 & 255, word & 255) for word in array("I", columns[12 * count :])]
    return Model(list(zip(x, y, z)), colors=colors)


PLY_TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}


def ply_elements(header):
    elements = []
    for line in header.split("\n"):
        words = line.split()
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    return elements


def ply_values(data, at, is_text):
    """A function that takes the next value of a type."""
    words = iter(data[at:].split()) if is_text else None
    place = [at]

    def take(kind):
        if is_text:
            return float(next(words)) if kind in ("float", "double") else int(next(words))
        value = struct.unpack_from("<" + PLY_TYPES[kind], data, place[0])[0]
        place[0] += struct.calcsize(PLY_TYPES[kind])
        return value

    return take


def strip_triangles(strip):
    """Triangles of strips, which -1 divides; every other one is turned round."""
    triangles, begin = [], 0
    for i, vertex in enumerate(strip):
        if vertex < 0:
            begin = i + 1
        elif i - begin >= 2:
            a, b, c = strip[i - 2 : i + 1]
            triangles.append((a, b, c) if (i - begin) % 2 == 0 else (b, a, c))
    return triangles


def read_ply(data):
    end = data.index(b"end_header\n")
    header = data[:end].decode("ascii")
    take = ply_values(data, end + len(b"end_header\n"), "format ascii" in header)
    points, triangles = [], []
    for name, count, properties in ply_elements(header):
        for _ in range(count):
            row = {}
            for kind in properties:
                row[kind[-1]] = [take(kind[2]) for _ in range(take(kind[1]))] if kind[0] == "list" else take(kind[0])
            if name == "vertex":
                points.append((row["x"], row["y"], row["z"]))
            elif name == "face":
                triangles += fans([row["vertex_indices"]])
            elif name == "tristrips":
                triangles += strip_triangles(row["vertex_indices"])
    return Model(points, triangles)


READERS = {".off": read_off, ".obj": read_obj, ".mesh": read_mesh, ".xyz": read_xyz, ".stl": read_stl, ".pts": read_splats,
           ".pcd": read_pcd, ".ply": read_ply}


def volume(points, triangles):
    sum_ = 0.0
    for a, b, c in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = points[a], points[b], points[c]
        sum_ += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return sum_


def header(model, triangles):
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(model.points)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"property float n{axis}" for axis in "xyz"] if model.normals else []
    lines += [f"property uchar {each}" for each in ("red", "green", "blue")] if model.colors else []
    if triangles:
        lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "end_header", ""]).encode("ascii")


def cloud_bytes(model):
    """The points alone, with what else the source says of them."""
    out = bytearray(header(model, ()))
    for i, point in enumerate(model.points):
        out += struct.pack("<3f", *point)
        out += struct.pack("<3f", *model.normals[i]) if model.normals else b""
        out += bytes(model.colors[i]) if model.colors else b""
    return bytes(out)


def mesh_bytes(model):
    """The source's mesh on the same points, outwards."""
    points = [tuple(map(rounded, point)) for point in model.points]
    triangles = model.triangles
    if is_closed(triangles) and volume(points, triangles) < 0:
        triangles = [(a, c, b) for a, b, c in triangles]
    out = bytearray(header(model, triangles))
    for point in points:
        out += struct.pack("<3f", *point)
    for triangle in triangles:
        out += struct.pack("<B3i", 3, *triangle)
    return bytes(out)


def is_closed(triangles):
    edges = {}
    for t in triangles:
        for i in range(3):
            edge = frozenset((t[i], t[(i + 1) % 3]))
            edges[edge] = edges.get(edge, 0) + 1
    return all(uses == 2 for uses in edges.values())
