# SPDX-License-Identifier: Apache-2.0
"""Equal requests give equal bytes: whatever the number of threads, with nothing cached, with meshes in
memory or on disk, in any order and side by side, as often as one likes.

Small pictures and a few repeats by default. All of it, 1920 x 1080 and a hundred repeats, half an
hour on two idle cores, or a hundred repeats of the small ones:
    FLARE_TEST_FULL=1 python3 -B tests/scenario/same_bytes_scenario.py
    FLARE_TEST_FULL=small python3 -B tests/scenario/same_bytes_scenario.py
"""
import hashlib
import json
import os
import random
import time
import unittest

from harness import Daemon, Scenario, at_once, eventually, small_request

FULL = os.environ.get("FLARE_TEST_FULL", "") not in ("", "0")
LARGE = FULL and os.environ["FLARE_TEST_FULL"] != "small"
WIDTH, HEIGHT = (1920, 1080) if LARGE else (48, 27)
REPEATS = 100 if FULL else 3
THREADS = (1, 2, 4, 8)
QUEUE = "flared_mesh_disk_queue_bytes"


def requests():
    """Pictures that share meshes with one another and pictures that do not."""
    image = {"width": WIDTH, "height": HEIGHT, "sensor_width_mm": 36.0}
    quality = {"preset": "preview" if LARGE else "draft"}

    def request(**changes):
        return small_request(**{"image": image, "quality": quality, **changes})

    near = {"direction": [-0.1, 0.06, 1.0], "distance_m": 1.0, "irradiance": [2, 1, 1]}
    return [
        request(),
        request(f_number=8.0, iris={"blades": 6, "roundness": 0.2, "rotation_deg": 10}),
        request(f_number=2.8, focus_m=1.0, output={"compression": "none", "pixel": "float"}),
        request(lights=[near, {"direction": [0.2, -0.1, 1.0], "irradiance": [1, 1, 1]}]),
        request(color_space="spectral", wavelengths_nm=[486.1, 587.6],
                lights=[{"direction": [0.05, 0.02, 1.0], "irradiance": 1}]),
    ]


def digest(body):
    return hashlib.sha256(body).hexdigest()


class SameBytesScenario(Scenario):
    expected = []  # by one thread, in process, with nothing cached

    def setUp(self):
        super().setUp()
        self.todo = requests()
        self.random = random.Random(4)
        if not SameBytesScenario.expected:
            SameBytesScenario.expected = [self.rendered_here(request, 1) for request in self.todo]
        self.assertEqual(len(set(self.expected)), len(self.todo), "each request must show")

    def rendered_here(self, request, threads):
        path = self.write("request.json", json.dumps(request))
        self.run_flare("render", path, "-o", self.path("here.exr"), "--threads", str(threads))
        with open(self.path("here.exr"), "rb") as file:
            return digest(file.read())

    def check(self, daemon, indices, what):
        """Asks for those pictures, one after the other; the reports of their replies."""
        reports = []
        for index in indices:
            reply = self.assert_ok(daemon.flare(self.todo[index]))
            self.assertEqual(digest(reply.body), self.expected[index], f"{what}, picture {index}")
            reports.append(reply.report["work"])
        return reports

    def shuffled(self):
        order = list(range(len(self.todo)))
        self.random.shuffle(order)
        return order

    def test_in_process_on_any_number_of_threads(self):
        for threads in THREADS[1:] if FULL else THREADS[-1:]:
            for request, expected in zip(self.todo, self.expected):
                self.assertEqual(self.rendered_here(request, threads), expected, threads)

    def test_cold_warm_and_from_disk_in_any_order(self):
        for threads in THREADS:
            options = ("--threads", str(threads), "--disk-cache", self.path(f"cache{threads}"))
            with Daemon(*options) as daemon:
                cold = self.check(daemon, self.shuffled(), f"{threads} threads, cold")
                self.assertGreater(cold[0]["rays_traced"], 0)
                warm = self.check(daemon, self.shuffled(), f"{threads} threads, warm")
                self.assertEqual(sum(work["rays_traced"] for work in warm), 0)
                self.assertTrue(eventually(lambda: daemon.metric(QUEUE) == 0))
            with Daemon(*options) as daemon:
                disk = self.check(daemon, self.shuffled(), f"{threads} threads, from disk")
                self.assertGreater(disk[0]["mesh_disk_hits"], 0)
                self.assertEqual(sum(work["rays_traced"] for work in disk), 0)

    def test_side_by_side_with_a_cache_too_small_for_any(self):
        with Daemon("--threads", "4", "--cache-mb", "1") as daemon:
            orders = [self.shuffled() for _ in range(2)]
            at_once(2, lambda client: self.check(daemon, orders[client], "side by side"))
            self.assertGreater(daemon.metric("flared_mesh_cache_evictions_total"), 0)

    def test_repeated(self):
        for threads in THREADS if FULL else THREADS[1:2]:
            started = time.monotonic()
            with Daemon("--threads", str(threads)) as daemon:
                for repeat in range(REPEATS):
                    self.check(daemon, self.shuffled(), f"{threads} threads, repeat {repeat}")
            if FULL:
                print(f"{threads} threads: {REPEATS} repeats of {len(self.todo)} pictures, "
                      f"{time.monotonic() - started:.0f} s", flush=True)


if __name__ == "__main__":
    unittest.main()
