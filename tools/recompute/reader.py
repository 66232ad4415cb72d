"""Reading a dump with nothing but NumPy."""

import json
import os
import struct

import numpy as np


class DumpError(Exception):
    """The dump cannot be read."""


def read_exr(path):
    """Channels of an uncompressed scan-line OpenEXR file by name, each height x width, row 0 at the top."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"\x76\x2f\x31\x01":
        raise DumpError(f"{path} is not OpenEXR")
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        size = struct.unpack_from("<i", data, type_end + 1)[0]
        attributes[data[at:name_end].decode()] = data[type_end + 5 : type_end + 5 + size]
        at = type_end + 5 + size
    at += 1
    if attributes["compression"] != b"\0":
        raise DumpError(f"{path} is compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels, rest = [], attributes["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        channels.append((name.decode(), ["<u4", "<f2", "<f4"][struct.unpack_from("<i", rest)[0]]))
        rest = rest[16:]
    offsets = np.frombuffer(data, "<u8", height, at)
    images = {name: np.empty((height, width), kind) for name, kind in channels}
    for offset in offsets:
        y = struct.unpack_from("<i", data, int(offset))[0] - y0
        position = int(offset) + 8
        for name, kind in channels:
            images[name][y] = np.frombuffer(data, kind, width, position)
            position += width * np.dtype(kind).itemsize
    return images


class Dump:
    """Files of a dump by pass and resource, read when they are asked for."""

    def __init__(self, folder):
        self.folder = folder
        try:
            with open(os.path.join(folder, "manifest.json"), encoding="utf-8") as file:
                self.manifest = json.load(file)
        except (OSError, ValueError) as error:
            raise DumpError(f"{folder}/manifest.json cannot be read: {error}") from error
        if self.manifest.get("schema") != "gridlight-dump/1":
            raise DumpError(f"{folder}/manifest.json is not the manifest of a dump")
        self.frame = self.manifest["frame"]
        self.files = {(f["pass"], f["resource"]): f for f in self.manifest["files"]}
        self.loaded = {}

    def has(self, step, resource):
        return (step, resource) in self.files

    @property
    def lighting_step(self):
        """The pass that lights: tiles that gather, or light volumes."""
        return "light_gather" if self.has("light_gather", "lighting") else "light_volumes"

    def get(self, step, resource):
        """An array, or for images float64 with the channels R, G, B, A or the one there is; UINT channels as they are."""
        key = (step, resource)
        if key not in self.loaded:
            if key not in self.files:
                raise DumpError(f"{self.folder} has no {resource} of pass {step}")
            path = os.path.join(self.folder, self.files[key]["file"])
            try:
                self.loaded[key] = self.image(path, key) if path.endswith(".exr") else np.load(path)
            except (OSError, ValueError, IndexError, KeyError, struct.error) as error:
                raise DumpError(f"{path} cannot be read: {error}") from error
        return self.loaded[key]

    def image(self, path, key):
        channels = read_exr(path)
        stacked = np.stack([channels[name] for name in self.files[key]["channels"]], axis=-1)
        return stacked if stacked.dtype == np.uint32 else stacked.astype(np.float64)

    def last(self, *starts):
        """Pass and resource of the last file whose resource has one of these names, or begins with it and `_`."""
        fits = [k for k in self.files if any(k[1] == s or k[1].startswith(s + "_") for s in starts)]
        return max(fits, key=lambda k: self.files[k]["pass_index"]) if fits else None

    def view_rays(self, x, y):
        """From the eye to where pixels were sampled, at distance 1 along the viewing direction."""
        frame = self.frame
        pixel = np.stack([x, y], axis=1) + 0.5 + np.array(frame["jitter_px"])
        ndc = pixel / frame["size_px"] * 2.0 - 1.0
        forward, right, up = (np.array(frame[key]) for key in ("forward_ws", "right_ws", "up_ws"))
        return forward + ndc[:, :1] * right - ndc[:, 1:] * up

    def levels(self):
        return range(1, self.frame["top_level"] + 1)

    def grid_lights(self, level):
        """The pass that made the grid lights of a level."""
        made = f"grid_scatter/resolve_S{level}"
        return made if self.has(made, "grid_lights") else f"grid_gather/S{level}"


def unpack_octahedral(snorm):
    """Unit vectors from two 16-bit snorm each (last axis)."""
    e = np.maximum(snorm.astype(np.float64) / 32767.0, -1.0)
    n = np.concatenate([e, 1.0 - np.abs(e).sum(axis=-1, keepdims=True)], axis=-1)
    t = np.maximum(-n[..., 2:], 0.0)
    n[..., :2] -= np.where(n[..., :2] >= 0.0, t, -t)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)
