"""What becomes of inputs that are large in one way each: a picture or a refusal, the memory, the time."""
import dataclasses
import math
import multiprocessing
import tempfile
import time
from pathlib import Path

from . import large, report
from .errors import BenchError
from .markdown import count, number, table
from .protocol import attempt, probe, shared_folder, without_paths

DIRECT = "--technique direct --size 320x180"
LARGE_PICTURE = "--size 16384x8192"


@dataclasses.dataclass(frozen=True)
class Input:
    """An input and the run of it. `make` writes the scene to a file, smaller in a quick run; without it the scene is the
    built-in one, or that of a path."""
    name: str
    words: str
    arguments: str
    make: object = None
    scene: Path | None = None


def inputs(quick):
    """All of them, or small ones of each kind."""
    def less(value, quick_value):
        return quick_value if quick else value

    vpls = f"--vpls {less('8M', 2000)} --size {less('640x360', '32x18')}"
    width, height = less((16384, 8192), (64, 32))
    picture = less(LARGE_PICTURE, "--size 64x36")
    colors, images, side = less(4096, 9), less(1000, 5), less(3162, 8)
    copies, copied_side = less(1000, 4), less(100, 4)
    moving_side, moving_copies = less(50, 3), less(20, 3)
    frames = f"--size {less('640x360', '32x18')} --vpls {less('100k', 2000)} --frames {less(12, 2)}"
    sky = f"{width}x{height}"
    squares = f"{colors} materials"
    return [
        Input("vpls", "built-in scene", vpls),
        Input("vpls-sponza", "Sponza, camera atrium", f"--camera atrium {vpls}",
              scene=shared_folder() / "assets/sponza/sponza-sun.gltf"),
        Input("materials", squares, f"--vpls 2000 {less('--size 320x180', '--size 32x18')}",
              lambda file: large.materials(file, colors)),
        Input("textures", f"{images} textures", DIRECT, lambda file: large.textures(file, images, less(256, 16))),
        Input("texture", f"a texture of {sky}", DIRECT, lambda file: large.texture(file, width, height)),
        Input("environment", f"an EXR environment of {sky}", f"{DIRECT} --environment ENVIRONMENT",
              lambda file: large.environment(file, width, height)),
        Input("picture", squares, f"--technique direct {picture}", lambda file: large.materials(file, colors)),
        Input("picture-vpls", squares, f"--vpls 1000 {picture}", lambda file: large.materials(file, colors)),
        Input("triangles", f"one grid of {2 * side**2:,} triangles", DIRECT, lambda file: large.grid(file, side)),
        *[Input(f"motion-{name}", f"{2 * moving_side**2 * moving_copies:,} triangles that move, {words}",
                f"{frames} --animation {name}", lambda file: large.moving(file, moving_side, moving_copies))
          for name, words in (("none", "at rest"), ("rise", "in motion"))],
        Input("instances", f"{2 * copied_side**2:,} triangles, {count(copies)} times (`EXT_mesh_gpu_instancing`)", DIRECT,
              lambda file: large.grid(file, copied_side, copies)),
    ]


NAMES = [one.name for one in inputs(quick=True)]


def make(one, file):
    """Makes an input in a process of its own: the memory of a process counts that of the one which started it."""
    process = multiprocessing.get_context("fork").Process(target=one.make, args=(file,))
    process.start()
    process.join()
    if process.exitcode:
        raise BenchError(f"{one.name}: the input could not be made")


def run_one(program, one, folder):
    """Makes the input, renders it, and deletes it; gives what became of it, or nothing where its scene is not there."""
    if one.scene is not None and not one.scene.is_file():
        print(f"{one.name}: left out, as {one.scene.name} is not there")
        return None
    scene = [str(one.scene)] if one.scene else []
    if one.make:
        file = folder / f"{one.name}.glb"
        make(one, file)
        scene = [str(file)]
    input_bytes = sum(file.stat().st_size for file in folder.iterdir())
    sky = str(folder / f"{one.name}.exr")
    words = [sky if word == "ENVIRONMENT" else word for word in program.words(one.arguments)]
    command = [words[0], *scene, *words[1:], "--output", str(folder / "picture.png")]
    start = time.monotonic()
    ended = attempt(command)
    seconds = time.monotonic() - start
    for file in folder.iterdir():
        file.unlink()
    result = "a picture" if ended.code == 0 else f"exit code {ended.code}: {ended.last_line()}"
    print(f"{one.name}: {result}, {seconds:.0f} s", flush=True)
    return {"case": one.name, "input": one.words, "options": one.arguments.replace("ENVIRONMENT", "FILE.exr"),
            "command": without_paths(command), "exit_code": ended.code, "result": result.replace(f"{folder}/", ""),
            "input_bytes": input_bytes, "resident_mib": ended.resident_mib, "seconds": seconds}


def run(options):
    """True: whatever becomes of an input is a result."""
    chosen = [one for one in inputs(options.quick) if not options.case or one.name in options.case]
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        rows = [run_one(options.program, one, Path(folder)) for one in chosen]
    found = [row for row in rows if row is not None]
    timings = probe(options.program)
    cells = [[row["input"], f"`{row['options']}`", row["result"], number(row["input_bytes"] / 2**20),
              number(row["resident_mib"]), math.ceil(row["seconds"])] for row in found]
    lines = ["Memory is the most that the process held.", "",
             *table(["input", "options", "result", "input, MiB", "memory, MiB", "seconds"], cells, words=3)]
    report.write(options, "scale", "Large inputs", timings, {"inputs": found}, lines)
    return True
