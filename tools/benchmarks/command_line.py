"""The subcommands of tools/bench and their options."""
import argparse
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from . import compare, cost, honesty, motion, pbgi, scale, tables, variants
from .errors import BenchError, UsageError
from .protocol import ROOT, Program, shared_folder

BENCHMARKS = {
    "cost": (cost, "the frame's cost against its limits, and the memory of a million VPLs"),
    "honesty": (honesty, "the passes' timestamps against the wall clock: their sum in serial frames, and each pass "
                "against a run in which every pass is submitted and waited for by itself"),
    "tables": (tables, "Tables 1, 2 and 3 and Figure 5 of the paper, ours beside the published numbers"),
    "compare": (compare, "the hierarchy against path tracing at equal time"),
    "pbgi": (pbgi, "point-based global illumination: counts, times by stage and pictures as in its paper, in the paper's way "
             "and in the default one"),
    "motion": (motion, "six sequences of the built-in scene against path-traced truth: flicker, lag, the answer to a step"),
    "scale": (scale, "inputs that are large in one way each, which it makes: what becomes of them, memory and time"),
    "variants": (variants, "options or programs against each other, alternating in one run"),
}


class Parser(argparse.ArgumentParser):
    def error(self, message):
        """One sentence, without the usage."""
        self.exit(2, f"error: {message}\n")


def at_least(least):
    def parse(text):
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of {least} or more")
        return int(text)
    return parse


def size(text):
    if not re.fullmatch(r"[1-9]\d*x[1-9]\d*", text):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT, such as 640x360")
    return text


def parser():
    result = Parser(
        prog="tools/bench", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Measures what gridlight costs, what it is worth, and whether its timings are honest.\n\n"
        "Needs only Python 3 and a built gridlight. Runs of the cases alternate, so that a machine that is busy for a\n"
        "while harms all alike; medians are quoted. Results of all but 'variants' go to\n"
        "docs/results/<driver>/<benchmark>.json and .md. 'tools/bench BENCHMARK --help' has the options.",
        epilog="Exit code 0 on success, 3 when a limit of cost or honesty does not hold, 2 on wrong usage, 1 "
        "when gridlight fails.")
    commands = result.add_subparsers(dest="benchmark", metavar="BENCHMARK", required=True)
    for name, (_, words) in BENCHMARKS.items():
        command = commands.add_parser(name, help=words, description=words[0].upper() + words[1:] + ".")
        fixed = name in ("cost", "honesty")
        sized = name in ("tables", "compare", "motion", "pbgi")
        command.add_argument("--program", metavar="PATH", help="the binary (default: build the release)")
        command.add_argument("--gpu", metavar="INDEX|NAME", help="device, as for gridlight")
        if name != "variants":
            command.add_argument("--results", type=Path, default=ROOT / "docs/results", metavar="DIR",
                                 help="default docs/results")
        if sized or name == "scale":
            command.add_argument("--quick", action="store_true", help="a tiny picture, few VPLs and one frame: shows "
                                 "that it works, measures nothing")
        if name == "scale":
            continue
        command.add_argument("--repeats", type=at_least(1), default=None if sized else 3, metavar="N",
                             help="runs of each case (default " + ("by the device)" if sized else "3)"))
        command.add_argument("--frames", type=at_least(1), default=None if sized else 3, metavar="N",
                             help="measured frames in each run (default " + ("by the device)" if sized else "3)"))
        command.add_argument("--warmup", type=at_least(0), default=None if sized else 1, metavar="N",
                             help="frames before them (default " + ("by the device)" if sized else "1)"))
        command.add_argument("--scene", metavar="PATH", help="a glTF file; 'courtyard' is the built-in scene (default: "
                             "Sponza from $GRIDLIGHT_SHARED or ../shared, the built-in scene without it)")
        command.add_argument("--camera", metavar="NAME", help="camera of that scene (default: atrium in Sponza, "
                             "else the first)")
        if sized:
            command.add_argument("--size", type=size, metavar="WxH",
                                 help="default 640x360 on a software driver, else 1280x720")
        if fixed:
            command.add_argument("--tolerance", type=float, default=0.25, metavar="F", help="honesty: allowed relative "
                                 "difference of a pass's share (default 0.25)")
            command.add_argument("--judge", action="store_true", help="cost: judge the limits on other devices than "
                                 "lavapipe too")
    command = commands.choices["compare"]
    command.add_argument("--cap", type=at_least(1), metavar="N", help="path tracing gets at most N times the paths of "
                         "equal time (default 64)")
    command.add_argument("--truth-samples", type=at_least(1), metavar="N", help="paths per pixel of the truth where no "
                         "reference fits (default 4096, 512 on a software driver)")
    command.add_argument("--curve-frames", type=at_least(1), metavar="N", help="most frames of the hierarchy in the curve "
                         "of error over time (default 256, 16 on a software driver)")
    commands.choices["pbgi"].add_argument("--points", type=at_least(4096), metavar="N",
                                          help="points of the scene, a power of two (default 524288)")
    command = commands.choices["motion"]
    command.add_argument("--vpls", type=at_least(1), metavar="N", help="virtual point lights (default 100000, 20000 on a "
                         "software driver)")
    command.add_argument("--truth-samples", type=at_least(1), metavar="N", help="paths per pixel of each of the two truths "
                         "(default 1024, 64 on a software driver)")
    command.add_argument("--sequence", action="append", choices=motion.SEQUENCES, help="one of the sequences; may be given more "
                         "than once (default: all)")
    command = commands.choices["scale"]
    command.add_argument("--case", action="append", choices=scale.NAMES, help="one of the inputs; may be given more than once "
                         "(default: all)")
    command.add_argument("--folder", type=Path, metavar="DIR", help="where inputs are made, up to 0.6 GB at a time (default: "
                         "that of temporary files)")
    command.set_defaults(scene="courtyard", camera=None, repeats=1, frames=1, warmup=0)
    command = commands.choices["variants"]
    command.add_argument("--base", default="", metavar="ARGS", help="options of gridlight that all variants have")
    command.add_argument("--variant", action="append", default=[], metavar="NAME=[BINARY::]ARGS", help="twice or more; "
                         "with BINARY:: another program, so that two commits can be compared")
    command.add_argument("--json", type=Path, metavar="FILE", help="writes everything that was found")
    return result


def prepare(options, words):
    """The program, the scene, and the command as the results quote it."""
    if options.program is None:
        subprocess.run(["cargo", "build", "--release", "--locked", "--bin", "gridlight"], cwd=ROOT, check=True)
        options.program = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/gridlight"
    path = Path(options.program).resolve()
    if not path.is_file():
        raise UsageError(f"--program {options.program} is not a file")
    shared = shared_folder()
    sponza = shared / "assets/sponza/sponza-sun.gltf"
    if options.scene is None and sponza.exists() and options.benchmark != "motion":
        options.scene, options.camera = str(sponza), options.camera or "atrium"
    named = options.scene not in (None, "courtyard")
    if named and not Path(options.scene).is_file():
        raise UsageError(f"--scene {options.scene} is not a file")
    options.scene_name = Path(options.scene).stem if named else "courtyard"
    options.references = shared / "references" if (shared / "references").is_dir() else None
    scene_arguments = [options.scene] if named else []
    for name in ("camera", "gpu"):
        if getattr(options, name):
            scene_arguments += [f"--{name}", getattr(options, name)]
    options.program = Program(path, scene_arguments)
    options.command = quoted(words)


def quoted(words):
    """Without what only says where things are on this machine."""
    kept, skip = [], False
    for word in words:
        located = word.partition("=")[0] in ("--program", "--results", "--json")
        if not skip and not located:
            kept.append(re.sub(r"(?<![^=])/(?:[^/\s]+/)*(?=[^/\s])", "", word))
        skip = located and "=" not in word
    return shlex.join(["tools/bench", *kept])


def main(words):
    try:
        options = parser().parse_args(words)
        prepare(options, words)
        return 0 if BENCHMARKS[options.benchmark][0].run(options) else 3
    except BenchError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.code
    except subprocess.CalledProcessError as error:
        print(f"error: exit code {error.returncode} from: {shlex.join(error.cmd)}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"error: {error.filename or 'a file'}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("error: interrupted; nothing was written", file=sys.stderr)
        return 130
