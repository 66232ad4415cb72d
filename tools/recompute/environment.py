"""Light of the environment: what its shadow rays find, and the background. Stages as in `hierarchy`."""

import numpy as np

from .compare import magnitude, worst
from .hierarchy import LUMINANCE
from .pictures import Visible, hash_words

# Directions that each ray is chosen from, and how far rays stay off a surface, relative to the numbers there.
CANDIDATES, RAY_OFFSET = 8, 2.0**-20
# Decisions this near, relative to what they are between, may fall either way in single precision.
NEAR = 2e-3
# Rays are compared with every triangle.
MOST_PIXELS = 30


class Environment:
    """The image and the table of a dump. Directions are before the environment is turned back, in world space."""

    def __init__(self, dump):
        frame = dump.frame
        self.image = dump.get("scene", "environment_map").astype(np.float64) * frame["environment_scale"]
        self.turn = frame["environment_turn"]
        self.columns, self.rows = frame["environment_cells"]
        table = dump.get("scene", "environment_table").astype(np.float64)
        self.row_sums = table[: self.rows + 1]
        self.cell_sums = table[self.rows + 1 :].reshape(self.rows, self.columns + 1)

    def place(self, direction):
        """Where directions lie in the image, 0 to 1 from the left and from the top."""
        x, y, z = np.moveaxis(direction, -1, 0)
        azimuth, polar = np.arctan2(z, x), np.arctan2(np.hypot(x, z), y)
        return (azimuth / (2.0 * np.pi) + 0.5 + self.turn) % 1.0, polar / np.pi

    def radiance(self, direction):
        """Bilinear between the centres of texels, around and up to the poles."""
        height, width, _ = self.image.shape
        u, v = self.place(direction)
        x, y = u * width - 0.5, v * height - 0.5
        left, top = np.floor(x).astype(int), np.floor(y).astype(int)
        across, down = (x - left)[..., None], (y - top)[..., None]
        rows = [np.clip(top + step, 0, height - 1) for step in (0, 1)]
        upper, lower = (
            (1.0 - across) * self.image[row, left % width] + across * self.image[row, (left + 1) % width]
            for row in rows
        )
        return (1.0 - down) * upper + down * lower

    def cosines(self, row):
        """Of the angles from +y at a row's upper and lower edge."""
        return np.cos(np.pi * row / self.rows), np.cos(np.pi * (row + 1) / self.rows)

    def density(self, row, column):
        """Probability of a cell over its solid angle."""
        upper, lower = self.cosines(row)
        share = self.row_sums[row + 1] - self.row_sums[row]
        share = share * (self.cell_sums[row, column + 1] - self.cell_sums[row, column])
        return share / (2.0 * np.pi / self.columns * (upper - lower))

    def draw(self, u, v):
        """The directions of two numbers each."""
        row = np.clip(np.searchsorted(self.row_sums, v, side="right") - 1, 0, self.rows - 1)
        column = (self.cell_sums[row] <= u[:, None]).sum(axis=1) - 1
        column = np.clip(column, 0, self.columns - 1)
        first, end = self.row_sums[row], self.row_sums[row + 1]
        down = (v - first) / (end - first)
        first, end = self.cell_sums[row, column], self.cell_sums[row, column + 1]
        along = (u - first) / (end - first)
        upper, lower = self.cosines(row)
        cosine = upper + (lower - upper) * down
        azimuth = 2.0 * np.pi * ((column + along) / self.columns - self.turn - 0.5)
        across = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
        return np.stack([across * np.cos(azimuth), cosine, across * np.sin(azimuth)], axis=-1)

    def density_of(self, direction):
        """Densities of directions, and whether each lies clearly within its cell."""
        u, v = self.place(direction)
        x, y = u * self.columns, v * self.rows
        column, row = np.minimum(x.astype(int), self.columns - 1), np.minimum(y.astype(int), self.rows - 1)
        inside = [(np.abs(at - np.round(at)) > NEAR) | (count == 1) for at, count in ((x, self.columns), (y, self.rows))]
        return self.density(row, column), inside[0] & inside[1]


def unit_float(bits):
    return ((np.asarray(bits, np.uint64) >> np.uint64(9)).astype(np.float64) + 0.5) / 8388608.0


def words(value):
    return np.asarray(value, np.uint64) & np.uint64(0xFFFFFFFF)


def r2_sequence(index, seed):
    """Point `index` of the R2 sequence, shifted by seeds."""
    shifts = hash_words(seed), hash_words(seed ^ np.uint64(0x68BC21EB))
    return [unit_float(words(np.uint64(step * index) + shift)) for step, shift in zip((3242174889, 2447445414), shifts)]


def cosine_direction(normal, u, v):
    """Directions about normals as their cosine, in the frame of Duff et al. 2017."""
    x, y, z = normal.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    c = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * c, -sign * x], axis=-1)
    bitangent = np.stack([c, sign + y * y * a, -y], axis=-1)
    radius, angle = np.sqrt(u), 2.0 * np.pi * v
    along = (radius * np.cos(angle))[:, None] * tangent + (radius * np.sin(angle))[:, None] * bitangent
    direction = along + np.sqrt(1.0 - u)[:, None] * normal
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


class Rays:
    """The directions that pixels have chosen: each with what it brings, and for each pixel whether all of its choices are
    clear in single precision too."""

    def __init__(self, dump, environment, seen):
        count = len(seen.x)
        self.clear = np.ones(count, bool)
        index = np.uint64(dump.frame["size_px"][0]) * seen.y.astype(np.uint64) + seen.x.astype(np.uint64)
        seed = np.uint64(dump.frame["sampling_seed"] ^ 0x1B873593)
        self.seed = hash_words(index ^ hash_words(seed))
        self.state = hash_words(self.seed)
        samples = dump.manifest["settings"]["environment-samples"]
        self.chosen = [self.choose(environment, seen, i * CANDIDATES) for i in range(samples)]
        for _, radiance in self.chosen:
            radiance /= np.pi * samples

    def choose(self, environment, seen, first):
        """One of the candidates from `first` on for every pixel: direction, irradiance."""
        direction, irradiance = np.zeros(seen.normal.shape), np.zeros(seen.normal.shape)
        total = np.zeros(len(seen.x))
        for i in range(CANDIDATES):
            u, v = r2_sequence((first + i) // 2, hash_words(self.seed ^ hash_words(np.uint64(i % 2))))
            drawn = environment.draw(u, v) if i % 2 == 0 else cosine_direction(seen.normal, u, v)
            self.state = hash_words(self.state)
            pick = unit_float(self.state)
            cosine, above = ((drawn * normal).sum(axis=-1) for normal in (seen.normal, seen.geometric))
            brought = environment.radiance(drawn) * cosine[:, None]
            brings = brought @ LUMINANCE
            density, inside = environment.density_of(drawn)
            counts = (cosine > 0.0) & (above > 0.0) & (brings > 0.0)
            weight = np.where(counts, brings / (0.5 * (density + np.maximum(cosine, 0.0) / np.pi)), 0.0)
            total += weight
            taken = counts & (pick * total < weight)
            edges = np.minimum(np.abs(cosine), np.abs(above)) < 1e-4
            self.clear &= ~edges & (inside | ~counts) & ~(counts & (np.abs(pick * total - weight) < NEAR * weight))
            direction[taken] = drawn[taken]
            irradiance[taken] = brought[taken] / brings[taken, None]
        return direction, irradiance * (total / CANDIDATES)[:, None]


def cross(a, b):
    """Of vectors in columns."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


class Triangles:
    """All triangles of the scene."""

    def __init__(self, dump):
        found = dump.get("scene", "triangles")
        names = ("v0_ws", "edge1", "edge2")
        self.v0, self.edge1, self.edge2 = (np.ascontiguousarray(found[name].T, np.float64) for name in names)
        self.normal = cross(self.edge1, self.edge2)
        self.solid = found["flags"] == 0

    def fates(self, origin, directions):
        """For each ray from here, 1 where it leaves the scene, 0 where a solid triangle is in its way, None where that is not
        clear: it passes an edge, or meets a triangle with holes, whose texture is in no dump."""
        offset = origin[:, None] - self.v0
        beside, before = cross(offset, self.edge1), cross(offset, self.edge2)
        height = (beside * self.edge2).sum(axis=0)
        return [self.fate(origin, direction, beside, before, height) for direction in directions]

    def fate(self, origin, direction, beside, before, height):
        with np.errstate(divide="ignore", invalid="ignore"):
            determinant = -(direction @ self.normal)
            u, v = -(direction @ before) / determinant, (direction @ beside) / determinant
            distance = height / determinant
            inside = np.minimum(np.minimum(u, v), 1.0 - u - v)
            near = np.abs(distance) < 1e-6 * np.abs(origin).max()
        if np.any(self.solid & (inside > 1e-4) & (distance > 0.0) & ~near):
            return 0.0
        return None if np.any((inside > -1e-4) & ((distance > 0.0) | near)) else 1.0


def environment_light(dump, rng, pixels):
    """Both estimates of random pixels: the unshadowed one of the directions they choose, the shadowed one where each ray
    has a clear fate."""
    if not dump.has("environment_light", "environment_shadowed") or not dump.has("scene", "environment_map"):
        return 0, 0.0
    seen = Visible(dump, rng, min(pixels, MOST_PIXELS))
    rays = Rays(dump, Environment(dump), seen)
    origins = seen.origins(dump.frame, RAY_OFFSET)
    kinds = ("environment_unshadowed", "environment_shadowed")
    unshadowed, shadowed = (dump.get("environment_light", kind)[seen.y, seen.x, :3] for kind in kinds)
    expected = sum(radiance for _, radiance in rays.chosen)
    scale = magnitude(expected)
    error = worst(unshadowed[rays.clear], expected[rays.clear], scale[rays.clear])
    compared = 3 * int(rays.clear.sum())
    triangles = Triangles(dump)
    for pixel in np.flatnonzero(rays.clear):
        parts = [(radiance[pixel], direction[pixel]) for direction, radiance in rays.chosen if radiance[pixel].any()]
        fates = triangles.fates(origins[pixel], [direction for _, direction in parts])
        if None not in fates:
            light = sum((f * radiance for f, (radiance, _) in zip(fates, parts)), np.zeros(3))
            error = max(error, worst(shadowed[pixel], light, scale[pixel]))
            compared += 3
    return compared, error


def background(dump, _rng, _pixels):
    """Where no surface hides it the environment is what is seen."""
    if not dump.has("direct_light", "direct") or not dump.has("scene", "environment_map"):
        return 0, 0.0
    y, x = np.nonzero(dump.get("gbuffer", "gbuffer_depth")[..., 0] <= 0.0)
    found = dump.get("direct_light", "direct")[y, x, :3]
    rays = dump.view_rays(x, y)
    expected = Environment(dump).radiance(rays)
    return found.size, worst(found, expected, magnitude(expected))
