"""Arched wall panels: one bay of wall over a round opening, with voussoirs in relief.

A panel spans `width` along x around the origin, from the springing line up to `top`, and
`front` to `back` along z. It has no side faces, because the next bay continues it, and
no lower face, because the abacus below reaches into it.
"""

import math


def arch_wall(mesh, width, radius, spring, top, back, front, segments=20):
    """The wall around the opening: both faces and the soffit."""
    half = width / 2.0
    arc = []
    for i in range(segments + 1):
        a = math.pi * (1.0 - i / segments)
        arc.append((radius * math.cos(a) if i not in (0, segments) else
                    (-radius if i == 0 else radius), spring + radius * math.sin(a)))
    arc[0], arc[-1] = (-radius, spring), (radius, spring)
    rim = [(-half, spring), *arc, (half, spring)]
    for (x0, y0), (x1, y1) in zip(rim, rim[1:]):
        mesh.polygon([(x0, y0, front), (x1, y1, front), (x1, top, front), (x0, top, front)])
        mesh.polygon([(x1, y1, back), (x0, y0, back), (x0, top, back), (x1, top, back)])
    rows = [[(x, y, z) for x, y in arc] for z in (front, back)]
    uvs = [[(i * math.pi * radius / segments / mesh.tile, z / mesh.tile)
            for i in range(segments + 1)] for z in (front, back)]
    mesh.grid(rows, uvs)


def wedge(mesh, a0, a1, inner, outer, spring, z0, z1, steps=2):
    """One stone of an arch between two angles; `z1` is its face, `z0` lies in the wall."""
    s = 1.0 if z1 > z0 else -1.0
    angles = [a0 + (a1 - a0) * i / steps for i in range(steps + 1)]

    def at(r, a, z):
        return (r * math.cos(a), spring + r * math.sin(a), z)

    def face(points):
        mesh.polygon(points if s > 0 else points[::-1])

    bevel = min(0.012, abs(z1 - z0) * 0.5)
    zb = z1 - s * bevel
    m0, m1 = a0 + bevel / outer, a1 - bevel / outer
    inset = [m0 + (m1 - m0) * i / steps for i in range(steps + 1)]
    for i in range(steps):
        p, q, m, n = angles[i], angles[i + 1], inset[i], inset[i + 1]
        ri, ro = inner + bevel, outer - bevel
        face([at(ri, m, z1), at(ro, m, z1), at(ro, n, z1), at(ri, n, z1)])
        face([at(ro, m, z1), at(outer, p, zb), at(outer, q, zb), at(ro, n, z1)])
        face([at(inner, p, zb), at(ri, m, z1), at(ri, n, z1), at(inner, q, zb)])
        face([at(outer, p, zb), at(outer, p, z0), at(outer, q, z0), at(outer, q, zb)])
        face([at(inner, p, z0), at(inner, p, zb), at(inner, q, zb), at(inner, q, z0)])
    ri, ro = inner + bevel, outer - bevel
    face([at(inner, a0, zb), at(outer, a0, zb), at(ro, m0, z1), at(ri, m0, z1)])
    face([at(ri, m1, z1), at(ro, m1, z1), at(outer, a1, zb), at(inner, a1, zb)])
    face([at(inner, a0, z0), at(outer, a0, z0), at(outer, a0, zb), at(inner, a0, zb)])
    face([at(inner, a1, zb), at(outer, a1, zb), at(outer, a1, z0), at(inner, a1, z0)])


def voussoirs(mesh, count, radius, ring, spring, face, relief, keystone=True, steps=2):
    """A ring of `count` stones on the wall face at `face`; a negative relief faces -z."""
    step, gap = math.pi / count, 0.007 / (radius + 0.5 * ring)
    sunk = face - math.copysign(0.02, relief)
    for i in range(count):
        key = keystone and i == count // 2
        outer = radius + ring * (1.3 if key else 1.0)
        wedge(mesh, i * step + gap, (i + 1) * step - gap, radius + 0.006, outer, spring,
              sunk, face + relief * (1.6 if key else 1.0), steps)
