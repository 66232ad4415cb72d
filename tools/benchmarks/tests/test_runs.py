"""Whole benchmarks on a program that answers at once, and the sentences for what goes wrong."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
BENCH = HERE.parents[1] / "bench"


def fake(folder):
    """The program, without the time that an ordinary start of Python takes."""
    file = Path(folder) / "gridlight"
    file.write_text(f"#!{sys.executable} -S\nimport runpy, sys\nsys.path.insert(0, {str(HERE)!r})\n"
                    f"runpy.run_path({str(HERE / 'fake_gridlight.py')!r})\n")
    file.chmod(0o755)
    return str(file)


def bench(words, fault="", **environment):
    return subprocess.run([sys.executable, str(BENCH), *words], capture_output=True, text=True,
                          env={**os.environ, "FAKE_FAULT": fault, "GRIDLIGHT_SHARED": "/nowhere", **environment})


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.results = Path(folder.name)
        self.fake = fake(folder.name)
        self.to = ["--program", self.fake, "--results", folder.name]

    def fails(self, found, code, *words):
        """One sentence on stderr, after what progress there was."""
        errors = [line for line in found.stderr.splitlines() if line.startswith("error: ")]
        self.assertEqual((found.returncode, len(errors)), (code, 1), found.stderr)
        self.assertNotIn("Traceback", found.stderr)
        self.assertTrue(found.stderr.endswith(errors[0] + "\n"), found.stderr)
        for word in words:
            self.assertIn(word, errors[0])
        self.assertEqual(list(self.results.rglob("*.md")), [])

    def test_tables(self):
        found = bench(["tables", "--quick", "--repeats", "2", "--frames", "3", *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        text = (self.results / "fake-driver-1/tables.md").read_text()
        self.assertIn("`tools/bench tables --quick --repeats 2 --frames 3`", text)
        self.assertNotIn(str(self.results), text)
        results = json.loads((self.results / "fake-driver-1/tables.json").read_text())
        case = next(case for case in results["cases"] if case["case"] == "scatter")
        section = text.split("## Table 1")[1].split("## Table 2")[0]
        cells = {line.split("|")[1].strip(): line.split("|")[2].split("(")[0].strip()
                 for line in section.splitlines() if line.startswith("| ")}
        self.assertEqual((case["runs"], len(case["frames_ms"])), (2, 6))
        # 3 ms for each pass of 2,000 VPLs; the total is all of them, and so is the sum of the rows.
        construction = [name for name in case["pass_ms"]
                        if re.match(r"bounds|compaction/(?!compact)|exclusive_scan/(?!vpls)|grid_|merge", name)]
        self.assertEqual(float(cells["Total"]), 3 * len(construction))
        self.assertEqual(sum(float(value) for title, value in cells.items()
                             if re.fullmatch(r"Bounds|Occupied vertices|S\d+|Merge", title) and value),
                         float(cells["Total"]))
        for title in ("Table 2", "Table 3", "volumes", "Growth", "Figure 5", "Memory", "RTX 2080"):
            self.assertIn(title, text)

    def test_tables_refuse_a_pass_without_a_row(self):
        self.fails(bench(["tables", "--quick", *self.to], fault="unknown"), 1, "tea_break is in no row")

    def test_a_failing_program(self):
        self.fails(bench(["tables", "--quick", *self.to], fault="lost"), 1, "exit code 5", "lost in shadow_rays")

    def compare(self, cap):
        found = bench(["compare", "--quick", "--truth-samples", "1", "--cap", cap, *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        folder = self.results / "fake-driver-1"
        return json.loads((folder / "compare.json").read_text()), (folder / "compare.md").read_text()

    def test_compare(self):
        results, text = self.compare("64")
        self.assertNotIn("no: the cap", text)
        # The program's errors are 0.05 for the hierarchy and 1 / samples for path tracing.
        for search in results["searches"]:
            self.assertTrue(search["reached"] and search["samples"] >= 20 and search["found"] <= 0.05, search)

    def test_compare_has_errors_over_time(self):
        results, text = self.compare("1")
        self.assertIn("## Error over time", text)
        points = results["curve"]
        traced = [p for p in points if p["series"] == "path tracing"]
        self.assertEqual([p["frames"] for p in points if p["series"] == "LGH, alpha 2"], [1, 2])
        # A frame with one path takes 30 ms; its error is one over the number of frames.
        for p in traced:
            self.assertEqual((p["ms"], p["relmse"]), (30.0 * p["frames"], 1 / p["frames"]))
        # As long as the hierarchy's slowest, and no doubling longer.
        slowest = max(p["ms"] for p in points if p["series"] != "path tracing")
        self.assertGreaterEqual(traced[-1]["ms"], slowest)
        self.assertLess(traced[-2]["ms"], slowest)

    def test_compare_says_where_path_tracing_was_given_up(self):
        results, text = self.compare("1")
        self.assertEqual([search["reached"] for search in results["searches"]], [False] * 4)
        self.assertEqual(text.count("**no: the cap**"), 4)

    def test_pbgi(self):
        found = bench(["pbgi", "--quick", "--repeats", "2", *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        folder = self.results / "fake-driver-1"
        results, text = json.loads((folder / "pbgi.json").read_text()), (folder / "pbgi.md").read_text()
        (scene,) = results["scenes"]
        for way, ms in (("paper", 3.0), ("default", 2.0)):
            entry = scene["ways"][way]
            self.assertEqual(sum(stage["median"] for stage in entry["stages"].values()), entry["frame_gpu_ms"]["median"])
            self.assertEqual(entry["stages"]["Radiance caches"]["median"], ms)
        self.assertIn("| courtyard | default | 40 (1.0 %) | 200 (4.9 %) | 50 (1.2 %) | 25 % |", text)
        self.assertIn("| Castle | published | 11720 | 19320 | 44.1 |", text)

    def test_pbgi_refuses_a_pass_without_a_row(self):
        self.fails(bench(["pbgi", "--quick", *self.to], fault="unknown"), 1, "tea_break is in no row")

    def test_motion(self):
        found = bench(["motion", "--quick", *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        folder = self.results / "fake-driver-1"
        results, text = json.loads((folder / "motion.json").read_text()), (folder / "motion.md").read_text()
        self.assertEqual(list(results["sequences"]), ["still", "sun", "object", "figure", "camera", "switch"])
        self.assertIn("| still | ours | 0.0200 | 0.0100 |  |  |  | 0.1000 | 0.2000 | 1.0000 |", text)
        self.assertIn("| switch | paper | 0.0200 | 0.0100 |  |  | > 1 |", text)
        self.assertIn("| switch | ours | 0.0200 | 0.0100 |  |  | 1 |", text)
        self.assertIn("--camera walk", results["sequences"]["camera"]["ours"]["command"])

    def test_motion_of_some_sequences(self):
        self.fails(bench(["motion", "--quick", "--sequence", "rest", *self.to]), 2, "invalid choice: 'rest'")
        found = bench(["motion", "--quick", "--sequence", "switch", "--sequence", "still", *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        results = json.loads((self.results / "fake-driver-1" / "motion.json").read_text())
        self.assertEqual(list(results["sequences"]), ["switch", "still"])

    def test_motion_needs_frames_after_the_step(self):
        self.fails(bench(["motion", "--quick", "--frames", "20", *self.to]), 2, "--frames must be above 25")

    def test_variants(self):
        words = ["variants", "--program", self.fake, "--base", "--size 8x8 --vpls 1000"]
        found = bench([*words, "--variant", "one=--alpha 1", "--variant", f"two={self.fake}::--alpha 3"])
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertNotIn(str(self.results), found.stdout)
        # 2 ms and 4 ms for every pass.
        self.assertRegex(found.stdout, r"\| frame \| two \|.*\| 2\.000 \|")
        self.assertRegex(found.stdout, r"\| \(Lighting\) \| two \| 4\.00 \| 4\.00 \| 4\.00 \| 2\.000 \|")

    def test_scale_tells_what_became_of_each(self):
        words = ["scale", "--quick", "--case", "materials", "--case", "environment", *self.to]
        self.fails(bench(["scale", "--case", "elephants", *self.to]), 2, "elephants")
        lost = bench(words, "lost")
        # What says which device it is fails too.
        self.fails(lost, 1, "lost")
        self.assertIn("materials: exit code 5: the device was lost in shadow_rays", lost.stdout)
        found = bench(words)
        self.assertEqual(found.returncode, 0, found.stderr)
        inputs = json.loads((self.results / "fake-driver-1/scale.json").read_text())["inputs"]
        self.assertEqual([row["case"] for row in inputs], ["materials", "environment"])
        self.assertTrue(all(row["result"] == "a picture" and row["input_bytes"] > 1000 for row in inputs))
        page = (self.results / "fake-driver-1/scale.md").read_text()
        self.assertIn("| 9 materials | `--vpls 2000 --size 32x18` | a picture |", page)
        self.assertNotIn(str(self.results), page)

    def test_scale_leaves_out_what_is_not_there(self):
        found = bench(["scale", "--quick", "--case", "vpls-sponza", *self.to])
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertIn("vpls-sponza: left out, as sponza-sun.gltf is not there", found.stdout)

    def test_wrong_use(self):
        variants = ["variants", "--program", self.fake]
        for words, sentence in [
            ([], "BENCHMARK"),
            (["coffee"], "coffee"),
            (["tables", "--repeats", "0", *self.to], "'0' is not a whole number of 1 or more"),
            (["tables", "--size", "big", *self.to], "'big' is not WIDTHxHEIGHT"),
            (["compare", "--size", "0x9", *self.to], "'0x9' is not WIDTHxHEIGHT"),
            (["tables", "--program", "/nowhere/gridlight"], "--program /nowhere/gridlight is not a file"),
            (["tables", "--scene", "/nowhere/a.gltf", *self.to], "--scene /nowhere/a.gltf is not a file"),
            ([*variants, "--variant", "one=--alpha 1"], "twice or more"),
            ([*variants, "--variant", "a=", "--variant", "a="], "same name"),
            ([*variants, "--variant", "a='", "--variant", "b="], "quotation"),
            ([*variants, "--variant", "a=--size 8x8 --alpha -1", "--variant", "b="], "--alpha must be above 0"),
        ]:
            with self.subTest(words=words):
                self.fails(bench(words), 2, sentence)


if __name__ == "__main__":
    unittest.main()
