"""Plants made of alpha-masked leaf cards."""

import math

from .mesh import Mesh, add, cross, normalize
from .noise import Rng


def card(mesh, root, direction, facing, length, width, bend=0.0, steps=1):
    """A leaf strip from `root` along `direction`, facing `facing`, drooping by `bend`."""
    direction = normalize(direction)
    side = normalize(cross(direction, facing))
    points, uvs, p = [], [], root
    for i in range(steps + 1):
        t = i / steps
        points.append([add(p, side, -width / 2), add(p, side, width / 2)])
        uvs.append([(0.01, 0.99 - 0.98 * t), (0.99, 0.99 - 0.98 * t)])
        direction = normalize(add(direction, (0.0, -1.0, 0.0), bend / steps))
        p = add(p, direction, length / steps)
    mesh.grid(points, uvs)


def bush(seed, count, radius, height, size):
    """A rounded crown of leaf sprays standing on y = 0."""
    mesh, rng = Mesh(), Rng(seed)
    for _ in range(count):
        out = rng.unit()
        r = radius * rng.next(0.25, 0.85)
        root = (out[0] * r, height * 0.5 + out[1] * height * 0.4 * r / radius, out[2] * r)
        aim = normalize(add(out, rng.unit(), 0.55))
        aim = add(aim, (0.0, 1.0, 0.0), 0.35)
        s = size * rng.next(0.75, 1.2)
        card(mesh, root, aim, add(rng.unit(), out, 1.2), s, s, 0.35, 2)
    return mesh


def fern(seed, count, length):
    """Arching fronds that spring from one point."""
    mesh, rng = Mesh(), Rng(seed)
    for i in range(count):
        a = 2.0 * math.pi * (i + rng.next(-0.3, 0.3)) / count
        rise = rng.next(0.9, 2.6)
        flat = (math.cos(a), 0.0, math.sin(a))
        aim = add(flat, (0.0, 1.0, 0.0), rise)
        s = length * rng.next(0.75, 1.1)
        root = (0.05 * flat[0], 0.0, 0.05 * flat[2])
        up = (-flat[0] * rise, 1.0, -flat[2] * rise)
        card(mesh, root, aim, up, s, s * 0.42, rng.next(1.3, 2.1), 6)
    return mesh


def ivy(seed, count, width, height):
    """A hanging mat in the xy plane in front of z = 0, from y = 0 downwards."""
    mesh, rng = Mesh(), Rng(seed)
    strands = max(3, int(width / 0.16))
    lengths = [height * rng.next(0.35, 1.0) for _ in range(strands)]
    for _ in range(count):
        k = int(rng.next(0, strands))
        x = ((k + 0.5) / strands - 0.5) * width + rng.next(-0.07, 0.07)
        y = -lengths[k] * rng.next() ** 0.8
        lean = (rng.next(-0.5, 0.5), rng.next(-0.35, 0.45), 1.0)
        s = rng.next(0.2, 0.3)
        aim = (rng.next(-0.5, 0.5), -1.0, rng.next(0.0, 0.5))
        # Below the handrail the strands swing out over the floor's edge.
        out = 0.36 * min(1.0, max(0.0, (-0.5 - y) / 0.35))
        card(mesh, (x, y + s / 2, out + rng.next(0.03, 0.12)), aim, lean, s, s)
    return mesh
