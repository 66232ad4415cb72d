#!/usr/bin/env python3
"""Writes the built-in scene `assets/courtyard.glb`, or checks that the committed file is current.

Needs the Python 3 standard library only. Two runs give identical bytes.
"""

import argparse
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from courtyard import scene  # noqa: E402  (the package lies next to this file)

DEFAULT = pathlib.Path(__file__).resolve().parent.parent / "assets" / "courtyard.glb"


def main():
    """Entry point; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=pathlib.Path, default=DEFAULT, help="file to write")
    parser.add_argument("--check", action="store_true",
                        help="write nothing; exit 1 if the file at --output differs")
    args = parser.parse_args()
    data, triangles = scene.build()
    if args.check:
        same = args.output.is_file() and args.output.read_bytes() == data
        print(f"{args.output}: {'up to date' if same else 'differs from the generator'}")
        return 0 if same else 1
    args.output.parent.mkdir(parents=True, exist_ok=True)
    args.output.write_bytes(data)
    print(f"{args.output}: {len(data)} bytes, {triangles} triangles")
    return 0


if __name__ == "__main__":
    sys.exit(main())
