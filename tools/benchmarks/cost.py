"""The frame's cost against its limits, and the memory of a million VPLs."""
import statistics
import sys

from . import report
from .markdown import table

# Limits are for lavapipe on two cores.
CASES = {
    "640x360, 100k VPLs, k 4": {
        "arguments": "--size 640x360 --vpls 100000 --alpha 1 --shadow-samples 4 --interleave 1",
        "measure": "frame_ms", "limit": 6000.0},
    "320x180, 10k VPLs, 4x4, k 1": {
        "arguments": "--size 320x180 --vpls 10000 --alpha 1 --shadow-samples 1 --interleave 4",
        "measure": "frame_ms", "limit": 600.0},
    "640x360, 1M VPLs, k 4": {
        "arguments": "--size 640x360 --vpls 1000000 --alpha 1 --shadow-samples 4 --interleave 1",
        "measure": "resident_mib", "limit": 2048.0},
}


def run(options):
    """The cases, alternating. True when every limit holds."""
    runs = {name: [] for name in CASES}
    for repeat in range(options.repeats):
        for name, case in CASES.items():
            if case["measure"] == "resident_mib" and repeat:
                continue
            runs[name].append(one(options, case))
            print(f"{name}: {runs[name][-1]['frame_ms']:.0f} ms, {runs[name][-1]['resident_mib']:.0f} MiB",
                  file=sys.stderr)
    timings = next(r["timings"] for case in runs.values() for r in case if "timings" in r)
    judged = options.judge or "llvmpipe" in timings["device"]["name"]
    cases, rows = [], []
    for name, case in CASES.items():
        frames = [r["frame_ms"] for r in runs[name]]
        value = statistics.median(r[case["measure"]] for r in runs[name])
        entry = {"case": name, "command": runs[name][0]["command"], "frame_ms": frames,
                 "resident_mib": [r["resident_mib"] for r in runs[name]], "measure": case["measure"],
                 "value": value, "limit": case["limit"], "passed": value < case["limit"] if judged else None}
        if "timings" in runs[name][0]:
            entry["pass_ms"] = {p["name"]: statistics.median(q["ms"]["median"] for r in runs[name]
                                for q in r["timings"]["passes"] if q["name"] == p["name"])
                                for p in runs[name][0]["timings"]["passes"]}
            entry["counts"] = runs[name][0]["timings"]["counts"]
        cases.append(entry)
        unit = "ms" if case["measure"] == "frame_ms" else "MiB"
        rows.append([name, f"{statistics.median(frames):.0f} ({min(frames):.0f} to {max(frames):.0f})",
                     f"{max(entry['resident_mib']):.0f}", f"{case['limit']:.0f} {unit}",
                     {True: "passed", False: "FAILED", None: "not judged"}[entry["passed"]]])
    lines = table(["case", "frame, median (min to max) ms", "resident MiB", "limit", ""], rows, words=5)
    lines += ["", "Passes that take 1 % of the frame or more, median ms:", ""]
    timed = [c for c in cases if "pass_ms" in c]
    shown = [n for n in dict.fromkeys(n for c in timed for n in c["pass_ms"])
             if any(c["pass_ms"].get(n, 0) >= 0.01 * statistics.median(c["frame_ms"]) for c in timed)]
    lines += table(["pass", *(c["case"] for c in timed)],
                   [[n, *(f"{c['pass_ms'].get(n, 0):.1f}" for c in timed)] for n in shown])
    lines += ["", "Commands:", ""] + [f"    {c['command']}" for c in cases]
    report.write(options, "cost", "Cost", timings, {"cases": cases}, lines)
    return all(c["passed"] is not False for c in cases)


def one(options, case):
    """JSON for time; CSV where memory counts, as JSON's statistics take a frame's memory again."""
    program, repetition = options.program, ("--frames", options.frames, "--warmup", options.warmup)
    result = {"command": f"{program.shown(case['arguments'])} --frames {options.frames} --warmup {options.warmup}"}
    if case["measure"] == "frame_ms":
        result["timings"], result["resident_mib"] = program.timings(case["arguments"], *repetition)
        result["frame_ms"] = result["timings"]["frame_cpu_ms"]["median"]
    else:
        frames, result["resident_mib"] = program.frames(case["arguments"], *repetition)
        result["frame_ms"] = statistics.median(sum(frame.values()) for frame in frames)
    return result
