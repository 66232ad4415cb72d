"""Everything by pixel: blending, lighting, shadow samples, composition. Stages as in `hierarchy`."""

import numpy as np

from .compare import magnitude, worst
from .hierarchy import LUMINANCE, Grid
from .reader import unpack_octahedral

NO_LIGHT = 0xFFFFFFFF


def blend_weight(d, radius, level, first, last):
    """Blending function of a level at distance d."""
    rise = np.where(level == first, 1.0, np.clip(2.0 * d / radius - 1.0, 0.0, 1.0))
    fall = np.where(level == last, 1.0, np.clip(2.0 - d / radius, 0.0, 1.0))
    return np.minimum(rise, fall)


def blending(dump, rng, pixels):
    """The radii, and that with them the weights of all levels add up to 1 at any distance."""
    grid, lights = Grid(dump), dump.get("merge", "merged_lights")
    radii = dump.get("merge", "blending_radii").astype(np.float64)
    expected = dump.frame["alpha"] * grid.h_top * 2.0 ** (lights["level"].astype(np.float64) - grid.top)
    first, last = dump.frame["first_level"], grid.top
    distance = rng.uniform(0.0, 3.0, pixels) * dump.frame["alpha"] * float(grid.h_top)
    total = np.zeros(pixels)
    for level in range(first, last + 1):
        of_level = radii[lights["level"] == level]
        radius = of_level[0] if len(of_level) else dump.frame["alpha"] * grid.edge(level)
        total += blend_weight(distance, radius, level, first, last)
    return len(radii) + pixels, max(worst(radii, expected, expected), worst(total, np.ones(pixels), 1.0))


class Visible:
    """Random pixels that show a surface: where they are, and what is seen there."""

    def __init__(self, dump, rng, pixels):
        frame = dump.frame
        depth = dump.get("gbuffer", "gbuffer_depth")[..., 0]
        y, x = np.nonzero(depth > 0.0)
        pick = rng.choice(len(x), min(pixels, len(x)), replace=False)
        self.x, self.y = x[pick], y[pick]
        ray = dump.view_rays(self.x, self.y)
        self.position = np.array(frame["eye_ws"]) + ray * (frame["near"] / depth[self.y, self.x])[:, None]
        words = np.ascontiguousarray(dump.get("gbuffer", "gbuffer_normals")[self.y, self.x])
        self.normal, self.geometric = np.moveaxis(unpack_octahedral(words.view("<i2").reshape(-1, 2, 2)), 1, 0)

    def origins(self, frame, offset):
        """Where rays start, off the surface by this much of the numbers there and a step of the rasteriser."""
        away = (self.position - np.array(frame["eye_ws"])) @ np.array(frame["forward_ws"])
        size = np.maximum(np.abs(self.position).max(axis=1), frame["largest_triangle"])
        return self.position + self.geometric * (offset * size + frame["rasteriser_step"] * away)[:, None]


class Surface(Visible):
    """The same with the lights of each pixel's sub-image and their weights."""

    def __init__(self, dump, rng, pixels):
        super().__init__(dump, rng, pixels)
        frame = dump.frame
        n, (w, h) = frame["interleave"], frame["sub_image_px"]
        self.sub_image = self.y % n * n + self.x % n
        self.row, self.column = self.y % n * h + self.y // n, self.x % n * w + self.x // n
        self.index = self.row * (w * n) + self.column
        self.lights = dump.get("merge", "merged_lights")
        self.radii = dump.get("merge", "blending_radii").astype(np.float64)
        self.sub_images = dump.get("merge/deal_lights", "sub_images")

    def lit(self, dump, pixel):
        """Radiance per unit albedo from each light of the pixel's sub-image, and the index of the first of them."""
        frame, starts = dump.frame, self.sub_images[self.sub_image[pixel]]
        first, top = frame["first_level"], frame["top_level"]
        start, end = starts[first], starts[top + 1]
        lights, radius = self.lights[start:end], self.radii[start:end]
        offset = lights["position_ws"] - self.position[pixel]
        d = np.linalg.norm(offset, axis=1)
        weight = blend_weight(d, radius, lights["level"], first, top)
        w = offset / np.maximum(d, 1e-20)[:, None]
        cosine = np.maximum(w @ self.normal[pixel], 0.0)
        length = np.minimum(np.linalg.norm(lights["lobe"], axis=1), 1.0)
        towards = np.maximum(-(lights["lobe"] * w).sum(axis=1), 0.0)
        intensity = ((1.0 - length) * 0.25 + towards) / np.pi
        is_vpl = (lights["level"] == 0) & (length > 0.0)
        own_luminance = lights["luminance"] / lights["weight"]
        larger = np.where(is_vpl, np.maximum(own_luminance / frame["large_vpl_luminance"], 1.0), 1.0)
        response = weight * intensity * cosine / np.maximum(d * d, frame["clamp_squared"] * larger) / np.pi
        return response[:, None] * lights["flux"].astype(np.float64), int(start)


def lighting(dump, rng, pixels):
    if not dump.has(dump.lighting_step, "lighting"):
        return 0, 0.0
    surface = Surface(dump, rng, pixels)
    found = dump.get(dump.lighting_step, "lighting")[surface.row, surface.column]
    expected = np.zeros(found.shape)
    for pixel in range(len(found)):
        radiance, start = surface.lit(dump, pixel)
        level = surface.lights["level"][start : start + len(radiance)]
        expected[pixel, :3] = radiance.sum(axis=0)
        expected[pixel, 3] = (radiance @ LUMINANCE)[level >= dump.frame["shadow_from"]].sum()
    return found.size, worst(found, expected, magnitude(expected))


def hash_words(value):
    """PCG hash of 32-bit words."""
    value = np.asarray(value, np.uint64)
    mask = np.uint64(0xFFFFFFFF)
    state = (value * np.uint64(747796405) + np.uint64(2891336453)) & mask
    word = (((state >> ((state >> np.uint64(28)) + np.uint64(4))) ^ state) * np.uint64(277803737)) & mask
    return (word >> np.uint64(22)) ^ word


def shadow_samples(dump, rng, pixels):
    """The light that each reservoir kept is the one with the smallest key -ln(u) / f; where every pixel's sum of weights
    was kept instead, that sum."""
    if not dump.has(dump.lighting_step, "reservoirs"):
        return 0, 0.0
    surface, reservoirs = Surface(dump, rng, pixels), dump.get(dump.lighting_step, "reservoirs")
    found = reservoirs[surface.row, surface.column]
    if dump.manifest["settings"]["reservoir"] == "race":
        # Updates may be lost, by design.
        return 0, 0.0
    if "total" in found.dtype.names:
        total = dump.get(dump.lighting_step, "lighting")[surface.row, surface.column, 3]
        return total.size, worst(found["total"], total, magnitude(total))
    error, seed = 0.0, np.uint64(dump.frame["seed"])
    for pixel, chosen in enumerate(found):
        radiance, start = surface.lit(dump, pixel)
        light = np.arange(start, start + len(radiance), dtype=np.uint64)
        f = np.where(surface.lights["level"][light] >= dump.frame["shadow_from"], radiance @ LUMINANCE, 0.0)
        stream = hash_words(light ^ hash_words(np.uint64(surface.index[pixel]) ^ hash_words(seed)))
        for i, kept in enumerate(chosen):
            random = hash_words((stream + np.uint64(i * 0x9E3779B9)) & np.uint64(0xFFFFFFFF))
            u = ((random >> np.uint64(9)).astype(np.float64) + 0.5) / 8388608.0
            keys = np.where(f > 0.0, -np.log(u) / np.maximum(f, 1e-300), np.inf)
            if kept["light"] == NO_LIGHT:
                error = max(error, 0.0 if keys.min() > 1e30 else np.inf)
            else:
                # Its own key must be what was noted, and no other may be clearly smaller. Near 0 logarithms are only
                # good to 2^-21.
                at = int(kept["light"]) - start
                own, weight = (keys[at], f[at]) if 0 <= at < len(keys) else (np.inf, 0.0)
                scale = max(own, 5e-4 / max(weight, 1e-300))
                error = max(error, worst(kept["key"], own, scale), worst(kept["key"], keys.min(), scale))
    return found.size, error


def shadowed_lighting(dump, lighting):
    """What the estimates make of the lighting: S / U darkens it, or S takes its place."""
    (s, _), (u, unit) = (np.split(dump.get(*dump.last(name)), [3], axis=-1) for name in ("shadowed", "unshadowed"))
    if dump.manifest["settings"]["shadow-estimate"] == "ratio":
        return lighting * np.where(u > 0.0, s / np.where(u > 0.0, u, 1.0), 1.0)
    return s * unit


def compose(dump, _rng, _pixels):
    """Direct light plus albedo times lighting with its shadow, at every pixel."""
    found = dump.get("compose", "radiance")[..., :3]
    expected = np.zeros(found.shape)
    if dump.has("direct_light", "direct"):
        expected += dump.get("direct_light", "direct")[..., :3]
    key = dump.last("lighting", "lighting_blurred", "reference_lighting")
    if key:
        indirect = dump.get(*key)[..., :3]
        if dump.last("shadowed"):
            indirect = shadowed_lighting(dump, indirect)
        expected += dump.get("gbuffer", "gbuffer_albedo")[..., :3] * indirect
    return found.size, worst(found, expected, magnitude(expected.reshape(-1, 3)).reshape(expected.shape))


def accumulate(dump, _rng, _pixels):
    """The mean is the sum over the sum of weights; of the first frame that is the frame."""
    if not dump.has("accumulate", "accumulated_mean"):
        return 0, 0.0
    found, total = dump.get("accumulate", "accumulated_mean")[..., :3], dump.get("accumulate", "accumulated_sum")
    expected = total[..., :3] / np.maximum(total[..., 3:], 1e-300)
    return found.size, worst(found, expected, magnitude(expected.reshape(-1, 3)).reshape(expected.shape))
