# SPDX-License-Identifier: Apache-2.0
"""Meshes outlive the daemon, whatever happens to it or to its files, and nobody can tell from the
picture."""
import os
import signal
import subprocess
import time
import unittest

from harness import FLARED, PATIENCE_S, Daemon, Scenario, at_once, eventually, small_request

RAYS = "flared_rays_traced_total"
DISK = "flared_mesh_disk_"


def requests(count):
    return [small_request(lights=[{"direction": [0.03 * i, 0.02, 1.0]}]) for i in range(count)]


class DiskCacheScenario(Scenario):
    def setUp(self):
        super().setUp()
        self.cache = self.path("cache")

    def daemon(self, *options):
        return Daemon("--disk-cache", self.cache, *options)

    def files(self, ending=".mesh"):
        if not os.path.isdir(self.cache):
            return []
        return sorted(os.path.join(self.cache, name) for name in os.listdir(self.cache)
                      if name.endswith(ending))

    def fill(self, request):
        """Renders, waits until all is written, and gives the picture."""
        with self.daemon() as daemon:
            body = self.assert_ok(daemon.flare(request)).body
            self.assertTrue(eventually(lambda: daemon.metric(DISK + "queue_bytes") == 0))
            return body

    def test_a_new_daemon_traces_no_ray_and_gives_the_same_bytes(self):
        request = small_request()
        with Daemon() as without:
            expected = self.assert_ok(without.flare(request)).body
        self.assertEqual(self.fill(request), expected)
        for threads in ("1", "4"):
            with self.daemon("--threads", threads) as daemon:
                reply = self.assert_ok(daemon.flare(request))
                self.assertEqual(reply.body, expected)
                work = reply.report["work"]
                self.assertEqual(work["rays_traced"], 0)
                self.assertEqual(work["mesh_cache_misses"], 0)
                self.assertEqual(work["mesh_disk_hits"], work["mesh_cache_hits"])
                self.assertGreater(work["mesh_disk_hits"], 0)
                metrics = daemon.metrics()
                self.assertEqual(metrics[RAYS], 0)
                self.assertEqual(metrics[DISK + "hits_total"], work["mesh_disk_hits"])
                self.assertEqual(metrics[DISK + "files"], len(self.files()))
                self.assertEqual(metrics[DISK + "bytes"],
                                 sum(os.path.getsize(file) for file in self.files()))
                again = self.assert_ok(daemon.flare(request))
                self.assertEqual(again.body, expected)
                self.assertEqual(again.report["work"]["mesh_disk_hits"], 0, "memory has them now")

    def test_damaged_files_are_traced_anew(self):
        request = small_request()
        expected = self.fill(request)
        for number, file in enumerate(self.files()):
            size = os.path.getsize(file)
            with open(file, "r+b") as stream:
                if number % 4 == 0:
                    stream.truncate(size * number // 97 % size)
                elif number % 4 == 1:
                    stream.seek(size * 31 // 97)
                    byte = stream.read(1)
                    stream.seek(-1, os.SEEK_CUR)
                    stream.write(bytes([byte[0] ^ 0x10]))
                elif number % 4 == 2:
                    stream.write(b"something else altogether")
                else:
                    os.replace(file, self.files()[0])
        with self.daemon() as daemon:
            reply = self.assert_ok(daemon.flare(request))
            self.assertEqual(reply.body, expected)
            self.assertGreater(daemon.metric(DISK + "discarded_total"), 10)
            self.assertEqual(daemon.log().count("is traced anew"), 1, "one line, not one a file")
        with self.daemon() as daemon:
            reply = self.assert_ok(daemon.flare(request))
            self.assertEqual(reply.body, expected)
            self.assertEqual(reply.report["work"]["rays_traced"], 0)

    def test_a_daemon_killed_while_it_writes_harms_nobody(self):
        todo = requests(4)
        with Daemon() as without:
            expected = [self.assert_ok(without.flare(request)).body for request in todo]
        written = 0
        for delay_s in (0.0, 0.004, 0.01, 0.02, 0.05):
            daemon = self.daemon()
            try:
                self.assert_ok(daemon.flare(todo[written % 4]))
                time.sleep(delay_s)
            finally:
                daemon.process.kill()
                daemon.process.wait()
                daemon.process.stdout.close()
            written += 1
        self.assertTrue(self.files(), "it must have come to write")
        with self.daemon() as daemon:
            self.assertEqual(self.files(".part"), [], "what the dead left is swept")
            for request, body in zip(todo, expected):
                self.assertEqual(self.assert_ok(daemon.flare(request)).body, body)
            self.assertEqual(daemon.metric(DISK + "discarded_total"), 0,
                             "no torn file without a loss of power")

    def test_two_daemons_share_a_folder(self):
        todo = requests(5)
        with Daemon() as without:
            expected = [self.assert_ok(without.flare(request)).body for request in todo]
        with self.daemon("--cache-mb", "0") as one, self.daemon("--cache-mb", "0") as two:
            def work(index):
                daemon = (one, two)[index % 2]
                return [daemon.flare(request).body for request in todo]
            for bodies in at_once(4, work):
                self.assertEqual(bodies, expected)
            self.assertTrue(eventually(lambda: all(
                daemon.metric(DISK + "queue_bytes") == 0 for daemon in (one, two))))
            for daemon in (one, two):
                rays = daemon.metric(RAYS)
                for request, body in zip(todo, expected):
                    self.assertEqual(daemon.flare(request).body, body)
                self.assertEqual(daemon.metric(RAYS), rays, "one's meshes serve the other")
                self.assertEqual(daemon.metric(DISK + "discarded_total"), 0)
                self.assertEqual(daemon.metric(DISK + "failed_total"), 0)

    def test_the_bound_holds(self):
        todo = requests(6)
        with Daemon() as without:
            expected = [self.assert_ok(without.flare(request)).body for request in todo]
        with self.daemon("--disk-cache-mb", "8", "--cache-mb", "0") as daemon:
            for request, body in zip(todo * 2, expected * 2):
                self.assertEqual(self.assert_ok(daemon.flare(request)).body, body)
            self.assertTrue(eventually(lambda: daemon.metric(DISK + "queue_bytes") == 0))
            self.assertGreater(daemon.metric(DISK + "evictions_total"), 0)
            self.assertLessEqual(sum(os.path.getsize(file) for file in self.files()), 8 << 20)

    def test_a_folder_that_cannot_be_written_costs_a_line_in_the_log(self):
        self.write("cache", "a file where the folder should be")
        with self.daemon() as daemon:
            first = self.assert_ok(daemon.flare(small_request()))
            self.assertTrue(eventually(lambda: daemon.metric(DISK + "failed_total") > 1))
            self.assertEqual(self.assert_ok(daemon.flare(small_request())).body, first.body)
            self.assertEqual(daemon.log().count("meshes are not kept on disk"), 1)

    def test_where_it_lies_and_how_it_is_switched_off(self):
        def folders_after_a_start(*options, **environment):
            listening = [FLARED, "--listen", "unix:" + self.path("s"), *options]
            with subprocess.Popen(listening, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True, env={**os.environ, **environment}) as process:
                process.stdout.readline()
                process.send_signal(signal.SIGTERM)
                log = process.communicate(timeout=PATIENCE_S)[1]
                self.assertEqual(process.returncode, 0, log)
                return log
        home, xdg = self.path("home"), self.path("xdg")
        self.assertIn(f"also in {xdg}/flared\n",
                      folders_after_a_start(HOME=home, XDG_CACHE_HOME=xdg))
        self.assertIn(f"also in {home}/.cache/flared\n",
                      folders_after_a_start(HOME=home, XDG_CACHE_HOME=""))
        self.assertIn("in memory alone", folders_after_a_start(HOME="", XDG_CACHE_HOME="relative"))
        self.assertIn("in memory alone", folders_after_a_start(
            "--disk-cache-mb", "0", HOME=home, XDG_CACHE_HOME=xdg))
        config = self.write("flared.toml", f'disk_cache = "{self.cache}"\n')
        self.assertIn(f"also in {self.cache}\n", folders_after_a_start("--config", config))
        self.assertFalse(os.path.exists(home) or os.path.exists(xdg),
                         "nothing is made before there is something to keep")


if __name__ == "__main__":
    unittest.main()
