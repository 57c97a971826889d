# SPDX-License-Identifier: MIT
"""Reads what codesign writes, strictly: each reader raises AssertionError on anything that another program might
trip over."""
import base64
import collections
import csv
import json
import os
import struct
import subprocess
import xml.etree.ElementTree as ElementTree
import zlib

SIZES = {"Float32": 4, "Int32": 4, "UInt8": 1}
CODES = {"Float32": "f", "Int32": "i", "UInt8": "B"}


def run(program, *arguments, **keywords):
    """The finished process, with text output."""
    keywords.setdefault("timeout", 600)
    return subprocess.run([program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          **keywords)


def read_history(folder):
    """(column names, rows of text)."""
    with open(os.path.join(folder, "history.csv"), newline="") as stream:
        rows = list(csv.reader(stream))
    assert all(len(row) == len(rows[0]) for row in rows), "rows of different length"
    return rows[0], rows[1:]


def history_without_seconds(folder):
    names, rows = read_history(folder)
    clocks = {names.index("seconds"), names.index("cpu_seconds")}
    return [[text for k, text in enumerate(row) if k not in clocks] for row in [names, *rows]]


def read_summary(folder):
    def refuse(text):
        raise AssertionError("not JSON: " + text)

    def unique(pairs):
        assert len({key for key, _ in pairs}) == len(pairs), "a key appears twice"
        return dict(pairs)

    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as stream:
        return json.load(stream, parse_constant=refuse, object_pairs_hook=unique)


def read_stl(path):
    """Triangles of a binary STL, each a triple of corners; the surface is closed, oriented and faces outward."""
    with open(path, "rb") as stream:
        data = stream.read()
    assert not data.startswith(b"solid")
    count = struct.unpack_from("<I", data, 80)[0]
    assert len(data) == 84 + 50 * count and count > 0, "size does not fit the count"
    triangles, edges, volume = [], collections.Counter(), 0.0
    for i in range(count):
        numbers = struct.unpack_from("<12f", data, 84 + 50 * i)
        a, b, c = numbers[3:6], numbers[6:9], numbers[9:12]
        triangles.append((a, b, c))
        for edge in ((a, b), (b, c), (c, a)):
            edges[edge] += 1
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                   + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6.0
    assert all(edges[(b, a)] == n for (a, b), n in edges.items() if a != b), "the surface is not closed"
    assert volume > 0.0, "the surface faces inward"
    return triangles


def count_shells(triangles):
    """Bodies of a closed surface: its connected parts that enclose a volume (the walls of a cavity take one away)."""
    parent = {}

    def root(corner):
        while parent[corner] != corner:
            parent[corner] = corner = parent[parent[corner]]
        return corner

    for triangle in triangles:
        for corner in triangle:
            parent.setdefault(corner, corner)
        for corner in triangle[1:]:
            parent[root(corner)] = root(triangle[0])
    volumes = collections.Counter()
    for a, b, c in triangles:
        volumes[root(a)] += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                             + a[2] * (b[0] * c[1] - b[1] * c[0]))
    return sum(volume > 0.0 for volume in volumes.values())


def read_vtu(path):
    """Arrays of an unstructured grid of triangles by name, checked for consistency."""
    root = ElementTree.parse(path).getroot()
    assert root.tag == "VTKFile" and root.get("type") == "UnstructuredGrid" and root.get("header_type") == "UInt64"
    order = {"LittleEndian": "<", "BigEndian": ">"}[root.get("byte_order")]
    piece = root.find("UnstructuredGrid/Piece")
    n_points, n_cells = int(piece.get("NumberOfPoints")), int(piece.get("NumberOfCells"))
    arrays = {}
    for array in piece.iter("DataArray"):
        assert array.get("format") == "binary"
        kind = array.get("type")
        data = base64.b64decode(array.text.strip(), validate=True)
        size = struct.unpack_from(order + "Q", data)[0]
        assert len(data) == 8 + size and size % SIZES[kind] == 0, "length does not fit the header"
        arrays[array.get("Name")] = struct.unpack(f"{order}{size // SIZES[kind]}{CODES[kind]}", data[8:])
    assert all(len(arrays[name]) == 3 * n_points for name in ("Points", "displacement", "velocity"))
    assert len(arrays["connectivity"]) == 3 * n_cells
    assert 0 <= min(arrays["connectivity"]) and max(arrays["connectivity"]) < n_points
    assert arrays["offsets"] == tuple(range(3, 3 * n_cells + 1, 3))
    assert set(arrays["types"]) == {5}
    return arrays


def read_pvd(path):
    """[(time, path of the frame)]."""
    root = ElementTree.parse(path).getroot()
    assert root.tag == "VTKFile" and root.get("type") == "Collection"
    folder = os.path.dirname(path)
    return [(float(item.get("timestep")), os.path.join(folder, item.get("file"))) for item in root.iter("DataSet")]


def read_png(path):
    """(width, height, rows of pixels), 8 bits a channel; a pixel is a bytes object."""
    with open(path, "rb") as stream:
        data = stream.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG signature"
    position, packed, header = 8, b"", None
    while position < len(data):
        size, kind = struct.unpack_from(">I4s", data, position)
        content = data[position + 8:position + 8 + size]
        assert zlib.crc32(kind + content) == struct.unpack_from(">I", data, position + 8 + size)[0], "damaged"
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", content)
        if kind == b"IDAT":
            packed += content
        position += 12 + size
    width, height, depth, colour, _, _, interlaced = header
    assert depth == 8 and interlaced == 0 and colour in (0, 2, 3, 6)
    step = {0: 1, 2: 3, 3: 1, 6: 4}[colour]
    raw, rows, previous = zlib.decompress(packed), [], bytearray(width * step)
    for y in range(height):
        start = y * (width * step + 1)
        rows.append(unfilter(raw[start], bytearray(raw[start + 1:start + 1 + width * step]), previous, step))
        previous = rows[-1]
    return width, height, [[bytes(row[i:i + step]) for i in range(0, len(row), step)] for row in rows]


def unfilter(kind, line, previous, step):
    """One row of a PNG (its specification, section 9)."""
    for i in range(len(line)):
        left = line[i - step] if i >= step else 0
        up, corner = previous[i], previous[i - step] if i >= step else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            base = left + up - corner
            guess = min((abs(base - left), 0, left), (abs(base - up), 1, up), (abs(base - corner), 2, corner))[2]
        else:
            guess = 0
        line[i] = line[i] + guess & 0xff
    return line
