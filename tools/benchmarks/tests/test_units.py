"""Statistics, order of the runs, tables, and which pass is in which row."""
import contextlib
import io
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from benchmarks import compare, markdown, plot, published, series, steps, variants
from benchmarks.errors import BenchError, UsageError
from benchmarks.tests.names import FIXTURE


class Series(unittest.TestCase):
    def test_median_and_least(self):
        self.assertEqual(series.summarise([3, 1, 2]).median, 2)
        self.assertEqual(series.summarise([4, 1, 2, 3]).median, 2.5)
        self.assertEqual(series.summarise([3, 1, 2]).minimum, 1)

    def test_p95_is_by_nearest_rank(self):
        for count, p95 in [(1, 1), (19, 19), (20, 19), (21, 20), (100, 95), (101, 96)]:
            self.assertEqual(series.summarise(range(1, count + 1)).p95, p95, count)

    def test_nothing_is_an_error(self):
        with self.assertRaises(ValueError):
            series.summarise([])

    def test_rounds_alternate_and_turn(self):
        order = list(series.rounds(["a", "b", "c"], {"a": 3, "b": 2, "c": 0}.get))
        self.assertEqual(order, ["a", "b", "b", "a", "a"])


class Markdown(unittest.TestCase):
    def test_numbers(self):
        for value, text in [(0, "0"), (0.01234, "0.012"), (1.234, "1.23"), (12.34, "12.3"), (1234.5, "1234"), (None, "")]:
            self.assertEqual(markdown.number(value), text)
        self.assertEqual([markdown.count(n) for n in (200, 1000, 1500, 100_000, 1_000_000)],
                         ["200", "1k", "1.5k", "100k", "1M"])

    def test_table(self):
        self.assertEqual(markdown.table(["", "ms"], [["a", 1]]), ["|  | ms |", "| --- | ---: |", "| a | 1 |"])

    def test_a_row_of_another_width_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "3 cells under a head of 2"):
            markdown.table(["", "ms"], [["a", 1, 2]])


class Steps(unittest.TestCase):
    def test_every_pass_is_in_exactly_one_row(self):
        for kind, names in FIXTURE.items():
            if kind == "pbgi":
                self.assertEqual(set(steps.assign(names, steps.PBGI_ROWS)), set(names))
                continue
            self.assertEqual(set(steps.assign(names)), set(names), kind)
            phases = [steps.members(names, phase) for phase in (steps.VPLS, steps.CONSTRUCTION, steps.RENDER)]
            listed = [name for phase in phases for passes in phase.values() for name in passes]
            self.assertEqual(sorted(listed), sorted(names), kind)

    def test_what_the_rows_sum(self):
        rows = steps.members(FIXTURE["scatter"], steps.CONSTRUCTION)
        self.assertEqual(rows["S3"], ["grid_scatter/S3", "grid_scatter/resolve_S3"])
        self.assertEqual(steps.members(FIXTURE["gather"], steps.CONSTRUCTION)["S3"], ["grid_gather/S3"])
        for kind in ("cascade", "gather", "interleaved"):
            lighting = steps.members(FIXTURE[kind], steps.RENDER)["Lighting"]
            self.assertTrue(all(name.startswith(("light_volumes", "light_gather")) for name in lighting) and lighting)
        # S1 is not S10.
        self.assertEqual(steps.assign(["grid_gather/S10"])["grid_gather/S10"].title, "S10")

    def test_the_papers_rows_are_ours(self):
        titles = {row.title for row in steps.ROWS} | {"Total"}
        self.assertLessEqual(set(published.CONSTRUCTION) | set(published.RENDERING), titles)

    def test_a_pass_that_no_row_claims_is_an_error(self):
        for name in ("grid_gather/S11", "interleave/blur_dreams_x", "tea_break"):
            with self.assertRaisesRegex(BenchError, f"{name} is in no row"):
                steps.assign([*FIXTURE["gather"], name])

    def test_a_pass_that_two_rows_claim_is_an_error(self):
        rows = [*steps.ROWS, steps.Row(steps.RENDER, "Greedy", "merge")]
        with self.assertRaisesRegex(BenchError, "merge is in 'Merge' and 'Greedy'"):
            steps.assign(FIXTURE["gather"], rows)


class Variants(unittest.TestCase):
    def test_parse(self):
        self.assertEqual(variants.parse("a=--alpha 2"), ("a", "--alpha 2", None))
        name, arguments, program = variants.parse(f"old={__file__}::--vpls 10")
        self.assertEqual((name, arguments, program), ("old", "--vpls 10", __file__))

    def test_what_is_no_variant(self):
        for text in ("--alpha 2", "=--alpha 2", "alpha"):
            with self.assertRaisesRegex(UsageError, "is not NAME=ARGS"):
                variants.parse(text)
        with self.assertRaisesRegex(UsageError, "not a file"):
            variants.parse("old=/nowhere/gridlight::--vpls 10")

    def test_passes_keep_the_order_of_the_frame(self):
        self.assertEqual(variants.in_frame_order([["a", "b", "d"], ["a", "c", "d", "e"]]), ["a", "c", "b", "d", "e"])


class EqualTime(unittest.TestCase):
    def test_samples_that_fit(self):
        # 10 ms besides, 5 ms a sample.
        self.assertEqual(compare.affordable(100, (1, 15), (4, 30)), 18)
        self.assertEqual(compare.affordable(99.9, (1, 15), (4, 30)), 17)
        self.assertEqual(compare.affordable(1, (1, 15), (4, 30)), 1)

    def test_samples_that_cost_nothing_are_an_error(self):
        with self.assertRaisesRegex(BenchError, "too busy to measure"):
            compare.affordable(100, (1, 15), (2, 15))


class Plot(unittest.TestCase):
    OVERDRAW = [{"alpha": 1, "grid_lights": n, "lights_tested_mean": n / 10} for n in (10, 100)]
    CURVES = {"measures": {"relmse": "relMSE", "flip": "FLIP"},
              "points": [{"series": name, "ms": 1000 * n, "relmse": 1 / n, "flip": 0.5 / n} for name in "ab" for n in (1, 2)]}
    DATA = {"overdraw": OVERDRAW, "curves": CURVES}

    def draw(self, folder, interpreter, drawing="overdraw"):
        file = Path(folder) / "picture.svg"
        file.write_text("of an earlier run")
        said = io.StringIO()
        with mock.patch.object(plot, "python", lambda: interpreter), contextlib.redirect_stderr(said):
            drawn = plot.draw(drawing, self.DATA[drawing], file)
        return drawn, file, said.getvalue()

    def test_without_matplotlib_a_sentence_says_how_to_get_it(self):
        with tempfile.TemporaryDirectory() as folder:
            drawn, file, said = self.draw(folder, None)
            self.assertEqual((drawn, file.exists(), said.count("\n")), (False, False, 1))
            self.assertIn("apt-get install python3-matplotlib", said)

    def test_the_same_points_give_the_same_file(self):
        interpreter = plot.python()
        if interpreter is None:
            self.skipTest("matplotlib is missing")
        for drawing in plot.DRAWINGS:
            with self.subTest(drawing), tempfile.TemporaryDirectory() as folder:
                pictures = []
                for _ in range(2):
                    drawn, file, said = self.draw(folder, interpreter, drawing)
                    self.assertTrue(drawn, said)
                    pictures.append(file.read_bytes())
                self.assertEqual(*pictures)
                self.assertIn(b"<svg", pictures[0])


if __name__ == "__main__":
    unittest.main()
