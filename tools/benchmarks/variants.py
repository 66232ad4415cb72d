"""Variants of options, or of the program, against each other in one run."""
import json
import re
import sys
from pathlib import Path

from . import protocol, report, steps
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
              f"{found[0].case.name}. Rows of the paper's tables in brackets, then passes; of 1 % of a frame or more:", ""]
    lines += table(["pass", "variant", "median", "p95", "min", "ratio"], rows(found), words=2)
    setup = report.setup(options, found[0].timings)
    print("\n".join(report.head("Variants", setup) + lines))
    if options.json:
        results = {**setup, "variants": [measurement.as_json() for measurement in found]}
        options.json.write_text(json.dumps(results, indent=1) + "\n")
        print(f"written to {options.json}", file=sys.stderr)
    return True


def in_frame_order(series):
    """All names of the series; what only a later one has comes after what it follows there."""
    result = []
    for names in series:
        place = 0
        for name in names:
            if name in result:
                place = result.index(name) + 1
            else:
                result.insert(place, name)
                place += 1
    return result


def rows(found):
    """For every variant that has it: the whole frame, the rows of the paper's tables (which a pass keeps when it is
    renamed or split), and the passes in the order of the frame."""
    names = in_frame_order([m.passes() for m in found])
    sums = [(f"({row.title})", [n for n in names if re.fullmatch(row.pattern, n)]) for row in steps.ROWS]
    frames = [m.frame() for m in found]
    result = group("frame", found, frames)
    for title, passes in sums + [(name, [name]) for name in names]:
        parts = [m.sum_of(passes) if set(passes) & set(m.passes()) else None for m in found]
        if any(part and part.median >= 0.01 * frame.median for part, frame in zip(parts, frames)):
            result += group(title, found, parts)
    return result


def group(title, found, summaries):
    first = summaries[0].median if summaries[0] else None
    return [[title, m.case.name, number(s.median), number(s.p95), number(s.minimum),
             ratio(s.median / first if first else None)] for m, s in zip(found, summaries) if s]
