"""Answers like gridlight at once, from the names of the passes and the options. FAKE_FAULT plants a fault."""
import json
import os
import sys

from names import FIXTURE

fault = os.environ.get("FAKE_FAULT", "")
words = sys.argv[1:]
options = {word: words[i + 1] if i + 1 < len(words) else "" for i, word in enumerate(words) if word.startswith("--")}
if words[:1] == ["compare"]:
    # A picture is its error.
    error = float(open(words[2], encoding="utf-8").read())
    metrics = {"energy_ratio": 1.0, "relmse": error, "smooth_relmse": error, "flip": error, "indirect_ratio": 1.0, "exposure": 2.0}
    with open(options["--json"], "w", encoding="utf-8") as file:
        json.dump({"metrics": metrics}, file)
    sys.exit()
if words[:1] == ["compare-sequence"]:
    answer = {"frame": 24, "frames": None if "paper" in words[2] else 1, "left": [0.5, 0.2]} if "switch" in words[1] else None
    frames = [{"frame": 6, "relmse": 0.1, "flip": 0.2, "energy_ratio": 1.0, "flicker": None, "block_flicker": None}]
    metrics = {"flicker": 0.02, "block_flicker": 0.01, "lag_frames": None, "answer": answer, "relmse": 0.1, "flip": 0.2,
               "energy_ratio": 1.0, "frames": frames}
    with open(options["--json"], "w", encoding="utf-8") as file:
        json.dump({"metrics": metrics}, file)
    sys.exit()
if "--help" in words:
    print("      --lighting <volumes|gather>  How lights reach pixels")
    sys.exit()
if fault == "lost":
    print("error: the device was lost in shadow_rays", file=sys.stderr)
    sys.exit(5)
if options.get("--alpha") == "-1":
    print("error: --alpha must be above 0", file=sys.stderr)
    sys.exit(2)

vpls, samples = int(options.get("--vpls", 1000)), int(options.get("--samples", 1))
frames = int(options.get("--accumulate", 1))
if options.get("--technique") == "path-trace":
    passes = {"gbuffer": 10.0, "path_trace": 20.0 * samples}
elif options.get("--technique") == "pbgi":
    # The points' own way takes longer.
    passes = {name: 3.0 if options.get("--micro") == "points" else 2.0 for name in FIXTURE["pbgi"]}
else:
    build = options.get("--build", "cascade")
    kind = "interleaved" if options.get("--interleave", "1") != "1" else build
    # Each pass takes as long as the others, longer with more lights.
    passes = {name: 1.0 + vpls / 1000 * float(options.get("--alpha", 1)) for name in FIXTURE[kind]}
if fault == "unknown":
    passes["tea_break"] = 1.0
total = sum(passes.values())
if "--timings" in options:
    file = options["--timings"]
    with open(file, "w", encoding="utf-8") as out:
        if file.endswith(".csv"):
            out.write("frame,pass,gpu_ms\n")
            for frame in range(int(options.get("--frames", 1))):
                out.writelines(f"{frame},{name},{ms}\n" for name, ms in passes.items())
        else:
            device = {"name": "llvmpipe (fake)", "driver": "fake driver 1 (x)", "api_version": "1.3"}
            counts = {"vpls": vpls, "grid_lights_per_level": [vpls // 2, 8], "lights_tested_mean": 10.0, "lights_tested_max": 20,
                      "primary_points": 40, "seen_points": 200, "needed_points": 50}
            json.dump({"device": device, "machine": {"cpu": "fake", "cores": 2, "os": "fake"},
                       "program": {"version": "0", "commit": "fake"}, "scene": {"name": "courtyard", "camera": "court"},
                       "settings": {"size": options["--size"], "reservoir": "exact"}, "counts": counts,
                       "memory": {"device_bytes": 1000 * vpls, "peak_resident_bytes": None},
                       "passes": [{"name": name, "ms": {"median": ms}} for name, ms in passes.items()],
                       "frame_gpu_ms": {"median": total}, "frame_cpu_ms": {"median": total}}, out)
outputs = [options["--output"]] if "--output" in options else []
if outputs and "{frame}" in outputs[0]:
    outputs = [outputs[0].replace("{frame}", f"{frame:04}") for frame in range(int(options["--frames"]))]
for output in outputs:
    with open(output, "w", encoding="utf-8") as out:
        # More paths, less error; the hierarchy's is always the same.
        out.write(str(1 / samples / frames if options.get("--technique") == "path-trace" else 0.05))
