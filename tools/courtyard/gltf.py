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
        self.skins, self.animations, self.second_scene = [], [], None
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

    def mesh(self, name, parts):
        """The index of the glTF mesh of `parts`."""
        key = tuple((id(mesh), material) for mesh, material in parts)
        if key not in self._mesh_ids:
            primitives = [{**self._accessors(mesh), "material": material}
                          for mesh, material in parts]
            self._mesh_ids[key] = len(self.meshes)
            self.meshes.append({"name": name, "primitives": primitives})
        return self._mesh_ids[key]

    def place(self, name, parts, at=(0.0, 0.0, 0.0), rotation=None, scale=1.0):
        """Adds a node with `parts`, a sequence of (mesh, material index) pairs.

        Equal parts share one glTF mesh, and equal meshes share their accessors.
        """
        node = {"name": name, "mesh": self.mesh(name, parts)}
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

    def light(self, name, kind, color, intensity):
        """Adds a light that no node carries yet and returns its index."""
        self.lights.append({"name": name, "type": kind, "color": list(color), "intensity": intensity})
        return len(self.lights) - 1

    def begin_second_scene(self, name, without):
        """Nodes that follow are of a second scene, which has those of the first but for some, by their names."""
        kept = [i for i, node in enumerate(self.nodes) if node["name"] not in without]
        self.second_scene = {"name": name, "nodes": kept}
        self.first_count = len(self.nodes)

    def node(self, name, **properties):
        """Adds a node of the second scene and returns its index; those that are children come before their parent."""
        for key in ("translation", "rotation"):
            if key in properties:
                properties[key] = _rounded(properties[key])
        self.nodes.append({"name": name, **properties})
        return len(self.nodes) - 1

    def camera_node(self, name, eye, rotation, yfov_degrees):
        """Adds a camera to the second scene and returns its node."""
        self.camera(name, eye, (0.0, 0.0, 0.0), yfov_degrees)
        self.nodes[-1]["rotation"] = _rounded(rotation)
        return len(self.nodes) - 1

    def _vectors(self, vectors, kind, component=5126, letter="f"):
        flat = [c for vector in vectors for c in (vector if isinstance(vector, (tuple, list)) else (vector,))]
        flat = [round(c, 6) + 0.0 for c in flat] if letter == "f" else flat
        accessor = {"bufferView": self._view(struct.pack(f"<{len(flat)}{letter}", *flat)),
                    "componentType": component, "count": len(vectors), "type": kind}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _with_bounds(self, accessor, vectors):
        rows = [vector if isinstance(vector, (tuple, list)) else (vector,) for vector in vectors]
        packed = [struct.unpack(f"<{len(row)}f", struct.pack(f"<{len(row)}f", *(round(c, 6) + 0.0 for c in row)))
                  for row in rows]
        self.accessors[accessor].update(min=[min(column) for column in zip(*packed)],
                                        max=[max(column) for column in zip(*packed)])
        return accessor

    def morphed(self, name, mesh, material, shapes, at):
        """Adds a node with a mesh that goes over into `shapes`, offsets of positions and normals; returns its index."""
        targets = [{"POSITION": self._with_bounds(self._vectors(positions, "VEC3"), positions),
                    "NORMAL": self._vectors(normals, "VEC3")} for positions, normals in shapes]
        self.meshes.append({"name": name, "weights": [0.0] * len(shapes), "primitives": [
            {**self._accessors(mesh), "material": material, "targets": targets}]})
        return self.node(name, mesh=len(self.meshes) - 1, translation=at)

    def skin(self, joints, places, root):
        """Adds a skin of joints that are at these places of the mesh, unturned."""
        matrices = [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1) for x, y, z in places]
        self.skins.append({"joints": joints, "skeleton": root, "inverseBindMatrices": self._vectors(matrices, "MAT4")})
        return len(self.skins) - 1

    def skinned(self, name, mesh, material, weights, skin):
        """Adds a node with a mesh bent by a skin; `weights` are up to four pairs of joint and weight per vertex."""
        rows = [row + [(0, 0.0)] * (4 - len(row)) for row in weights]
        entry = self._accessors(mesh)
        attributes = {**entry["attributes"],
                      "JOINTS_0": self._vectors([[joint for joint, _ in row] for row in rows], "VEC4", 5121, "B"),
                      "WEIGHTS_0": self._vectors([[weight for _, weight in row] for row in rows], "VEC4")}
        self.meshes.append({"name": name, "primitives": [{**entry, "attributes": attributes, "material": material}]})
        return self.node(name, mesh=len(self.meshes) - 1, skin=skin)

    def channel(self, times, values, kind, between="LINEAR", pointer=None, **target):
        """A channel of an animation, by node and path or by pointer, with its sampler."""
        if pointer:
            target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}
        sampler = {"input": self._with_bounds(self._vectors(times, "SCALAR"), times),
                   "output": self._vectors(values, kind), "interpolation": between}
        return target, sampler

    def animation(self, name, channels):
        """Adds an animation."""
        self.animations.append({
            "name": name, "samplers": [sampler for _, sampler in channels],
            "channels": [{"sampler": i, "target": target} for i, (target, _) in enumerate(channels)]})

    def glb(self, copyright_line):
        """The whole file."""
        while len(self.binary) % 4:
            self.binary.append(0)
        children = {child for node in self.nodes for child in node.get("children", ())}
        second = range(self.first_count, len(self.nodes))
        self.second_scene["nodes"] += [i for i in second if i not in children]
        root = {
            "asset": {"version": "2.0", "generator": "gridlight tools/build_courtyard.py",
                      "copyright": copyright_line},
            "extensionsUsed": ["KHR_animation_pointer", "KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": self.lights}},
            "scene": 0,
            "scenes": [{"name": "courtyard", "nodes": list(range(self.first_count))},
                       self.second_scene],
            "nodes": self.nodes, "cameras": self.cameras, "meshes": self.meshes,
            "materials": self.materials, "textures": self.textures, "images": self.images,
            "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
            "skins": self.skins, "animations": self.animations,
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.binary)}],
        }
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = (struct.pack("<II", len(text), 0x4E4F534A) + text
                + struct.pack("<II", len(self.binary), 0x004E4942) + bytes(self.binary))
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
