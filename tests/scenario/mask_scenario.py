# SPDX-License-Identifier: Apache-2.0
"""Irises and lights by an image: the client reads it, the daemon opens no file it is told of."""
import base64
import json
import os
import struct
import unittest
import zlib

from harness import Daemon, Scenario, small_request


def png(rows):
    """8 bits of grey."""
    def chunk(name, data):
        return (struct.pack(">I", len(data)) + name + data
                + struct.pack(">I", zlib.crc32(name + data)))
    lines = b"".join(b"\0" + bytes(row) for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
            + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))


def mask(hole):
    """A disc, with or without a hole off its middle."""
    def value(x, y):
        return 255 if x * x + y * y < 800 and ((x - 8)**2 + y * y > 60 or not hole) else 0
    return png([[value(i - 32, j - 32) for i in range(64)] for j in range(64)])


class MaskScenario(Scenario):
    def rendered(self, name, iris, *options):
        path = self.write(name + ".json", json.dumps(small_request(iris=iris)))
        self.run_flare("render", path, "-o", self.path(name + ".exr"), *options)
        with open(self.path(name + ".exr"), "rb") as file:
            return file.read()

    def test_the_file_beside_the_request_is_sent_inside_it(self):
        with open(self.path("hole.png"), "wb") as file:
            file.write(mask(True))
        inside = base64.b64encode(mask(True)).decode()
        plain = self.rendered("plain", {})
        here = self.rendered("here", {"mask": "hole.png"})
        self.assertNotEqual(here, plain)
        full = self.rendered("full", {"mask": {"png_base64": base64.b64encode(mask(False)).decode()}})
        self.assertNotEqual(here, full, "the hole must show")
        self.assertEqual(self.rendered("inside", {"mask": {"png_base64": inside}}), here)
        with Daemon() as daemon:
            url = daemon.unix_url
            self.assertEqual(self.rendered("there", {"mask": {"file": "hole.png"}}, "--server", url),
                             here)
            reply = self.assert_ok(
                daemon.flare(small_request(iris={"mask": {"png_base64": inside}})))
            self.assertEqual(reply.body, here)
            reply = daemon.flare(small_request(iris={"mask": self.path("hole.png")}))
            self.assert_refused(reply, 400, "bad_value", "/iris/mask")

    def test_dust_and_scratches_lie_where_their_seed_says(self):
        clean = self.rendered("clean", {})
        dust = {"count": 40, "size_mm": 0.5, "seed": 3}
        dusty = self.rendered("dusty", {"dust": dust})
        self.assertNotEqual(dusty, clean)
        self.assertEqual(self.rendered("again", {"dust": dust}), dusty)
        self.assertNotEqual(self.rendered("other", {"dust": dict(dust, seed=4)}), dusty)
        scratched = self.rendered("scratched", {"scratches": {"count": 3, "width_mm": 0.2}})
        self.assertNotIn(scratched, (clean, dusty))

    def test_so_is_the_shape_of_a_light(self):
        def lit(**shape):
            return small_request(lights=[{"direction": [0, 0, 1]},
                                         dict({"direction": [0.1, 0.1, 1],
                                               "angular_diameter_deg": 2}, **shape)])

        def rendered(name, request, *options):
            self.run_flare("render", self.write(name + ".json", json.dumps(request)), "-o",
                           self.path(name + ".exr"), *options)
            with open(self.path(name + ".exr"), "rb") as file:
                return file.read()

        with open(self.path("hole.png"), "wb") as file:
            file.write(mask(True))
        inside = {"png_base64": base64.b64encode(mask(True)).decode()}
        here = rendered("here", lit(shape="hole.png"))
        self.assertNotEqual(here, rendered("disc", lit()))
        self.assertEqual(rendered("inside", lit(shape=inside)), here)
        with Daemon() as daemon:
            self.assertEqual(rendered("there", lit(shape={"file": "hole.png"}), "--server",
                                      daemon.unix_url), here)
            self.assert_refused(daemon.flare(lit(shape="hole.png")), 400, "bad_value",
                                "/lights/1/shape")
            dark = {"png_base64": base64.b64encode(png([[0, 0]])).decode()}
            self.assert_refused(daemon.flare(lit(shape=dark)), 400, "bad_value",
                                "/lights/1/shape/png_base64")
            broken = {"png_base64": "AAAA"}
            self.assert_refused(daemon.flare(lit(shape=broken)), 400, "bad_image",
                                "/lights/1/shape/png_base64")
            self.assert_refused(daemon.flare(dict(lit(shape=inside), layers=["bokeh"])), 400,
                                "unsupported", "/lights/1/angular_diameter_deg")

    def test_a_file_that_is_missing_or_no_image_is_refused(self):
        path = self.write("a.json", json.dumps(small_request(iris={"mask": "none.png"})))
        self.run_flare("render", path, "-o", self.path("a.exr"), exit_code=2)
        self.write("text.png", "no image")
        path = self.write("a.json", json.dumps(small_request(iris={"mask": "text.png"})))
        self.run_flare("render", path, "-o", self.path("a.exr"), exit_code=2)
        self.assertFalse(os.path.exists(self.path("a.exr")))

    def test_a_picture_is_an_exr_as_well(self):
        source = self.write("source.json", json.dumps(small_request()))
        self.run_flare("render", source, "-o", self.path("mask.exr"))
        shown = self.rendered("shown", {"mask": {"file": "mask.exr", "scale": "stop"}})
        self.assertNotEqual(shown, self.rendered("plain", {}))


if __name__ == "__main__":
    unittest.main()
