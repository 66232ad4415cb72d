"""The passes' timestamps against the wall clock: their sum in serial frames, and each pass against a run in which
every pass is submitted and waited for by itself."""
import statistics
import sys

from . import report
from .markdown import table

MODES = {
    "default": "--size 320x180 --vpls 10000",
    "alpha 2": "--size 320x180 --vpls 10000 --alpha 2",
    "4x4, k 1": "--size 320x180 --vpls 10000 --interleave 4 --shadow-samples 1",
    "lock, scatter": "--size 320x180 --vpls 10000 --reservoir lock --build scatter",
    "direct": "--size 320x180 --technique direct",
}
# Sum of the passes against the frame's wall clock.
SUM_TOLERANCE = 0.05


def run(options):
    """Timestamps of ordinary serial frames beside the wall clock of passes submitted one by one."""
    runs = {name: ([], []) for name in MODES}
    for _ in range(options.repeats):
        for name, arguments in MODES.items():
            for split in (0, 1):
                runs[name][split].append(options.program.timings(
                    arguments, "--frames", options.frames, "--warmup", options.warmup,
                    environment={"GRIDLIGHT_SPLIT_SUBMITS": str(split)})[0])
            print(f"{name}: {runs[name][0][-1]['frame_cpu_ms']['median']:.0f} ms in one submission, "
                  f"{runs[name][1][-1]['pass_sum_ms']['median']:.0f} ms in many", file=sys.stderr)
    modes, rows, passed = [], [], True
    for name, arguments in MODES.items():
        whole = runs[name][0]
        frame = statistics.median(t["frame_cpu_ms"]["median"] for t in whole)
        ratios = [t["pass_sum_ms"]["mean"] / t["frame_cpu_ms"]["mean"] for t in whole]
        ratio = statistics.median(ratios)
        good = abs(ratio - 1) <= SUM_TOLERANCE
        # The quietest of all frames: noise only ever adds.
        least = [{p["name"]: min(q["ms"]["min"] for t in half for q in t["passes"] if q["name"] == p["name"])
                  for p in half[0]["passes"]} for half in runs[name]]
        large = [p for p in least[1] if max(least[0][p], least[1][p]) >= 0.02 * frame]
        # As shares of the frame: a machine that is slower for a while is so for all passes.
        share = [{p: ms / sum(half.values()) for p, ms in half.items()} for half in least]
        wrong = [p for p in large if abs(share[0][p] - share[1][p]) > options.tolerance * share[1][p]]
        passed = passed and good and not wrong
        command = f"{options.program.shown(arguments)} --frames {options.frames} --warmup {options.warmup}"
        modes.append({"mode": name, "command": command, "frame_ms": frame, "sum_over_frame": ratios,
                      "stamped_ms": least[0], "alone_ms": least[1], "stamped_share": share[0],
                      "alone_share": share[1], "large": large, "wrong": wrong})
        total = statistics.median(t["pass_sum_ms"]["median"] for t in whole)
        rows.append([name, f"{frame:.1f}", f"{total:.1f}", f"{ratio:.4f}", "agrees" if good else "DISAGREES"])
    lines = table(["mode", "frame, wall clock ms", "sum of passes ms", "sum / frame", ""], rows)
    lines += ["", "Passes of 2 % of the frame or more: least ms by timestamp within the frame, and by wall clock when "
              f"submitted and waited for alone; their shares of the frame must agree within {options.tolerance:.0%}:", ""]
    lines += table(["mode", "pass", "timestamp", "alone", "share", "share alone", ""],
                   [row for mode in modes for row in rows_of(mode)], words=2)
    lines += ["", "Commands (for the second column with `GRIDLIGHT_SPLIT_SUBMITS=1`):", ""]
    lines += [f"    {m['command']}" for m in modes]
    report.write(options, "honesty", "Honesty", runs["default"][0][0], {"modes": modes}, lines)
    return passed


def rows_of(mode):
    """The large passes one by one, then the small ones together."""
    kinds = ("stamped_ms", "alone_ms", "stamped_share", "alone_share")
    rows = [(p, [mode[kind][p] for kind in kinds], "DISAGREES" if p in mode["wrong"] else "agrees")
            for p in mode["large"]]
    small = [p for p in mode["alone_ms"] if p not in mode["large"]]
    rows.append((f"the other {len(small)}", [sum(mode[kind][p] for p in small) for kind in kinds], ""))
    return [[mode["mode"], name, f"{a:.2f}", f"{b:.2f}", f"{c:.1%}", f"{d:.1%}", verdict]
            for name, (a, b, c, d), verdict in rows]
