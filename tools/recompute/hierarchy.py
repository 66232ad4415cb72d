"""The hierarchy: placement, moments, grid lights, the merged list.

Every stage takes a dump, a random generator and a number of pixels, and gives the number of values it compared and the
worst difference.
"""

import numpy as np

from .compare import magnitude, worst
from .reader import unpack_octahedral

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# The unit of the fixed-point sums.
FIXED_POINT = 2.0**-40
# Shares of a light at a vertex that are not above this are left out.
MIN_WEIGHT = 1e-6


class Grid:
    """Placement and levels of the grids. Positions in cells are computed in single precision as the shaders do, since
    they decide which cell a light is in."""

    def __init__(self, dump):
        placement = dump.get("bounds/place_grid", "grid_placement")[0]
        self.origin, self.top = placement["origin_ws"], dump.frame["top_level"]
        self.h_top, self.inverse_h_top = placement["h_top"], placement["inverse_h_top"]
        self.flux_scale = float(placement["flux_scale"])

    def edge(self, level):
        return float(self.h_top) * 2.0 ** (level - self.top)

    def vertices(self, level):
        return 2 ** (self.top - level) + 1

    def cells(self, positions, level):
        scale = np.float32(self.inverse_h_top * np.float32(2.0 ** (self.top - level)))
        return np.clip((positions - self.origin) * scale, 0, self.vertices(level) - 1).astype(np.float64)

    def corners(self, cells, level):
        """Of the eight vertices around each position in cells: index in the level, trilinear weight, offset."""
        n = self.vertices(level)
        cell = np.minimum(np.floor(cells), n - 2)
        fraction = cells - cell
        for i in range(8):
            corner = np.array([i & 1, i >> 1 & 1, i >> 2])
            weight = np.where(corner == 1, fraction, 1.0 - fraction).prod(axis=1)
            x, y, z = (cell + corner).astype(np.int64).T
            yield (z * n + y) * n + x, weight, fraction - corner

    def vertex_position(self, index, level):
        n = self.vertices(level)
        index = index.astype(np.int64)
        return np.stack([index % n, index // n % n, index // (n * n)], axis=1).astype(np.float64)


def add_at(records, vertices, index, values):
    """Adds values to the records of the vertices that have one; `vertices` are sorted, as grid lights are."""
    place = np.minimum(np.searchsorted(vertices, index), len(vertices) - 1)
    known = vertices[place] == index
    np.add.at(records, place[known], values[known])


def placement(dump, _rng, _pixels):
    positions = dump.get("compaction/compact_vpls", "light_positions")["position_ws"]
    fluxes = dump.get("compaction/compact_vpls", "light_fluxes")["flux"]
    bounds = dump.get("bounds/reduce_bounds", "bounds")[0]
    found = dump.get("bounds/place_grid", "grid_placement")[0]
    low, high = positions.min(axis=0), positions.max(axis=0)
    radius = dump.frame["scene_radius"]
    origin, edge = low, max(float((high - low).max()) * 1.0001, 1e-4 * radius)
    flux_scale = fluxes.max()
    anchor = dump.manifest["shape"]["grid_anchor"]
    if anchor is not None:
        origin, edge = np.array(anchor["low_ws"]), anchor["edge"]
        slack = 1.0 / 1024.0
        while (low < origin - slack * edge).any() or (high > origin + (1.0 + slack) * edge).any():
            origin, edge = origin - edge * (low < origin - slack * edge), 2.0 * edge
        flux_scale = 2.0 ** np.ceil(np.log2(flux_scale))
    errors = [
        worst(bounds["lowest_ws"], low, radius),
        worst(bounds["highest_ws"], high, radius),
        worst(bounds["largest_flux"], fluxes.max(), fluxes.max()),
        worst(found["origin_ws"], origin, radius),
        worst(found["h_top"], edge, edge),
        worst(found["inverse_h_top"], 1.0 / edge, 1.0 / edge),
        worst(found["flux_scale"], flux_scale, flux_scale),
        worst(found["light_count"], len(positions), 1.0),
    ]
    return 15, max(errors)


def moments(dump, _rng, _pixels):
    grid = Grid(dump)
    lights = dump.get("compaction/compact_vpls", "light_positions")
    fluxes = dump.get("compaction/compact_vpls", "light_fluxes")
    flux = fluxes["flux"] / grid.flux_scale
    m = flux @ LUMINANCE
    normal = unpack_octahedral(lights["normal_octahedral"]) * (fluxes["is_vpl"] > 0.5)[:, None]
    count, error = 0, 0.0
    for level in dump.levels():
        if not dump.has(f"grid_scatter/S{level}", "moments"):
            continue
        found = dump.get(f"grid_scatter/S{level}", "moments") * FIXED_POINT
        vertices = dump.get(dump.grid_lights(level), "grid_lights")["vertex"]
        sums = np.zeros(found.shape)
        for index, w, q in grid.corners(grid.cells(lights["position_ws"], level), level):
            w = np.where(w > MIN_WEIGHT, w, 0.0)
            wm = np.where(w > 0.0, np.maximum(w * m, FIXED_POINT), 0.0)[:, None]
            w = w[:, None]
            values = np.concatenate([w, wm, wm * q, wm * q * q, wm * normal, w * flux], axis=1)
            add_at(sums, vertices, index, values)
        scale = magnitude(sums[:, :2])
        scale = np.concatenate([scale, np.repeat(scale[:, 1:2], 9, axis=1), magnitude(sums[:, 11:])], axis=1)
        count, error = count + found.size, max(error, worst(found, sums, scale))
    return count, error


def compare_lights(found, light, h):
    """Worst difference of grid lights: centre in cells, variance in squared cells, the rest relative."""
    return max(
        worst(found["position_ws"], light["position_ws"], h),
        worst(found["variance"], light["variance"], h * h),
        worst(found["lobe"], light["lobe"], 1.0),
        *(worst(found[key], light[key], magnitude(light[key])) for key in ("luminance", "weight", "flux")),
    )


def scattered_lights(dump, _rng, _pixels):
    grid, count, error = Grid(dump), 0, 0.0
    for level in dump.levels():
        if not dump.has(f"grid_scatter/S{level}", "moments"):
            continue
        sums = dump.get(f"grid_scatter/S{level}", "moments") * FIXED_POINT
        found = dump.get(f"grid_scatter/resolve_S{level}", "grid_lights")
        h, wm = grid.edge(level), sums[:, 1:2]
        mean = sums[:, 2:5] / wm
        light = {
            "position_ws": grid.origin + (grid.vertex_position(found["vertex"], level) + mean) * h,
            "variance": np.maximum(sums[:, 5:8] / wm - mean**2, 0.0) * h * h,
            "lobe": sums[:, 8:11] / wm,
            "luminance": sums[:, 1] * grid.flux_scale,
            "weight": sums[:, 0],
            "flux": sums[:, 11:] * grid.flux_scale,
        }
        count, error = count + 14 * len(found), max(error, compare_lights(found, light, h))
    return count, error


def gathered_lights(dump, _rng, _pixels):
    grid, count, error = Grid(dump), 0, 0.0
    s1 = dump.get(dump.grid_lights(1), "grid_lights")
    for level in dump.levels():
        if not dump.has(f"grid_gather/S{level}", "grid_lights"):
            continue
        found = dump.get(f"grid_gather/S{level}", "grid_lights")
        h, sums = grid.edge(level), np.zeros((len(found), 14))
        at_vertex = grid.vertex_position(s1["vertex"], 1) * 0.5 ** (level - 1)
        off_vertex = grid.cells(s1["position_ws"], level) - at_vertex
        for index, w, q in grid.corners(at_vertex, level):
            w, q = w[:, None], q + off_vertex
            wm = w * s1["luminance"][:, None]
            square = wm * (s1["variance"] / (h * h) + q * q)
            values = [w * s1["weight"][:, None], wm, wm * q, square, wm * s1["lobe"], w * s1["flux"]]
            add_at(sums, found["vertex"], index, np.concatenate(values, axis=1))
        wm = sums[:, 1:2]
        mean = sums[:, 2:5] / wm
        light = {
            "position_ws": grid.origin + (grid.vertex_position(found["vertex"], level) + mean) * h,
            "variance": np.maximum(sums[:, 5:8] / wm - mean**2, 0.0) * h * h,
            "lobe": sums[:, 8:11] / wm,
            "luminance": sums[:, 1],
            "weight": sums[:, 0],
            "flux": sums[:, 11:],
        }
        count, error = count + 14 * len(found), max(error, compare_lights(found, light, h))
    return count, error


def energy(dump, _rng, _pixels):
    total = dump.get("compaction/compact_vpls", "light_fluxes")["flux"].sum(axis=0, dtype=np.float64)
    sums = [dump.get(dump.grid_lights(l), "grid_lights")["flux"].sum(axis=0, dtype=np.float64) for l in dump.levels()]
    return 3 * len(sums), max(worst(s, total, total) for s in sums)


def original_lights(dump, like):
    """The lights S0 as merged lights."""
    lights = dump.get("compaction/compact_vpls", "light_positions")
    fluxes = dump.get("compaction/compact_vpls", "light_fluxes")
    made = np.zeros(len(lights), like)
    made["position_ws"], made["flux"], made["weight"] = lights["position_ws"], fluxes["flux"], 1.0
    made["luminance"] = fluxes["flux"] @ LUMINANCE
    made["lobe"] = unpack_octahedral(lights["normal_octahedral"]) * (fluxes["is_vpl"] > 0.5)[:, None]
    made["vertex"] = np.arange(len(lights))
    return made


def merged(dump, _rng, _pixels):
    """The merged list: dealt to the sub-images, a level with fewer lights than sub-images copied to each."""
    found = dump.get("merge", "merged_lights")
    sub_image_count = dump.frame["interleave"] ** 2
    levels = []
    for level in range(dump.frame["first_level"], dump.frame["top_level"] + 1):
        if level == 0:
            levels.append(original_lights(dump, found.dtype))
            continue
        step = dump.grid_lights(level)
        lights = dump.get(step, "grid_lights").copy()
        lights["vertex"] = dump.files[step, "grid_lights"]["first_element"] + np.arange(len(lights))
        levels.append(lights)
    parts = []
    for sub_image in range(sub_image_count):
        for lights in levels:
            part = lights if len(lights) < sub_image_count else lights[sub_image::sub_image_count].copy()
            if len(lights) >= sub_image_count:
                part["flux"] *= sub_image_count
                part["luminance"] *= sub_image_count
                part["weight"] *= sub_image_count
            parts.append(part)
    expected = np.concatenate(parts)
    scales = {key: 1.0 if key == "lobe" else magnitude(expected[key]) for key in found.dtype.names}
    return found.size * 16, max(worst(found[key], expected[key], scale) for key, scale in scales.items())
