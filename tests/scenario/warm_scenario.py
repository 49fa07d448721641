# SPDX-License-Identifier: Apache-2.0
"""POST /v1/warm: what was warmed traces no ray when a picture asks for it, and pictures come first."""
import json
import math
import time
import unittest

from harness import LENS, Daemon, Scenario, eventually, small_request

RAYS = "flared_rays_traced_total"


def warm_request(**changes):
    request = {"lens": LENS, "quality": {"preset": "draft"},
               "lights": [{"direction": [0.087, 0.05, 0.995]}]}
    request.update(changes)
    return {key: value for key, value in request.items() if value is not None}


class WarmScenario(Scenario):
    def start(self, daemon, **changes):
        reply = daemon.ask("POST", "/v1/warm", body=json.dumps(warm_request(**changes)),
                           headers={"Content-Type": "application/json"})
        self.assertEqual(reply.status, 202, reply.body)
        self.assertEqual(reply.headers["Location"], "/v1/warm/" + reply.json()["id"])
        return reply

    def finish(self, daemon, reply):
        where = reply.headers["Location"]
        self.assertTrue(eventually(lambda: daemon.get(where).json()["state"] != "running"))
        return daemon.get(where).json()

    def test_a_picture_of_what_was_warmed_traces_no_ray(self):
        # Warming traces all ghosts, whichever a picture may leave out.
        request = small_request(model={"culling": "none"})
        with Daemon() as cold:
            expected = self.assert_ok(cold.flare(request))
        folder = self.path("cache")
        with Daemon("--disk-cache", folder) as daemon:
            reply = self.start(daemon)
            self.assertEqual(reply.json()["lights"], 1)
            done = self.finish(daemon, reply)
            self.assertEqual((done["state"], done["lights_done"]), ("done", 1))
            rays = daemon.metric(RAYS)
            self.assertEqual(done["rays_traced"], rays)
            self.assertEqual(rays, expected.report["work"]["rays_traced"])
            self.assertEqual(done["mesh_cache_misses"], expected.report["work"]["mesh_cache_misses"])
            warm = self.assert_ok(daemon.flare(request))
            self.assertEqual(warm.body, expected.body)
            self.assertEqual(daemon.metric(RAYS), rays)
            again = self.finish(daemon, self.start(daemon))
            self.assertEqual((again["rays_traced"], again["mesh_cache_misses"]), (0, 0))
            self.assertTrue(eventually(
                lambda: daemon.metric("flared_mesh_disk_queue_bytes") == 0))
        with Daemon("--disk-cache", folder) as daemon:
            done = self.finish(daemon, self.start(daemon))
            self.assertEqual(done["mesh_disk_hits"], done["mesh_cache_hits"])
            self.assertEqual(daemon.metric(RAYS), 0, "warming fills the disk, too")

    def test_field_angles_are_lights_of_the_ghost_lists_angles(self):
        a = math.radians(5.0)
        with Daemon() as daemon:
            reply = self.start(daemon, lights=None, field_deg=[0, 10, 5])
            self.assertEqual(reply.json()["lights"], 3)
            self.assertEqual(self.finish(daemon, reply)["lights_done"], 3)
            rays = daemon.metric(RAYS)
            for azimuth in (0.3, 2.0):
                direction = [math.sin(a) * math.cos(azimuth), math.sin(a) * math.sin(azimuth),
                             math.cos(a)]
                self.assert_ok(daemon.flare(small_request(lights=[{"direction": direction}])))
            self.assertEqual(daemon.metric(RAYS), rays, "a round lens needs one mesh for all")

    def test_pictures_come_first_and_warming_can_be_called_off(self):
        with Daemon("--workers", "1") as daemon:
            reply = self.start(daemon, lights=None, field_deg=[0, 20, 0.01])
            self.assertEqual(reply.json()["lights"], 2001)
            where = reply.headers["Location"]
            self.assertTrue(eventually(
                lambda: daemon.get(where).json()["mesh_cache_misses"] > 0))
            self.assert_ok(daemon.flare(small_request()))
            progress = daemon.get(where).json()
            self.assertEqual(progress["state"], "running")
            self.assertLess(progress["lights_done"], 2001, "the picture did not wait for it")
            self.assertEqual(daemon.metric("flared_warm_jobs"), 1)
            self.assertEqual(daemon.ask("DELETE", where).json()["state"], "cancelled")
            self.assertEqual(daemon.metric("flared_warm_jobs"), 0)
            self.assertTrue(eventually(lambda: self.rays_rest(daemon)))

    def rays_rest(self, daemon):
        before = daemon.metric(RAYS)
        time.sleep(0.3)
        return daemon.metric(RAYS) == before

    def test_there_is_an_end_to_how_much_may_be_asked(self):
        with Daemon("--workers", "1") as daemon:
            for _ in range(16):
                self.start(daemon, lights=None, field_deg=[0, 20, 0.01])
            reply = daemon.ask("POST", "/v1/warm", body=json.dumps(warm_request()),
                               headers={"Content-Type": "application/json"})
            self.assert_refused(reply, 503, "overloaded", "")
            self.assertEqual(daemon.metric("flared_warm_jobs"), 16)
        # The end of the with block drains: what is left of the warming must not hold it up.


if __name__ == "__main__":
    unittest.main()
