"""Faults planted in memory, each of which one stage must notice."""

import numpy as np


def scale_part(step, resource, field, where, factor):
    """A fault: multiplies one element (or field of it) of a file."""

    def plant(dump):
        target = dump.get(*(part(dump) if callable(part) else part for part in (step, resource)))
        view = target[field] if field else target
        index = where(target)
        view[index] = (view[index] * factor).astype(view.dtype)

    return plant


def brightest(array):
    return int(np.argmax(array["flux"].sum(axis=1)))


def everywhere(_array):
    return slice(None)


def sample_keys(dump):
    samples = dump.get(dump.lighting_step, "reservoirs")
    if "total" in samples.dtype.names:
        samples["total"] *= 1.01
    else:
        samples["key"] *= 1.01


def lighting_step(dump):
    return dump.lighting_step


def top_lights(dump):
    return dump.grid_lights(dump.frame["top_level"])


def last_shadows(dump):
    """The shadowed estimate that is composed, or without shadows the picture itself."""
    for name in [key for key in dump.files if key[1].startswith("shadowed")] or [("compose", "radiance")]:
        dump.get(*name)[...] *= 1.01


def environment_light(dump):
    for estimate in ("environment_shadowed", "environment_unshadowed"):
        dump.get("environment_light", estimate)[...] *= 1.01


def unblocked(dump):
    """No ray meets anything."""
    found, all_of_it = (dump.get("environment_light", f"environment_{name}") for name in ("shadowed", "unshadowed"))
    found[:] = all_of_it


def picture(dump):
    found = dump.get("tone_map", "picture")
    found[:] = np.where(found > 128, found - 2, found + 2)


def histogram(dump):
    """Everything one bin to the right."""
    found = dump.get("tone_map/exposure_histogram", "exposure_histogram")
    found[:] = np.roll(found, 1)


FAULTS = {
    # name: (stage that must fail, what is done)
    "edge": ("placement", scale_part("bounds/place_grid", "grid_placement", "h_top", everywhere, 1.001)),
    "flux": ("moments", scale_part("compaction/compact_vpls", "light_fluxes", "flux", brightest, 1.01)),
    "moment": ("moments", scale_part("grid_scatter/S1", "moments", None, lambda a: (int(a[:, 1].argmax()), 1), 1.01)),
    "centre": ("scattered lights", scale_part("grid_scatter/resolve_S1", "grid_lights", "position_ws", brightest, 1.01)),
    "lobe": ("scattered lights", scale_part("grid_scatter/resolve_S1", "grid_lights", "lobe", everywhere, 0.99)),
    "gather": ("gathered lights", scale_part(top_lights, "grid_lights", "flux", brightest, 1.01)),
    "energy": ("energy", scale_part(top_lights, "grid_lights", "flux", everywhere, 1.01)),
    "merge": ("merged", scale_part("merge", "merged_lights", "flux", brightest, 1.01)),
    "radius": ("blending", scale_part("merge", "blending_radii", None, everywhere, 1.01)),
    "depth": ("lighting", scale_part("gbuffer", "gbuffer_depth", None, everywhere, 1.05)),
    "lighting": ("lighting", scale_part(lighting_step, "lighting", None, everywhere, 1.01)),
    "sample": ("shadow samples", sample_keys),
    "environment": ("environment light", environment_light),
    "unblocked": ("environment light", unblocked),
    "background": ("background", scale_part("direct_light", "direct", None, everywhere, 1.01)),
    "shadow": ("compose", last_shadows),
    "histogram": ("exposure", histogram),
    "exposure": ("exposure", scale_part("tone_map/measure_exposure", "exposure", None, everywhere, 1.01)),
    "picture": ("tone_map", picture),
}


def plant_fault(dump, name):
    """Plants the fault of this name."""
    _, plant = FAULTS[name]
    plant(dump)
