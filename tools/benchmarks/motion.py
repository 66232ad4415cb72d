"""Six sequences of the built-in scene, in the way of the paper and in ours, beside path-traced truth: flicker, lag, the answer
to a step, and the error of single frames."""
import json
import math
import os
import sys
import tempfile
from pathlib import Path

from . import plot, protocol, report
from .errors import UsageError
from .markdown import number, table
from .protocol import Program

FPS = 24
# Frame that the truth has together with the one before: every eighth.
TRUE_PAIRS = 8
# Frames after which the means of both ways are as long as they get.
SETTLED = 24
# How many times as many paths each frame of the truth has where there are few frames of it.
STILL_SAMPLES = 8
# Of each sequence: the animation; the frames at which the truth changes, where it stands still between; what happens.
SEQUENCES = {
    "still": ("none", [0], "nothing moves"),
    "sun": ("sun", None, "the sun turns by half a degree a frame"),
    "object": ("object", None, "a crate crosses the court in four seconds"),
    "figure": ("figure", None, "a figure walks, and awnings move in the wind"),
    "camera": ("camera", None, "the camera moves; what moves over edges counts as flicker"),
    "switch": ("switch", [0, FPS], "a lamp is switched on after a second"),
}
MEASURES = {"flicker": "flicker", "block_flicker": "of blocks", "settled": "settled", "lag_frames": "lag", "answer": "answer", "relmse": "relMSE",
            "flip": "FLIP", "energy_ratio": "energy", "frame_ms": "frame ms"}


# Options of each way: what the paper does, and what is used here.
WAYS = {
    "paper": "--vpl-seeds fresh --temporal shadows --temporal-weight 0.2 --antilag off",
    "ours": "--vpl-seeds held --temporal shadows --antilag tiles",
}


def settle(options, software):
    """Sizes by the kind of device, unless options say otherwise."""
    ordinary = {"size": "160x90", "frames": 64, "warmup": 0, "vpls": 20_000, "truth_samples": 64} if software else {
        "size": "1280x720", "frames": 64, "warmup": 0, "vpls": 100_000, "truth_samples": 1024}
    quick = {"size": "32x18", "frames": 32, "warmup": 0, "vpls": 500, "truth_samples": 2}
    for name, value in (quick if options.quick else ordinary).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    options.repeats = 1
    if options.frames <= FPS + 1:
        raise UsageError(f"--frames must be above {FPS + 1}, so that the lamp of `switch` is switched on")


def run(options):
    # The sequences are those of the built-in scene.
    gpu = ["--gpu", options.gpu] if options.gpu else []
    options.program = Program(options.program.path, [*gpu, *(["--camera", options.camera] if options.camera else [])])
    timings = protocol.probe(options.program)
    settle(options, protocol.is_software(timings))
    found = {}
    with tempfile.TemporaryDirectory() as place:
        for name in options.sequence or SEQUENCES:
            folder = Path(place) / name
            folder.mkdir()
            truth(options, name, folder)
            found[name] = {way: measure(options, name, folder, way, words) for way, words in WAYS.items()}
            print(f"{name}: done", file=sys.stderr)
    drawn = plot.draw("sequences", series(found), report.folder_of(options, timings) / "motion.svg")
    results = {"size": options.size, "vpls": options.vpls, "truth_samples": options.truth_samples, "fps": FPS,
               "sequences": found}
    timings["scene"] = {"name": "courtyard in motion", "camera": "that of each"}
    report.write(options, "motion", "Motion", timings, results, page(options, found, drawn))
    return True


def view(options, name):
    """The camera that moves is another than the one that stands."""
    return "--camera walk" if name == "camera" else "" if options.camera else "--camera court"


def pairs(frames):
    """First frames of the pairs that the truth has."""
    return range(TRUE_PAIRS - 2, frames - 1, TRUE_PAIRS)


def truth(options, name, folder):
    """Truth twice, with different noise: in frames 7 and 8 of every eight, or in all where it stands still between steps."""
    animation, steps, _ = SEQUENCES[name]
    for half in ("truth", "second"):
        firsts = list(pairs(options.frames)) if steps is None else steps
        for first in firsts:
            count = 2 if steps is None else 1
            seed = 2 * first + (1 if half == "truth" else 2)
            samples = options.truth_samples if steps is None else options.truth_samples * STILL_SAMPLES // len(steps)
            options.program.run(
                f"--technique path-trace --samples {samples} --seed {seed} --size {options.size} "
                f"--animation {animation} --time {first / FPS!r} --fps {FPS} --frames {count} {view(options, name)}",
                "--output", folder / "part-{frame}.exr")
            last = first + count
            if steps is not None:
                later = [step for step in steps if step > first]
                last = later[0] if later else options.frames
            for frame in range(first, last):
                part = folder / f"part-{0 if steps is not None else frame - first:04}.exr"
                os.link(part, folder / f"{half}-{frame:04}.exr")
            for part in folder.glob("part-*.exr"):
                part.unlink()


def measure(options, name, folder, way, words):
    """What is found of a sequence in a way."""
    arguments = (f"{words} --vpls {options.vpls} --size {options.size} --animation {SEQUENCES[name][0]} --fps {FPS} "
                 f"--frames {options.frames} --warmup {options.warmup} {view(options, name)}").strip()
    timings, _ = options.program.timings(arguments, "--output", folder / f"{way}-{{frame}}.exr")
    metrics = folder / f"{way}.json"
    protocol.execute([options.program.path, "compare-sequence", str(folder / "truth-{frame}.exr"),
                      str(folder / f"{way}-{{frame}}.exr"), "--second-truth", str(folder / "second-{frame}.exr"), "--quiet",
                      "--json", str(metrics)])
    found = json.loads(metrics.read_text())["metrics"]
    return {"command": options.program.shown(arguments), "frame_ms": timings["frame_gpu_ms"]["median"],
            "settled": settled(found["frames"]), **found}


def settled(frames):
    """Flicker of blocks after the first frames; None where there is none."""
    squares = [frame["block_flicker"] ** 2 for frame in frames if frame["frame"] > SETTLED and frame["block_flicker"] is not None]
    return math.sqrt(sum(squares) / len(squares)) if squares else None


def value_of(entry, key):
    """A measure as text."""
    if key == "answer":
        answer = entry["answer"]
        if answer is None:
            return ""
        return str(answer["frames"]) if answer["frames"] is not None else f"> {len(answer['left']) - 1}"
    return "" if entry[key] is None else number(entry[key]) if key == "frame_ms" else f"{entry[key]:.4f}"


def series(found):
    """Points of the plot: the flicker of every pair of frames."""
    return [{"sequence": name, "series": way, "frame": frame["frame"], "flicker": frame["flicker"], "flip": frame["flip"]}
            for name, entry in found.items() for way, metrics in entry.items() for frame in metrics["frames"]]


def page(options, found, drawn):
    lines = [f"{options.size}, {options.vpls} VPLs, {options.frames} frames at {FPS} a second; truth of twice "
             f"{options.truth_samples} paths per pixel, of `still` {STILL_SAMPLES} and of `switch` {STILL_SAMPLES // 2} times as many.", ""]
    if options.quick:
        lines += ["**A quick run: its numbers say nothing.**", ""]
    lines += [f"- `{way}`: `{words}`" for way, words in WAYS.items()]
    lines += ["", "`gridlight compare-sequence` says what the measures are ([comparing.md](../../comparing.md)). Flicker is over "
              f"the mean luma, and settled is that of blocks after frame {SETTLED}; lag and answer are in frames.", ""]
    rows = [[name, way, *(value_of(entry, key) for key in MEASURES)] for name in found for way, entry in found[name].items()]
    lines += table(["sequence", "way", *MEASURES.values()], rows, words=2)
    lines += [""] + [f"- `{name}`: {SEQUENCES[name][2]}." for name in found]
    if drawn:
        lines += ["", "![flicker and FLIP of each frame](motion.svg)"]
    lines += ["", "## Commands", ""]
    return lines + [f"    {entry['command']}" for ways_of in found.values() for entry in ways_of.values()]
