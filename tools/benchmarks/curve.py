"""Error over time: the hierarchy's frames and path tracing's, accumulated one after the other."""
import sys

from . import plot
from .markdown import number, table

# Measures that fall with time: key in the metrics of `gridlight compare`, words.
MEASURES = {"relmse": "relMSE", "smooth_relmse": "relMSE of 8x8 blocks", "flip": "FLIP"}
PICTURE = "compare-curve.svg"
# A series ends here even where a frame takes next to no time.
MOST_FRAMES = 4096


def doublings(most):
    """1, 2, 4, ... up to `most`."""
    return [1 << i for i in range(most.bit_length())]


def point(options, truth, name, arguments, frames, picture):
    """Errors of the mean of so many frames, and the time that all of them take on the device's clock."""
    timings, _ = options.program.timings(arguments, "--accumulate", frames, "--output", picture)
    errors = truth.errors(picture)
    found = {"series": name, "frames": frames, "ms": frames * timings["frame_gpu_ms"]["median"],
             **{key: errors[key] for key in MEASURES}}
    print(f"{name}, {frames} frames: {found['ms']:.0f} ms, relMSE {found['relmse']:.4f}", file=sys.stderr)
    return found


def measure(options, truth, hierarchies, traced, folder):
    """Points of every series. `hierarchies` are (name, arguments) whose frames are doubled up to `--curve-frames`; path
    tracing, one path per pixel and frame, goes on until it has taken as long as the slowest of them."""
    picture = folder / "curve.exr"
    points = [point(options, truth, name, arguments, frames, picture)
              for name, arguments in hierarchies for frames in doublings(options.curve_frames)]
    longest = max(entry["ms"] for entry in points)
    for frames in doublings(MOST_FRAMES):
        points.append(point(options, truth, "path tracing", traced, frames, picture))
        if points[-1]["ms"] >= longest:
            break
    return points


def page(points, truth_words, folder):
    lines = ["## Error over time", "", "Frames are accumulated, each with fresh samples and another place in the pixel; path "
             f"tracing has one path per pixel in each. Time is the device's of all frames. Truth: {truth_words}.", ""]
    if plot.draw("curves", {"points": points, "measures": MEASURES}, folder / PICTURE):
        lines += [f"![error over time]({PICTURE})", ""]
    return lines + table(["", "frames", "ms", *MEASURES.values()],
                         [[p["series"], p["frames"], number(p["ms"]), *(f"{p[key]:.4f}" for key in MEASURES)]
                          for p in points])
