"""Inputs that are large in one way each, for tools/bench scale: grids, materials, textures, an environment."""
import json
import math
import struct
import sys
import zlib
from array import array
from pathlib import Path

FLOAT, UINT32 = 5126, 5125
# So many rows of a picture differ: making one takes longer than writing it.
ROWS = 64


class Scene:
    """A glTF in the making: square metres in the xz plane, which look up, and a lamp above them."""

    def __init__(self, squares_a_side):
        self.chunks, self.length = [], 0
        height = max(1.0, squares_a_side / 2)
        lamp = {"type": "point", "intensity": 20.0 * height * height}
        middle = squares_a_side / 2
        self.document = {
            "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [lamp]}},
            "nodes": [{"translation": [middle, height, middle], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
            "meshes": [], "materials": [], "accessors": [], "bufferViews": []}

    def add(self, key, value):
        """Adds to one of the document's lists; gives the index."""
        self.document.setdefault(key, []).append(value)
        return len(self.document[key]) - 1

    def view(self, data):
        """A buffer view of these bytes."""
        data = bytes(data)
        data += bytes(-len(data) % 4)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": self.length, "byteLength": len(data)})
        self.chunks.append(data)
        self.length += len(data)
        return view

    def accessor(self, values, kind):
        """An accessor of an array of floats or of unsigned integers."""
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[kind]
        component = FLOAT if values.typecode == "f" else UINT32
        if sys.byteorder == "big":
            values.byteswap()
        return self.add("accessors", {"bufferView": self.view(values), "componentType": component,
                                      "count": len(values) // width, "type": kind})

    def square(self):
        """The parts of a primitive that is one square."""
        attributes = {"POSITION": self.accessor(array("f", [0, 0, 1, 1, 0, 1, 1, 0, 0, 0, 0, 0]), "VEC3"),
                      "TEXCOORD_0": self.accessor(array("f", [0, 1, 1, 1, 1, 0, 0, 0]), "VEC2")}
        return {"attributes": attributes, "indices": self.accessor(array("I", [0, 1, 2, 0, 2, 3]), "SCALAR")}

    def write(self, file):
        """Writes the scene as a GLB."""
        nodes = range(len(self.document["nodes"]))
        document = {**self.document, "scene": 0, "scenes": [{"nodes": list(nodes)}], "buffers": [{"byteLength": self.length}]}
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        with open(file, "wb") as out:
            out.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + self.length, len(text), 0x4E4F534A))
            out.write(text)
            out.write(struct.pack("<II", self.length, 0x004E4942))
            for chunk in self.chunks:
                out.write(chunk)


def grid_primitive(scene, side):
    """One primitive of side x side squares."""
    positions = array("f")
    for z in range(side + 1):
        positions.extend(value for x in range(side + 1) for value in (x, 0, z))
    indices = array("I")
    corners = (0, side + 1, side + 2, 0, side + 2, 1)
    for z in range(side):
        first = z * (side + 1)
        indices.extend(first + x + corner for x in range(side) for corner in corners)
    normals = array("f", [0, 1, 0]) * (side + 1) ** 2
    attributes = {"POSITION": scene.accessor(positions, "VEC3"), "NORMAL": scene.accessor(normals, "VEC3")}
    return {"attributes": attributes, "indices": scene.accessor(indices, "SCALAR")}


def grid(file, side, copies=1):
    """A grid of 2 side^2 triangles, at several places by EXT_mesh_gpu_instancing where there is more than one."""
    scene = Scene(side * math.isqrt(copies))
    mesh = scene.add("meshes", {"primitives": [grid_primitive(scene, side)]})
    node = {"mesh": mesh}
    if copies > 1:
        row = math.isqrt(copies)
        places = array("f", (value for i in range(copies) for value in (i % row * side, 0, i // row * side)))
        node["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": scene.accessor(places, "VEC3")}}}
        scene.document["extensionsUsed"].append("EXT_mesh_gpu_instancing")
    scene.add("nodes", node)
    scene.write(file)


def moving(file, side, copies):
    """So many grids of 2 side^2 triangles each, in a square, that rise in turn and come back after two seconds."""
    row = math.isqrt(copies - 1) + 1
    scene = Scene(side * row)
    mesh = scene.add("meshes", {"primitives": [grid_primitive(scene, side)]})
    times = scene.accessor(array("f", [0, 1, 2]), "SCALAR")
    samplers, channels = [], []
    for i in range(copies):
        x, z = i % row * side, i // row * side
        heights = [0, side * (i + 1) / copies, 0]
        places = scene.accessor(array("f", (value for y in heights for value in (x, y, z))), "VEC3")
        node = scene.add("nodes", {"mesh": mesh, "translation": [x, 0, z]})
        channels.append({"sampler": len(samplers), "target": {"node": node, "path": "translation"}})
        samplers.append({"input": times, "output": places})
    scene.add("animations", {"name": "rise", "samplers": samplers, "channels": channels})
    scene.write(file)


def materials(file, count, textures=()):
    """So many squares, each with a material of its own, and with a texture of its own where there are any."""
    row = math.isqrt(count - 1) + 1
    scene = Scene(row)
    square = scene.square()
    for i in range(count):
        pbr = {"baseColorFactor": [i * step % 1 for step in (0.37, 0.61, 0.83)] + [1]}
        if i < len(textures):
            image = scene.add("images", {"bufferView": scene.view(textures[i]), "mimeType": "image/png"})
            pbr = {"baseColorTexture": {"index": scene.add("textures", {"source": image})}}
        material = scene.add("materials", {"pbrMetallicRoughness": pbr})
        mesh = scene.add("meshes", {"primitives": [{**square, "material": material}]})
        scene.add("nodes", {"mesh": mesh, "translation": [i % row, 0, i // row]})
    scene.write(file)


def png(width, height, shade):
    """The bytes of a PNG of ramps, whose blue is `shade`."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = []
    for y in range(min(ROWS, height)):
        row = bytearray(1 + 3 * width)
        row[1::3] = bytes(x * 256 // width for x in range(width))
        row[2::3] = bytes([y * 256 // ROWS]) * width
        row[3::3] = bytes([shade % 256]) * width
        rows.append(bytes(row))
    packer = zlib.compressobj(1)
    data = b"".join([*(packer.compress(rows[y % ROWS]) for y in range(height)), packer.flush()])
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def exr(file, width, height):
    """An OpenEXR file of half floats, in rows that are compressed by ZIPS: a sky that is brighter in the middle."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data

    channels = b"".join(name + b"\0" + struct.pack("<IIII", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = b"".join([
        b"\x76\x2f\x31\x01\x02\0\0\0", attribute(b"channels", b"chlist", channels),
        attribute(b"compression", b"compression", b"\x02"), attribute(b"dataWindow", b"box2i", window),
        attribute(b"displayWindow", b"box2i", window), attribute(b"lineOrder", b"lineOrder", b"\0"),
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", bytes(8)), attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)),
        b"\0"])
    rows = [exr_row(width, y / ROWS) for y in range(ROWS)]
    chosen = [rows[y * ROWS // height] for y in range(height)]
    with open(file, "wb") as out:
        out.write(head)
        at = len(head) + 8 * height
        for row in chosen:
            out.write(struct.pack("<Q", at))
            at += 8 + len(row)
        for y, row in enumerate(chosen):
            out.write(struct.pack("<iI", y, len(row)) + row)


def exr_row(width, brightness):
    """A row as ZIPS has it: the even bytes before the odd ones, each byte less the one before, deflated."""
    values = [struct.pack("<e", 0.1 + brightness * (0.5 + 0.5 * math.sin(x / width * math.tau))) for x in range(width)]
    raw = b"".join(values) * 3
    split = raw[0::2] + raw[1::2]
    deltas = bytes([split[0], *((b - a + 128) & 255 for a, b in zip(split, split[1:]))])
    packed = zlib.compress(deltas, 1)
    # What does not become smaller is stored as it is.
    return packed if len(packed) < len(raw) else raw


def textures(file, count, edge):
    """So many squares with a texture each."""
    materials(file, count, [png(edge, edge, i) for i in range(count)])


def texture(file, width, height):
    """One square with one texture."""
    materials(file, 1, [png(width, height, 128)])


def environment(file, width, height):
    """A few squares under a sky of this size: the picture beside the scene, of the same name."""
    materials(file, 4)
    exr(Path(file).with_suffix(".exr"), width, height)
