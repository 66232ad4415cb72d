"""The hierarchy against path tracing at equal time, on the same device."""
import json
import math
import sys
import tempfile
from pathlib import Path

from . import protocol, report
from .markdown import number, spread, table
from .protocol import Case

ALPHAS = (1, 2)
# Errors that are compared: key in the metrics of `gridlight compare`, words.
ERRORS = {"relmse": "relMSE", "flip": "FLIP"}
COLUMNS = [("relMSE", "relmse"), ("relMSE of 8x8 blocks", "smooth_relmse"), ("FLIP", "flip"),
           ("indirect energy", "indirect_ratio")]
# Pictures stand beside the results when they are no larger.
PICTURE_BYTES = 300 * 1024
# Another seed than any picture that is compared.
TRUTH_SEED = 1_000_003


class Truth:
    """What the pictures are compared with: an independent renderer's reference where there is one for this scene, camera
    and size, else a long path-traced frame of gridlight's own."""

    def __init__(self, options, size, folder):
        self.program, self.folder = options.program, folder
        place = options.references / options.scene_name / (options.camera or "") if options.references else None
        if place and size == "640x360" and (place / "gi3.exr").is_file() and (place / "direct.exr").is_file():
            self.words = "gi3 of the shared references, by an independent path tracer, antialiased (its direct light apart)"
            self.whole, self.direct = place / "gi3.exr", place / "direct.exr"
            return
        samples = options.truth_samples
        self.words = f"gridlight's own path tracing, {samples} paths per pixel, seed {TRUTH_SEED}"
        self.whole, self.direct = folder / "truth.exr", folder / "direct.exr"
        print(f"the truth: {samples} paths per pixel", file=sys.stderr)
        self.program.run(f"--size {size} --technique path-trace --samples {samples} --seed {TRUTH_SEED}",
                         "--output", self.whole)
        self.program.run(f"--size {size} --technique direct", "--output", self.direct)

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
        raise ValueError(f"{many[0]} samples took no longer than {few[0]}")
    return max(1, math.floor((budget_ms - few[1]) / per_sample + few[0] + 1e-9))


def samples_within(program, size, budget_ms):
    """Doubles the samples until the frame is longer than the budget: the nearest two frames say what a sample costs."""
    before = None
    samples = 1
    while True:
        ms = frame_ms(program, path_trace(size, samples))
        print(f"path tracing, {samples} per pixel: {ms:.1f} ms", file=sys.stderr)
        if ms >= budget_ms:
            break
        before, samples = (samples, ms), samples * 2
    return affordable(budget_ms, before, (samples, ms)) if before else 1


def frame_ms(program, arguments):
    """Of one frame after one to warm up."""
    frames, _ = program.frames(arguments, "--warmup", 1)
    return sum(frames[0].values())


def lgh(size, vpls, alpha):
    return f"--size {size} --vpls {vpls} --alpha {alpha} --shadow-samples 4"


def run(options):
    program = options.program
    timings = protocol.probe(program)
    software = protocol.is_software(timings)
    size = options.size or ("64x36" if options.quick else "640x360" if software else "1280x720")
    vpls = 2_000 if options.quick else 100_000
    defaults = {"repeats": 0 if options.quick else 3, "frames": 1 if options.quick else 2 if software else 32,
                "warmup": 0 if options.quick else 1 if software else 8, "truth_samples": 16 if options.quick else 4096,
                "cap": 2 if options.quick else 64}
    for name, value in defaults.items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        truth = Truth(options, size, folder)
        cases = [Case(f"LGH, alpha {alpha}", lgh(size, vpls, alpha), options.repeats) for alpha in ALPHAS]
        budget = [frame_ms(program, case.arguments) for case in cases]
        samples = [samples_within(program, size, ms) for ms in budget]
        traced = [Case(f"path tracing, {n} per pixel", path_trace(size, n), options.repeats)
                  for n in dict.fromkeys(samples)]
        measured = protocol.measure(program, cases + traced, options.frames, options.warmup)
        errors, pictures = {}, {}
        for case in cases + traced:
            pictures[case.name] = folder / f"{len(pictures)}.exr"
            program.run(case.arguments, "--output", pictures[case.name])
            errors[case.name] = truth.errors(pictures[case.name])
        searches = search(options, size, truth, cases, samples, errors, folder)
        shown = show(options, timings, cases + traced, size, errors)
    rows = [[case.name, spread(measured[case.name].frame()),
             number(measured[case.name].timings["frame_cpu_ms"]["median"]),
             *(errors_cell(errors[case.name].get(key)) for _, key in COLUMNS)] for case in cases + traced]
    lines = [f"{size}, {vpls} VPLs, four shadow samples. Truth: {truth.words}. Each picture is one frame of seed 1. Time is "
             "that of a frame on the device's clock, median (p95 by nearest rank); path tracing has as many paths per pixel "
             "as fit into the hierarchy's frame, at least one.", ""]
    lines += table(["", "frame ms", "wall clock ms", *(title for title, _ in COLUMNS)], rows)
    lines += ["", "Indirect energy is taken where no direct light falls, as a ratio to the truth's.", ""]
    equal = [[case.name, f"path tracing, {n} per pixel",
              number(measured[f"path tracing, {n} per pixel"].frame().median / measured[case.name].frame().median),
              *(number(errors[f"path tracing, {n} per pixel"][key] / errors[case.name][key]) for key in ERRORS)]
             for case, n in zip(cases, samples)]
    lines += ["## At equal time", "", *table(["", "against", "time, times", *(f"{w}, times" for w in ERRORS.values())],
                                             equal, words=2), ""]
    lines += ["## Path tracing until its error is the hierarchy's", "",
              f"Paths per pixel are doubled from those of equal time, to at most {options.cap} times as many.", ""]
    lines += table(["", "error", "hierarchy's", "paths per pixel", "path tracing's", "frame ms", "reached"],
                   [[s["case"], ERRORS[s["error"]], errors_cell(s["aim"]), s["samples"], errors_cell(s["found"]),
                     number(s["frame_ms"]), "yes" if s["reached"] else "**no: the cap**"] for s in searches], words=2)
    lines += ["", *shown, "", "## Commands", "", *(f"    {m.command}" for m in measured.values())]
    results = {"size": size, "vpls": vpls, "truth": truth.words, "cases": [
        {**measured[case.name].as_json(), "errors": errors[case.name]} for case in cases + traced], "searches": searches}
    report.write(options, "compare", "Equal time", timings, results, lines)
    return True


def errors_cell(value):
    return "" if value is None else f"{value:.4f}"


def search(options, size, truth, cases, samples, errors, folder):
    """For each case and error: path tracing's first doubling that is no worse, or the last one tried."""
    tried = {}

    def attempt(n):
        if n not in tried:
            picture = folder / "search.exr"
            timings, _ = options.program.timings(path_trace(size, n), "--output", picture)
            tried[n] = (truth.errors(picture), timings["frame_gpu_ms"]["median"])
            print(f"path tracing, {n} per pixel: relMSE {tried[n][0]['relmse']:.4f}, FLIP {tried[n][0]['flip']:.4f}",
                  file=sys.stderr)
        return tried[n]

    result = []
    for case, start in zip(cases, samples):
        for error in ERRORS:
            aim, n = errors[case.name][error], start
            while attempt(n)[0][error] > aim and 2 * n <= options.cap * start:
                n *= 2
            found, ms = attempt(n)
            result.append({"case": case.name, "error": error, "aim": aim, "samples": n, "found": found[error],
                           "frame_ms": ms, "reached": found[error] <= aim})
    return result


def show(options, timings, cases, size, errors):
    """The pictures side by side, all at the truth's exposure; half as large where they would be too large to keep."""
    folder = report.folder_of(options, timings)
    width, height = map(int, size.split("x"))
    exposure = next(iter(errors.values()))["exposure"]
    for divisor in (1, 2, 4):
        files = {}
        for case in cases:
            smaller = case.arguments.replace(f"--size {size}", f"--size {width // divisor}x{height // divisor}")
            slug = "".join(c if c.isalnum() else "-" for c in case.name.lower()).replace("--", "-")
            files[case.name] = folder / f"compare-{slug}.png"
            options.program.run(smaller, "--exposure", exposure, "--output", files[case.name])
        if all(file.stat().st_size <= PICTURE_BYTES for file in files.values()):
            note = "" if divisor == 1 else f" One frame each of {width // divisor}x{height // divisor} pixels."
            return ["## Pictures", "", f"The same exposure for all.{note}", "",
                    *table(list(files), [[f"![{name}]({file.name})" for name, file in files.items()]], words=len(files))]
        for file in files.values():
            file.unlink()
    return ["The pictures are too large to stand beside the results."]
