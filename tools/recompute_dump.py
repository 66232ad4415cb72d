#!/usr/bin/env python3
"""Computes much of a dump (docs/dumps.md) anew from its inputs and compares. Needs NumPy; shares no code with the program.

    tools/recompute_dump.py DIR [--pixels N] [--plant NAME | --self-test]

Each stage starts from what the dump has of the stage before, so that the first row that fails is where the fault is.
Differences are relative to a scale given with each stage. --plant NAME perturbs one thing in memory, which the stage of
that name in the list below must notice; --self-test plants each in turn. Exit code 0 when every stage holds (in a
self-test: when every fault is noticed), 3 when one does not, 1 when the dump cannot be read, 2 for wrong options.
"""
import argparse
import sys

import numpy as np

# The folder of the sources stays as it is.
sys.dont_write_bytecode = True
from recompute import display, environment, hierarchy, pictures  # noqa: E402
from recompute.faults import FAULTS, plant_fault  # noqa: E402
from recompute.reader import Dump, DumpError  # noqa: E402

# Name, function, tolerance, what differences are relative to and why they may be as large, whether it needs the hierarchy.
# "own size" is a number's own magnitude, or where that is more a hundredth of the mean one.
STAGES = [
    ("placement", hierarchy.placement, 1e-6, "scene radius; one rounding of the edge", True),
    ("moments", hierarchy.moments, 5e-6, "w, wm, flux of the vertex; weights of 24 bits, each sum cut at 2^-40", True),
    ("scattered lights", hierarchy.scattered_lights, 5e-5, "cells, own size; positions of 24 bits, many cells", True),
    ("gathered lights", hierarchy.gathered_lights, 5e-5, "cells, own size; sums of S1 in single precision", True),
    ("energy", hierarchy.energy, 1e-5, "flux of S0; shares below 1e-6 are left out", True),
    ("merged", hierarchy.merged, 1e-6, "own size; copies, but normals and luminances of S0 are computed", True),
    ("blending", pictures.blending, 1e-6, "own size; powers of two", True),
    ("lighting", pictures.lighting, 1e-4, "own size; hundreds of lights added in single precision", True),
    ("shadow samples", pictures.shadow_samples, 3e-3, "own key; logarithms are good to 2^-21, so at least 5e-4", True),
    ("environment light", environment.environment_light, 1e-3, "own size; angles in single precision", False),
    ("background", environment.background, 1e-3, "own size; angles in single precision", False),
    ("compose", pictures.compose, 1e-5, "own size; a few roundings", False),
    ("accumulate", pictures.accumulate, 1e-6, "own size; one division", False),
    ("exposure", display.exposure, 1e-4, "own size; logarithms and sums in single precision", False),
    ("tone_map", display.tone_map, 0.6 / 255, "white; rounded to 8 bits", False),
]

# Where lights are added in an image of half floats, 11 bits of each partial sum are left.
HALF_FLOAT_TOLERANCE = 0.1


def tolerance_of(name, tolerance, dump):
    """The tolerance of a stage for this dump."""
    half = name == "lighting" and dump.files[dump.lighting_step, "lighting"]["dtype"] == "<f2"
    return HALF_FLOAT_TOLERANCE if half else tolerance


def run(folder, pixels, plant=None, only=None):
    """Rows of name, values, worst difference, tolerance, reason, whether it holds: of all stages, or of one alone."""
    dump, rows = Dump(folder), []
    if plant:
        plant_fault(dump, plant)
    # Where no light reaches the scene there is nothing to build.
    has_hierarchy = dump.has("merge", "merged_lights") and len(dump.get("merge", "merged_lights")) > 0
    # A view has the passes that it shows, and may end without these.
    is_picture = dump.has("compose", "radiance") and dump.has("tone_map", "picture")
    for name, function, tolerance, reason, needs in STAGES:
        if not (has_hierarchy if needs else is_picture) or only not in (None, name):
            continue
        values, error = function(dump, np.random.default_rng(1), pixels)
        if values:
            limit = tolerance_of(name, tolerance, dump)
            rows.append((name, values, error, limit, reason, error <= limit))
    return rows


def print_rows(rows):
    print(f"{'stage':<17}{'values':>9}{'worst':>11}{'tolerance':>11}  {'':<5} relative to; why it may differ")
    for name, values, error, limit, reason, holds in rows:
        print(f"{name:<17}{values:>9}{error:>11.2e}{limit:>11.1e}  {'pass' if holds else 'FAIL':<5} {reason}")


def self_test(folder, pixels):
    rows = run(folder, pixels)
    print_rows(rows)
    missed = [] if all(row[5] for row in rows) else ["no fault"]
    there = {row[0] for row in rows}
    for fault, (stage, _) in FAULTS.items():
        if stage not in there:
            continue
        is_noticed = any(not row[5] for row in run(folder, pixels, fault, stage))
        print(f"planted {fault}: {stage} {'fails' if is_noticed else 'does not fail'}")
        if not is_noticed:
            missed.append(fault)
    print(f"missed: {', '.join(missed)}" if missed else "every planted fault was noticed")
    return 3 if missed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("--pixels", type=int, default=300, metavar="N", help="random pixels of the lighting [300]")
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--plant", choices=sorted(FAULTS), metavar="NAME", help=", ".join(FAULTS))
    group.add_argument("--self-test", action="store_true")
    options = parser.parse_args()
    try:
        if options.self_test:
            return self_test(options.folder, options.pixels)
        rows = run(options.folder, options.pixels, options.plant)
    except DumpError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print_rows(rows)
    return 0 if all(row[5] for row in rows) else 3


if __name__ == "__main__":
    sys.exit(main())
