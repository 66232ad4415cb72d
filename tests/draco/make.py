#!/usr/bin/env python3
"""Writes the Draco files of this folder with Google's encoder (`pip install DracoPy numpy`; made with 2.2.0, Draco 1.5.7).

A torus of u x v vertices with a seam: where it closes, positions and normals are there twice and all else differs.
The test in src/scene/gltf_draco_tests.rs knows the same functions of u and v."""

import pathlib

import DracoPy
import numpy as np


def write(name, u_count, v_count, **options):
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(u_count), np.arange(v_count), indexing="ij"))
    a, b = (2 * np.pi * (n % (count - 1)) / (count - 1) for n, count in ((i, u_count), (j, v_count)))
    normals = np.stack([np.cos(a) * np.cos(b), np.sin(b), np.sin(a) * np.cos(b)], 1)
    positions = 0.4 * normals + np.stack([np.cos(a), 0 * a, np.sin(a)], 1)
    colors = np.stack([i % 256, 7 * j % 256, (i + j) % 256, 255 + 0 * i], 1).astype("u1")
    joints = np.stack([i, j, i + j, 300 + 0 * i], 1).astype("u2")
    weights = np.stack([255 - j, j, 0 * i, 0 * i], 1).astype("u1")
    first = (np.arange(u_count - 1)[:, None] * v_count + np.arange(v_count - 1)).ravel()
    triangles = [first, first + 1, first + v_count, first + 1, first + v_count + 1, first + v_count]
    data = DracoPy.encode(
        positions.astype("f4"),
        np.stack(triangles, 1).reshape(-1, 3).astype("u4"),
        tex_coord=np.stack([i / (u_count - 1), j / (v_count - 1)], 1),
        normals=normals,
        colors=colors,
        generic_attributes={7: joints, 9: weights},
        **options,
    )
    pathlib.Path(__file__).with_name(name).write_bytes(data)
    ids = {a["attribute_type"]: a["unique_id"] for a in DracoPy.decode(data).attributes}
    print(f"{name}: {len(data)} bytes, ids by type {ids}")


quantized = {"tex_coord_quantization_bits": 10, "normal_quantization_bits": 8, "quantization_bits": 11}
write("sequential.drc", 9, 6, compression_level=0, preserve_order=True, **quantized)
write("unquantized.drc", 9, 6, compression_level=3)
write("standard.drc", 9, 6, compression_level=5, **quantized)
write("valence.drc", 27, 22, compression_level=7, **quantized)
write("smallest.drc", 27, 22, compression_level=10, **quantized)
