# SPDX-License-Identifier: Apache-2.0
"""Zoom, focus, coatings, the sensor as a mirror, four reflections, an anamorphic lens: by the
daemon, in process, in the report and in the picture's header."""
import json
import unittest

from harness import Daemon, Scenario, exr_attributes, small_request

ZOOM = "nikon-zoom-80-200mm-f2_8"
SMALL = "kodak-petzval-100mm-f2_2"  # few surfaces

# Two singlets around the stop, and a sensor that reflects.
MIRROR = {"name": "mirror", "surface": [
    {"kind": "sphere", "radius_mm": 60, "gap_mm": 4, "nd": 1.5168, "vd": 64.2,
     "semi_diameter_mm": 10},
    {"kind": "sphere", "radius_mm": -200, "gap_mm": 3, "semi_diameter_mm": 10},
    {"kind": "stop", "gap_mm": 3, "semi_diameter_mm": 5},
    {"kind": "sphere", "radius_mm": 200, "gap_mm": 4, "nd": 1.5168, "vd": 64.2,
     "semi_diameter_mm": 10},
    {"kind": "sphere", "radius_mm": -60, "semi_diameter_mm": 10},
    {"kind": "sensor", "reflectance": 0.1, "semi_diameter_mm": 21.6}]}

# Two cylinders, R 50 and R 100 with n = 1.5, their curved vertices 2 (100 - 50) mm apart: afocal, and
# the focal length in x is half of that in y.
ANAMORPHIC = {"name": "anamorphic", "surface": [
    {"kind": "plane", "gap_mm": 3, "nd": 1.5, "semi_diameter_mm": 25},
    {"kind": "cylinder_x", "radius_mm": 50, "gap_mm": 100, "semi_diameter_mm": 25},
    {"kind": "cylinder_x", "radius_mm": 100, "gap_mm": 6, "nd": 1.5, "semi_diameter_mm": 25},
    {"kind": "plane", "gap_mm": 5, "semi_diameter_mm": 25},
    {"kind": "stop", "gap_mm": 1, "semi_diameter_mm": 6},
    {"kind": "sphere", "radius_mm": 50, "gap_mm": 4, "nd": 1.5168, "vd": 64.2,
     "semi_diameter_mm": 12},
    {"kind": "sphere", "radius_mm": -200, "semi_diameter_mm": 12}]}


class LensStateScenario(Scenario):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.daemon = Daemon()
        cls.daemon.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__(None, None, None)
        super().tearDownClass()

    def render(self, here=True, **changes):
        """(bytes, whole report) by the daemon; `here`: the same bytes in process."""
        request = small_request(**{"f_number": None, **changes})
        reply = self.assert_ok(self.daemon.flare(request))
        if here:
            path = self.write("request.json", json.dumps(request))
            self.run_flare("render", path, "-o", self.path("here.exr"))
            with open(self.path("here.exr"), "rb") as file:
                self.assertEqual(file.read(), reply.body, "in process and by the daemon")
        whole = self.assert_ok(self.daemon.get("/v1/reports/" + reply.report["id"])).json()
        return reply.body, whole

    def test_zoom_and_focus(self):
        pictures = set()
        for zoom, focus in ((None, None), (120, 2.5)):
            body, report = self.render(here=focus is not None, lens=ZOOM, zoom_mm=zoom,
                                       focus_m=focus)
            pictures.add(body)
            self.assertEqual(report["state"], {"focus_m": focus, "zoom_mm": zoom or 80})
            self.assertEqual(report["clamped"], [])
            attributes = exr_attributes(body)
            self.assertAlmostEqual(attributes["flareZoom"], zoom or 80, places=4)
            self.assertAlmostEqual(attributes["nominalFocalLength"], zoom or 80, places=4)
            self.assertAlmostEqual(attributes["effectiveFocalLength"], zoom or 80, delta=0.4)
            self.assertEqual(attributes.get("focus"), focus)
        self.assertEqual(len(pictures), 2, "each state must show")

    def test_a_state_out_of_range_is_clamped_and_said(self):
        body, report = self.render(here=False, lens=ZOOM, zoom_mm=500, focus_m=0.01)
        self.assertEqual(report["state"]["zoom_mm"], 200)
        self.assertGreater(report["state"]["focus_m"], 0.5)
        self.assertEqual([text.split(":")[0] for text in report["clamped"]],
                         ["/zoom_mm", "/focus_m"])
        self.assertIn("/zoom_mm: 500", exr_attributes(body)["flareClamped"])

    def test_unit_focusing_traces_no_ray(self):
        changes = {"lens": SMALL, "lights": [{"direction": [0.03, 0.11, 1]}]}
        _, report = self.render(here=False, **changes)
        rays = self.daemon.metric("flared_rays_traced_total")
        self.assertGreater(report["work"]["rays_traced"], 0)
        for focus in (10, 1):
            _, near = self.render(here=False, focus_m=focus, **changes)
            self.assertNotEqual(near["request_hash"], report["request_hash"])
        self.assertEqual(self.daemon.metric("flared_rays_traced_total"), rays)

    def test_the_lens_route_follows_the_state(self):
        target = f"/v1/lenses/{ZOOM}?zoom_mm=135&focus_m=3"
        shown = self.assert_ok(self.daemon.get(target)).json()
        printed = json.loads(self.run_flare("lens", "show", ZOOM, "--zoom-mm", "135", "--focus-m",
                                            "3", "--json"))
        self.assertEqual(shown, printed)
        self.assertAlmostEqual(shown["efl_mm"], 135, delta=0.3)
        self.assertEqual(shown["state"]["focus_m"], 3)
        self.assertGreater(shown["state"]["focus_shift_mm"], 0)

    def test_the_ghost_route_follows_state_and_coatings(self):
        target = f"/v1/lenses/{SMALL}/ghosts?field_deg=-5&focus_m=2&coatings=mgf2-500"
        listed = self.assert_ok(self.daemon.get(target)).json()
        printed = json.loads(self.run_flare(
            "ghosts", SMALL, "--field-deg", "-5", "--focus-m", "2", "--coatings", "mgf2-500",
            "--json"))
        self.assertEqual(listed, printed)
        self.assertEqual(listed["coatings"], "mgf2-500")
        self.assertEqual(listed["state"]["focus_m"], 2)
        self.assertGreater(listed["state"]["focus_shift_mm"], 1)

    def test_coatings_by_name_and_surface(self):
        flux = {}
        for name, coatings in (("own", None), ("none", "none"), ("bare", {"default": "bare"}),
                               ("blue", "mgf2-400"), ("one", {"surfaces": {"0": "bare"}})):
            _, report = self.render(here=name == "one", lens=SMALL, coatings=coatings)
            flux[name] = sum(ghost["flux_mm2"] for ghost in report["ghosts"])
        self.assertEqual(flux["none"], flux["bare"], "the seed lens coats no cemented face")
        self.assertGreater(flux["bare"], 3 * flux["own"])
        self.assertGreater(flux["one"], flux["own"])
        self.assertGreater(flux["blue"], flux["own"], "further from the d line than mgf2-550")

    def test_a_reflecting_sensor_adds_its_ghosts(self):
        changes = {"lens": None, "prescription": MIRROR}
        _, without = self.render(**changes)
        _, with_sensor = self.render(model={"sensor_reflection": True}, **changes)
        self.assertFalse(without["model"]["sensor_reflection"])
        self.assertTrue(with_sensor["model"]["sensor_reflection"])
        self.assertEqual(without["ghost_count"], 6)
        self.assertEqual(with_sensor["ghost_count"], 10)
        new = [g for g in with_sensor["ghosts"] if g["sequence"][0] == 5]
        self.assertEqual([g["sequence"] for g in new], [[5, 0], [5, 1], [5, 3], [5, 4]])
        self.assertTrue(all(g["flux_mm2"] > 0 for g in new), new)

    def test_four_reflections_are_chosen_and_the_rest_reported(self):
        changes = {"lens": None, "prescription": MIRROR}
        lost = []
        for threshold in (1.0, 1e-6):
            _, report = self.render(
                model={"reflections": 4, "four_reflection_threshold": threshold}, **changes)
            four = report["four_reflections"]
            self.assertEqual(four["threshold"], threshold)
            self.assertAlmostEqual(report["culled_flux_mm2"],
                                   four["lost_flux_mm2"] + report["culling"]["lost_flux_mm2"])
            listed = [g for g in report["ghosts"] if len(g["sequence"]) == 4]
            self.assertEqual(len(listed), four["rendered"])
            self.assertEqual(report["ghost_count"], 6 + four["rendered"])
            lost.append(four["lost_flux_mm2"])
        self.assertEqual(len(listed) > 0, True)
        self.assertGreater(lost[0], lost[1])

    def test_an_anamorphic_picture_squeezed_and_desqueezed(self):
        image = {"width": 48, "height": 40, "sensor_width_mm": 36.0}
        changes = {"lens": None, "prescription": ANAMORPHIC}
        squeezed, first = self.render(image=image, **changes)
        shown, second = self.render(image={**image, "desqueeze": True}, **changes)
        self.assertAlmostEqual(exr_attributes(squeezed)["pixelAspectRatio"], 2, places=5)
        self.assertAlmostEqual(exr_attributes(shown)["pixelAspectRatio"], 1, places=5)
        self.assertAlmostEqual(first["squeeze"], 2, places=9)
        self.assertEqual((first["desqueezed"], second["desqueezed"]), (False, True))
        (x0, y0), (x1, y1) = (r["lights"][0]["pixel"] for r in (first, second))
        self.assertAlmostEqual(x1, x0, places=6)
        self.assertAlmostEqual(20 - y1, (20 - y0) / 2, places=6)
        self.assertGreater(20 - y0, 1)


if __name__ == "__main__":
    unittest.main()
