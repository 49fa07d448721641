# SPDX-License-Identifier: Apache-2.0
"""`flare tradeoff` on one lens, small: its files, an interrupted sweep, and errors that fall."""
import csv
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xml.dom.minidom

from harness import FLARE, PATIENCE_S

# Two lenses about a stop: six ghosts, so that a reference picture takes a second.
LENS = """
name = "pair"
source = "made up"
default_coating = "mgf2-550"
[design]
focal_mm = 55.1
f_number = 4.1
image_circle_mm = 43
"""
SURFACES = ((60, 4, 1.62, 9), (-300, 6, None, 9), (None, 6, None, 6), (300, 4, 1.62, 9),
            (-120, None, None, 9))
OPTIONS = ["--size", "48x27", "--f-numbers", "1,2", "--angles", "8", "--runs", "1", "--knobs",
           "tolerance=0.25,tolerance=0.05,tolerance=0.02,tolerance=0.005,founding-report"]
ROWS = 5  # the lens does not open to f/2: both f-numbers are its own
MEASURED = ("rel_l1", "energy", "rel_l2_blur2", "log_error_stops_mean", "log_error_stops_p99",
            "p999_ratio", "estimated_rel_l1", "rays", "pieces")
NAMED = ("lens", "coatings", "lens_hash", "f_number", "field_deg", "width", "height", "truth", "knob",
         "value")


def write_lens(path):
    text = LENS
    for radius, gap, index, height in SURFACES:
        text += "[[surface]]\n" + ("kind = \"stop\"\n" if radius is None else
                                  f"kind = \"sphere\"\nradius_mm = {radius}\n")
        text += f"semi_diameter_mm = {height}\n"
        text += "" if gap is None else f"gap_mm = {gap}\n"
        text += "" if index is None else f"nd = {index}\nvd = 60\n"
    with open(path, "w") as file:
        file.write(text)


def rows_of(folder):
    path = os.path.join(folder, "tradeoff.csv")
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def facts(rows):
    """What does not depend on the machine or its load."""
    return [[row[name] for name in NAMED + MEASURED] for row in rows]


class TradeoffScenario(unittest.TestCase):
    def setUp(self):
        home = tempfile.TemporaryDirectory()
        self.addCleanup(home.cleanup)
        self.home = home.name
        lens = os.path.join(self.home, "pair.toml")
        write_lens(lens)
        self.command = [FLARE, "tradeoff", lens, *OPTIONS, "-o"]

    def folder(self, name):
        return os.path.join(self.home, name)

    def sweep(self, folder):
        return subprocess.run(self.command + [folder], capture_output=True, text=True,
                              timeout=PATIENCE_S)

    def interrupted(self, folder, rows):
        """A sweep that is sent SIGINT once so many rows are there."""
        running = subprocess.Popen(self.command + [folder], stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + PATIENCE_S
        while len(rows_of(folder)) < rows and time.monotonic() < end:
            time.sleep(0.005)
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=PATIENCE_S)
        return running.returncode, errors

    def test_a_sweep_that_is_interrupted_goes_on_and_ends_as_one_that_was_not(self):
        whole = self.folder("whole")
        done = self.sweep(whole)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = rows_of(whole)
        self.assertEqual(len(rows), ROWS)
        self.assertEqual({row["f_number"] for row in rows}, {"4.14"})
        self.check_errors(rows)
        self.check_files(whole)

        broken = self.interrupted_sweep(whole)
        before = rows_of(broken)
        self.assertTrue(1 <= len(before) < ROWS, before)
        with open(os.path.join(broken, "tradeoff.csv"), "a") as file:
            file.write("pair,own,half a li")  # what a crash may leave
        again = self.sweep(broken)
        self.assertEqual(again.returncode, 0, again.stderr)
        after = rows_of(broken)
        self.assertEqual(after[:len(before)], before, "what was measured stays")
        self.assertEqual(facts(after), facts(rows))
        self.assertIn(f"{ROWS - len(before)} of them new", again.stderr)
        self.assertIn(" 0 of them new", self.sweep(broken).stderr)

    def interrupted_sweep(self, whole):
        """The folder of one that was stopped in time; the signal may come too late."""
        for attempt in range(20):
            broken = self.folder(f"broken{attempt}")
            # The reference picture is dear, and kept: it is taken over.
            shutil.copytree(os.path.join(whole, "reference"), os.path.join(broken, "reference"))
            code, errors = self.interrupted(broken, 1)
            if code == 1:
                self.assertIn("interrupted", errors)
                return broken
            self.assertEqual(code, 0, errors)
        self.fail("no sweep was stopped by SIGINT")

    def check_errors(self, rows):
        """Smaller with the tolerance, and near the estimate; the old rules lose light."""
        by_scene = {}
        for row in rows:
            scene = by_scene.setdefault(row["f_number"], {})
            scene[row["knob"], row["value"]] = float(row["rel_l1"])
            self.assertGreater(float(row["cold_cpu_ms"]), 0.0)
            self.assertEqual(row["runs"], "1")
        for scene in by_scene.values():
            errors = [scene["tolerance", value] for value in ("0.25", "0.05", "0.02", "0.005")]
            self.assertEqual(errors, sorted(errors, reverse=True))
            self.assertLess(errors[-1], 0.01)
            self.assertGreater(scene["founding-report", "all"], 0.1)

    def check_files(self, folder):
        charts = [name for name in os.listdir(folder) if name.endswith(".svg")]
        self.assertEqual(sorted(charts), ["estimate.svg", "knobs.svg", "lens_1.svg",
                                          "methods_cold.svg", "methods_warm.svg"])
        for name in charts:
            drawn = xml.dom.minidom.parse(os.path.join(folder, name))
            self.assertEqual(drawn.documentElement.tagName, "svg")
        with open(os.path.join(folder, "index.html")) as file:
            page = file.read()
        drawn = xml.dom.minidom.parseString(page.replace("<!DOCTYPE html>", ""))
        self.assertEqual(len(drawn.getElementsByTagName("svg")), len(charts))
        for outside in ("src=", "href=", "url("):
            self.assertNotIn(outside, page)
        references = os.listdir(os.path.join(folder, "reference"))
        self.assertEqual(len(references), 1)

    def test_a_table_that_is_none_is_left_alone(self):
        folder = self.folder("mine")
        os.mkdir(folder)
        path = os.path.join(folder, "tradeoff.csv")
        with open(path, "w") as file:
            file.write("mine,not yours\n1,2\n")
        refused = self.sweep(folder)
        self.assertEqual(refused.returncode, 2, refused.stderr)
        self.assertIn("tradeoff.csv", refused.stderr)
        with open(path) as file:
            self.assertEqual(file.read(), "mine,not yours\n1,2\n")


if __name__ == "__main__":
    unittest.main()
