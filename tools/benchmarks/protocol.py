"""How anything is measured here: processes of gridlight, one after the other, the cases alternating."""
import csv
import dataclasses
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from . import series
from .errors import BenchError, UsageError

ROOT = Path(__file__).resolve().parents[2]
# Drivers that render on the processor, by what their devices are called.
SOFTWARE = ("llvmpipe", "lavapipe", "swiftshader")


def shared_folder():
    """Scenes and references that are not part of the project."""
    return Path(os.environ.get("GRIDLIGHT_SHARED", ROOT.parent / "shared"))


@dataclasses.dataclass(frozen=True)
class Case:
    """`repeats` 0: only described (counts, memory), with one frame that says no more than that it works."""
    name: str
    arguments: str
    repeats: int = 3
    program: str | None = None


@dataclasses.dataclass
class Measurement:
    case: Case
    command: str
    # What the program says in a run of its own that is not measured: device, counts, memory, wall clock.
    timings: dict
    # Milliseconds of every measured frame, by pass; without any, of the frame that describes.
    frames: list = dataclasses.field(default_factory=list)

    def passes(self):
        return list(dict.fromkeys(name for frame in self.frames for name in frame))

    def sum_of(self, names):
        """Summary of the sum of these passes: summed in every frame, then summarised."""
        return series.summarise([sum(frame.get(name, 0.0) for name in names) for frame in self.frames])

    def frame(self):
        return self.sum_of(self.passes())

    def as_json(self):
        counts, memory = self.timings["counts"], self.timings["memory"]
        return {"case": self.case.name, "command": self.command, "runs": self.case.repeats, "counts": counts,
                "memory": memory, "frame_gpu_ms": self.frame().as_json(),
                "pass_ms": {name: self.sum_of([name]).as_json() for name in self.passes()},
                "frames_ms": [sum(frame.values()) for frame in self.frames]}


class Program:
    """gridlight with the scene and device of this benchmark."""

    def __init__(self, path, scene_arguments):
        self.path, self.scene_arguments = str(path), scene_arguments

    def words(self, arguments, program=None):
        try:
            split = shlex.split(arguments)
        except ValueError as error:
            raise UsageError(f"'{arguments}' cannot be split into options: {error}") from None
        return [program or self.path, *self.scene_arguments, *split, "--headless", "--quiet"]

    def run(self, arguments, *extra, program=None, environment=None):
        """One process; its peak of resident memory in MiB. A failure is told in the program's own words."""
        return execute([*self.words(arguments, program), *map(str, extra)], environment)

    def timings(self, arguments, *extra, program=None, environment=None):
        """What a process says about itself in JSON, and its peak memory."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "timings.json"
            resident_mib = self.run(arguments, *extra, "--timings", file, program=program, environment=environment)
            return json.loads(file.read_text()), resident_mib

    def frames(self, arguments, *extra, program=None):
        """Milliseconds of every pass, for each measured frame; and the peak memory."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "timings.csv"
            resident_mib = self.run(arguments, *extra, "--timings", file, program=program)
            return read_frames(file), resident_mib

    def has_option(self, option):
        text = subprocess.run([self.path, "--help"], capture_output=True, text=True).stdout
        return re.search(rf"^\s*{re.escape(option)}\b", text, re.MULTILINE) is not None

    def shown(self, arguments, program=None):
        """The command without paths of this machine."""
        return without_paths(self.words(arguments, program))


@dataclasses.dataclass
class Ended:
    """How a process ended."""
    code: int
    messages: str
    resident_mib: float

    def last_line(self):
        """The error, in the program's own words."""
        return self.messages.splitlines()[-1].removeprefix("error: ") if self.messages else "no message"


def attempt(command, environment=None):
    """Runs a process to its end, whichever that is."""
    with tempfile.TemporaryFile("w+") as messages:
        try:
            process = subprocess.Popen(command, env={**os.environ, **(environment or {})}, stderr=messages)
        except OSError as error:
            raise UsageError(f"{command[0]} cannot be run: {error.strerror}") from None
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        return Ended(process.returncode, messages.read().strip(), usage.ru_maxrss / 1024)


def execute(command, environment=None):
    ended = attempt(command, environment)
    if ended.code:
        kind = UsageError if ended.code == 2 else BenchError
        raise kind(f"exit code {ended.code} from: {without_paths(command)}: {ended.last_line()}")
    if ended.messages:
        print(ended.messages, file=sys.stderr)
    return ended.resident_mib


def without_paths(command):
    """Whatever its file is called, the program is gridlight."""
    words = [Path(word).name if word.startswith("/") else word for word in command[1:]]
    return shlex.join(["gridlight", *words])


def read_frames(file):
    """A pass that is recorded several times in a frame counts with all of them."""
    frames = {}
    with open(file, encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines):
            frame = frames.setdefault(row["frame"], {})
            frame[row["pass"]] = frame.get(row["pass"], 0.0) + float(row["gpu_ms"])
    return list(frames.values())


def measure(program, cases, frames, warmup, check=lambda names: None):
    """Every case by its name. First a run of each that only describes it and warms caches, then the rounds. `check` looks
    at the names of its passes before anything takes long."""
    names = [case.name for case in cases]
    if len(set(names)) != len(names):
        raise ValueError(f"two cases have one name: {names}")
    found = {}
    for case in cases:
        timings, _ = program.timings(case.arguments, program=case.program)
        check([entry["name"] for entry in timings["passes"]])
        found[case.name] = Measurement(case, program.shown(case.arguments, case.program), timings)
        if not case.repeats:
            found[case.name].frames = [{entry["name"]: entry["ms"]["median"] for entry in timings["passes"]}]
        print(f"{case.name}: {timings['frame_gpu_ms']['median']:.1f} ms, to describe it", file=sys.stderr)
    for case in series.rounds(cases, lambda case: case.repeats):
        new, _ = program.frames(case.arguments, "--frames", frames, "--warmup", warmup, program=case.program)
        found[case.name].frames += new
        milliseconds = series.summarise([sum(frame.values()) for frame in new]).median
        print(f"{case.name}: {milliseconds:.1f} ms", file=sys.stderr)
    return found


def is_software(timings):
    return any(name in timings["device"]["name"].lower() for name in SOFTWARE)


def probe(program):
    """Timings of next to nothing: they say which device it is."""
    return program.timings("--technique direct --size 16x16")[0]
