# SPDX-License-Identifier: Apache-2.0
"""What is traced once is not traced again, and nobody can tell from the picture."""
import json
import unittest

from harness import Daemon, Scenario, at_once, small_request

RAYS = "flared_rays_traced_total"


class CacheScenario(Scenario):
    def test_an_equal_request_traces_no_ray(self):
        with Daemon() as daemon:
            first = self.assert_ok(daemon.flare(small_request()))
            rays = daemon.metric(RAYS)
            self.assertGreater(rays, 0)
            self.assertEqual(first.report["work"]["rays_traced"], rays)
            second = self.assert_ok(daemon.flare(small_request()))
            self.assertEqual(daemon.metric(RAYS), rays)
            self.assertEqual(second.report["work"]["rays_traced"], 0)
            self.assertEqual(second.body, first.body)

    def test_the_iris_is_no_part_of_the_trace(self):
        changes = [
            {"f_number": 2.8},
            {"f_number": 11},
            {"f_number": None},
            {"iris": {"blades": 6, "roundness": 0.2, "rotation_deg": 10}},
            {"iris": {"blades": 9}},
            {"coatings": "none"},
            {"units": "sensor_irradiance"},
            {"lights": [{"direction": [0.087, 0.05, 0.995], "irradiance": [3, 2, 1]}]},
        ]
        with Daemon() as daemon:
            # Which ghosts are worth drawing does depend on the iris.
            every_ghost = {"model": {"culling": "none"}}
            pictures = {self.assert_ok(daemon.flare(small_request(**every_ghost))).body}
            rays = daemon.metric(RAYS)
            for change in changes:
                request = small_request(**change, **every_ghost)
                pictures.add(self.assert_ok(daemon.flare(request)).body)
                self.assertEqual(daemon.metric(RAYS), rays, change)
            self.assertEqual(len(pictures), 1 + len(changes), "each change must show")
            self.assert_ok(daemon.flare(small_request(
                lights=[{"direction": [0.2, 0.05, 0.995], "irradiance": [1, 1, 1]}])))
            self.assertGreater(daemon.metric(RAYS), rays, "another light needs other rays")

    def test_equal_requests_at_once_trace_the_rays_of_one(self):
        with Daemon() as daemon:
            alone = self.assert_ok(daemon.flare(small_request()))
            rays_of_one = daemon.metric(RAYS)
        with Daemon() as daemon:
            replies = at_once(16, lambda _: daemon.flare(small_request()))
            for reply in replies:
                self.assertEqual(self.assert_ok(reply).body, alone.body)
            metrics = daemon.metrics()
            self.assertEqual(metrics[RAYS], rays_of_one)
            self.assertEqual(sum(r.report["work"]["rays_traced"] for r in replies), rays_of_one)
            self.assertEqual(metrics["flared_mesh_cache_hits_total"],
                             15 * metrics["flared_mesh_cache_misses_total"])

    def test_a_tiny_cache_evicts_and_gives_the_same_bytes(self):
        requests = [small_request(lights=[{"direction": [0.05 * i, 0.02, 1.0]}])
                    for i in range(3)]
        tiny_options = ("--cache-mb", "2", "--ghost-cache-mb", "0")
        with Daemon() as roomy, Daemon(*tiny_options) as tiny:
            expected = [self.assert_ok(roomy.flare(request)).body for request in requests]
            for _ in range(2):
                got = [self.assert_ok(tiny.flare(request)).body for request in requests]
                self.assertEqual(got, expected)
            metrics = tiny.metrics()
            self.assertGreater(metrics["flared_mesh_cache_evictions_total"], 0)
            self.assertLessEqual(metrics["flared_mesh_cache_bytes"], 2 << 20)
            self.assertGreater(metrics[RAYS], roomy.metric(RAYS))

    def test_ghosts_are_kept_within_their_bound(self):
        one = {"direction": [0.05, 0.02, 1.0]}
        other = {"direction": [0.1, 0.02, 1.0]}
        with Daemon() as daemon:
            first = self.assert_ok(daemon.flare(small_request(lights=[one])))
            self.assertEqual(first.report["work"]["ghost_cache_hits"], 0)
            again = self.assert_ok(daemon.flare(small_request(lights=[one])))
            hits = again.report["work"]["ghost_cache_hits"]
            self.assertGreater(hits, 0)
            self.assertEqual(hits, again.report["work"]["mesh_cache_hits"])
            self.assertEqual(again.body, first.body)
            both = self.assert_ok(daemon.flare(small_request(lights=[one, other])))
            self.assertEqual(both.report["work"]["ghost_cache_hits"], hits)
            self.assertEqual(daemon.metric("flared_ghost_cache_hits_total"), 2 * hits)
            self.assertGreater(daemon.metric("flared_ghost_cache_bytes"), 0)
        with Daemon("--ghost-cache-mb", "1") as tiny, Daemon("--ghost-cache-mb", "0") as none:
            for n in range(24):
                request = small_request(lights=[{"direction": [0.01 * n, 0.02, 1.0]}])
                self.assertEqual(self.assert_ok(tiny.flare(request)).body,
                                 self.assert_ok(none.flare(request)).body)
            self.assertGreater(tiny.metric("flared_ghost_cache_evictions_total"), 0)
            self.assertLessEqual(tiny.metric("flared_ghost_cache_bytes"), 1 << 20)
            self.assertEqual(none.metric("flared_ghost_cache_bytes"), 0)

    def test_the_same_bytes_everywhere(self):
        request = small_request(iris={"blades": 7})
        path = self.write("request.json", json.dumps(request))
        self.run_flare("render", path, "-o", self.path("in_process.exr"))
        with open(self.path("in_process.exr"), "rb") as file:
            expected = file.read()
        self.run_flare("render", path, "-o", self.path("again.exr"))
        with open(self.path("again.exr"), "rb") as file:
            self.assertEqual(file.read(), expected, "two runs")
        for threads in (1, 2, 4):
            with Daemon("--threads", str(threads)) as daemon:
                self.assertEqual(self.assert_ok(daemon.flare(request)).body, expected, threads)
                self.assertEqual(daemon.flare(request).body, expected, "warm")
                for url in daemon.urls:
                    self.run_flare("render", path, "-o", self.path("served.exr"), "--server", url)
                    with open(self.path("served.exr"), "rb") as file:
                        self.assertEqual(file.read(), expected, url)


if __name__ == "__main__":
    unittest.main()
