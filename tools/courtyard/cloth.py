"""Cloth: thin wavy sheets, each a grid with two-sided material."""

import math

from .mesh import Mesh


def sheet(rows, cols, function, width, height):
    """A grid through `function(s, t)` with s, t in [0, 1]; t grows upwards."""
    mesh = Mesh(0.25)
    points, uvs = [], []
    for i in range(rows + 1):
        t = i / rows
        points.append([function(j / cols, t) for j in range(cols + 1)])
        uvs.append([(width * j / cols / 0.25, height * (1.0 - t) / 0.25)
                    for j in range(cols + 1)])
    mesh.grid(points, uvs)
    return mesh


def banner(width, height, phase, folds=3.0, depth=0.06):
    """Hangs from y = 0 in the xy plane with soft vertical folds that open downwards."""
    def at(s, t):
        drop = 1.0 - t
        wave = math.sin(2 * math.pi * folds * s + phase + 0.8 * math.sin(2.3 * drop + phase))
        z = depth * (0.35 + 0.65 * drop) * wave + 0.05 * drop * math.sin(3.0 * drop + phase)
        x = (s - 0.5) * width * (1.0 - 0.06 * math.sin(math.pi * drop * 0.8))
        hem = 0.03 * math.sin(2 * math.pi * folds * s + phase + 1.0)
        return (x, -height * drop + hem * drop, z)
    return sheet(18, 22, at, width, height)


def curtain(width, height, tie, phase):
    """A curtain on a rod at y = 0, gathered to the left at height fraction `tie`."""
    def at(s, t):
        drop = 1.0 - t
        pull = math.exp(-((drop - tie) / 0.2) ** 2)
        below = 1.0 / (1.0 + math.exp(-(drop - tie) * 16.0))
        scale = 1.0 - 0.72 * pull - 0.42 * below * (1.0 - pull)
        x = s * width * scale
        folds = math.sin(2 * math.pi * 4.5 * s + phase) + \
            0.22 * math.sin(2 * math.pi * 7.0 * s + 2 * phase)
        z = (0.06 + 0.015 * below - 0.025 * pull) * folds
        # The free edge sags towards the tie.
        y = -height * drop - 0.22 * s * s * math.exp(-((drop - tie * 0.7) / 0.3) ** 2)
        return (x, y, z)
    return sheet(26, 48, at, width * 1.3, height)


def awning(length, width, sag, phase):
    """A strip that spans along z between two galleries and sags in the middle."""
    def at(s, t):
        z = (0.5 - t) * length
        arc = 1.0 - (2.0 * t - 1.0) ** 2
        gather = 1.0 - 0.3 * (2.0 * t - 1.0) ** 4
        x = (s - 0.5) * width * gather
        across = math.sin(math.pi * s)
        y = -sag * arc - 0.14 * across * arc - 0.03 * math.sin(8 * math.pi * t + phase) * across
        y += 0.035 * (1.0 - 0.6 * arc) * math.sin(2 * math.pi * 4.0 * s + phase)
        return (x, y, z)
    return sheet(44, 20, at, width, length)


def draped(width, drop, phase):
    """A cloth thrown over a rail along x: an upside-down U that hangs on both sides."""
    def at(s, t):
        length = (2.0 * t - 1.0) * (drop + 0.12)
        side = math.copysign(1.0, length)
        bend = min(abs(length), 0.19) / 0.19
        hang = max(0.0, abs(length) - 0.19)
        wave = math.sin(2 * math.pi * 3.0 * s + phase + (0.6 if side > 0 else 0.0))
        z = side * 0.165 * math.sin(bend * math.pi / 2) + side * 0.03 * hang * (1.2 + wave) \
            + 0.02 * bend * wave * side
        y = 0.03 - 0.04 * (1 - math.cos(bend * math.pi / 2)) - hang
        return ((s - 0.5) * width * (1.0 - 0.05 * hang), y, -z)
    return sheet(30, 18, at, width, 2 * drop)
