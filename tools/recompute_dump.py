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
from recompute import hierarchy, pictures  # noqa: E402
from recompute.faults import FAULTS, plant_fault  # noqa: E402
from recompute.reader import Dump, DumpError  # noqa: E402

STAGES = [
    # name, function, tolerance, what differences are relative to and why this much, needs the hierarchy
    ("placement", hierarchy.placement, 1e-6, "scene radius; one rounding of the edge", True),
    ("moments", hierarchy.moments, 2e-5, "the vertex's w, wm, flux; 23-bit weights, 2^-40 lost by each light", True),
    ("scattered lights", hierarchy.scattered_lights, 2e-5, "cells, own size; moments rounded to 24 bits", True),
    ("gathered lights", hierarchy.gathered_lights, 1e-4, "cells, own size; sums of S1 lights in single precision", True),
    ("energy", hierarchy.energy, 1e-5, "flux of S0; shares below 1e-6 are left out", True),
    ("merged", hierarchy.merged, 1e-6, "own size; copies, normals unpacked anew", True),
    ("blending", pictures.blending, 1e-6, "radius, 1; powers of two", True),
    ("lighting", pictures.lighting, None, "own size; hundreds of lights added in the image's format", True),
    ("shadow samples", pictures.shadow_samples, 3e-3, "own key, at least that of a logarithm of 5e-4; those are good to 2^-21", True),
    ("compose", pictures.compose, 1e-5, "own size; a few roundings", False),
    ("tone_map", pictures.tone_map, 0.6 / 255, "255; the picture is rounded to 8 bits", False),
]


def tolerance_of(name, tolerance, dump):
    """Where it depends on the dump: a half-float image keeps 11 bits of every partial sum."""
    if tolerance is not None:
        return tolerance
    if dump.files["light_volumes", "lighting"]["dtype"] == "<f2":
        return 0.1
    return 1e-3


def run(folder, pixels, plant=None):
    """Rows of name, values, worst difference, tolerance, reason, whether it holds."""
    dump, rows = Dump(folder), []
    if plant:
        plant_fault(dump, plant)
    has_hierarchy = dump.has("merge", "merged_lights")
    for name, function, tolerance, reason, needs in STAGES:
        if needs and not has_hierarchy:
            continue
        values, error = function(dump, np.random.default_rng(1), pixels)
        if values:
            limit = tolerance_of(name, tolerance, dump)
            rows.append((name, values, error, limit, reason, error <= limit))
    return rows


def print_rows(rows):
    print(f"{'stage':<17}{'values':>9}{'worst':>11}{'tolerance':>11}  {'':<5} relative to; why this much")
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
        failed = [row[0] for row in run(folder, pixels, fault) if not row[5]]
        print(f"planted {fault}: {stage} must fail; failed: {', '.join(failed) or 'none'}")
        if stage not in failed:
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
