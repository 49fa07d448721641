# SPDX-License-Identifier: Apache-2.0
"""What comes back: the forms of a picture, its report, and light near and far."""
import json
import math
import re
import shutil
import struct
import subprocess
import unittest

from harness import LENS, PATIENCE_S, Daemon, Scenario, small_request


def half_planes(body):
    """{channel: [values]} of application/x-flare-half, and (width, height)."""
    magic, version, width, height, channels, name_bytes = struct.unpack_from("<4sIIIII", body)
    assert magic == b"FLRH" and version == 1
    names = body[64:64 + name_bytes].split(b"\0")[:channels]
    pixels = width * height
    planes = {}
    for index, name in enumerate(names):
        start = 64 + name_bytes + 2 * pixels * index
        planes[name.decode()] = struct.unpack_from(f"<{pixels}e", body, start)
    assert len(body) == 64 + name_bytes + 2 * pixels * channels
    return planes, (width, height)


class PictureScenario(Scenario):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.daemon = Daemon()
        cls.daemon.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__(None, None, None)
        super().tearDownClass()

    def render(self, name, **changes):
        """Path of the float EXR of a request."""
        request = small_request(output={"pixel": "float", "compression": "none"}, **changes)
        return self.write(name, self.assert_ok(self.daemon.flare(request)).body)

    def compare(self, one, other):
        return json.loads(self.run_flare("compare", one, other, "--json"))

    @unittest.skipUnless(shutil.which("oiiotool"), "oiiotool is not installed")
    def test_the_exr_opens_in_oiiotool_with_its_layers_named(self):
        path = self.render("a.exr")
        text = subprocess.run(["oiiotool", "--info", "-v", "--stats", path], capture_output=True,
                              text=True, timeout=PATIENCE_S, check=True).stdout
        self.assertIn("48 x   27, 6 channel, float openexr", text)
        self.assertIn("channel list: R, G, B, ghosts.R, ghosts.G, ghosts.B", text)
        self.assertIn(f'"{LENS}"', text)
        largest = [float(value) for value in
                   re.search(r"Stats Max: ([^(\n]*)", text).group(1).split()]
        self.assertEqual(len(largest), 6)
        self.assertTrue(all(value > 0 for value in largest), largest)
        nans = re.search(r"Stats NanCount: ([^\n]*)", text).group(1).split()
        self.assertEqual(set(nans), {"0"})

    def test_png_and_half_planes_by_accept(self):
        png = self.assert_ok(self.daemon.flare(small_request(), accept="image/png"))
        self.assertEqual(png.headers["Content-Type"], "image/png")
        self.assertEqual(png.body[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack_from(">II", png.body, 16), (48, 27))
        half = self.assert_ok(self.daemon.flare(small_request(),
                                                accept="application/x-flare-half"))
        self.assertEqual(half.headers["Content-Type"], "application/x-flare-half")
        planes, size = half_planes(half.body)
        self.assertEqual(size, (48, 27))
        self.assertEqual(list(planes), ["R", "G", "B", "ghosts.R", "ghosts.G", "ghosts.B"])
        self.assertGreater(max(planes["G"]), 0)
        self.assertEqual(planes["G"], planes["ghosts.G"])

    def test_a_spectral_picture_names_its_wavelengths(self):
        request = small_request(
            color_space="spectral", wavelengths_nm=[450, 587.5618], units="sensor_irradiance",
            lights=[{"direction": [0.087, 0.05, 0.995], "irradiance": 1}])
        planes, _ = half_planes(self.assert_ok(
            self.daemon.flare(request, accept="application/x-flare-half")).body)
        self.assertEqual(list(planes), ["S0.450nm", "S0.587,5618nm", "ghosts.S0.450nm",
                                        "ghosts.S0.587,5618nm"])

    def test_a_very_far_light_is_an_infinite_one(self):
        direction = {"direction": [0.1, 0.03, 1.0]}
        infinite = self.render("infinite.exr", lights=[direction])
        far = self.render("far.exr", lights=[{**direction, "distance_m": 1e9}])
        near = self.render("near.exr", lights=[{**direction, "distance_m": 0.5}])
        self.assertLess(self.compare(far, infinite)["rel_l1"], 1e-6)
        self.assertGreater(self.compare(near, infinite)["rel_l1"], 1e-2)

    def test_a_light_may_be_given_by_its_pixel(self):
        # direction = ((px - W/2) p, (H/2 - py) p, d'), d' = EFL for this lens at infinity.
        pitch, efl = 36.0 / 48, 50.358167
        direction = [(30 - 24) * pitch, (13.5 - 9) * pitch, efl]
        by_direction = self.render("direction.exr", lights=[{"direction": direction}])
        by_pixel = self.render("pixel.exr", lights=[{"pixel": [30, 9]}])
        self.assertLess(self.compare(by_pixel, by_direction)["rel_l1"], 1e-4)

    def test_light_that_cannot_arrive_gives_black(self):
        for light in ({"direction": [0, 0.1, -1]}, {"direction": [1, 0, 0.001]},
                      {"direction": [0, 0, 1], "irradiance": [0, 0, 0]}):
            reply = self.daemon.flare(small_request(lights=[light]),
                                      accept="application/x-flare-half")
            planes, _ = half_planes(self.assert_ok(reply).body)
            self.assertEqual(max(planes["G"]), 0, light)
        self.assert_ok(self.daemon.flare(small_request(lights=[])))

    def test_a_crop_is_a_piece_of_the_whole(self):
        whole, (width, _) = half_planes(self.assert_ok(
            self.daemon.flare(small_request(), accept="application/x-flare-half")).body)
        image = {"width": 48, "height": 27, "sensor_width_mm": 36.0, "crop": [10, 5, 20, 12]}
        piece, size = half_planes(self.assert_ok(self.daemon.flare(
            small_request(image=image), accept="application/x-flare-half")).body)
        self.assertEqual(size, (20, 12))
        expected = [whole["G"][(5 + y) * width + 10 + x] for y in range(12) for x in range(20)]
        for got, wanted in zip(piece["G"], expected):
            self.assertTrue(math.isclose(got, wanted, rel_tol=2e-3, abs_tol=1e-7), (got, wanted))

    def test_the_report_can_be_had_whole(self):
        reply = self.assert_ok(self.daemon.flare(small_request(f_number=1.0)))
        self.assertLessEqual(len(reply.headers["Flare-Report"]), 4096)
        summary = reply.report
        whole = self.assert_ok(self.daemon.get("/v1/reports/" + summary["id"])).json()
        self.assertEqual(whole["id"], summary["id"])
        self.assertEqual(whole["request_hash"], summary["request_hash"])
        self.assertEqual(summary["work"]["pixels"], 48 * 27)
        self.assertIn("/f_number", json.dumps(whole["clamped"]), "2.03 is all this lens has")
        self.assertEqual(len(whole["ghosts"]), 45)

    def test_the_lens_routes(self):
        shown = self.assert_ok(self.daemon.get("/v1/lenses/" + LENS)).json()
        self.assertAlmostEqual(shown["efl_mm"], 50.3582, delta=0.005)
        printed = json.loads(self.run_flare("lens", "show", LENS, "--json"))
        self.assertEqual(shown, printed)
        names = [lens["name"] for lens in self.daemon.get("/v1/lenses").json()["lenses"]]
        self.assertIn(LENS, names)

    def test_the_ghost_route(self):
        target = f"/v1/lenses/{LENS}/ghosts?field_deg=5&coatings=none"
        listed = self.assert_ok(self.daemon.get(target)).json()
        self.assertEqual(len(listed["ghosts"]), 45)
        self.assertAlmostEqual(listed["total_flux_mm2"], 13.611, delta=0.002 * 13.611)
        self.assertEqual(listed["ghosts"][0]["sequence"], [10, 6])

    def test_head_tells_the_length_of_get(self):
        got = self.assert_ok(self.daemon.get("/v1/openapi.yaml"))
        head = self.assert_ok(self.daemon.ask("HEAD", "/v1/openapi.yaml"))
        self.assertEqual(head.body, b"")
        self.assertEqual(head.headers["Content-Length"], str(len(got.body)))
        self.assertTrue(got.body.startswith(b"openapi: 3.1"), got.body[:40])


if __name__ == "__main__":
    unittest.main()
