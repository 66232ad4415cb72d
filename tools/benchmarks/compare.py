"""The hierarchy against path tracing at equal time, on the same device."""
import json
import math
import re
import sys
import tempfile
from pathlib import Path

from . import curve, protocol, report
from .errors import BenchError
from .markdown import number, table
from .protocol import Case

ALPHAS = (1, 2)
# Errors that are compared: key in the metrics of `gridlight compare`, words.
ERRORS = {"relmse": "relMSE", "flip": "FLIP"}
COLUMNS = [("relMSE", "relmse"), ("relMSE of 8x8 blocks", "smooth_relmse"), ("FLIP", "flip"),
           ("indirect energy", "indirect_ratio")]
# Paths per pixel of the two frames that say what a path costs.
PILOT = (1, 4)
# Pictures stand beside the results when they are no larger.
PICTURE_BYTES = 300 * 1024
# Frames of a truth that is antialiased.
TRUTH_FRAMES = 64
# Another seed than any picture that is compared.
TRUTH_SEED = 1_000_003


class Truth:
    """What the pictures are compared with: an independent renderer's reference where there is one for this scene, camera
    and size, else a long path-traced frame of gridlight's own, or the mean of many, jittered like accumulated frames."""

    def __init__(self, options, size, folder, accumulated=False):
        self.program, self.folder = options.program, folder
        self.antialiased = True
        place = options.references / options.scene_name / (options.camera or "") if options.references else None
        if place and size == "640x360" and (place / "gi3.exr").is_file() and (place / "direct.exr").is_file():
            self.words = "gi3 of the shared references, by an independent path tracer, antialiased (its direct light apart)"
            self.whole, self.direct = place / "gi3.exr", place / "direct.exr"
            return
        self.antialiased, samples = accumulated, options.truth_samples
        self.words = f"gridlight's own path tracing, {samples} paths per pixel, seed {TRUTH_SEED}"
        frames = min(samples, TRUTH_FRAMES) if accumulated else 1
        per_frame = -(-samples // frames)
        if accumulated:
            self.words += f", in {frames} frames"
        self.whole, self.direct = folder / f"truth-{frames}.exr", folder / f"direct-{frames}.exr"
        print(f"the truth: {samples} paths per pixel", file=sys.stderr)
        mean = f"--size {size} --accumulate {frames}"
        self.program.run(f"{mean} --technique path-trace --samples {per_frame} --seed {TRUTH_SEED}", "--output", self.whole)
        self.program.run(f"{mean} --technique direct", "--output", self.direct)

    def errors(self, picture):
        file = self.folder / "errors.json"
        protocol.execute([self.program.path, "compare", str(self.whole), str(picture), "--quiet", "--json", str(file),
                          "--direct", str(self.direct)])
        return json.loads(file.read_text())["metrics"]


def path_trace(size, samples):
    return f"--size {size} --technique path-trace --samples {samples}"


def affordable(budget_ms, few, many):
    """Paths per pixel that fit into the time, from two frames (samples, ms): what a frame costs besides is no sample's.
    At least one."""
    per_sample = (many[1] - few[1]) / (many[0] - few[0])
    if per_sample <= 0:
        raise BenchError(f"{many[0]} paths per pixel took no longer than {few[0]}: the machine is too busy to measure")
    return max(1, math.floor((budget_ms - few[1]) / per_sample + few[0] + 1e-9))


def traced_case(options, samples):
    return Case(f"path tracing, {samples} per pixel", path_trace(options.size, samples), options.repeats)


def equal_time(options, cases):
    """Paths per pixel for each case of the hierarchy; all are measured alternately first."""
    few, many = PILOT
    pilots = [traced_case(options, few), traced_case(options, many)]
    measured = protocol.measure(options.program, cases + pilots, options.frames, options.warmup)
    ms = {name: measurement.frame().median for name, measurement in measured.items()}
    return [affordable(ms[case.name], (few, ms[pilots[0].name]), (many, ms[pilots[1].name])) for case in cases]


def lgh(options, alpha):
    return f"--size {options.size} --vpls {options.vpls} --alpha {alpha} --shadow-samples 4"


def settle(options, software):
    """Sizes and numbers by the kind of device, unless options say otherwise."""
    ordinary = {"size": "640x360", "repeats": 3, "frames": 2, "warmup": 1, "truth_samples": 512,
                "curve_frames": 16} if software else {
        "size": "1280x720", "repeats": 3, "frames": 32, "warmup": 8, "truth_samples": 4096, "curve_frames": 256}
    quick = {"size": "64x36", "repeats": 0, "frames": 1, "warmup": 0, "truth_samples": 16, "cap": 2,
             "curve_frames": 2}
    for name, value in (quick if options.quick else {**ordinary, "cap": 64}).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    options.vpls = 2_000 if options.quick else 100_000


def run(options):
    timings = protocol.probe(options.program)
    settle(options, protocol.is_software(timings))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        truth = Truth(options, options.size, folder)
        cases = [Case(f"LGH, alpha {alpha}", lgh(options, alpha), options.repeats) for alpha in ALPHAS]
        # Case of the hierarchy, paths per pixel, and path tracing's case.
        pairs = [(case, n, traced_case(options, n)) for case, n in zip(cases, equal_time(options, cases))]
        everything = list(dict.fromkeys([*cases, *(traced for _, _, traced in pairs)]))
        measured = protocol.measure(options.program, everything, options.frames, options.warmup)
        found = {case.name: {**measured[case.name].as_json(), **judge(options, truth, case, folder)}
                 for case in everything}
        searches = search(options, truth, pairs, found, folder)
        antialiased = truth if truth.antialiased else Truth(options, options.size, folder, accumulated=True)
        points = curve.measure(options, antialiased, [(case.name, case.arguments) for case in cases],
                               path_trace(options.size, 1), folder)
        pictures = show(options, timings, everything, found[cases[0].name]["errors"]["exposure"])
    curves = curve.page(points, antialiased.words, report.folder_of(options, timings))
    lines = page(options, truth, found, pairs, searches) + ["", *curves, "", *pictures, "", "## Commands", ""]
    lines += [f"    {m.command}" for m in measured.values()]
    report.write(options, "compare", "Equal time", timings,
                 {"size": options.size, "vpls": options.vpls, "truth": truth.words, "cases": list(found.values()),
                  "searches": searches, "curve": points}, lines)
    return True


def judge(options, truth, case, folder):
    """The errors of the first frame, and the wall clock of frames that are warm."""
    picture = folder / "picture.exr"
    options.program.run(case.arguments, "--output", picture)
    warm, _ = options.program.timings(case.arguments, "--frames", options.frames, "--warmup", options.warmup)
    return {"errors": truth.errors(picture), "frame_cpu_ms": warm["frame_cpu_ms"]["median"]}


def page(options, truth, found, pairs, searches):
    lines = [f"{options.size}, {options.vpls} VPLs, four shadow samples. Truth: {truth.words}. Each picture is one frame of "
             "seed 1, its samples at the centres of the pixels. Time is that of a frame on the device's clock, median (p95 "
             "by nearest rank); path tracing has as many paths per pixel as fit into the hierarchy's frame, at least one.",
             ""]
    if options.quick:
        lines += ["**A quick run: its times and errors say nothing.**", ""]
    frame = {name: entry["frame_gpu_ms"] for name, entry in found.items()}
    lines += table(["", "frame ms", "wall clock ms", *(title for title, _ in COLUMNS)],
                   [[name, f"{number(frame[name]['median'])} ({number(frame[name]['p95'])})",
                     number(entry["frame_cpu_ms"]), *(error_cell(entry["errors"].get(key)) for _, key in COLUMNS)]
                    for name, entry in found.items()])
    lines += ["", "Indirect energy is taken where no direct light falls, as a ratio to the truth's.", "",
              "## At equal time", "", "Path tracing's time and errors, as multiples of the hierarchy's.", ""]
    lines += table(["", "against", "time", *ERRORS.values()],
                   [[case.name, traced.name, number(frame[traced.name]["median"] / frame[case.name]["median"]),
                     *(number(found[traced.name]["errors"][key] / found[case.name]["errors"][key]) for key in ERRORS)]
                    for case, _, traced in pairs], words=2)
    lines += ["", "## Path tracing until its error is the hierarchy's", "", "Paths per pixel are doubled from the fewest "
              f"above, to at most {options.cap} times those of equal time. One frame of each, not warmed up.", ""]
    lines += table(["", "error", "the hierarchy's", "paths per pixel", "path tracing's", "frame ms",
                    "times the hierarchy's frame", "reached"],
                   [[s["case"], ERRORS[s["error"]], error_cell(s["aim"]), s["samples"], error_cell(s["found"]),
                     number(s["frame_ms"]), number(s["frame_ms"] / frame[s["case"]]["median"]),
                     "yes" if s["reached"] else "**no: the cap**"] for s in searches], words=2)
    return lines


def error_cell(value):
    return "" if value is None else f"{value:.4f}"


def search(options, truth, pairs, found, folder):
    """For each case of the hierarchy and each error: path tracing's first doubling that is no worse, or the last that
    was tried."""
    tried = {}

    def attempt(n):
        if n not in tried:
            picture = folder / "search.exr"
            timings, _ = options.program.timings(path_trace(options.size, n), "--output", picture)
            tried[n] = (truth.errors(picture), timings["frame_gpu_ms"]["median"])
            print(f"path tracing, {n} per pixel: relMSE {tried[n][0]['relmse']:.4f}, FLIP {tried[n][0]['flip']:.4f}, "
                  f"{tried[n][1]:.1f} ms", file=sys.stderr)
        return tried[n]

    result = []
    for case, affordable_samples, _ in pairs:
        for error in ERRORS:
            aim, n = found[case.name]["errors"][error], min(samples for _, samples, _ in pairs)
            while attempt(n)[0][error] > aim and 2 * n <= options.cap * affordable_samples:
                n *= 2
            errors, ms = attempt(n)
            result.append({"case": case.name, "error": error, "aim": aim, "samples": n, "found": errors[error],
                           "frame_ms": ms, "reached": errors[error] <= aim})
    return result


def show(options, timings, cases, exposure):
    """The pictures side by side, all at the truth's exposure; smaller where they would be too large to keep."""
    folder = report.folder_of(options, timings)
    # How many paths per pixel an earlier run had is in its pictures' names.
    for old in folder.glob("compare-*.png"):
        old.unlink()
    width, height = map(int, options.size.split("x"))
    files = {case.name: folder / f"compare-{re.sub('[^a-z0-9]+', '-', case.name.lower())}.png" for case in cases}
    for divisor in (1, 2, 4):
        size = f"{max(1, width // divisor)}x{max(1, height // divisor)}"
        for case in cases:
            arguments = case.arguments.replace(f"--size {options.size}", f"--size {size}")
            options.program.run(arguments, "--exposure", exposure, "--output", files[case.name])
        if all(file.stat().st_size <= PICTURE_BYTES for file in files.values()):
            return ["## Pictures", "", f"One frame each of {size}, all at one exposure.", "",
                    *table(list(files), [[f"![{name}]({file.name})" for name, file in files.items()]], words=len(files))]
    for file in files.values():
        file.unlink()
    return ["The pictures are too large to stand beside the results."]
