"""Variants of options, or of the program, against each other in one run."""
import json
import sys
from pathlib import Path

from . import protocol, report
from .errors import UsageError
from .markdown import number, ratio, table


def parse(text):
    """NAME=ARGS or NAME=BINARY::ARGS."""
    name, equals, arguments = text.partition("=")
    if not equals or not name.strip() or name.strip().startswith("-"):
        raise UsageError(f"--variant '{text}' is not NAME=ARGS or NAME=BINARY::ARGS")
    binary, colons, rest = arguments.partition("::")
    if not colons:
        return name.strip(), arguments, None
    path = Path(binary.strip()).expanduser().resolve()
    if not path.is_file():
        raise UsageError(f"the program of variant {name.strip()}, {binary.strip()}, is not a file")
    return name.strip(), rest, str(path)


def cases(options):
    variants = [parse(text) for text in options.variant]
    names = [name for name, _, _ in variants]
    if len(names) < 2:
        raise UsageError("variants needs --variant twice or more: the first is what the others are compared with")
    if len(set(names)) != len(names):
        raise UsageError(f"two variants have the same name: {', '.join(names)}")
    return [protocol.Case(name, f"{options.base} {arguments}".strip(), options.repeats, program)
            for name, arguments, program in variants]


def run(options):
    found = list(protocol.measure(options.program, cases(options), options.frames, options.warmup).values())
    lines = []
    for measurement in found:
        program = measurement.timings["program"]
        lines.append(f"- {measurement.case.name}: `{measurement.command}` (commit {program['commit']})")
    lines += ["", "Milliseconds on the device's clock; p95 by nearest rank. The ratio is that of the medians to "
              f"{found[0].case.name}. Passes of 1 % or more of a frame:", ""]
    lines += table(["pass", "variant", "median", "p95", "min", "ratio"], rows(found), words=2)
    setup = report.setup(options, found[0].timings)
    print("\n".join(report.head("Variants", setup) + lines))
    if options.json:
        results = {**setup, "variants": [measurement.as_json() for measurement in found]}
        options.json.write_text(json.dumps(results, indent=1) + "\n")
        print(f"written to {options.json}", file=sys.stderr)
    return True


def rows(found):
    """The whole frame, then the passes in the order of the frame, each for every variant that has it."""
    frames = [m.frame() for m in found]
    names = dict.fromkeys(name for m in found for name in m.passes())
    shown = [name for name in names if any(
        m.sum_of([name]).median >= 0.01 * frame.median for m, frame in zip(found, frames))]
    result = group("frame", found, frames)
    for name in shown:
        result += group(name, found, [m.sum_of([name]) if name in m.passes() else None for m in found])
    return result


def group(title, found, summaries):
    first = summaries[0].median if summaries[0] else None
    return [[title, m.case.name, number(s.median), number(s.p95), number(s.minimum),
             ratio(s.median / first if first else None)] for m, s in zip(found, summaries) if s]
