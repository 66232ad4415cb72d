"""The paper's Tables 1, 2 and 3 and the plot of its Figure 5, ours beside the published numbers."""
import math

from . import plot, protocol, published, report, steps
from .markdown import count, number, spread, table
from .protocol import Case

SHADOWS = (0, 1, 4)
INTERLEAVES = (1, 2, 4)
ALPHAS = (1, 2)
# How coarse levels are built: the paper's two ways, and ours by default.
BUILDS = ("scatter", "gather", "cascade")
# Construction's share of the frame that is aimed at, with MIDDLE lights.
SHARE_TARGET = 0.10


class Plan:
    """How large everything is: by the kind of device, unless options say otherwise."""

    def __init__(self, options, software):
        if options.quick:
            self.vpls, self.size, defaults = (200, 2_000), "64x36", (0, 1, 0)
        else:
            self.vpls = published.VPLS
            self.size, defaults = ("640x360", (3, 2, 1)) if software else ("1280x720", (4, 64, 8))
        self.size = options.size or self.size
        for name, value in zip(("repeats", "frames", "warmup"), defaults):
            if getattr(options, name) is None:
                setattr(options, name, value)
        self.repeats = options.repeats
        # A million lights take so long on a processor that a process more would cost more than it tells.
        self.repeats_of_most = -(-options.repeats // 3) if software else options.repeats
        self.middle = self.vpls[-1] if options.quick else 100_000
        # Half decades: a logarithmic plot wants more points than the tables.
        halves = () if options.quick else [3 * vpls for vpls in self.vpls[:-1]]
        self.plotted = sorted([*self.vpls, *halves])

    def arguments(self, vpls, shadow_samples=4, rest="--interleave 1", alpha=1):
        return f"--size {self.size} --vpls {vpls} --alpha {alpha} --shadow-samples {shadow_samples} {rest}"


def half(size):
    width, height = map(int, size.split("x"))
    return f"{max(1, width // 2)}x{max(1, height // 2)}"


def cases(plan, volumes):
    """The cases by what the tables call them. `volumes`: the option that draws lights as volumes, where that is not the
    only way."""
    found = {("build", build): Case(build, plan.arguments(plan.middle, rest=f"--interleave 1 --build {build}"), plan.repeats)
             for build in BUILDS if build != "cascade"}
    for vpls in plan.vpls:
        repeats = plan.repeats if vpls < 1_000_000 else plan.repeats_of_most
        for k in SHADOWS:
            found["vpls", vpls, k] = Case(f"{count(vpls)}, k {k}", plan.arguments(vpls, k), repeats)
    for lighting in dict.fromkeys(["", volumes]):
        for n in INTERLEAVES:
            rest = f"--interleave {n}{lighting}"
            name = f"{n}x{n}{lighting.replace(' --lighting', ',')}"
            found["interleave", lighting, n] = Case(name, plan.arguments(plan.middle, rest=rest), plan.repeats)
    for alpha in ALPHAS:
        for vpls in plan.plotted:
            arguments = plan.arguments(vpls, 0, f"--interleave 1{volumes}", alpha)
            found["overdraw", alpha, vpls] = Case(f"overdraw, {count(vpls)}, alpha {alpha}", arguments, 0)
    small = plan.arguments(plan.middle).replace(plan.size, half(plan.size), 1)
    found["small",] = Case("half the size", small, 0)
    # What stands in two tables is measured once.
    found["build", "cascade"] = found["interleave", "", 1] = found["vpls", plan.middle, 4]
    return found


def run(options):
    timings = protocol.probe(options.program)
    plan = Plan(options, protocol.is_software(timings))
    volumes = " --lighting volumes" if options.program.has_option("--lighting") else ""
    wanted = cases(plan, volumes)
    measured = protocol.measure(options.program, list(dict.fromkeys(wanted.values())), options.frames, options.warmup,
                                check=steps.assign)
    found = {key: measured[case.name] for key, case in wanted.items()}
    lines = [f"{plan.size}, all other options as by default. Times are milliseconds on the device's clock: median (p95 by "
             "nearest rank) over all measured frames. A cell that sums passes sums them in every frame first, so that "
             "medians need not add up to the median of their total.", ""]
    if plan.repeats_of_most != plan.repeats:
        lines += [f"Runs of the cases with a million VPLs: {plan.repeats_of_most}.", ""]
    if options.quick:
        lines += ["**A quick run: its times say nothing.**", ""]
    for section in (construction, vpl_counts, rendering, growth, overdraw):
        lines += section(plan, found) + [""]
    points = overdraw_points(plan, found)
    picture = plot.draw("overdraw", points, report.folder_of(options, timings) / "overdraw.svg")
    lines += ["![mean overdraw against grid lights](overdraw.svg)", ""] if picture else []
    lines += memory(plan, found) + [""]
    lines += ["## Commands", "", f"Each with `--frames {options.frames} --warmup {options.warmup}`; those for the overdraw "
              "and the half size once, for their counts.", ""]
    lines += [f"    {m.command}" for m in measured.values()]
    report.write(options, "tables", "The paper's tables", found["build", "cascade"].timings,
                 {"size": plan.size, "cases": [m.as_json() for m in measured.values()],
                  "overdraw": points}, lines)
    return True


def phase(measurement, *phases):
    """Summary of everything in these phases of the frame."""
    names = [name for p in phases for passes in steps.members(measurement.passes(), p).values() for name in passes]
    return measurement.sum_of(names)


def construction(plan, found):
    builds = [found["build", name] for name in BUILDS]
    rows_of = [steps.members(m.passes(), steps.CONSTRUCTION) for m in builds]
    order = [row.title for row in steps.ROWS if any(row.title in rows for rows in rows_of)]
    cells = {title: [spread(m.sum_of(rows[title])) if title in rows else "" for m, rows in zip(builds, rows_of)]
             for title in order}
    cells["Total"] = [spread(phase(m, steps.CONSTRUCTION)) for m in builds]
    # Levels and the total, which only one of the two sides has, in their places.
    order += [title for title in published.CONSTRUCTION if title not in order]
    order.sort(key=lambda title: (title == "Total", title == "Merge"))
    rows = [[title, *cells.get(title, [""] * len(BUILDS)), *map(number, published.CONSTRUCTION.get(title, (None, None)))]
            for title in order]
    return [f"## Table 1: construction by step, {count(plan.middle)} VPLs", "",
            *table(["step", *(f"ours, {build}" for build in BUILDS), f"{published.DEVICE}, scatter",
                    f"{published.DEVICE}, gather"], rows), "",
            "`cascade`, the default, gathers each level from the one below; `gather`, as the paper, each from S1. Passes in "
            "each row, by build; the total is the sum of all of them:", "",
            *(f"- {title}: " + "; ".join(dict.fromkeys(", ".join(f"`{p}`" for p in rows[title])
                                                       for rows in rows_of if title in rows))
              for title in order if title in cells and title != "Total"), "",
            "The paper's table has no row for finding, counting and listing the vertices that have light; it is one row for "
            "all levels here, as `--build scatter` does it for all levels at once. The published times are of 100k VPLs."]


def vpl_counts(plan, found):
    paper = dict(zip(published.VPLS, range(len(published.VPLS))))

    def row(title, summary, numbers):
        return [title, *(cell for vpls in plan.vpls for cell in (
            spread(summary(vpls)), number(numbers[paper[vpls]]) if vpls in paper else ""))]

    names = {0: "no shadow", 1: "1 shadow sample", 4: "4 shadow samples"}
    rows = [row("VPL generation", lambda v: phase(found["vpls", v, 4], steps.VPLS), published.VPL_GENERATION),
            row("Hierarchy construction", lambda v: phase(found["vpls", v, 4], steps.CONSTRUCTION), published.HIERARCHY)]
    for k in SHADOWS:
        rows.append(row(f"Render, {names[k]}", lambda v, k=k: phase(found["vpls", v, k], steps.RENDER), published.RENDER[k]))
    lights = ", ".join(f"{found['vpls', v, 4].timings['counts']['vpls']:,}" for v in plan.vpls)
    generated = steps.members(found["build", "cascade"].passes(), steps.VPLS)["VPL generation"]
    return ["## Table 2: computation and render times by number of VPLs", "",
            *table(["", *(cell for v in plan.vpls for cell in (count(v), published.DEVICE))], rows), "",
            f"VPLs made: {lights}. VPL generation: {', '.join(f'`{p}`' for p in generated)}. Rendering is every pass that "
            "is neither VPL generation nor construction, direct light and display included. The first two rows are "
            "those of the runs with four shadow samples."]


def rendering(plan, found):
    lines = []
    for lighting in dict.fromkeys(key[1] for key in found if key[0] == "interleave"):
        lines += rendering_with(lighting, plan, [found["interleave", lighting, n] for n in INTERLEAVES])
    return lines + [
        "The totals leave out VPL generation and construction, as in the paper, and are the sum of every other pass; the "
        "paper's have no direct light and no display. The paper draws light volumes, and chooses shadow samples by plain "
        "read-modify-write, with locks for 4x4 only."]


def rendering_with(lighting, plan, columns):
    totals = [phase(m, steps.RENDER) for m in columns]
    sums = [steps.members(m.passes(), steps.RENDER) for m in columns]
    rows = []
    for title in [row.title for row in steps.ROWS if any(row.title in s for s in sums)]:
        cells = []
        for i, (m, total) in enumerate(zip(columns, totals)):
            own = m.sum_of(sums[i].get(title, []))
            paper = published.RENDERING.get(title)
            cells += [spread(own), f"{own.median / total.median:.1%}", number(paper[i] if paper else None)]
        rows.append([title, *cells])
    rows.append(["Total", *(cell for i, total in enumerate(totals)
                            for cell in (spread(total), "", number(published.RENDERING["Total"][i])))])
    settings = columns[0].timings["settings"]
    chosen = ", ".join(f"`--{key} {settings[key]}`" for key in ("lighting", "reservoir") if settings.get(key))
    title = f"## Table 3: rendering by operation, {count(plan.middle)} VPLs, 4 shadow samples"
    return [title + (f",{lighting.replace(' --', ' ')}" if lighting else ""), "",
            *table(["", *(cell for n in INTERLEAVES for cell in (
                "no interleaving" if n == 1 else f"{n}x{n}", "share", published.DEVICE))], rows), "",
            f"With {chosen}. Passes in each row:", "",
            *(f"- {row[0]}: {', '.join(f'`{p}`' for p in dict.fromkeys(p for s in sums for p in s.get(row[0], [])))}"
              for row in rows[:-1]), ""]


def growth(plan, found):
    rows, before = [], None
    for i, vpls in enumerate(plan.vpls):
        measurement = found["vpls", vpls, 4]
        lights = measurement.timings["counts"]["vpls"]
        ours = phase(measurement, steps.CONSTRUCTION).median
        theirs = published.HIERARCHY[published.VPLS.index(vpls)] if vpls in published.VPLS else None
        factors = ["", ""]
        if before:
            decades = math.log10(lights / before[0])
            factors = [number((ours / before[1]) ** (1 / decades)), number(theirs / before[2]) if theirs else ""]
        frame = measurement.frame().median
        rows.append([f"{lights:,}", number(ours), factors[0], f"{ours / frame:.1%}", number(theirs), factors[1]])
        before = (lights, ours, theirs)
    middle = found["vpls", plan.middle, 4]
    share = phase(middle, steps.CONSTRUCTION).median / middle.frame().median
    verdict = "met" if share < SHARE_TARGET else "**missed**"
    return ["## Growth of the construction", "",
            *table(["VPLs", "construction", "times, per tenfold VPLs", "share of the frame", published.DEVICE,
                    "times, per tenfold VPLs"], rows), "",
            "Less than 10 times per tenfold VPLs is sublinear. Construction is "
            f"{share:.1%} of the whole frame (VPL generation and rendering with four shadow samples included) with "
            f"{count(plan.middle)} VPLs; target below {SHARE_TARGET:.0%}: {verdict}."]


def overdraw_points(plan, found):
    result = []
    for alpha in ALPHAS:
        for vpls in plan.plotted:
            counts = found["overdraw", alpha, vpls].timings["counts"]
            result.append({"alpha": alpha, "vpls": counts["vpls"], "grid_lights": sum(counts["grid_lights_per_level"]),
                           "lights_tested_mean": counts["lights_tested_mean"], "lights_tested_max": counts["lights_tested_max"]})
    return result


def overdraw(plan, found):
    rows, first = [], None
    for point in overdraw_points(plan, found):
        added = ""
        if first and first["alpha"] == point["alpha"]:
            # From the first, as neighbours may have nearly as many grid lights.
            decades = math.log10(point["grid_lights"] / first["grid_lights"])
            added = number((point["lights_tested_mean"] - first["lights_tested_mean"]) / decades) if decades else ""
        else:
            first = point
        rows.append([point["alpha"], f"{point['vpls']:,}", f"{point['grid_lights']:,}", number(point["lights_tested_mean"]),
                     point["lights_tested_max"], added])
    return ["## Figure 5: overdraw of the light volumes", "",
            *table(["alpha", "VPLs", "grid lights", "fragments per pixel, mean", "most",
                    "more per tenfold grid lights, from the first"], rows), "",
            "Where growth is logarithmic the last column is the same in every line."]


def memory(plan, found):
    few, many = (found["vpls", v, 4].timings for v in plan.vpls[-2:])
    lights = many["counts"]["vpls"] - few["counts"]["vpls"]
    small, large = found["small",], found["build", "cascade"]
    pixels = [math.prod(map(int, m.timings["settings"]["size"].split("x"))) for m in (small, large)]
    per_pixel = (large.timings["memory"]["device_bytes"] - small.timings["memory"]["device_bytes"]) / (pixels[1] - pixels[0])
    per_vpl = (many["memory"]["device_bytes"] - few["memory"]["device_bytes"]) / lights
    rows = [[count(v), *(f"{(found['vpls', v, 4].timings['memory'][key] or 0) / 2**20:.0f}"
                         for key in ("device_bytes", "peak_resident_bytes"))] for v in plan.vpls]
    return ["## Memory, four shadow samples", "",
            *table(["VPLs", "device MiB", "peak of the process MiB"], rows), "",
            f"Device memory grows by {per_vpl:.0f} bytes per VPL (from {count(plan.vpls[-2])} to {count(plan.vpls[-1])} "
            f"VPLs) and {per_pixel:.0f} bytes per pixel (from {half(plan.size)} to {plan.size}). It is what is "
            "reserved, in blocks, the scene and the statistics frame included."]
