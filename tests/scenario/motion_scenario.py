# SPDX-License-Identifier: Apache-2.0
"""What a moving camera costs: a focus pull traces nothing, a light that comes nearer says what it does.

Few steps by default; all hundred of the pull:
    FLARE_TEST_FULL=1 python3 -B tests/scenario/motion_scenario.py
"""
import os
import unittest

from harness import Daemon, Scenario, small_request

RAYS = "flared_rays_traced_total"
STEPS = 100 if os.environ.get("FLARE_TEST_FULL", "") not in ("", "0") else 15


class MotionScenario(Scenario):
    def test_a_focus_pull_traces_no_ray(self):
        with Daemon() as daemon:
            # Which ghosts are worth drawing may change with the focus.
            every_ghost = {"model": {"culling": "none"}}
            self.assert_ok(daemon.flare(small_request(**every_ghost)))
            rays = daemon.metric(RAYS)
            self.assertGreater(rays, 0)
            pictures = set()
            for step in range(STEPS):
                # Evenly in 1/distance, from 100 m to 0.5 m.
                focus_m = 1.0 / (0.01 + (2.0 - 0.01) * step / (STEPS - 1))
                reply = self.assert_ok(daemon.flare(small_request(focus_m=focus_m, **every_ghost)))
                work = reply.report["work"]
                self.assertEqual(work["rays_traced"], 0, focus_m)
                self.assertEqual(work["mesh_cache_misses"], 0, focus_m)
                pictures.add(reply.body)
            self.assertEqual(len(pictures), STEPS, "each step must show")
            self.assertEqual(daemon.metric(RAYS), rays)

    def test_a_light_from_infinity_to_half_a_metre_reports_its_rays(self):
        def sweep(daemon):
            total = 0
            for step in range(7):
                distance = {} if step == 0 else {"distance_m": 3.0 / step}
                request = small_request(lights=[{"direction": [0.087, 0.05, 0.995], **distance}])
                total += self.assert_ok(daemon.flare(request)).report["work"]["rays_traced"]
            return total

        with Daemon() as daemon:
            first = sweep(daemon)
            self.assertGreater(first, 0)
            self.assertEqual(daemon.metric(RAYS), first, "the reports account for every ray")
            self.assertEqual(sweep(daemon), 0, "and back again nothing is traced")
            self.assertEqual(daemon.metric(RAYS), first)


if __name__ == "__main__":
    unittest.main()
