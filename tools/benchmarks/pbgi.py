"""Point-based global illumination, in the paper's way and in the default one: the paper's Figure 5 (how many points of each
kind there are), Figure 6 (times by stage), Table 1 and Figure 8 (against every point lit) beside its numbers."""
import json
import shlex
import sys
import tempfile
from pathlib import Path

from . import plot, protocol, published, report
from .markdown import count, number, table
from .protocol import Case, Program, shared_folder
from .steps import PBGI_ROWS, RENDER, assign, members

# Scene, its file under shared/, camera, environment: a file beside the scene, or what --environment takes.
SCENES = [
    ("primitives", "assets/env/primitives.gltf", "front", "1,1,1"),
    ("teapots", "assets/env/teapots.gltf", "front", "sky.exr"),
    ("castle", "assets/env/castle.gltf", "yard", "sky.exr"),
    ("courtyard", None, None, "sky"),
    ("Sponza", "assets/sponza/sponza-sun.gltf", "atrium", "sky"),
]
# The way of the paper and the default one.
WAYS = {"paper": "--micro points --coverage binary --selection paper --sun-leaves 1", "default": ""}
# Counts of a run: key in the timings, words.
COUNTS = {"primary_points": "primary", "seen_points": "secondary, seen", "needed_points": "secondary, lit"}


class Scene:
    def __init__(self, options, name, file, camera, environment):
        self.name, folder = name, shared_folder()
        self.path = folder / file if file else None
        beside = self.path.parent / environment if self.path else None
        lit = beside if beside and beside.is_file() else environment
        words = ([str(self.path)] if self.path else []) + (["--camera", camera] if camera else [])
        self.program = Program(options.program.path, words + ["--environment", str(lit)])

    def is_there(self):
        return self.path is None or self.path.is_file()


def settle(options, software):
    """Sizes by the kind of device, unless options say otherwise; on a fast one those of the paper."""
    ordinary = {"size": "640x360", "repeats": 1, "frames": 2, "warmup": 1} if software else {
        "size": "1280x720", "repeats": 3, "frames": 32, "warmup": 8}
    quick = {"size": "64x36", "repeats": 0, "frames": 1, "warmup": 0}
    for name, value in (quick if options.quick else ordinary).items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    if options.points is None:
        options.points = 4096 if options.quick else 524_288


def run(options):
    settle(options, protocol.is_software(protocol.probe(options.program)))
    scenes = [scene for scene in (Scene(options, *entry) for entry in SCENES) if scene.is_there()]
    missing = len(SCENES) - len(scenes)
    if missing:
        print(f"skipped: {missing} scenes that are not in {shared_folder()}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as place:
        found = {scene.name: measure(options, scene, Path(place)) for scene in scenes}
        timings = next(iter(found.values()))["timings"]
        folder = report.folder_of(options, timings)
        differences = {scene.name: compare(options, scene, Path(place), folder) for scene in scenes}
    lines = page(options, found, differences)
    cases = [{"scene": name, "ways": entry["ways"], "difference": differences[name]} for name, entry in found.items()]
    said = {**timings, "scene": {"name": "each below", "camera": "that of each"}}
    report.write(options, "pbgi", "Point-based global illumination", said,
                 {"size": options.size, "points": options.points, "scenes": cases}, lines)
    return True


def arguments(options, way):
    return f"--technique pbgi --points {options.points} --size {options.size} {WAYS[way]}".strip()


def picture_of(place, scene, way):
    return place / f"{scene.name.lower()}-{way}.exr"


def measure(options, scene, place):
    """Both ways of a scene, alternating; their pictures are left in `place`."""
    cases = [Case(way, f"{arguments(options, way)} --output {shlex.quote(str(picture_of(place, scene, way)))}",
                  options.repeats) for way in WAYS]
    print(f"{scene.name}:", file=sys.stderr)
    measured = protocol.measure(scene.program, cases, options.frames, options.warmup,
                                lambda names: assign(names, PBGI_ROWS))
    ways = {way: {**m.as_json(), "stages": stages(m)} for way, m in measured.items()}
    return {"timings": measured["default"].timings, "ways": ways}


def stages(measurement):
    """Milliseconds of each stage, summed in every frame."""
    sums = members(measurement.passes(), RENDER, PBGI_ROWS)
    return {title: measurement.sum_of(names).as_json() for title, names in sums.items()}


def compare(options, scene, place, folder):
    """Both ways against every point lit and a micro-buffer at every pixel, and the picture of the default one."""
    size = f"--points {options.points} --size {options.size}"
    reference = place / "reference.exr"
    scene.program.run(f"--technique pbgi-reference {size}", "--output", reference)
    errors = {way: errors_of(scene.program, reference, picture_of(place, scene, way)) for way in WAYS}
    found = {way: {key: errors[way].get(key) for key in ("energy_ratio", "relmse", "flip")} for way in WAYS}
    if options.quick:
        return {"errors": found, "picture": None}
    # One exposure for both, or the difference would show that of exposures.
    pictures = [place / f"{technique}.png" for technique in ("pbgi", "pbgi-reference")]
    for picture in pictures:
        shown = f"--technique {picture.stem} {size} --exposure {errors['default']['exposure']}"
        scene.program.run(shown, "--output", picture)
    drawing = f"pbgi-{scene.name.lower()}.svg"
    drawn = plot.draw("difference", [str(picture) for picture in pictures], folder / drawing)
    return {"errors": found, "picture": drawing if drawn else None}


def errors_of(program, reference, picture):
    with tempfile.TemporaryDirectory() as name:
        metrics = Path(name) / "metrics.json"
        protocol.execute([program.path, "compare", str(reference), str(picture), "--quiet", "--json", str(metrics)])
        return json.loads(metrics.read_text())["metrics"]


def page(options, found, differences):
    lines = [f"{options.size}, {options.points} points. The paper: {published.PBGI_DEVICE}, 1280x720, 500k points.", ""]
    if options.quick:
        lines += ["**A quick run: its times say nothing.**", ""]
    lines += [f"`{way}` is " + (f"`{way_options}`." if way_options else "what is used without options.") for way, way_options in WAYS.items()]
    lines += ["", "## Figure 5: points", "", "Beside each number its share of all points; *lit* is what is left of those seen "
              "once light of others tells theirs.", ""]
    lines += table(["scene", "way", *COUNTS.values(), "lit of seen"], points_rows(options, found), words=2)
    lines += ["", "## Table 1: micro-buffers", ""]
    lines += table(["scene", "way", "primary", "secondary, lit", "frame ms"], table_1(found), words=2)
    lines += ["", "## Figure 6: times by stage", "", "Milliseconds, median (p95).", ""]
    columns = [(scene, way) for scene in found for way in WAYS]
    lines += table(["stage", *(f"{scene}, {way}" for scene, way in columns)],
                   [[row.title, *(stage_cell(found[scene]["ways"][way]["stages"].get(row.title)) for scene, way in columns)]
                    for row in PBGI_ROWS])
    lines += ["", "## Figure 8: against every point lit", "", "Against `--technique pbgi-reference`; pictures are the default "
              "way, the reference, and their difference times four.", ""]
    lines += table(["scene", "way", "energy", "relMSE", "FLIP"],
                   [[scene, way, *(f"{value:.4f}" for value in entry["errors"][way].values())]
                    for scene, entry in differences.items() for way in WAYS], words=2)
    lines += [f"\n![{scene}]({entry['picture']})" for scene, entry in differences.items() if entry["picture"]]
    lines += ["", "## Commands", ""]
    return lines + [f"    {entry['ways'][way]['command']}" for entry in found.values() for way in WAYS]


def points_rows(options, found):
    rows = []
    for scene, entry in found.items():
        for way in WAYS:
            counts = entry["ways"][way]["counts"]
            share = counts["needed_points"] / counts["seen_points"] if counts["seen_points"] else 0.0
            cells = [f"{counts[key]} ({100 * counts[key] / options.points:.1f} %)" for key in COUNTS]
            rows.append([scene, way, *cells, f"{100 * share:.0f} %"])
    for scene, (primary, seen, lit, _) in published.PBGI.items():
        seen_cells = [count(seen), f"{100 * lit / seen:.0f} %"] if seen else ["", ""]
        rows.append([scene, "published", f"{count(primary)} ({100 * primary / 500_000:.1f} %)", seen_cells[0],
                     f"{count(lit)} ({100 * lit / 500_000:.1f} %)", seen_cells[1]])
    return rows


def table_1(found):
    rows = [[scene, way, entry["ways"][way]["counts"]["primary_points"], entry["ways"][way]["counts"]["needed_points"],
             number(entry["ways"][way]["frame_gpu_ms"]["median"])] for scene, entry in found.items() for way in WAYS]
    return rows + [[scene, "published", primary, lit, number(ms)] for scene, (primary, _, lit, ms) in published.PBGI.items()]


def stage_cell(summary):
    return "" if summary is None else f"{number(summary['median'])} ({number(summary['p95'])})"
