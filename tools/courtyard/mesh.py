"""Meshes: vertices with normals and texture coordinates, and the solids built from them.

Front faces are counter-clockwise. Texture coordinates are metres divided by `tile`.
"""

import math
import struct


def sub(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add(a, b, scale=1.0):
    """a + scale * b."""
    return (a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2])


def cross(a, b):
    """Cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    """Dot product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def normalize(a):
    """a with length 1 (or up for a zero vector)."""
    n = math.sqrt(dot(a, a))
    return (a[0] / n, a[1] / n, a[2] / n) if n > 1e-12 else (0.0, 1.0, 0.0)


class Mesh:
    """An indexed triangle mesh under construction.

    With `upright`, flat faces run their texture's u axis upwards (planks of a door).
    """

    def __init__(self, tile=1.0, upright=False):
        self.tile = tile
        self.upright = upright
        self.vertices = []
        self.indices = []
        self._known = {}

    def vertex(self, position, normal, uv):
        """Index of a vertex, shared with an equal one."""
        key = tuple(round(c, 5) + 0.0 for c in (*position, *normal, *uv))
        index = self._known.get(key)
        if index is None:
            index = self._known[key] = len(self.vertices)
            self.vertices.append(key)
        return index

    def triangle(self, a, b, c):
        """Adds a triangle unless it has no area."""
        pa, pb, pc = (self.vertices[i][:3] for i in (a, b, c))
        n = cross(sub(pb, pa), sub(pc, pa))
        if dot(n, n) > 1e-14:
            self.indices += (a, b, c)

    def planar_uv(self, p, n):
        """Box projection, turned by a quarter for `upright` meshes."""
        u, v = self.box_uv(p, n)
        return (-v, u) if self.upright else (u, v)

    def box_uv(self, p, n):
        """Box projection along the largest component of the normal; v runs downwards."""
        ax, ay, az = abs(n[0]), abs(n[1]), abs(n[2])
        s = 1.0 / self.tile
        if ay >= ax and ay >= az:
            return (p[0] * s, p[2] * s)
        if ax >= az:
            return (math.copysign(s, -n[0]) * p[2], -p[1] * s)
        return (math.copysign(s, n[2]) * p[0], -p[1] * s)

    def polygon(self, points, uvs=None):
        """A flat convex polygon, counter-clockwise as seen from its front."""
        n = (0.0, 0.0, 0.0)
        for i in range(1, len(points) - 1):
            n = add(n, cross(sub(points[i], points[0]), sub(points[i + 1], points[0])))
        n = normalize(n)
        ids = [self.vertex(p, n, uvs[i] if uvs else self.planar_uv(p, n))
               for i, p in enumerate(points)]
        for i in range(1, len(ids) - 1):
            self.triangle(ids[0], ids[i], ids[i + 1])

    def box(self, low, high, skip=""):
        """An axis-aligned box; `skip` names left-out faces: l r (x), b t (y), n f (z)."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        faces = {
            "l": ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
            "r": ((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
            "b": ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
            "t": ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
            "n": ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
            "f": ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        }
        for name, face in faces.items():
            if name not in skip:
                self.polygon(face)

    def grid(self, points, uvs, closed=False):
        """A smooth surface through rows of points; front towards d(column) x d(row).

        With `closed` the first and last column coincide and share their normals.
        """
        rows, cols = len(points), len(points[0])
        normals = [[(0.0, 0.0, 0.0)] * cols for _ in range(rows)]
        for i in range(rows - 1):
            for j in range(cols - 1):
                a, b = points[i][j], points[i][j + 1]
                c, d = points[i + 1][j + 1], points[i + 1][j]
                n = cross(sub(c, a), sub(d, b))
                for r, s in ((i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)):
                    normals[r][s] = add(normals[r][s], n)
        ids = []
        for i in range(rows):
            if closed:
                seam = add(normals[i][0], normals[i][-1])
                normals[i][0] = normals[i][-1] = seam
            ids.append([self.vertex(points[i][j], normalize(normals[i][j]), uvs[i][j])
                        for j in range(cols)])
        for i in range(rows - 1):
            for j in range(cols - 1):
                self.triangle(ids[i][j], ids[i][j + 1], ids[i + 1][j + 1])
                self.triangle(ids[i][j], ids[i + 1][j + 1], ids[i + 1][j])

    def lathe(self, profile, segments, center=(0.0, 0.0, 0.0), shape=None):
        """A surface of revolution about y through (radius, height) pairs, listed upwards on
        the outside. `shape(angle, height)` may scale the radius."""
        points, uvs, length = [], [], 0.0
        widest = max(r for r, _ in profile)
        for i, (r, y) in enumerate(profile):
            if i:
                length += math.hypot(r - profile[i - 1][0], y - profile[i - 1][1])
            row, uv = [], []
            for j in range(segments + 1):
                a = 2.0 * math.pi * (j % segments) / segments
                k = r * (shape(a, y) if shape else 1.0)
                row.append((center[0] + k * math.cos(a), center[1] + y,
                            center[2] - k * math.sin(a)))
                uv.append((2.0 * math.pi * widest * j / segments / self.tile,
                           -length / self.tile))
            points.append(row)
            uvs.append(uv)
        self.grid(points, uvs, closed=True)

    def prism_lathe(self, profile, sides, turn=0.0, center=(0.0, 0.0, 0.0)):
        """Like `lathe`, with flat sides; the profile may be any polyline on the outside."""
        def at(r, y, j):
            a = turn + 2.0 * math.pi * (j % sides) / sides
            return (center[0] + r * math.cos(a), center[1] + y, center[2] - r * math.sin(a))

        length = 0.0
        for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
            step = math.hypot(r1 - r0, y1 - y0)
            for j in range(sides):
                corners = [at(r0, y0, j), at(r0, y0, j + 1), at(r1, y1, j + 1), at(r1, y1, j)]
                w0, w1 = (r * math.sin(math.pi / sides) / self.tile for r in (r0, r1))
                v0, v1 = -length / self.tile, -(length + step) / self.tile
                uvs = [(-w0, v0), (w0, v0), (w1, v1), (-w1, v1)]
                if r0 < 1e-6:
                    corners, uvs = corners[1:], uvs[1:]
                elif r1 < 1e-6:
                    corners, uvs = corners[:3], uvs[:3]
                self.polygon(corners, uvs)
            length += step

    def ring(self, profile, half_x, half_z, closed=True):
        """Sweeps a profile of (outwards, up) pairs around a rectangle, with mitred corners.

        Counter-clockwise profiles (outwards to the right) give outward normals.
        """
        pairs = list(zip(profile, profile[1:] + profile[:1]))
        for (d0, y0), (d1, y1) in pairs if closed else pairs[:-1]:
            for side in range(4):
                hx, hz = (half_x, half_z) if side % 2 == 0 else (half_z, half_x)
                quad = ((-(hx + d0), y0, hz + d0), (hx + d0, y0, hz + d0),
                        (hx + d1, y1, hz + d1), (-(hx + d1), y1, hz + d1))
                self.polygon([turned(p, side) for p in quad])

    def append(self, other, place):
        """Copies another mesh with every vertex passed through `place(p, is_vector)`."""
        ids = [self.vertex(place(v[:3], False), normalize(place(v[3:6], True)), v[6:])
               for v in other.vertices]
        for i in range(0, len(other.indices), 3):
            self.triangle(*(ids[k] for k in other.indices[i:i + 3]))

    def buffers(self):
        """Packed positions, normals and texture coordinates."""
        flat = [c for v in self.vertices for c in v[:3]], \
               [c for v in self.vertices for c in normalize(v[3:6])], \
               [c for v in self.vertices for c in v[6:]]
        return [struct.pack(f"<{len(f)}f", *f) for f in flat]


def turned(p, quarter):
    """A point turned by quarters about y: +z goes to +x."""
    x, y, z = p
    return ((x, y, z), (z, y, -x), (-x, y, -z), (-z, y, x))[quarter % 4]
