"""Procedural textures: tiling surfaces as palette images, and normal maps from heights.

Colours are linear; `srgb` encodes them. A surface is a function (u, v) -> (class, shade) with
a colour ramp per class, so that every image needs a palette only.
"""

import math

from . import png
from .noise import Fbm, Rng, hash01

LEVELS = 20


def srgb(c):
    """Encodes one linear channel to 8 bits."""
    c = min(1.0, max(0.0, c))
    e = 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1.0 / 2.4) - 0.055
    return int(e * 255.0 + 0.5)


def surface(size, ramps, function):
    """A palette image of `function` with a (dark, light) pair of colours per class."""
    palette = []
    for dark, light in ramps:
        for level in range(LEVELS):
            t = level / (LEVELS - 1)
            palette.append(tuple(srgb(a + (b - a) * t) for a, b in zip(dark, light)))
    indices = bytearray()
    for y in range(size):
        for x in range(size):
            kind, shade = function((x + 0.5) / size, (y + 0.5) / size)
            indices.append(kind * LEVELS + min(LEVELS - 1, max(0, int(shade * LEVELS))))
    return png.indexed(size, size, indices, palette)


def normal_map(size, depth, height):
    """A tangent-space normal map (+y up) of a tiling height; `depth` is relief over tile size."""
    h = [[height((x + 0.5) / size, (y + 0.5) / size) for x in range(size)] for y in range(size)]
    pixels = bytearray()
    for y in range(size):
        above, row, below = h[y - 1], h[y], h[(y + 1) % size]
        for x in range(size):
            dx = (row[(x + 1) % size] - row[x - 1]) * 0.5 * size * depth
            dy = (below[x] - above[x]) * 0.5 * size * depth
            s = 1.0 / math.sqrt(1.0 + dx * dx + dy * dy)
            for c in (-dx * s, dy * s, s):
                # Steps of 8 keep the file small; 128 is exactly flat.
                pixels.append(min(255, 128 + 8 * math.floor(c * 15.875 + 0.5)))
    return png.rgb(size, size, pixels)


def limestone():
    """Smooth, faintly veined stone for columns and mouldings."""
    broad, fine = Fbm(3, 3, 4, 11), Fbm(24, 24, 2, 12)

    def at(u, v):
        return 0, 0.7 * broad(u, v) + 0.45 * fine(u, v) - 0.07
    return surface(256, [((0.52, 0.45, 0.35), (0.75, 0.69, 0.58))], at)


def _ashlar_block(u, v):
    """Block number and distance to the joint (in tiles) of a wall of four courses."""
    course = int(v * 4.0) % 4
    shift = (0.0, 0.27, 0.06, 0.31)[course]
    x = (u + shift) % 1.0 * 2.0
    fx, fy = x % 1.0, v * 4.0 % 1.0
    edge = min(min(fx, 1.0 - fx) * 0.5, min(fy, 1.0 - fy) * 0.25)
    return course * 2 + int(x) % 2, edge


def ashlar():
    """Dressed stone blocks: colour and normal map. One tile is 1.2 m."""
    broad, fine = Fbm(4, 4, 4, 21), Fbm(32, 32, 2, 22)

    def at(u, v):
        block, edge = _ashlar_block(u, v)
        tone = 0.22 * hash01(5, block) + 0.5 * broad(u, v) + 0.3 * fine(u, v)
        return (1, 0.5 * tone) if edge < 0.006 else (0, tone)

    def height(u, v):
        _, edge = _ashlar_block(u, v)
        return min(1.0, edge / 0.014) + 0.3 * fine(u, v)
    ramps = [((0.5, 0.4, 0.28), (0.75, 0.67, 0.52)), ((0.36, 0.29, 0.21), (0.56, 0.47, 0.36))]
    return surface(256, ramps, at), normal_map(128, 0.006, height)


def plaster():
    """Warm lime plaster with stains. One tile is 2.4 m."""
    broad, fine = Fbm(2, 2, 4, 31), Fbm(40, 40, 2, 32)

    def at(u, v):
        return 0, 0.85 * broad(u, v) + 0.25 * fine(u, v) - 0.05
    return surface(256, [((0.58, 0.49, 0.37), (0.75, 0.69, 0.58))], at)


def _paving(u, v):
    """Class, slab number and joint distance of the court floor; one tile is 2.4 m.

    Octagon-like slabs of 0.6 m with small dark diamonds where four of them meet.
    """
    x, y = u * 4.0, v * 4.0
    fx, fy = x % 1.0, y % 1.0
    nx, ny = min(fx, 1.0 - fx), min(fy, 1.0 - fy)
    diamond = 0.2 - (nx + ny)
    number = int(x) % 4 + 4 * (int(y) % 4)
    if diamond > 0.0:
        return 1 + (round(x) + round(y)) % 2, number, diamond * 0.7
    return 0, number, min(nx, ny, -diamond * 0.7)


def paving():
    """The court floor: colour and normal map."""
    broad, fine = Fbm(5, 5, 4, 41), Fbm(64, 64, 2, 42)

    def at(u, v):
        kind, number, edge = _paving(u, v)
        tone = 0.35 * hash01(7, number) + 0.5 * broad(u, v) + 0.25 * fine(u, v)
        return (3, 0.6 * tone) if edge < 0.011 else (kind, tone)

    def height(u, v):
        _, _, edge = _paving(u, v)
        return min(1.0, edge / 0.03) + 0.25 * broad(u, v)
    ramps = [((0.48, 0.4, 0.31), (0.74, 0.66, 0.54)), ((0.1, 0.16, 0.2), (0.2, 0.3, 0.36)),
             ((0.34, 0.13, 0.07), (0.56, 0.25, 0.15)), ((0.24, 0.2, 0.15), (0.4, 0.33, 0.26))]
    return surface(512, ramps, at), normal_map(256, 0.004, height)


def checker():
    """Terracotta and cream tiles laid diagonally. One tile is 1.2 m."""
    broad, fine = Fbm(6, 6, 3, 51), Fbm(48, 48, 2, 52)

    def at(u, v):
        a, b = (u + v) * 3.0, (u - v) * 3.0
        fa, fb = a % 1.0, b % 1.0
        edge = min(fa, 1.0 - fa, fb, 1.0 - fb)
        ia, ib = math.floor(a), math.floor(b)
        tone = 0.3 * hash01(9, ia % 6, ib % 6) + 0.45 * broad(u, v) + 0.25 * fine(u, v)
        return (2, 0.5) if edge < 0.025 else ((ia + ib) % 2, tone)
    ramps = [((0.38, 0.16, 0.09), (0.58, 0.29, 0.18)), ((0.55, 0.48, 0.38), (0.74, 0.67, 0.56)),
             ((0.35, 0.29, 0.22), (0.4, 0.34, 0.26))]
    return surface(256, ramps, at)


def zellige():
    """Glazed mosaic of eight-pointed stars. One tile is 0.6 m with two stars each way."""
    fine = Fbm(24, 24, 2, 61)

    def star(x, y, a):
        ax, ay = abs(x), abs(y)
        return a - min(max(ax, ay), (ax + ay) * 0.7071)

    def at(u, v):
        x, y = u * 2.0 % 1.0 - 0.5, v * 2.0 % 1.0 - 0.5
        tone = 0.25 + 0.5 * fine(u, v)
        outer = star(x, y, 0.345)
        inner = star(x, y, 0.17)
        if abs(outer) < 0.022 or abs(inner) < 0.016:
            return 0, tone + 0.2
        if inner > 0.0:
            return 3, tone
        if outer > 0.0:
            return 1, tone + 0.15 * hash01(3, int(math.atan2(y, x) * 8.0 / math.pi + 8.5))
        nx, ny = 0.5 - abs(x), 0.5 - abs(y)
        if nx + ny < 0.19:
            return 2, tone
        return 0, tone
    ramps = [((0.58, 0.56, 0.5), (0.74, 0.72, 0.66)), ((0.04, 0.13, 0.34), (0.09, 0.25, 0.52)),
             ((0.05, 0.26, 0.18), (0.1, 0.42, 0.3)), ((0.55, 0.3, 0.06), (0.68, 0.42, 0.12))]
    return surface(256, ramps, at)


def pool():
    """Small blue tiles for the basin. One tile is 0.5 m."""
    fine = Fbm(16, 16, 2, 71)

    def at(u, v):
        x, y = u * 5.0, v * 5.0
        edge = min(x % 1.0, 1 - x % 1.0, y % 1.0, 1 - y % 1.0)
        tone = 0.6 * hash01(4, int(x), int(y)) + 0.35 * fine(u, v)
        return (1, 0.5) if edge < 0.06 else (0, tone)
    return surface(128, [((0.03, 0.16, 0.3), (0.12, 0.44, 0.58)),
                         ((0.4, 0.45, 0.45), (0.6, 0.62, 0.6))], at)


def terracotta():
    """Fired clay."""
    broad, fine = Fbm(4, 4, 3, 81), Fbm(24, 24, 2, 82)

    def at(u, v):
        return 0, 0.7 * broad(u, v) + 0.4 * fine(u, v)
    return surface(128, [((0.36, 0.14, 0.07), (0.62, 0.32, 0.18))], at)


def wood():
    """Planks with the grain along u; two planks of 0.2 m per tile of 0.4 m."""
    grain, wide = Fbm(2, 48, 3, 91), Fbm(1, 6, 3, 92)

    def at(u, v):
        edge = min(v * 2.0 % 1.0, 1.0 - v * 2.0 % 1.0)
        tone = 0.65 * grain(u, v) + 0.45 * wide(u, v) + 0.12 * hash01(6, int(v * 2.0)) - 0.1
        return 0, tone * (0.25 if edge < 0.03 else 1.0)
    return surface(128, [((0.1, 0.055, 0.028), (0.44, 0.28, 0.15))], at)


def weave():
    """A neutral woven pattern that the cloth colours multiply. One tile is 0.25 m."""
    slub = Fbm(2, 24, 2, 95)

    def at(u, v):
        over = (int(u * 32.0) + int(v * 32.0)) % 2
        return 0, 0.35 + 0.25 * over + 0.5 * (slub(u, v) - 0.35)
    return surface(128, [((0.66, 0.66, 0.66), (1.0, 1.0, 1.0))], at)


def rug():
    """A bordered rug; the image covers it once."""
    fine = Fbm(48, 48, 2, 97)

    def at(u, v):
        # The rug is about twice as long (v) as it is wide (u).
        x, y = min(u, 1.0 - u), min(v, 1.0 - v) * 2.0
        border, tone = min(x, y), 0.2 + 0.6 * fine(u, v)
        if border < 0.03 or 0.13 < border < 0.155:
            return 1, tone
        if border < 0.13:
            return (2 if (int(u * 20.0) + int(v * 40.0)) % 2 else 3), tone
        a = abs(u - 0.5) * 2.0
        b = abs(v * 3.0 % 1.0 - 0.5) * 2.0
        d = a * 1.1 + b
        band = int(d * 5.0)
        return (0, 1, 2, 0, 3, 0)[min(band, 5)], tone
    ramps = [((0.4, 0.04, 0.03), (0.58, 0.09, 0.06)), ((0.5, 0.42, 0.28), (0.66, 0.57, 0.4)),
             ((0.04, 0.07, 0.2), (0.08, 0.13, 0.32)), ((0.5, 0.26, 0.05), (0.62, 0.36, 0.09))]
    return surface(256, ramps, at)


class LeafSheet:
    """A transparent image on which leaves are painted from back to front."""

    def __init__(self, width, height, dark, light):
        self.width, self.height = width, height
        self.pixels = bytearray(width * height)
        mean = tuple(0.5 * (a + b) for a, b in zip(dark, light))
        self.palette = [tuple(srgb(c) for c in mean)]
        for level in range(LEVELS):
            t = level / (LEVELS - 1)
            self.palette.append(tuple(srgb(a + (b - a) * t) for a, b in zip(dark, light)))

    def leaf(self, x, y, angle, length, width, tone, belly=0.4):
        """A pointed oval from (x, y) towards `angle`, in texels."""
        ca, sa = math.cos(angle), math.sin(angle)
        for py in range(max(0, int(y - length)), min(self.height, int(y + length) + 1)):
            for px in range(max(0, int(x - length)), min(self.width, int(x + length) + 1)):
                dx, dy = px + 0.5 - x, py + 0.5 - y
                along = (dx * ca + dy * sa) / length
                if not 0.0 < along < 1.0:
                    continue
                across = (dy * ca - dx * sa) / width
                if along < belly:
                    limit = math.sqrt(1.0 - (1.0 - along / belly) ** 2)
                else:
                    limit = 1.0 - ((along - belly) / (1.0 - belly)) ** 1.6
                if abs(across) < limit:
                    vein = 0.25 if abs(across) * width < 0.9 else 0.0
                    side = 0.14 if across > 0.0 else 0.0
                    rib = 0.06 if (along * 9.0 - abs(across)) % 1.0 < 0.25 else 0.0
                    shade = tone + vein + side - rib
                    level = min(LEVELS - 1, max(0, int(shade * LEVELS)))
                    self.pixels[py * self.width + px] = 1 + level

    def png(self):
        """The finished image."""
        return png.indexed(self.width, self.height, self.pixels, self.palette, (0,))


def leaf_spray():
    """A twig with oval leaves, root at the bottom centre."""
    sheet, rng = LeafSheet(256, 256, (0.035, 0.1, 0.02), (0.22, 0.36, 0.08)), Rng(201)
    sheet.leaf(128, 254, -math.pi / 2, 200, 4, 0.1)
    for i in range(15):
        t = i / 14.0
        side = -1.0 if i % 2 else 1.0
        angle = -math.pi / 2 + side * (1.15 - 0.75 * t + rng.next(-0.15, 0.15))
        sheet.leaf(128 + rng.next(-5, 5), 235 - 165 * t, angle, 105 - 30 * t,
                   23 - 5 * t, rng.next(0.2, 0.65))
    return sheet.png()


def ivy():
    """A cluster of heart-shaped ivy leaves."""
    sheet, rng = LeafSheet(256, 256, (0.03, 0.08, 0.025), (0.16, 0.3, 0.09)), Rng(202)
    for i in range(13):
        a = 2.4 * i
        r = 92.0 * math.sqrt((13 - i) / 13.0)
        x, y = 128 + r * math.cos(a), 128 + r * math.sin(a)
        turn, tone = a + rng.next(-0.6, 0.6), rng.next(0.15, 0.65)
        for lobe, size in ((-1.1, 0.72), (1.1, 0.72), (-0.5, 0.85), (0.5, 0.85), (0.0, 1.0)):
            sheet.leaf(x - 14 * math.cos(turn), y - 14 * math.sin(turn), turn + lobe,
                       46 * size, 15 * size, tone, 0.45)
    return sheet.png()


def frond():
    """A feather-like palm frond, root at the bottom centre."""
    sheet, rng = LeafSheet(128, 256, (0.05, 0.14, 0.03), (0.26, 0.42, 0.1)), Rng(203)
    for i in range(34):
        t = i / 33.0
        reach = 60.0 * math.sin(math.pi * (0.12 + 0.83 * t)) ** 0.7
        for side in (-1.0, 1.0):
            angle = -math.pi / 2 + side * (1.0 - 0.45 * t)
            sheet.leaf(64, 248 - 220 * t, angle, reach, 5.0, rng.next(0.25, 0.6), 0.3)
    sheet.leaf(64, 256, -math.pi / 2, 250, 3.0, 0.6)
    return sheet.png()
