"""From radiance to what is shown: exposure, tone curve, sRGB. Stages as in `hierarchy`."""

import numpy as np

from .compare import worst
from .hierarchy import LUMINANCE

# The histogram: bins, once for surfaces and once for the background, over these stops; at most so many pixels in it.
BINS, LOWEST, STOPS, MOST_PIXELS = 1024, -32.0, 64.0, 1 << 20


def measured_radiance(dump):
    return dump.get(*dump.last("radiance", "accumulated_mean"))[..., :3]


def shown_radiance(dump):
    return dump.get(*dump.last("radiance", "accumulated_mean", "antialiased"))[..., :3]


def histogram(dump):
    """Pixels by luminance, as the frame's own; those within a thousandth of a bin's edge may be on either side."""
    radiance, depth = measured_radiance(dump), dump.get("gbuffer", "gbuffer_depth")[..., 0]
    height, width = depth.shape
    step = 1
    while -(-height // step) * -(-width // step) > MOST_PIXELS:
        step += 1
    x, y = (np.minimum(np.arange(0, edge, step) + step // 2, edge - 1) for edge in (width, height))
    luminance = radiance[np.ix_(y, x)] @ LUMINANCE
    behind = depth[np.ix_(y, x)] <= 0.0
    seen = luminance > 2.0**LOWEST
    place = (np.log2(luminance[seen]) - LOWEST) * BINS / STOPS
    near = np.abs(place - np.round(place)) < 1e-3
    bins = np.clip(place, 0, BINS - 1).astype(int) + BINS * behind[seen]
    return np.bincount(bins, minlength=2 * BINS), int(near.sum())


def exposure_of(counts):
    """Half way between middle grey for the average of the middle part and white for the highlights."""
    surfaces, background = np.split(counts.astype(np.float64), 2)
    most = 0.25 * surfaces.sum() + 0.01 * counts.sum()
    weights = surfaces + background * min(most / max(background.sum(), 1.0), 1.0)
    ends = np.cumsum(weights)
    total = ends[-1]
    if total == 0.0:
        return 1.0
    part = np.minimum(ends, 0.9 * total) - np.maximum(ends - weights, 0.1 * total)
    middle = np.average(LOWEST + (np.arange(BINS) + 0.5) * STOPS / BINS, weights=np.maximum(part, 0.0))
    at = np.flatnonzero((weights > 0.0) & (ends - weights < 0.98 * total))[-1]
    place = at + min((0.98 * total - (ends - weights)[at]) / weights[at], 1.0)
    return 2.0 ** (0.5 * (np.log2(0.18) - middle - (LOWEST + place * STOPS / BINS)))


def exposure(dump, _rng, _pixels):
    """The histogram, but for pixels on the edge of a bin, and the exposure that follows from it."""
    if not dump.has("tone_map/exposure_histogram", "exposure_histogram"):
        return 0, 0.0
    found = dump.get("tone_map/exposure_histogram", "exposure_histogram").astype(np.int64)
    expected, on_edges = histogram(dump)
    moved = np.abs(found - expected).sum()
    # One that is on the other side is missing in one bin and too much in another.
    error = 0.0 if moved <= 2 * on_edges else float(moved - 2 * on_edges)
    factor = dump.frame["exposure"]
    if factor <= 0.0:
        # Below 0 it is the most that the automatic exposure may be.
        factor = min(exposure_of(found), -factor or np.inf)
    factor *= dump.frame["exposure_compensation"]
    used = float(dump.get("tone_map/measure_exposure", "exposure")[0])
    return found.size + 1, max(error, worst(used, factor, factor))


def reinhard(color):
    return color / (1.0 + color)


def agx(color):
    """AgX with Wrensch's polynomial and the matrices of three.js, which has them by columns."""
    to_rec2020 = np.reshape([0.6274, 0.0691, 0.0164, 0.3293, 0.9195, 0.0880, 0.0433, 0.0113, 0.8956], (3, 3))
    to_rec709 = np.reshape([1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187], (3, 3))
    inset = np.reshape([0.856627153315983, 0.137318972929847, 0.11189821299995,
                        0.0951212405381588, 0.761241990602591, 0.0767994186031903,
                        0.0482516061458583, 0.101439036467562, 0.811302368396859], (3, 3))
    outset = np.reshape([1.1271005818144368, -0.1413297634984383, -0.14132976349843826,
                         -0.11060664309660323, 1.157823702216272, -0.11060664309660294,
                         -0.016493938717834573, -0.016493938717834257, 1.2519364065950405], (3, 3))
    stops = (np.log2(np.maximum(color @ to_rec2020 @ inset, 1e-10)) + 12.47393) / 16.5
    fit = np.polyval([15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232], np.clip(stops, 0.0, 1.0))
    return np.maximum(fit @ outset, 0.0) ** 2.2 @ to_rec709


def neutral(color):
    """Khronos PBR Neutral."""
    least = color.min(axis=-1, keepdims=True)
    color = color - np.where(least < 0.08, least - 6.25 * least**2, 0.04)
    peak = color.max(axis=-1, keepdims=True)
    bright = np.maximum(peak, 0.76)
    compressed = 1.0 - 0.24**2 / (bright - 0.52)
    white = 1.0 - 1.0 / (0.15 * (bright - compressed) + 1.0)
    return np.where(peak < 0.76, color, (1.0 - white) * color * compressed / bright + white * compressed)


CURVES = {"reinhard": reinhard, "agx": agx, "neutral": neutral}


def tone_map(dump, _rng, _pixels):
    exposed = np.maximum(shown_radiance(dump) * float(dump.get("tone_map/measure_exposure", "exposure")[0]), 0.0)
    value = np.clip(CURVES[dump.manifest["settings"]["tone-map"]](exposed), 0.0, 1.0)
    srgb = np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.maximum(value, 1e-12) ** (1 / 2.4) - 0.055)
    found = dump.get("tone_map", "picture")[..., :3]
    return found.size, worst(found, srgb * 255.0, 255.0)
