"""Deterministic randomness: an integer hash, a small generator and periodic value noise."""

import math


def hash32(*keys):
    """Mixes integers into 32 well-scrambled bits."""
    h = 0x9E3779B9
    for key in keys:
        h ^= key & 0xFFFFFFFF
        h = (h * 0x85EBCA6B) & 0xFFFFFFFF
        h ^= h >> 13
        h = (h * 0xC2B2AE35) & 0xFFFFFFFF
        h ^= h >> 16
    return h


def hash01(*keys):
    """The same as a number in [0, 1)."""
    return hash32(*keys) / 4294967296.0


class Rng:
    """A counter-based stream of random numbers."""

    def __init__(self, seed):
        self.seed = seed
        self.count = 0

    def next(self, low=0.0, high=1.0):
        """Uniform in [low, high)."""
        self.count += 1
        return low + (high - low) * hash01(self.seed, self.count)

    def unit(self):
        """A direction uniform on the sphere."""
        y = self.next(-1.0, 1.0)
        a = self.next(0.0, 2.0 * math.pi)
        r = math.sqrt(max(0.0, 1.0 - y * y))
        return (r * math.cos(a), y, r * math.sin(a))


class ValueNoise:
    """Value noise on a lattice that repeats after `px` by `py` cells over the unit square."""

    def __init__(self, px, py, seed):
        self.px, self.py = px, py
        self.lattice = [[hash01(seed, x, y) for x in range(px)] for y in range(py)]

    def __call__(self, u, v):
        x, y = u * self.px, v * self.py
        xi, yi = math.floor(x), math.floor(y)
        fx, fy = x - xi, y - yi
        fx, fy = fx * fx * (3.0 - 2.0 * fx), fy * fy * (3.0 - 2.0 * fy)
        row0 = self.lattice[yi % self.py]
        row1 = self.lattice[(yi + 1) % self.py]
        x0, x1 = xi % self.px, (xi + 1) % self.px
        top = row0[x0] + (row0[x1] - row0[x0]) * fx
        bottom = row1[x0] + (row1[x1] - row1[x0]) * fx
        return top + (bottom - top) * fy


class Fbm:
    """Octaves of value noise, normalised to [0, 1], periodic over the unit square."""

    def __init__(self, px, py, octaves, seed, gain=0.5):
        self.layers = []
        total, amplitude = 0.0, 1.0
        for octave in range(octaves):
            noise = ValueNoise(px << octave, py << octave, seed + 101 * octave)
            self.layers.append((amplitude, noise))
            total += amplitude
            amplitude *= gain
        self.scale = 1.0 / total

    def __call__(self, u, v):
        return self.scale * sum(a * noise(u, v) for a, noise in self.layers)
