"""How far numbers are from what they should be."""

import numpy as np


def worst(found, expected, scale):
    """Largest difference in units of `scale`; infinite where one side is not finite."""
    found, expected = np.asarray(found, np.float64), np.asarray(expected, np.float64)
    if found.shape != expected.shape:
        return np.inf
    if found.size == 0:
        return 0.0
    with np.errstate(invalid="ignore"):
        difference = np.abs(found - expected) / np.maximum(scale, 1e-300)
    return float(np.where(np.isfinite(difference), difference, np.inf).max())


def magnitude(values, fraction=0.01):
    """Each value's own magnitude, but at least a fraction of the mean one (by column)."""
    values = np.abs(np.asarray(values, np.float64))
    return np.maximum(values, fraction * values.mean(axis=0)) if values.size else values
