"""Collects meshes, materials and nodes, and writes them as a GLB."""

import json
import math
import struct

from .mesh import cross, normalize, sub


def yaw(degrees):
    """Quaternion of a turn about y (+z towards +x)."""
    a = math.radians(degrees) / 2.0
    return (0.0, math.sin(a), 0.0, math.cos(a))


def look(direction):
    """Quaternion that turns -z towards `direction` and keeps y up."""
    back = normalize(tuple(-c for c in direction))
    right = normalize(cross((0.0, 1.0, 0.0), back))
    up = cross(back, right)
    m = (right, up, back)
    trace = m[0][0] + m[1][1] + m[2][2]
    w = math.sqrt(max(0.0, 1.0 + trace)) / 2.0
    if w > 1e-3:
        return ((m[1][2] - m[2][1]) / (4 * w), (m[2][0] - m[0][2]) / (4 * w),
                (m[0][1] - m[1][0]) / (4 * w), w)
    x = math.sqrt(max(0.0, 1 + m[0][0] - m[1][1] - m[2][2])) / 2.0
    y = math.sqrt(max(0.0, 1 - m[0][0] + m[1][1] - m[2][2])) / 2.0
    z = math.sqrt(max(0.0, 1 - m[0][0] - m[1][1] + m[2][2])) / 2.0
    return (x, math.copysign(y, m[0][1] + m[1][0]), math.copysign(z, m[0][2] + m[2][0]), 0.0)


def _rounded(values):
    return [round(v, 6) + 0.0 for v in values]


class Document:
    """A glTF document under construction."""

    def __init__(self):
        self.binary = bytearray()
        self.views, self.accessors, self.meshes = [], [], []
        self.images, self.textures, self.materials, self.nodes = [], [], [], []
        self.cameras, self.lights = [], []
        self._geometry, self._mesh_ids = {}, {}
        self.triangles = 0

    def _view(self, data, target=None):
        while len(self.binary) % 4:
            self.binary.append(0)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.binary += data
        self.views.append(view)
        return len(self.views) - 1

    def texture(self, name, png):
        """Adds an image and returns its texture index."""
        self.images.append({"name": name, "mimeType": "image/png", "bufferView": self._view(png)})
        self.textures.append({"sampler": 0, "source": len(self.images) - 1})
        return len(self.textures) - 1

    def material(self, name, color=(1.0, 1.0, 1.0), texture=None, normal=None, scale=1.0,
                 mask=False, two_sided=False):
        """Adds a diffuse material (linear colour) and returns its index."""
        pbr = {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        entry = {"name": name, "pbrMetallicRoughness": pbr}
        if normal is not None:
            entry["normalTexture"] = {"index": normal, "scale": scale}
        if mask:
            entry["alphaMode"] = "MASK"
            entry["alphaCutoff"] = 0.5
        if two_sided:
            entry["doubleSided"] = True
        self.materials.append(entry)
        return len(self.materials) - 1

    def _accessors(self, mesh):
        known = self._geometry.get(id(mesh))
        if known:
            return known[0]
        positions, normals, uvs = mesh.buffers()
        count = len(mesh.vertices)
        packed = [struct.unpack("<3f", positions[12 * i:12 * i + 12]) for i in range(count)]
        base = len(self.accessors)
        self.accessors.append({
            "bufferView": self._view(positions, 34962), "componentType": 5126, "count": count,
            "type": "VEC3", "min": [min(p[k] for p in packed) for k in range(3)],
            "max": [max(p[k] for p in packed) for k in range(3)]})
        for data, kind in ((normals, "VEC3"), (uvs, "VEC2")):
            self.accessors.append({"bufferView": self._view(data, 34962), "componentType": 5126,
                                   "count": count, "type": kind})
        wide = count > 65535
        data = struct.pack(f"<{len(mesh.indices)}{'I' if wide else 'H'}", *mesh.indices)
        self.accessors.append({"bufferView": self._view(data, 34963), "type": "SCALAR",
                               "componentType": 5125 if wide else 5123,
                               "count": len(mesh.indices)})
        entry = {"attributes": {"POSITION": base, "NORMAL": base + 1, "TEXCOORD_0": base + 2},
                 "indices": base + 3}
        self._geometry[id(mesh)] = (entry, mesh)
        return entry

    def place(self, name, parts, at=(0.0, 0.0, 0.0), rotation=None, scale=1.0):
        """Adds a node with `parts`, a sequence of (mesh, material index) pairs.

        Equal parts share one glTF mesh, and equal meshes share their accessors.
        """
        key = tuple((id(mesh), material) for mesh, material in parts)
        if key not in self._mesh_ids:
            primitives = [{**self._accessors(mesh), "material": material}
                          for mesh, material in parts]
            self._mesh_ids[key] = len(self.meshes)
            self.meshes.append({"name": name, "primitives": primitives})
        node = {"name": name, "mesh": self._mesh_ids[key]}
        if any(at):
            node["translation"] = _rounded(at)
        if rotation:
            node["rotation"] = _rounded(rotation)
        if scale != 1.0:
            node["scale"] = [scale] * 3
        self.nodes.append(node)
        self.triangles += sum(len(mesh.indices) // 3 for mesh, _ in parts)

    def camera(self, name, eye, target, yfov_degrees):
        """Adds a camera node, 16:9."""
        self.cameras.append({"name": name, "type": "perspective", "perspective": {
            "aspectRatio": round(16 / 9, 6), "yfov": round(math.radians(yfov_degrees), 6),
            "znear": 0.05}})
        self.nodes.append({"name": name, "camera": len(self.cameras) - 1,
                           "translation": _rounded(eye),
                           "rotation": _rounded(look(sub(target, eye)))})

    def sun(self, name, direction, color, intensity):
        """Adds a directional light that shines along `direction`."""
        self.lights.append({"name": name, "type": "directional", "color": list(color),
                            "intensity": intensity})
        self.nodes.append({"name": name, "rotation": _rounded(look(direction)), "extensions": {
            "KHR_lights_punctual": {"light": len(self.lights) - 1}}})

    def glb(self, copyright_line):
        """The whole file."""
        while len(self.binary) % 4:
            self.binary.append(0)
        root = {
            "asset": {"version": "2.0", "generator": "gridlight tools/build_courtyard.py",
                      "copyright": copyright_line},
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": self.lights}},
            "scene": 0,
            "scenes": [{"name": "courtyard", "nodes": list(range(len(self.nodes)))}],
            "nodes": self.nodes, "cameras": self.cameras, "meshes": self.meshes,
            "materials": self.materials, "textures": self.textures, "images": self.images,
            "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.binary)}],
        }
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = (struct.pack("<II", len(text), 0x4E4F534A) + text
                + struct.pack("<II", len(self.binary), 0x004E4942) + bytes(self.binary))
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
