# SPDX-License-Identifier: Apache-2.0
"""Lenses of other programs through the command line, and the pages of the library."""
import json
import os
import re
import subprocess
import tempfile
import unittest

from harness import FLARE, SOURCE

# The table of US 2,673,491 as lens courses print it; apertures are diameters.
TABLE = """# D-GAUSS F/2 22deg HFOV
Radius Axpos N Aperture v-no
29.475 3.76 1.67 25.2 47.1
84.83 0.12 1 25.2 -
19.275 4.025 1.67 23 47.1
40.77 3.275 1.699 23 30.1
12.75 5.705 1 18 -
0 4.5 1 17.1 -
-14.495 1.18 1.603 17 38.4
40.77 6.065 1.658 20 57.0
-20.385 0.19 1 20 -
437.065 3.22 1.717 20 48.1
-39.73 0 1 20 -
"""
MIRROR = "UNIT MM\nSURF 0\nDISZ INFINITY\nSURF 1\nSTOP\nCURV -0.01\nGLAS MIRROR\nSURF 2\nDISZ 0\n"


class Import(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="flare-import-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def flare(self, *arguments, text=""):
        return subprocess.run([FLARE, *arguments], input=text, capture_output=True, text=True,
                              cwd=self.folder, timeout=120)

    def test_a_printed_table_becomes_a_lens_that_renders_and_says_what_was_guessed(self):
        done = self.flare("lens", "import", "-", "-o", "printed.toml", text=TABLE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("read as table, 11 surfaces", done.stderr)
        self.assertIn("were read as diameters", done.stderr)
        shown = json.loads(self.flare("lens", "show", "printed.toml", "--json").stdout)
        self.assertEqual(shown["name"], "printed")
        self.assertAlmostEqual(shown["efl_mm"], 50.358166958313646, places=6)
        self.assertIn("were read as diameters", shown["notes"])
        request = {"lens": os.path.join(self.folder, "printed.toml"),
                   "image": {"width": 32, "height": 18, "sensor_width_mm": 36},
                   "lights": [{"pixel": [8, 5], "irradiance": [1, 1, 1]}]}
        drawn = self.flare("render", "-", "-o", "flare.exr", text=json.dumps(request))
        self.assertEqual(drawn.returncode, 0, drawn.stderr)

    def test_what_cannot_be_read_is_refused_with_its_line_and_writes_nothing(self):
        done = self.flare("lens", "import", "-", "-o", "mirror.toml", text=MIRROR)
        self.assertEqual(done.returncode, 2)
        self.assertIn("line 7", done.stderr)
        self.assertIn("mirror", done.stderr)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "mirror.toml")))
        self.assertEqual(self.flare("lens", "import", "-", "-o", "x.toml", "--from", "oslo",
                                    text=TABLE).returncode, 2)

    def test_a_lens_that_the_lint_finds_wrong_is_written_to_be_mended(self):
        broken = TABLE.replace("F/2", "F/4").replace("12.75", "13.75")
        done = self.flare("lens", "import", "-", "-o", "broken.toml", text=broken)
        self.assertEqual(done.returncode, 2)
        self.assertIn("error:", done.stderr)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "broken.toml")))
        self.assertEqual(self.flare("lens", "show", "broken.toml").returncode, 2)


class Pages(unittest.TestCase):
    """docs/lenses/make_pages.py was run after the last lens was added or changed."""

    def test_every_lens_of_the_library_has_a_page_with_its_own_figures(self):
        done = subprocess.run([FLARE, "lens", "list", "--json"], capture_output=True, text=True)
        lenses = json.loads(done.stdout)["lenses"]
        self.assertGreaterEqual(len(lenses), 30)
        folder = os.path.join(SOURCE, "docs", "lenses")
        for lens in lenses:
            with self.subTest(lens["name"]):
                with open(os.path.join(folder, lens["name"] + ".md"), encoding="utf-8") as file:
                    page = file.read()
                lengths = [float(found) for found in
                           re.findall(r"\| focal length(?: in [xy])? \| ([0-9.]+) mm", page)]
                self.assertTrue(any(abs(found - lens["efl_mm"]) < 1e-4 for found in lengths),
                                (lengths, lens["efl_mm"]))
                for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page):
                    size = os.path.getsize(os.path.join(folder, picture))
                    self.assertTrue(1000 < size <= 100_000, (picture, size))


if __name__ == "__main__":
    unittest.main(verbosity=2)
