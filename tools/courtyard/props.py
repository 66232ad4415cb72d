"""Fountain, pots, jars, crates, benches and lanterns."""

import math

from .mesh import Mesh


def fountain():
    """An octagonal basin: (stone, mosaic, pool) meshes."""
    stone, mosaic, pool = Mesh(2.0), Mesh(0.6), Mesh(0.5)
    turn = math.pi / 8
    stone.prism_lathe([(1.98, -0.05), (1.98, 0.1), (1.94, 0.13), (1.6, 0.13)], 8, turn)
    mosaic.prism_lathe([(1.62, 0.12), (1.62, 0.5)], 8, turn)
    stone.prism_lathe([(1.6, 0.47), (1.72, 0.49), (1.76, 0.52), (1.76, 0.57), (1.72, 0.61),
                       (1.42, 0.61), (1.38, 0.57), (1.38, 0.4)], 8, turn)
    pool.prism_lathe([(1.4, 0.5), (1.4, 0.2), (0.0, 0.2)], 8, turn)
    stone.prism_lathe([(0.42, 0.19), (0.42, 0.34), (0.36, 0.4), (0.1, 0.4)], 8, turn)
    stone.lathe([(0.26, 0.39), (0.27, 0.45), (0.2, 0.5), (0.13, 0.58), (0.12, 0.72),
                 (0.15, 0.86), (0.12, 0.98), (0.14, 1.06), (0.3, 1.12), (0.55, 1.2),
                 (0.72, 1.31), (0.77, 1.38)], 24)
    stone.lathe([(0.77, 1.38), (0.76, 1.41), (0.72, 1.41)], 24)
    stone.lathe([(0.72, 1.41), (0.6, 1.31), (0.36, 1.24), (0.1, 1.22)], 24)
    stone.lathe([(0.13, 1.2), (0.08, 1.28), (0.07, 1.42), (0.1, 1.5), (0.07, 1.56), (0.11, 1.6),
                 (0.24, 1.65), (0.31, 1.71), (0.3, 1.73)], 16)
    stone.lathe([(0.3, 1.73), (0.2, 1.69), (0.0, 1.68)], 16)
    stone.lathe([(0.05, 1.67), (0.035, 1.76), (0.07, 1.82), (0.075, 1.87), (0.04, 1.93),
                 (0.0, 1.97)], 12)
    return stone, mosaic, pool


def pot(radius, height):
    """A rimmed clay pot and its soil: (clay, soil) meshes."""
    clay, soil = Mesh(1.0), Mesh(1.0)
    r, h = radius, height
    clay.lathe([(0.0, 0.0), (r * 0.62, 0.0)], 16)
    clay.lathe([(r * 0.62, 0.0), (r * 0.74, h * 0.25), (r * 0.86, h * 0.55), (r * 0.92, h * 0.8)],
               16)
    clay.lathe([(r * 0.92, h * 0.8), (r, h * 0.81)], 16)
    clay.lathe([(r, h * 0.81), (r * 1.02, h * 0.9), (r, h)], 16)
    clay.lathe([(r, h), (r * 0.86, h)], 16)
    clay.lathe([(r * 0.86, h), (r * 0.84, h * 0.8)], 16)
    soil.lathe([(r * 0.87, h * 0.88), (0.0, h * 0.92)], 16)
    return clay, soil


def jar(height):
    """A tall two-handled storage jar."""
    mesh, h = Mesh(1.0), height
    outer = [(0.0, 0.0), (0.16, 0.0), (0.2, 0.06), (0.31, 0.3), (0.36, 0.52), (0.33, 0.7),
             (0.22, 0.82), (0.14, 0.87), (0.13, 0.93), (0.17, 0.98), (0.175, 1.0), (0.14, 1.0)]
    mesh.lathe([(r * h, y * h) for r, y in outer[:2]], 18)
    mesh.lathe([(r * h, y * h) for r, y in outer[1:]], 18)
    mesh.lathe([(0.14 * h, h), (0.105 * h, 0.92 * h), (0.12 * h, 0.84 * h), (0.0, 0.8 * h)], 18)
    for s in (-1, 1):
        rows, uvs = [], []
        for i in range(9):
            t = i / 8.0
            a = -0.5 + (math.pi * 0.5 + 0.9) * t
            cx = s * (0.2 + 0.13 * math.cos(a)) * h
            cy = (0.81 + 0.1 * math.sin(a)) * h
            rows.append([])
            uvs.append([])
            for j in range(7):
                b = 2 * math.pi * (j % 6) / 6
                k = 0.024 * h * math.cos(b)
                rows[-1].append((cx + s * k * math.cos(a), cy + k * math.sin(a),
                                 -s * 0.024 * h * math.sin(b)))
                uvs[-1].append((j * 0.03, t * 0.4))
        mesh.grid(rows, uvs, closed=True)
    return mesh


def crate(size):
    """A planked crate with a frame."""
    mesh, h = Mesh(0.4), size / 2.0
    mesh.box((-h, 0.0, -h), (h, size, h), skip="b")
    e, w = h + 0.02, 0.07
    for sx in (-1, 1):
        for sz in (-1, 1):
            x0, x1 = sorted((sx * e, sx * (e - w)))
            z0, z1 = sorted((sz * e, sz * (e - w)))
            mesh.box((x0, -0.0, z0), (x1, size + 0.01, z1))
    for y in (0.02, size - w - 0.01):
        for s in (-1, 1):
            z0, z1 = sorted((s * (e - 0.005), s * (e - w)))
            mesh.box((-e + w, y, z0), (e - w, y + w, z1), skip="lr")
            mesh.box((z0, y, -e + w), (z1, y + w, e - w), skip="nf")
    return mesh


def bench(length):
    """A stone bench on two blocks."""
    mesh, h = Mesh(2.0), length / 2.0
    mesh.box((-h, 0.4, -0.24), (h, 0.5, 0.24))
    for s in (-1, 1):
        mesh.box((s * (h - 0.25) - 0.1, -0.02, -0.18), (s * (h - 0.25) + 0.1, 0.41, 0.18),
                 skip="tb")
    return mesh


def lantern(chain):
    """A hanging lantern below y = 0 on a chain."""
    mesh = Mesh(1.0)
    c = -chain
    mesh.prism_lathe([(0.012, c - 0.02), (0.012, 0.02)], 5)
    mesh.prism_lathe([(0.0, c - 0.62), (0.05, c - 0.58), (0.09, c - 0.52), (0.17, c - 0.5),
                      (0.19, c - 0.46), (0.2, c - 0.2), (0.22, c - 0.19), (0.22, c - 0.16),
                      (0.12, c - 0.08), (0.05, c - 0.02), (0.03, c + 0.02), (0.0, c + 0.03)], 8)
    return mesh


def trunk(height):
    """A slim tree trunk."""
    mesh = Mesh(0.4)
    mesh.lathe([(0.07, 0.0), (0.055, height * 0.3), (0.05, height * 0.7), (0.04, height)], 9)
    return mesh


def ball(radius):
    """A small fruit."""
    mesh = Mesh(1.0)
    mesh.lathe([(0.0, -radius)] + [
        (radius * math.cos(a), radius * math.sin(a)) for a in (-0.9, -0.3, 0.3, 0.9)]
        + [(0.0, radius)], 8)
    return mesh


def plate(half_x, half_z, thickness):
    """A rug: a thin box whose top shows the image once."""
    mesh = Mesh(1.0)
    mesh.box((-half_x, 0.0, -half_z), (half_x, thickness, half_z), skip="bt")
    y = thickness
    mesh.polygon([(-half_x, y, half_z), (half_x, y, half_z), (half_x, y, -half_z),
                  (-half_x, y, -half_z)], [(0, 1), (1, 1), (1, 0), (0, 0)])
    return mesh
