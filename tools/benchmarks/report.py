"""Results as JSON and Markdown, with the machine and the command that made them."""
import json
import re
import sys
from pathlib import Path


def folder_of(options, timings):
    slug = re.sub(r"[^a-z0-9.]+", "-", timings["device"]["driver"].split("(")[0].lower()).strip("-")
    folder = options.results / slug
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def setup(options, timings):
    """What every result says about where it comes from."""
    machine = dict(timings["machine"])
    try:
        memory = re.search(r"MemTotal:\s+(\d+)", Path("/proc/meminfo").read_text())
        machine["memory_gib"] = round(int(memory.group(1)) / 2**20, 1)
    except OSError:
        pass
    return {"device": timings["device"], "machine": machine, "program": timings["program"],
            "scene": timings["scene"]["name"], "camera": timings["scene"]["camera"], "frames": options.frames,
            "warmup": options.warmup, "repeats": options.repeats, "command": options.command}


def head(title, setup):
    device, machine, program = setup["device"], setup["machine"], setup["program"]
    memory = f", {machine['memory_gib']} GiB" if "memory_gib" in machine else ""
    return [f"# {title}: {device['driver']}", "",
            f"- Device: {device['name']}, driver {device['driver']}, Vulkan {device['api_version']}",
            f"- Machine: {machine['cpu']}, {machine['cores']} hardware threads{memory}, {machine['os']}",
            f"- gridlight {program['version']}, commit {program['commit']}",
            f"- Scene {setup['scene']}, camera {setup['camera']}",
            f"- Runs of each case, alternating: {setup['repeats']}; measured frames in each: {setup['frames']}, after "
            f"{setup['warmup']} to warm up", f"- `{setup['command']}`", ""]


def write(options, name, title, timings, results, lines):
    folder = folder_of(options, timings)
    said = setup(options, timings)
    (folder / f"{name}.json").write_text(json.dumps({**said, **results}, indent=1) + "\n")
    text = "\n".join(head(title, said) + lines) + "\n"
    (folder / f"{name}.md").write_text(text)
    print(text)
    print(f"written to {folder / name}.md and .json", file=sys.stderr)
