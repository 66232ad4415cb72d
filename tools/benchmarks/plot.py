"""Pictures of results: mean overdraw against the number of grid lights, as in Figure 5 of the paper, and errors over time.
Drawn by matplotlib, in whichever Python has it; without it there is a sentence on stderr and no picture."""
import json
import subprocess
import sys

# `data` comes in as JSON; a drawing leaves `figure`.
SCRIPT = """
import json, sys
import matplotlib
matplotlib.use("svg")
from matplotlib import pyplot
# The same file for the same points: no random ids, no date.
matplotlib.rcParams.update({"svg.hashsalt": "gridlight", "svg.fonttype": "path"})
data = json.load(sys.stdin)
%s
figure.savefig(sys.argv[1], format="svg", metadata={"Date": None})
"""
DRAWINGS = {"overdraw": """
figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
for alpha in sorted({p["alpha"] for p in data}):
    series = [p for p in data if p["alpha"] == alpha]
    axes.plot([p["grid_lights"] for p in series], [p["lights_tested_mean"] for p in series], marker="o", label=f"alpha {alpha}")
axes.set_xscale("log")
axes.set_ylim(bottom=0)
axes.set_xlabel("grid lights")
axes.set_ylabel("fragments per pixel, mean")
axes.grid(True, which="major", linewidth=0.4)
axes.legend()
""", "curves": """
measures = data["measures"]
figure, all_axes = pyplot.subplots(1, len(measures), figsize=(4 * len(measures), 4), layout="constrained")
for axes, (key, words) in zip(all_axes, measures.items()):
    for name in dict.fromkeys(p["series"] for p in data["points"]):
        series = [p for p in data["points"] if p["series"] == name]
        axes.plot([p["ms"] / 1000 for p in series], [p[key] for p in series], marker="o", label=name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("seconds on the device")
    axes.set_ylabel(words)
    axes.grid(True, which="major", linewidth=0.4)
all_axes[0].legend()
""", "sequences": """
names = list(dict.fromkeys(p["sequence"] for p in data))
figure, grid = pyplot.subplots(2, len(names), figsize=(3 * len(names), 5), layout="constrained", squeeze=False)
for row, key in zip(grid, ("flicker", "flip")):
    for axes, name in zip(row, names):
        for way in dict.fromkeys(p["series"] for p in data):
            series = [p for p in data if (p["sequence"], p["series"]) == (name, way) and p[key] is not None]
            axes.plot([p["frame"] for p in series], [p[key] for p in series], marker=".", label=way)
        axes.set_ylim(bottom=0)
        axes.set_title(name)
        axes.grid(True, which="major", linewidth=0.4)
    row[0].set_ylabel(key)
grid[0][0].legend()
""", "difference": """
ours, reference = (pyplot.imread(file)[..., :3] for file in data)
figure, all_axes = pyplot.subplots(1, 3, figsize=(12, 2.6), layout="constrained")
for axes, picture in zip(all_axes, (ours, reference, (4 * abs(ours - reference)).clip(0, 1))):
    axes.imshow(picture)
    axes.set_axis_off()
"""}
PYTHONS = ("python3", "/usr/bin/python3")


def python():
    """A Python that has matplotlib: Debian's package is not seen by another Python that comes first in PATH."""
    for candidate in dict.fromkeys([sys.executable, *PYTHONS]):
        try:
            found = subprocess.run([candidate, "-c", "import matplotlib"], capture_output=True)
        except OSError:
            continue
        if found.returncode == 0:
            return candidate
    return None


def draw(drawing, data, file):
    """Whether there is a picture, one of DRAWINGS; never one of an earlier run."""
    file.unlink(missing_ok=True)
    interpreter = python()
    if interpreter is None:
        print(f"{file.name} is not drawn: matplotlib is missing; apt-get install python3-matplotlib", file=sys.stderr)
        return False
    found = subprocess.run([interpreter, "-c", SCRIPT % DRAWINGS[drawing], str(file)], input=json.dumps(data), text=True,
                           capture_output=True)
    if found.returncode:
        last = found.stderr.strip().splitlines()[-1:] or ["no message"]
        print(f"{file.name} is not drawn: {last[0]}", file=sys.stderr)
    return found.returncode == 0
