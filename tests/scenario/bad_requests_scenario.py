# SPDX-License-Identifier: Apache-2.0
"""A table of bad requests: each gets its status, code and place, and the daemon serves on."""
import json
import subprocess
import unittest

from harness import FLARE, LENS, Daemon, Scenario, small_request

GOOD = json.dumps(small_request())


def changed(**changes):
    return json.dumps(small_request(**changes))


def with_light(**light):
    return changed(lights=[light])


def with_image(**image):
    return changed(image={"width": 48, "height": 27, "sensor_width_mm": 36.0, **image})


def with_surfaces(*surfaces, **fields):
    """A request with an inline lens."""
    return changed(lens=None, prescription={"name": "inline", "surface": list(surfaces), **fields})


FRONT = {"kind": "sphere", "radius_mm": 50, "gap_mm": 5, "nd": 1.5, "vd": 60,
         "semi_diameter_mm": 10}
BACK = {"kind": "sphere", "radius_mm": -50, "gap_mm": 1, "semi_diameter_mm": 10}
STOP = {"kind": "stop", "gap_mm": 48, "semi_diameter_mm": 5}

# body, status, code, where
BODIES = [
    # No JSON, or more than one.
    ("", 400, "bad_json", "byte 1"),
    ("{", 400, "bad_json", "byte 2"),
    (GOOD[:-10], 400, "bad_json", f"byte {len(GOOD) - 9}"),
    (GOOD + GOOD, 400, "bad_json", f"byte {len(GOOD) + 1}"),
    (GOOD + "x", 400, "bad_json", f"byte {len(GOOD) + 1}"),
    ("[]", 400, "bad_type", ""),
    ("null", 400, "bad_type", ""),
    (b'{"lens": "\xff"}', 400, "bad_json", "byte 11"),
    ("[" * 100_000, 400, "limit", None),
    (GOOD.replace('"lens"', '"f_number": 2, "lens"'), 400, "duplicate_key", "/f_number"),
    # Numbers that are none.
    (GOOD.replace("4.0", "NaN"), 400, "bad_json", None),
    (GOOD.replace("4.0", "Infinity"), 400, "bad_json", None),
    (GOOD.replace("4.0", "-Infinity"), 400, "bad_json", None),
    (GOOD.replace("4.0", "1e999"), 400, "bad_value", "/f_number"),
    (GOOD.replace("4.0", '"4.0"'), 400, "bad_type", "/f_number"),
    # Fields.
    (changed(lenz=1), 400, "unknown_field", "/lenz"),
    (with_image(widht=1), 400, "unknown_field", "/image/widht"),
    (changed(lens=None), 400, "missing_field", "/lens"),
    (changed(image=None), 400, "missing_field", "/image"),
    (changed(lights=None), 400, "missing_field", "/lights"),
    (changed(lens="no-such-lens"), 404, "unknown_lens", "/lens"),
    (changed(lens=""), 400, "bad_value", "/lens"),
    (changed(lens="../../etc/passwd"), 404, "unknown_lens", "/lens"),
    (changed(lens=7), 400, "bad_type", "/lens"),
    (changed(lens="x" * 5000), 400, "limit", "/lens"),
    (changed(f_number=-1), 400, "bad_value", "/f_number"),
    (changed(f_number=0), 400, "bad_value", "/f_number"),
    (changed(iris={"blades": -3}), 400, "bad_value", "/iris/blades"),
    (changed(iris={"blades": 1e9}), 400, "limit", "/iris/blades"),
    (changed(iris={"blades": 6.5}), 400, "bad_type", "/iris/blades"),
    (changed(iris={"roundness": 1.5}), 400, "bad_value", "/iris/roundness"),
    (changed(coatings="all"), 400, "bad_value", "/coatings"),
    (changed(coatings={"default": "all"}), 400, "bad_value", "/coatings/default"),
    (changed(coatings={"surfaces": {"3": "all"}}), 400, "bad_value", "/coatings/surfaces/3"),
    (changed(coatings={"surfaces": {"5": "bare"}}), 400, "bad_value", "/coatings/surfaces/5"),
    (changed(coatings={"surfaces": {"11": "bare"}}), 400, "bad_value", "/coatings/surfaces/11"),
    (changed(coatings={"surfaces": {"x": "bare"}}), 400, "bad_value", "/coatings/surfaces/x"),
    (changed(coatings={"stack": "bare"}), 400, "unknown_field", "/coatings/stack"),
    (changed(focus_m=0), 400, "bad_value", "/focus_m"),
    (changed(focus_m=-1), 400, "bad_value", "/focus_m"),
    (changed(focus_m="near"), 400, "bad_type", "/focus_m"),
    (changed(zoom_mm=0), 400, "bad_value", "/zoom_mm"),
    (changed(zoom_mm=[70, 200]), 400, "bad_type", "/zoom_mm"),
    (changed(model={"reflections": 3}), 400, "bad_value", "/model/reflections"),
    (changed(model={"four_reflection_threshold": 0}), 400, "bad_value",
     "/model/four_reflection_threshold"),
    (changed(model={"sensor_reflection": True}), 400, "bad_value", "/model/sensor_reflection"),
    (changed(units="lumen"), 400, "bad_value", "/units"),
    (changed(quality={"preset": "best"}), 400, "bad_value", "/quality/preset"),
    # The picture.
    (with_image(width=-1), 400, "bad_value", "/image/width"),
    (with_image(width=0), 400, "bad_value", "/image/width"),
    (with_image(width=1_000_000_000), 400, "limit", "/image/width"),
    (with_image(height=1.5), 400, "bad_type", "/image/height"),
    (with_image(width=16384, height=16384), 400, "limit", "/image"),
    (with_image(sensor_width_mm=-36), 400, "bad_value", "/image/sensor_width_mm"),
    (with_image(sensor_width_mm=0), 400, "bad_value", "/image/sensor_width_mm"),
    (with_image(crop=[40, 20, 20, 20]), 400, "bad_value", "/image/crop"),
    (with_image(crop=[0, 0, 0, 5]), 400, "bad_value", "/image/crop"),
    (with_image(crop=[1, 2]), 400, "bad_value", "/image/crop"),
    (with_image(overscan=[-1, 0, 0, 0]), 400, "bad_value", "/image/overscan/0"),
    (with_image(pixel_aspect=0), 400, "bad_value", "/image/pixel_aspect"),
    (with_image(desqueeze=2), 400, "bad_type", "/image/desqueeze"),
    # The lights.
    (with_light(direction=[0, 0, 0]), 400, "bad_value", "/lights/0/direction"),
    (with_light(direction=[0, 1]), 400, "bad_value", "/lights/0/direction"),
    (with_light(direction=[0, 0, "1"]), 400, "bad_type", "/lights/0/direction/2"),
    (with_light(direction=[0, 0, 1], pixel=[1, 1]), 400, "bad_value", "/lights/0"),
    (with_light(irradiance=[1, 1, 1]), 400, "missing_field", "/lights/0"),
    (with_light(direction=[0, 0, 1], irradiance=[1, -1, 1]), 400, "bad_value",
     "/lights/0/irradiance/1"),
    (with_light(direction=[0, 0, 1], distance_m=-2), 400, "bad_value", "/lights/0/distance_m"),
    (with_light(direction=[0, 0, 1], distance_m=0), 400, "bad_value", "/lights/0/distance_m"),
    (changed(lights={}), 400, "bad_type", "/lights"),
    (changed(lights=[{"direction": [0, 0, 1]}, {"direction": [0, 0, 0]}]), 400, "bad_value",
     "/lights/1/direction"),
    ('{"lens":"' + LENS + '","image":{"width":8,"height":8,"sensor_width_mm":36},"lights":['
     + ",".join(['{"pixel":[1,1]}'] * 1_000_000) + "]}", 400, "limit", ""),
    ('{"lens":"' + LENS + '","image":{"width":8,"height":8,"sensor_width_mm":36},"lights":['
     + ",".join(['{"pixel":[1,1]}'] * 100_001) + "]}", 400, "limit", "/lights"),
    (" " * (17 << 20), 413, "too_large", ""),
    # Colour.
    (changed(color_space="spectral"), 400, "missing_field", "/wavelengths_nm"),
    (changed(color_space="spectral", wavelengths_nm=[]), 400, "bad_value", "/wavelengths_nm"),
    (changed(color_space="spectral", wavelengths_nm=[-5]), 400, "bad_value", "/wavelengths_nm/0"),
    (changed(wavelengths_nm=[550]), 400, "bad_value", "/wavelengths_nm"),
    # In the contract, not built yet.
    (changed(split="ghosts"), 400, "bad_value", "/split"),
    (changed(artist={"ghosts": [{"sequence": [1, 9]}]}), 400, "bad_value",
     "/artist/ghosts/0/sequence"),
    (changed(encoder="follow-focus"), 404, "unknown_encoder", "/encoder"),
    (changed(color_space="srgb"), 400, "bad_value", "/color_space"),
    (changed(quality={"max_error": 2}), 400, "bad_value", "/quality/max_error"),
    (changed(quality={"time_budget_ms": -40}), 400, "bad_value", "/quality/time_budget_ms"),
    (changed(quality={"max_error": 0.02, "time_budget_ms": 40}), 400, "bad_value",
     "/quality/preset"),
    # A daemon opens no file that a client names; masks come inside, and whole.
    (changed(iris={"mask": "/etc/passwd"}), 400, "bad_value", "/iris/mask"),
    (changed(iris={"mask": {"file": "a.png"}}), 400, "bad_value", "/iris/mask"),
    (changed(iris={"mask": {"png_base64": "AAAA"}}), 400, "bad_image", "/iris/mask/png_base64"),
    (changed(iris={"mask": {"png_base64": "A" * (9 << 20)}}), 400, "limit",
     "/iris/mask/png_base64"),
    (with_light(direction=[0, 0, 1], temperature_k=3), 400, "bad_value",
     "/lights/0/temperature_k"),
    (with_light(direction=[0, 0, 1], spectrum={"wavelengths_nm": [500], "values": [0]}), 400,
     "bad_value", "/lights/0/spectrum/values"),
    (with_light(direction=[0, 0, 1], angular_diameter_deg=20.5), 400, "limit",
     "/lights/0/angular_diameter_deg"),
    # Inline lenses of every sort of brokenness.
    (changed(prescription={"name": "x", "surface": []}), 400, "bad_value", None),
    (with_surfaces(), 400, None, None),
    (with_surfaces(FRONT, BACK), 400, "bad_lens", None),  # no stop
    (with_surfaces(STOP), 400, "bad_lens", None),  # no glass
    (with_surfaces({**FRONT, "kind": "blob"}, BACK, STOP), 400, None,
     "/prescription/surface/0/kind"),
    (with_surfaces({**FRONT, "colour": 1}, BACK, STOP), 400, "bad_lens",
     "/prescription/surface/0/colour"),
    (with_surfaces({**FRONT, "nd": -1.5}, BACK, STOP), 400, "bad_lens",
     "/prescription/surface/0"),
    (with_surfaces({**FRONT, "semi_diameter_mm": 60}, BACK, STOP), 400, None, None),
    (with_surfaces({**FRONT, "radius_mm": "50"}, BACK, STOP), 400, "bad_lens",
     "/prescription/surface/0/radius_mm"),
    (with_surfaces(FRONT, BACK, STOP, STOP), 400, None, None),  # two stops
    (with_surfaces(*[FRONT] * 500), 400, "limit", None),
    (with_surfaces({**FRONT, "glass": "UNOBTAINIUM"}, BACK, STOP), 400, None, None),
]

# method, target, headers, body, status, code, where
REQUESTS = [
    ("GET", "/v1/flare", {}, None, 405, "method_not_allowed", ""),
    ("DELETE", "/v1/lenses", {}, None, 405, "method_not_allowed", ""),
    ("POST", "/healthz", {}, b"", 405, "method_not_allowed", ""),
    ("GET", "/v2/flare", {}, None, 404, "not_found", ""),
    ("GET", "/v1/lenses/" + LENS + "/", {}, None, 404, "not_found", ""),
    ("GET", "/v1/lenses/nope", {}, None, 404, "unknown_lens", None),
    ("GET", "/v1/lenses/..%2F..%2Fetc%2Fpasswd", {}, None, 404, "unknown_lens", None),
    ("GET", "/v1/reports/nope", {}, None, 404, "not_found", ""),
    ("GET", f"/v1/lenses/{LENS}/ghosts?field_deg=five", {}, None, 400, "bad_value", "?field_deg"),
    ("GET", f"/v1/lenses/{LENS}/ghosts?fieldd=5", {}, None, 400, "unknown_field", "?fieldd"),
    ("GET", f"/v1/lenses/{LENS}/ghosts?f_number=2&f_number=3", {}, None, 400, "bad_query",
     "?f_number"),
    ("GET", "/v1/lenses/nope/ghosts", {}, None, 404, "unknown_lens", None),
    ("GET", f"/v1/lenses/{LENS}/ghosts?coatings=all", {}, None, 400, "bad_value", "?coatings"),
    ("GET", f"/v1/lenses/{LENS}/ghosts?sensor_reflection=true", {}, None, 400, "bad_value",
     "?sensor_reflection"),
    ("GET", f"/v1/lenses/{LENS}?focus_m=0", {}, None, 400, "bad_value", "?focus_m"),
    ("GET", f"/v1/lenses/{LENS}?field_deg=5", {}, None, 400, "unknown_field", "?field_deg"),
    ("POST", "/v1/flare", {"Content-Type": "text/plain"}, GOOD, 415, "unsupported_media_type", ""),
    ("POST", "/v1/flare", {"Accept": "text/html"}, GOOD, 406, "not_acceptable", ""),
    ("POST", "/v1/flare?fast=1", {}, GOOD, 400, "bad_query", "?"),
    ("GET", "/v1/warm", {}, None, 405, "method_not_allowed", ""),
    ("POST", "/v1/warm/x", {}, None, 405, "method_not_allowed", ""),
    ("GET", "/v1/warm/x", {}, None, 404, "not_found", ""),
    ("POST", "/v1/warm", {}, changed(units="scene_linear"), 400, "unknown_field", "/units"),
    ("POST", "/v1/warm", {"Content-Type": "text/plain"}, GOOD, 415, "unsupported_media_type", ""),
    ("POST", "/v1/warm?x=1", {}, GOOD, 400, "bad_query", "?"),
    ("POST", "/v1/warm", {}, changed(lens="nope"), 404, "unknown_lens", "/lens"),
    ("POST", "/v1/warm", {}, changed(lights=None, field_deg=[0, 1, 0]), 400, "bad_value",
     "/field_deg"),
    ("POST", "/v1/warm", {}, with_light(direction=[0, 0, 1], distance_m=0.005), 400, "bad_value",
     "/lights/0/distance_m"),
    ("GET", "/v1/live", {}, None, 501, "unsupported", ""),
    ("GET", "/", {}, None, 501, "unsupported", ""),
]

# What is no HTTP at all, and the status line it gets.
RAW = [
    (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" * 10 + b"\r\n\r\n", b"400"),
    (b"GET / HTTP/9.9\r\nHost: x\r\n\r\n", b"400"),
    (b"GET /healthz HTTP/1.1\r\n\r\n", b"400"),
    (b"POST /v1/flare HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\nabcde",
     b"400"),
    (b"POST /v1/flare HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n", b"400"),
    (b"GET /healthz HTTP/1.1\r\nHost: x\r\nX: " + b"y" * 40_000 + b"\r\n\r\n", b"431"),
]


class BadRequestsScenario(Scenario):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.daemon = Daemon()
        cls.daemon.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.__exit__(None, None, None)
        super().tearDownClass()

    def check(self, reply, status, code, where, name):
        """None in the table: anything non-empty of that kind."""
        self.assertEqual(reply.status, status, f"{name}: {reply.body[:300]}")
        error = reply.error
        self.assertTrue(error["message"], name)
        self.assertIn("where", error, name)
        if code is not None:
            self.assertEqual(error["code"], code, f"{name}: {error}")
        if where is not None:
            self.assertEqual(error["where"], where, f"{name}: {error}")
        else:
            self.assertTrue(error["where"] or status == 404, f"{name}: {error}")

    def test_bad_bodies(self):
        self.assertGreaterEqual(len(BODIES), 30)
        for body, status, code, where in BODIES:
            with self.subTest(body=body[:120]):
                self.check(self.daemon.flare(body), status, code, where, body[:120])
        self.assert_ok(self.daemon.flare(GOOD))

    def test_bad_requests(self):
        for method, target, headers, body, status, code, where in REQUESTS:
            with self.subTest(method=method, target=target):
                reply = self.daemon.ask(method, target, body=body, headers=headers)
                self.check(reply, status, code, where, target)
        self.assertEqual(self.daemon.get("/v1/flare").headers["Allow"], "POST")
        self.assert_ok(self.daemon.flare(GOOD))

    def test_what_is_no_http(self):
        for text, status in RAW:
            with self.subTest(text=text[:60]):
                with self.daemon.raw() as connection:
                    connection.sendall(text)
                    reply = b""
                    while part := connection.recv(65536):
                        reply += part
                self.assertEqual(reply[:12], b"HTTP/1.1 " + status)
        self.assert_ok(self.daemon.flare(GOOD))

    def test_the_command_line_says_what_the_daemon_says(self):
        path = self.write("bad.json", with_light(direction=[0, 0, 0]))
        for options, exit_code in (([], 2), (["--server", self.daemon.unix_url], 3)):
            done = subprocess.run([FLARE, "render", path, "-o", self.path("x.exr"), *options],
                                  capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, exit_code, done.stderr)
            self.assertIn("/lights/0/direction", done.stderr)
            self.assertIn("bad_value", done.stderr)
        good = self.write("good.json", GOOD)
        self.run_flare("render", good, "-o", self.path("x.exr"), "--server",
                       "unix:" + self.path("nobody"), exit_code=3)


if __name__ == "__main__":
    unittest.main()
