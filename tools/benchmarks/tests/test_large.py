"""The inputs of tools/bench scale, in small: what is in the files."""
import json
import struct
import tempfile
import unittest
import zlib
from pathlib import Path

from benchmarks import large


class Large(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = Path(folder.name) / "scene.glb"

    def document(self):
        """The JSON of the file, whose lengths must be right."""
        data = self.file.read_bytes()
        magic, version, length, text_length, kind = struct.unpack_from("<4sIIII", data)
        self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(data), 0x4E4F534A))
        binary_length, kind = struct.unpack_from("<II", data, 20 + text_length)
        self.assertEqual((28 + text_length + binary_length, kind), (len(data), 0x004E4942))
        document = json.loads(data[20:20 + text_length])
        self.assertEqual(document["buffers"], [{"byteLength": binary_length}])
        for view in document["bufferViews"]:
            self.assertLessEqual(view["byteOffset"] + view["byteLength"], binary_length)
        return document

    def test_a_grid_has_its_triangles(self):
        large.grid(self.file, 3)
        document = self.document()
        primitive = document["meshes"][0]["primitives"][0]
        self.assertEqual(document["accessors"][primitive["indices"]]["count"], 3 * 2 * 3**2)
        for name in ("POSITION", "NORMAL"):
            self.assertEqual(document["accessors"][primitive["attributes"][name]]["count"], 4**2)

    def test_copies_have_a_place_each(self):
        large.grid(self.file, 2, copies=5)
        instancing = self.document()["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]
        places = self.document()["accessors"][instancing["attributes"]["TRANSLATION"]]
        self.assertEqual(places["count"], 5)

    def test_materials_and_textures_are_as_many(self):
        large.materials(self.file, 7)
        self.assertEqual([len(self.document()[key]) for key in ("materials", "meshes", "nodes")], [7, 7, 8])
        large.textures(self.file, 3, 8)
        document = self.document()
        self.assertEqual([len(document[key]) for key in ("images", "textures", "materials")], [3, 3, 3])
        self.assertEqual(len({large.png(8, 8, shade) for shade in range(3)}), 3)

    def test_pictures_have_their_size(self):
        data = large.png(5, 130, 7)
        self.assertEqual(struct.unpack_from(">II", data, 16), (5, 130))
        length = struct.unpack_from(">I", data, 33)[0]
        self.assertEqual(len(zlib.decompress(data[41:41 + length])), 130 * (1 + 3 * 5))

    def test_an_environment_has_its_rows(self):
        large.environment(self.file, 6, 100)
        data = self.file.with_suffix(".exr").read_bytes()
        first = data.index(b"screenWindowWidth\0float\0") + 24 + 4 + 4 + 1
        offsets = struct.unpack_from("<100Q", data, first)
        for y, offset in enumerate(offsets):
            row, length = struct.unpack_from("<iI", data, offset)
            self.assertEqual(row, y)
            raw = zlib.decompress(data[offset + 8:offset + 8 + length]) if length < 36 else data[offset + 8:offset + 44]
            self.assertEqual(len(raw), 36)
        self.assertEqual(offset + 8 + length, len(data))
