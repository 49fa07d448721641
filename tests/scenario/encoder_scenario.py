# SPDX-License-Identifier: Apache-2.0
"""Lens encoders from outside: scripted, FreeD and OpenTrackIO over localhost, in requests, routes,
counters, the log and the command line."""
import json
import socket
import struct
import subprocess
import unittest

from encoder_checks import EncoderChecks
from harness import (FLARE, FLARED, LENS, PATIENCE_S, at_once, eventually, exr_attributes,
                     small_request)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def freed(camera, zoom, focus):
    body = bytes([0xD1, camera]) + bytes(18) + zoom.to_bytes(3, "big") + focus.to_bytes(3, "big")
    body += bytes(2)
    return body + bytes([(0x40 - sum(body)) & 0xFF])


def open_track_io(sequence, lens):
    payload = json.dumps({"protocol": {"name": "OpenTrackIO", "version": [1, 0, 1]},
                          "lens": lens}).encode()
    head = b"OTrk" + struct.pack("!BBHIH", 0, 1, sequence & 0xFFFF, 0, 0x8000 | len(payload))
    a = b = 0
    for byte in head + payload:
        a = (a + byte) % 255
        b = (b + a) % 255
    return head + bytes([a, b]) + payload


class EncoderScenario(EncoderChecks):
    def test_a_script_drives_requests_routes_counters_and_commands(self):
        script = self.write("pull.csv", "time_s,focus_m,t_stop\n0,1.5,4\n0.05,2.5,2.8\n")
        config = f"""
[[encoder]]
name = "A-cam"
kind = "script"
file = "{script}"
lens = "{LENS}"
"""
        with self.daemon(config) as daemon:
            self.assertTrue(eventually(lambda: self.encoder(daemon, "A-cam")["samples"] == 2))
            seen = self.encoder(daemon, "A-cam")
            self.assertEqual(seen["state"], {"focus_m": 2.5, "t_stop": 2.8})
            self.assertEqual((seen["kind"], seen["lens"]), ("script", LENS))
            request = small_request(lens=None, f_number=None, encoder="A-cam")
            reply = self.assert_ok(daemon.flare(request))
            attributes = exr_attributes(reply.body)
            self.assertEqual(attributes["encoder"], "A-cam")
            self.assertAlmostEqual(attributes["encoderTStop"], 2.8, places=5)
            self.assertEqual(attributes["focus"], 2.5)
            self.assertGreaterEqual(attributes["encoderAge"], 0)
            report = self.assert_equals_numbers(daemon, {**request, "lens": LENS}, reply)
            self.assertAlmostEqual(report["f_number"], 2.8 * report["t_axis"] ** 0.5)
            past = self.assert_ok(daemon.flare(
                {**request, "encoder_time": seen["time_s"] - 0.025}))
            self.assertAlmostEqual(past.report["state"]["focus_m"], 1.875, places=3)
            self.assert_refused(daemon.flare({**request, "encoder_max_age_ms": 0}), 503,
                                "encoder_stale", "/encoder_max_age_ms")
            self.assertEqual(daemon.metric("flared_encoder_samples_total{name=A-cam}"), 2)
            self.assertEqual(daemon.metric("flared_encoder_connected{name=A-cam}"), 1)
            # The commands ask the daemon, or run the encoders themselves; pictures agree.
            table = self.run_flare("encoder", "list", "--server", daemon.unix_url)
            self.assertIn("2.5 m, T2.8", table)
            line = self.run_flare("encoder", "watch", "A-cam", "--count", "1", "--server",
                                  daemon.unix_url)
            self.assertIn("2.5 m, T2.8", line)
            path = self.write("request.json",
                              json.dumps(small_request(lens=None, f_number=None)))
            for source in (("--server", daemon.unix_url),
                           ("--config", self.path("flared.toml"))):
                self.run_flare("render", path, "-o", self.path("out.exr"), "--encoder", "A-cam",
                               *source)
                with open(self.path("out.exr"), "rb") as file:
                    body = file.read()
                self.assertEqual(exr_attributes(body)["encoder"], "A-cam")
            self.run_flare("encoder", "watch", "B-cam", "--server", daemon.unix_url, exit_code=2)
            self.run_flare("render", path, "-o", self.path("out.exr"), "--encoder", "B-cam",
                           "--config", self.path("flared.toml"), exit_code=2)

    def test_freed_counts_through_a_table(self):
        port = free_port()
        config = f"""
[[encoder]]
name = "A-cam"
kind = "freed"
port = {port}
address = "127.0.0.1"
camera_id = 1
stale_ms = 300
[encoder.focus]
raw = [0, 10000, 20000]
value = [0.5, 1, inf]
"""
        with self.daemon(config) as daemon:
            request = small_request(f_number=4, encoder="A-cam")
            self.assert_refused(daemon.flare(request), 503, "encoder_stale", "/encoder")
            self.assertEqual(self.encoder(daemon, "A-cam")["health"], "waiting")
            end = self.sender(port, lambda i: freed(1 + i % 2, 99, 10000))
            self.assertTrue(eventually(lambda: self.encoder(daemon, "A-cam")["connected"]))
            reply = self.assert_ok(daemon.flare(request))
            self.assertEqual(exr_attributes(reply.body)["encoderFocus"], 1.0)
            self.assert_equals_numbers(daemon, request, reply)
            end()
            # The cable is pulled: the state is held and marked, requests go on.
            self.assertTrue(eventually(
                lambda: self.encoder(daemon, "A-cam")["health"] == "lost"))
            self.assertEqual(daemon.metric("flared_encoder_connected{name=A-cam}"), 0)
            self.assertEqual(
                daemon.metric("flared_encoder_faults_total{kind=timeout,name=A-cam}"), 1)
            held = self.assert_ok(daemon.flare(request))
            self.assertGreater(exr_attributes(held.body)["encoderAge"], 290)
            self.assert_refused(daemon.flare({**request, "encoder_max_age_ms": 250}), 503,
                                "encoder_stale", "/encoder_max_age_ms")
            self.assertIn("no datagram for 300 ms", daemon.log())
            # And plugged in again, turned to infinity.
            self.sender(port, lambda i: freed(1, 99, 20000))
            self.assertTrue(eventually(
                lambda: self.encoder(daemon, "A-cam").get("state") == {"focus_m": None}))
            reply = self.assert_ok(daemon.flare(request))
            self.assertNotIn("focus", exr_attributes(reply.body))
            self.assert_equals_numbers(daemon, request, reply)

    def test_a_person_is_led_through_a_calibration(self):
        port, count = free_port(), [100]
        config = f'[[encoder]]\nname = "x"\nkind = "freed"\nport = {port}\naddress = "127.0.0.1"\n'
        with self.daemon(config) as daemon:
            self.sender(port, lambda i: freed(1, 0, count[0]))
            self.assertTrue(eventually(lambda: self.encoder(daemon, "x")["connected"]))
            lead = subprocess.Popen(
                [FLARE, "encoder", "calibrate", "x", "--axis", "focus", "--server",
                 daemon.unix_url, "-o", self.path("table.toml")],
                stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
            marks = [("0.45", 100), ("1", 9_000), ("2.5", 20_000), ("inf", 31_000)]
            for mark, counts in marks:
                count[0] = counts
                self.assertTrue(eventually(
                    lambda c=counts: self.encoder(daemon, "x")["raw"]["focus"] == c))
                lead.stdin.write(mark + "\n")
                said = lead.stderr.readline()
                self.assertIn(f"count {counts} ", said)
            lead.stdin.write("0.7\none\n\n")  # the ring was not turned
            lead.stdin.close()
            said = lead.stderr.read()
            self.assertIn("left out: with it the table's raw has the same count twice", said)
            self.assertIn("'one' is no mark", said)
            self.assertEqual(lead.wait(PATIENCE_S), 0)
            lead.stderr.close()
        with open(self.path("table.toml"), encoding="utf-8") as file:
            table = file.read()
        with self.daemon(config + table) as daemon:
            for mark, counts in marks:
                count[0] = counts
                wanted = {"focus_m": None if mark == "inf" else float(mark)}
                self.assertTrue(eventually(
                    lambda w=wanted: self.encoder(daemon, "x").get("state") == w), mark)

    def test_open_track_io_at_285_samples_a_second_under_load(self):
        ports = free_port(), free_port()
        config = "".join(f"""
[[encoder]]
name = "cam-{i}"
kind = "opentrackio"
port = {port}
address = "127.0.0.1"
""" for i, port in enumerate(ports))
        with self.daemon(config) as daemon:
            ends = [self.sender(port, lambda i: open_track_io(
                i, {"tStop": 2.8, "focusDistance": 2 + 1e-3 * i}), 1 / 285) for port in ports]
            for i in (0, 1):
                self.assertTrue(eventually(
                    lambda name=f"cam-{i}": self.encoder(daemon, name)["connected"]))
            replies = at_once(16, lambda i: daemon.flare(
                small_request(f_number=None, encoder=f"cam-{i % 2}")))
            for reply in replies:
                self.assert_ok(reply)
            for end in ends:
                end()
            for i in (0, 1):
                seen = self.encoder(daemon, f"cam-{i}")
                self.assertEqual(seen["faults"]["lost_data"], 0)
                self.assertEqual(seen["faults"]["bad_data"], 0)
                self.assertGreater(seen["samples"], 10)

    def test_a_request_finds_the_meshes_that_the_ring_came_to(self):
        # Lights by pixel: their directions follow the focus, so that each step of the ring has its own
        # meshes. A step moves the image by 10 um (ring_steps.h).
        port, cell = free_port(), [100]
        config = f"""
[[encoder]]
name = "A-cam"
kind = "opentrackio"
port = {port}
address = "127.0.0.1"
"""
        request = small_request(encoder="A-cam", lights=[{"pixel": [10, 8]}])
        with self.daemon(config) as daemon:
            step = 1e3 * 0.01 / daemon.get("/v1/lenses/" + LENS).json()["efl_mm"]**2
            self.sender(port, lambda i: open_track_io(
                i, {"focusDistance": 1 / (step * (cell[0] + 0.1))}))

            def turn_to(step_number):
                cell[0] = step_number
                wanted = 1 / (step * (step_number + 0.1))
                self.assertTrue(eventually(lambda: abs(
                    self.encoder(daemon, "A-cam").get("state", {}).get("focus_m", 0) / wanted - 1)
                    < 1e-9))

            def misses():
                reply = self.assert_ok(daemon.flare(request))
                self.assertAlmostEqual(reply.report["state"]["focus_m"], 1 / (cell[0] * step), 9)
                self.assert_equals_numbers(daemon, request, reply)
                return reply.report["work"]["mesh_cache_misses"]

            def warmed():
                return daemon.metric("flared_encoder_states_warmed_total{name=A-cam}")

            turn_to(100)
            self.assertGreater(misses(), 0)

            # The ring goes on without a request; the next step but one is there when it comes to it.
            # A machine that is too busy to be ahead of this ring has some tries.
            def is_ahead():
                before = warmed()
                turn_to(cell[0] + 1)
                eventually(lambda: warmed() >= before + 2, 1.5)
                turn_to(cell[0] + 1)
                return misses() == 0

            self.assertTrue(eventually(is_ahead), daemon.metrics())

            def is_surprised():
                turn_to(100 if cell[0] > 400 else cell[0] + 100)
                return misses() > 0

            self.assertTrue(eventually(is_surprised))

    def test_noise_is_counted_and_a_bad_configuration_refused(self):
        port = free_port()
        config = f'[[encoder]]\nname = "x"\nkind = "opentrackio"\nport = {port}\n'
        with self.daemon(config) as daemon:
            good = open_track_io(0, {"fStop": 4})
            broken = [good[:9], good[:-1], good.replace(b"4", b"5"), b"", b"OTrk" * 300]
            end = self.sender(port, lambda i: broken[i % len(broken)], 0.001)
            self.assertTrue(eventually(
                lambda: self.encoder(daemon, "x")["faults"]["bad_data"] > 50))
            end()
            self.assertEqual(self.encoder(daemon, "x")["samples"], 0)
            self.assertEqual(daemon.log().count("encoder x:"), 1, "once a change, not each time")
        for text, where in (('encoder = 3', "line 1"),
                            ('[[encoder]]\nname="a"\nkind="script"\nfile="/nowhere"',
                             "encoder a, file")):
            done = subprocess.run([FLARED, "--config", self.write("bad.toml", text)], text=True,
                                  capture_output=True, timeout=PATIENCE_S, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn(where, done.stderr)


if __name__ == "__main__":
    unittest.main()
