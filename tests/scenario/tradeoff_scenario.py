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

LENS = "sasian-triplet-50mm-f4"
COMMAND = [FLARE, "tradeoff", LENS, "--size", "48x27", "--f-numbers", "1,2", "--angles", "8",
           "--runs", "1", "--knobs", "tolerance=0.25,tolerance=0.05,tolerance=0.02,founding-report",
           "-o"]
ROWS = 4  # the lens opens to f/3.9: both f-numbers are that
MEASURED = ("rel_l1", "energy", "rel_l2_blur2", "log_error_stops_mean", "log_error_stops_p99",
            "p999_ratio", "estimated_rel_l1", "rays", "pieces")
NAMED = ("lens", "coatings", "lens_hash", "f_number", "field_deg", "width", "height", "truth", "knob",
         "value")


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
    def sweep(self, folder):
        return subprocess.run(COMMAND + [folder], capture_output=True, text=True,
                              timeout=PATIENCE_S)

    def interrupted(self, folder, rows):
        """A sweep that is sent SIGINT once so many rows are there."""
        running = subprocess.Popen(COMMAND + [folder], stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + PATIENCE_S
        while len(rows_of(folder)) < rows and time.monotonic() < end:
            time.sleep(0.005)
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=PATIENCE_S)
        return running.returncode, errors

    def test_a_sweep_that_is_interrupted_goes_on_and_ends_as_one_that_was_not(self):
        with tempfile.TemporaryDirectory() as whole, tempfile.TemporaryDirectory() as broken:
            done = self.sweep(whole)
            self.assertEqual(done.returncode, 0, done.stderr)
            rows = rows_of(whole)
            self.assertEqual(len(rows), ROWS)
            self.assertEqual({row["f_number"] for row in rows}, {"3.9"})
            self.check_errors(rows)
            self.check_files(whole)

            # The reference picture is dear, and kept: it is taken over here.
            shutil.copytree(os.path.join(whole, "reference"), os.path.join(broken, "reference"))
            code, errors = self.interrupted(broken, 1)
            self.assertEqual(code, 1, errors)
            self.assertIn("interrupted", errors)
            before = rows_of(broken)
            self.assertTrue(1 <= len(before) < ROWS, before)
            with open(os.path.join(broken, "tradeoff.csv"), "a") as file:
                file.write(LENS + ",own,half a li")  # what a crash may leave
            again = self.sweep(broken)
            self.assertEqual(again.returncode, 0, again.stderr)
            after = rows_of(broken)
            self.assertEqual(after[:len(before)], before, "what was measured stays")
            self.assertEqual(facts(after), facts(rows))
            self.assertIn(f"{ROWS - len(before)} of them new", again.stderr)
            self.assertIn(" 0 of them new", self.sweep(broken).stderr)

    def check_errors(self, rows):
        """Smaller with the tolerance, and near the estimate; the old rules lose light."""
        by_scene = {}
        for row in rows:
            scene = by_scene.setdefault(row["f_number"], {})
            scene[row["knob"], row["value"]] = float(row["rel_l1"])
            self.assertGreater(float(row["cold_cpu_ms"]), 0.0)
            self.assertEqual(row["runs"], "1")
        for scene in by_scene.values():
            errors = [scene["tolerance", value] for value in ("0.25", "0.05", "0.02")]
            self.assertEqual(errors, sorted(errors, reverse=True))
            self.assertLess(errors[2], 0.03)
            self.assertGreater(scene["founding-report", "all"], 0.1)

    def check_files(self, folder):
        charts = [name for name in os.listdir(folder) if name.endswith(".svg")]
        self.assertEqual(sorted(charts), ["knobs.svg", "lens_1.svg", "methods_cold.svg",
                                          "methods_warm.svg"])
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
        with tempfile.TemporaryDirectory() as folder:
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
