"""The building: floors, outer walls, arcades, gallery, ceilings, cornice and roof."""

import math

from . import layout as L
from .arches import arch_wall, voussoirs
from .mesh import Mesh, turned

# Yaw of the four sides (+z, +x, -z, -x) and their half lengths along the column line.
SIDES = ((0, L.HALF_X, L.HALF_Z, L.BAYS_X), (1, L.HALF_Z, L.HALF_X, L.BAYS_Z),
         (2, L.HALF_X, L.HALF_Z, L.BAYS_X), (3, L.HALF_Z, L.HALF_X, L.BAYS_Z))


def ring(tile, profile, closed=True):
    """A mesh swept around the column lines."""
    mesh = Mesh(tile)
    mesh.ring(profile, L.HALF_X, L.HALF_Z, closed)
    return mesh


def on_side(side, along, d, y):
    """World position at `along` on a side, `d` outwards from its column line."""
    quarter, _, line, _ = SIDES[side]
    return turned((along, y, line + d), quarter)


def column(radius, height, base, segments, bumps):
    """A column of the given shaft radius from y = 0: plinth, torus, shaft, capital, abacus."""
    mesh = Mesh(2.0)
    plinth = base * 0.22
    half = base / 2.0
    mesh.box((-half, 0.0, -half), (half, plinth, half), skip="b")
    torus = []
    for i in range(7):
        a = -math.pi / 2 + math.pi * i / 6
        torus.append((radius * 1.12 + 0.16 * radius * math.cos(a) + radius * 0.08,
                      plinth + 0.16 * base * (0.5 + 0.5 * math.sin(a))))
    mesh.lathe([(radius * 1.2, plinth - 0.005), *torus], segments)
    y0 = torus[-1][1]
    cap = base * 0.95
    abacus = base * 0.2
    y1 = height - cap
    mesh.lathe([(radius * 1.2, y0), (radius * 1.1, y0 + 0.04 * base)], segments)
    shaft = []
    for i in range(9):
        t = i / 8.0
        swell = 1.0 - 0.17 * t ** 1.8 + 0.025 * math.sin(math.pi * t)
        foot = 0.1 * max(0.0, 1.0 - t * 14.0)
        shaft.append((radius * (swell + foot), y0 + 0.04 * base + (y1 - y0 - 0.04 * base) * t))
    mesh.lathe(shaft, segments)
    neck = shaft[-1][0]
    bead = [(neck, y1 - 0.01)] + [
        (neck + 0.09 * radius * (1 + math.sin(a)), y1 + 0.09 * base * (0.5 - 0.5 * math.cos(a)))
        for a in (0.4, 1.0, 1.57, 2.2, 2.8)] + [(neck * 0.98, y1 + 0.09 * base)]
    mesh.lathe(bead, segments)
    # The capital changes from round to a soft square and carries two rows of leaf bumps.
    low, high = y1 + 0.08 * base, height - abacus
    wide = base * 0.5

    def shape(angle, y):
        t = (y - low) / (high - low)
        c, s = abs(math.cos(angle)), abs(math.sin(angle))
        power = 2.0 + 5.0 * max(0.0, t - 0.45)
        square = (c ** power + s ** power) ** (-1.0 / power)
        row = 0.0 if t < 0.5 else math.pi / bumps
        leaf = 0.075 * max(0.0, math.sin(2.0 * math.pi * t)) if t < 0.5 else \
            0.06 * max(0.0, -math.sin(2.0 * math.pi * t))
        return square * (1.0 + leaf * (0.4 + math.cos(bumps * (angle + row))))

    bell = []
    for i in range(11):
        t = i / 10.0
        bell.append((neck + (wide * 0.93 - neck) * (0.25 * t + 0.75 * t ** 2.6),
                     low + (high - low) * t))
    mesh.lathe(bell, segments, shape=shape)
    lip = half * 1.12
    mesh.box((-half, high - 0.002, -half), (half, high + abacus * 0.45, half), skip="t")
    mesh.box((-lip, high + abacus * 0.4, -lip), (lip, height + 0.012, lip))
    return mesh


def floors(doc, mats):
    """Ground slab, court paving, arcade platform and gallery slab."""
    paving = Mesh(2.4)
    hx, hz = L.HALF_X + 3.8, L.HALF_Z + 3.8
    paving.box((-hx, -0.4, -hz), (hx, 0.0, hz))
    doc.place("court floor", [(paving, mats["paving"])])
    step = ring(1.2, [(3.1, -0.1), (3.1, L.FLOOR), (-0.33, L.FLOOR)], closed=False)
    doc.place("arcade floor", [(step, mats["checker"])])
    kerb = ring(2.0, [(-0.52, -0.1), (-0.3, -0.1), (-0.3, L.FLOOR + 0.006),
                      (-0.5, L.FLOOR + 0.006), (-0.52, L.FLOOR - 0.014)])
    doc.place("arcade kerb", [(kerb, mats["stone"])])
    c, g = L.CEILING, L.GALLERY
    slab = ring(2.4, [(-0.3, c), (3.1, c), (3.1, g - 0.02), (-0.3, g - 0.02)])
    doc.place("gallery slab", [(slab, mats["plaster"])])
    tiles = ring(1.2, [(3.1, g - 0.04), (3.1, g), (-0.3, g), (-0.3, g - 0.04)])
    doc.place("gallery floor", [(tiles, mats["checker"])])
    course = ring(2.0, [(-0.22, c - 0.06), (-0.22, g + 0.05), (-0.5, g + 0.05), (-0.5, g - 0.04),
                        (-0.46, g - 0.09), (-0.4, g - 0.13), (-0.37, c + 0.02),
                        (-0.33, c - 0.02), (-0.3, c - 0.06)])
    doc.place("string course", [(course, mats["stone"])])


def outer_walls(doc, mats):
    """The enclosing wall with plinth and coping."""
    wall = ring(2.4, [(L.DEPTH, -0.2), (L.OUTER, -0.2), (L.OUTER, L.PARAPET),
                      (L.DEPTH, L.PARAPET)])
    doc.place("outer wall", [(wall, mats["plaster"])])
    o = L.OUTER
    plinth = ring(1.2, [(o - 0.1, -0.3), (o + 0.1, -0.3), (o + 0.1, 0.85), (o + 0.05, 0.9),
                        (o - 0.1, 0.9)])
    doc.place("outer plinth", [(plinth, mats["ashlar"])])
    p = L.PARAPET
    coping = ring(2.0, [(L.DEPTH - 0.1, p - 0.06), (o + 0.12, p - 0.06), (o + 0.12, p + 0.06),
                        (o - 0.2, p + 0.14), (L.DEPTH - 0.1, p + 0.06)])
    doc.place("coping", [(coping, mats["stone"])])


def bay_positions(side):
    """Centres of the bays along one side."""
    count = SIDES[side][3]
    return [(i - (count - 1) / 2.0) * L.BAY for i in range(count)]


def arcades(doc, mats):
    """Ground-floor columns and arches, corner piers, transverse arches."""
    half = L.WALL / 2.0
    radius = (L.BAY - L.WALL) / 2.0
    wall, ring_mesh = Mesh(1.2), Mesh(2.0)
    arch_wall(wall, L.BAY, radius, L.SPRING, L.CEILING + 0.05, -half, half)
    for face, relief in ((-half, -0.035), (half, 0.035)):
        voussoirs(ring_mesh, 11, radius, 0.25, L.SPRING, face, relief)
    shaft = column(0.19, L.SPRING - L.FLOOR, 0.5, 18, 6)
    for side, (quarter, line, _, count) in enumerate(SIDES):
        for along in bay_positions(side):
            doc.place("arch", [(wall, mats["ashlar"]), (ring_mesh, mats["stone"])],
                      on_side(side, along, 0.0, 0.0), doc_yaw(quarter))
        for i in range(1, count):
            doc.place("column", [(shaft, mats["stone"])],
                      on_side(side, i * L.BAY - line, 0.0, L.FLOOR), doc_yaw(quarter))
    pier, trim = Mesh(1.2), Mesh(2.0)
    w = half + 0.03
    pier.box((-w, 0.05, -w), (w, L.UPPER_CEILING + 0.05, w), skip="tb")
    for y0, y1, grow in ((0.05, 0.5, 0.06), (0.5, 0.56, 0.03),
                         (L.SPRING - 0.16, L.SPRING - 0.08, 0.035),
                         (L.SPRING - 0.08, L.SPRING + 0.02, 0.075),
                         (L.UPPER_SPRING - 0.12, L.UPPER_SPRING + 0.02, 0.06)):
        trim.box((-w - grow, y0, -w - grow), (w + grow, y1, w + grow))
    for sx in (-1, 1):
        for sz in (-1, 1):
            doc.place("corner pier", [(pier, mats["ashlar"]), (trim, mats["stone"])],
                      (sx * L.HALF_X, 0.0, sz * L.HALF_Z))
    # Arches from the corner piers to the outer walls close the four corner rooms.
    span = L.DEPTH - w
    cross, cross_ring, corbel = Mesh(1.2), Mesh(2.0), Mesh(2.0)
    cross_radius, spring = (span - 0.3) / 2.0, L.SPRING - 0.12
    arch_wall(cross, span + 0.1, cross_radius, spring, L.CEILING + 0.05, -0.2, 0.2)
    for face, relief in ((-0.2, -0.03), (0.2, 0.03)):
        voussoirs(cross_ring, 13, cross_radius, 0.2, spring, face, relief, keystone=False)
    for s in (-1, 1):
        x0, x1 = sorted((s * cross_radius, s * (span / 2.0 + 0.05)))
        corbel.box((x0 - 0.04, spring - 0.14, -0.24), (x1 + 0.04, spring + 0.01, 0.24))
        x0, x1 = sorted((s * (cross_radius + 0.02), s * (span / 2.0 + 0.05)))
        corbel.box((x0, 0.1, -0.18), (x1, spring - 0.12, 0.18), skip="tb")
    for side, (quarter, line, _, _) in enumerate(SIDES):
        for s in (-1, 1):
            doc.place("transverse arch", [(cross, mats["ashlar"]), (cross_ring, mats["stone"]),
                                          (corbel, mats["stone"])],
                      on_side(side, s * (line - 0.02), w + span / 2.0, 0.0),
                      doc_yaw(90 * quarter + 90, True))


def doc_yaw(value, degrees=False):
    """Quaternion of a side's turn, given in quarters or degrees."""
    from .gltf import yaw
    return yaw(value if degrees else 90 * value)


def blind_arcade(doc, mats):
    """Arched niches with mosaic dados along the outer wall of the ground floor, and doors."""
    d = L.DEPTH
    front, back = 0.0, 0.14  # local z points outwards; the niche's face looks inwards
    radius, spring, top = 0.88, 2.45, L.CEILING + 0.03
    wall, stones, dado, panel = Mesh(2.4), Mesh(2.0), Mesh(0.6), Mesh(2.0)
    arch_wall(wall, L.BAY, radius, spring, top, front, back, 16)
    voussoirs(stones, 11, radius, 0.2, spring, front, -0.03, keystone=False)
    edge = L.BAY / 2.0
    for s in (-1, 1):
        x0, x1 = sorted((s * radius, s * edge))
        wall.box((x0, 0.05, front), (x1, spring, back), skip=("tbr" if s > 0 else "tbl"))
        x0, x1 = sorted((s * (radius - 0.03), s * edge))
        stones.box((x0, spring - 0.1, front - 0.04), (x1, spring + 0.012, back),
                   skip="r" if s > 0 else "l")
        stones.box((x0, 0.05, front - 0.03), (x1, 0.3, back), skip="r" if s > 0 else "l")
    dado.box((-radius, 0.1, back - 0.03), (radius, 1.3, back + 0.02), skip="bf")
    panel.box((-radius, 1.3, back - 0.05), (radius, 1.37, back + 0.02), skip="f")
    door, frame = Mesh(0.4, upright=True), Mesh(2.0)
    door.box((-0.62, 0.1, back - 0.05), (0.62, 2.5, back + 0.02), skip="bf")
    for i in range(2):
        for y in (0.28, 1.0, 1.72):
            x = -0.54 + 0.58 * i
            door.box((x, y, back - 0.075), (x + 0.5, y + 0.58, back - 0.04), skip="f")
    for x0, x1 in ((-0.8, -0.6), (0.6, 0.8)):
        frame.box((x0, 0.1, back - 0.12), (x1, 2.48, back + 0.02), skip="bf")
    frame.box((-0.92, 2.48, back - 0.16), (0.92, 2.72, back + 0.02), skip="f")
    for side, (quarter, line, _, _) in enumerate(SIDES):
        for along in bay_positions(side):
            doc.place("niche", [(wall, mats["plaster"]), (stones, mats["stone"]),
                                (dado, mats["zellige"]), (panel, mats["stone"])],
                      on_side(side, along, d - 0.13, 0.0), doc_yaw(quarter))
        for s in (-1, 1):
            doc.place("door", [(door, mats["wood"]), (frame, mats["stone"])],
                      on_side(side, s * (line + 1.6), d - 0.13, 0.0), doc_yaw(quarter))
        if side % 2 == 0:
            for along in bay_positions(side)[::2]:
                doc.place("gallery door", [(door, mats["wood"]), (frame, mats["stone"])],
                          on_side(side, along, d - 0.13, L.GALLERY - 0.15), doc_yaw(quarter))


def gallery(doc, mats):
    """Upper columns and arches, balustrade."""
    wall, ring_mesh = Mesh(1.2), Mesh(2.0)
    width, radius, half = L.BAY / 2.0, 0.44, 0.16
    arch_wall(wall, width, radius, L.UPPER_SPRING, L.UPPER_CEILING + 0.05, -half, half, 14)
    voussoirs(ring_mesh, 9, radius, 0.15, L.UPPER_SPRING, -half, -0.025, steps=1)
    shaft = column(0.095, L.UPPER_SPRING - L.GALLERY, 0.3, 10, 5)
    rail, baluster = Mesh(2.0), Mesh(2.0)
    top = 0.98
    rail.box((-width / 2, 0.0, -0.1), (width / 2, 0.12, 0.1), skip="lrb")
    rail.box((-width / 2, top - 0.13, -0.09), (width / 2, top - 0.07, 0.09), skip="lr")
    rail.box((-width / 2, top - 0.075, -0.13), (width / 2, top, 0.13), skip="lr")
    outline = [(0.06, 0.11), (0.06, 0.15), (0.035, 0.19), (0.062, 0.32), (0.066, 0.38),
               (0.045, 0.52), (0.03, 0.66), (0.034, 0.74), (0.055, 0.79), (0.055, 0.86)]
    for i in range(5):
        baluster.lathe(outline, 6, ((i - 2) * 0.205, 0.0, 0.0))
    for side, (quarter, line, _, count) in enumerate(SIDES):
        for i in range(2 * count):
            along = (i + 0.5) * width - line
            doc.place("gallery arch", [(wall, mats["ashlar"]), (ring_mesh, mats["stone"])],
                      on_side(side, along, 0.0, 0.0), doc_yaw(quarter))
            doc.place("balustrade", [(rail, mats["stone"]), (baluster, mats["stone"])],
                      on_side(side, along, 0.0, L.GALLERY), doc_yaw(quarter))
            if i:
                doc.place("gallery column", [(shaft, mats["stone"])],
                          on_side(side, i * width - line, 0.0, L.GALLERY), doc_yaw(quarter))


def beams(doc, mats):
    """Wooden beams under both ceilings."""
    beam = Mesh(0.4)
    # The grain runs along u, so the beam is modelled along x and turned into place.
    beam.box((-0.25, -0.2, -0.08), (3.05, 0.06, 0.08), skip="tlr")
    for side, (quarter, line, _, count) in enumerate(SIDES):
        for ceiling, spacing, first in ((L.CEILING, 0.8, 0.4), (L.UPPER_CEILING, 1.2, 0.6)):
            for i in range(round(2 * line / spacing)):
                along = first + i * spacing - line
                doc.place("beam", [(beam, mats["wood"])], on_side(side, along, 0.0, ceiling),
                          doc_yaw(90 * quarter - 90, True))


def roof(doc, mats):
    """Upper ceiling, cornice with dentils, and the lean-to roof with barrel tiles."""
    e, r, u = L.EAVE, L.RIDGE, L.UPPER_CEILING
    ceiling = ring(2.4, [(-0.1, u), (3.1, u), (3.1, u + 0.12), (-0.1, u + 0.12)])
    doc.place("upper ceiling", [(ceiling, mats["plaster"])])
    cornice = ring(2.0, [(0.14, u - 0.06), (0.14, e - 0.1), (-0.44, e - 0.1), (-0.44, e - 0.17),
                         (-0.42, e - 0.2), (-0.38, e - 0.22), (-0.3, e - 0.24), (-0.3, u + 0.02),
                         (-0.24, u - 0.02), (-0.2, u - 0.06)])
    doc.place("cornice", [(cornice, mats["stone"])])
    slab = ring(1.0, [(-0.48, e - 0.12), (3.1, r - 0.12), (3.1, r), (-0.48, e)])
    doc.place("roof slab", [(slab, mats["terracotta"])])
    dentil = Mesh(2.0)
    for i in range(6):
        x = (i - 2.5) * 0.2
        dentil.box((x - 0.05, e - 0.36, -0.37), (x + 0.05, e - 0.23, -0.28), skip="tf")
    for side, (quarter, line, _, count) in enumerate(SIDES):
        for i in range(2 * count):
            doc.place("dentils", [(dentil, mats["stone"])],
                      on_side(side, (i + 0.5) * L.BAY / 2 - line, 0.0, 0.0), doc_yaw(quarter))
    for side in range(2):
        tiles = barrel_tiles(SIDES[side][1])
        for quarter in (side, side + 2):
            doc.place("roof tiles", [(tiles, mats["terracotta"])],
                      on_side(quarter, 0.0, 0.0, 0.0), doc_yaw(quarter))


def barrel_tiles(line):
    """Rows of half-round tiles on one side of the roof, cut at the mitres."""
    mesh = Mesh(1.0)
    d0, d1, rows, radius = -0.55, 3.05, 3, 0.105
    slope = (L.RIDGE - L.EAVE) / 3.58
    count = int(2 * (line + d1) / 0.25)
    for i in range(count):
        x = (i + 0.5) * 0.25 - count * 0.125
        start = max(d0, abs(x) - line + 0.02)
        step = (d1 - d0) / rows
        for k in range(rows):
            a, b = max(start, d0 + k * step), d0 + (k + 1) * step
            if b - a < 0.08:
                continue
            points, uvs = [], []
            for z, r, lift in ((a, radius, 0.035), (b, radius * 0.86, 0.0)):
                y = L.EAVE + (z + 0.48) * slope - 0.01
                arc = [math.pi * j / 5 for j in range(6)]
                points.append([(x + r * math.cos(t), y + lift * math.sin(t) + r * math.sin(t), z)
                               for t in arc])
                uvs.append([(x + 0.04 * j + 0.37 * k, z) for j in range(6)])
            mesh.grid([points[1], points[0]], [uvs[1], uvs[0]])
            mesh.polygon(points[0][::-1])
    return mesh
