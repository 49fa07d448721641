# SPDX-License-Identifier: Apache-2.0
"""Clients that are slow, leave, come in crowds, or come too late."""
import json
import re
import signal
import threading
import time
import unittest

from harness import PATIENCE_S, Daemon, Scenario, eventually, slow_request, small_request

LEFT = "flared_requests_total{code=499,route=/v1/flare}"


def post_head(length):
    return (f"POST /v1/flare HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
            f"Content-Length: {length}\r\n\r\n").encode()


def start_slow(daemon):
    """A bare connection whose request is in work."""
    body = json.dumps(slow_request()).encode()
    connection = daemon.raw()
    connection.sendall(post_head(len(body)) + body)
    return connection


class ClientScenario(Scenario):
    def test_slow_clients_are_cut_off_and_hold_nobody_up(self):
        with Daemon("--header-timeout-s", "1", "--body-timeout-s", "1", "--idle-timeout-s",
                    "1") as daemon:
            half = len(json.dumps(small_request())) // 2
            starts = [b"", b"GET /hea", post_head(1000), post_head(1000) + b" " * half]
            connections = [daemon.raw() for _ in range(40)]
            for index, connection in enumerate(connections):
                connection.sendall(starts[index % len(starts)])
            begin = time.monotonic()
            self.assert_ok(daemon.get("/healthz"))
            self.assertLess(time.monotonic() - begin, 5)
            for connection in connections:
                self.assertEqual(connection.recv(100), b"")
                connection.close()
            reason = "flared_requests_rejected_total{reason=slow_client}"
            self.assertTrue(eventually(lambda: daemon.metric(reason) >= 30))
            self.assertEqual(daemon.metric(reason), 30, "all but the silent ones")

    def test_a_client_that_leaves_has_its_work_cancelled(self):
        with Daemon("--workers", "1") as daemon:
            connection = start_slow(daemon)
            self.assertTrue(eventually(lambda: daemon.metric("flared_mesh_cache_misses_total") > 0))
            self.assertEqual(daemon.metric(LEFT), 0, "it must still be in work")
            connection.close()
            self.assertTrue(eventually(lambda: daemon.metric(LEFT) == 1))
            misses = daemon.metric("flared_mesh_cache_misses_total")
            self.assertLess(misses, 400 * 45 / 2, "most of its work was never done")
            self.assert_ok(daemon.flare(small_request()))

    def test_a_client_that_leaves_the_queue_gives_its_place_back(self):
        with Daemon("--workers", "1", "--queue", "1") as daemon:
            in_work = start_slow(daemon)
            self.assertTrue(eventually(lambda: daemon.metric("flared_mesh_cache_misses_total") > 0))
            waiting = start_slow(daemon)
            self.assertTrue(eventually(lambda: daemon.metric("flared_queue_depth") == 1))
            waiting.close()
            self.assertTrue(eventually(lambda: daemon.metric("flared_queue_depth") == 0))
            in_work.close()

    def test_a_full_queue_says_when_to_come_back(self):
        with Daemon("--workers", "1", "--queue", "2") as daemon:
            crowd = [start_slow(daemon)]
            self.assertTrue(eventually(lambda: daemon.metric("flared_mesh_cache_misses_total") > 0))
            crowd += [start_slow(daemon) for _ in range(2)]
            self.assertTrue(eventually(lambda: daemon.metric("flared_queue_depth") == 2))
            reply = daemon.flare(small_request())
            self.assert_refused(reply, 503, "overloaded", "")
            self.assertGreaterEqual(int(reply.headers["Retry-After"]), 1)
            self.assertEqual(
                daemon.metric("flared_requests_rejected_total{reason=queue_full}"), 1)
            self.assert_ok(daemon.get("/v1/lenses"))
            for connection in crowd:
                connection.close()
            self.assertTrue(eventually(lambda: daemon.flare(small_request()).status == 200))

    def test_pictures_beyond_the_memory_are_refused(self):
        with Daemon("--picture-mb", "64") as daemon:
            image = {"width": 4096, "height": 4096, "sensor_width_mm": 36}
            self.assert_refused(daemon.flare(small_request(image=image)), 413, "too_large", "")
            self.assert_ok(daemon.flare(small_request()))

    def test_a_deadline_ends_a_request(self):
        with Daemon("--deadline-s", "1") as daemon:
            reply = daemon.flare(slow_request(quality={"preset": "final"}))
            self.assert_refused(reply, 503, "deadline", "")
            self.assert_ok(daemon.get("/healthz"))

    def test_sigterm_drains(self):
        with Daemon("--workers", "1", "--drain-s", "100") as daemon:
            replies = []
            lights = slow_request()["lights"][:12]
            running = threading.Thread(
                target=lambda: replies.append(daemon.flare(small_request(lights=lights))))
            running.start()
            self.assertTrue(eventually(lambda: daemon.metric("flared_mesh_cache_misses_total") > 0))
            daemon.process.send_signal(signal.SIGTERM)
            self.assertTrue(eventually(lambda: daemon.get("/readyz").status == 503))
            self.assert_refused(daemon.flare(small_request()), 503, "draining", "")
            self.assertEqual(replies, [], "the request must still have been in work")
            running.join()
            self.assert_ok(replies[0])
            self.assertEqual(daemon.process.wait(PATIENCE_S), 0)

    def test_a_drain_ends_even_if_the_work_does_not(self):
        with Daemon("--workers", "1", "--drain-s", "1") as daemon:
            replies = []
            running = threading.Thread(target=lambda: replies.append(daemon.flare(slow_request())))
            running.start()
            self.assertTrue(eventually(lambda: daemon.metric("flared_mesh_cache_misses_total") > 0))
            daemon.process.send_signal(signal.SIGTERM)
            self.assertEqual(daemon.process.wait(PATIENCE_S), 0)
            running.join()
            self.assert_refused(replies[0], 503, "draining", "")

    def test_connections_are_kept_and_pipelines_answered_in_order(self):
        with Daemon() as daemon:
            connection = daemon.raw()
            targets = ["/healthz", "/v1/nothing", "/readyz", "/v1/lenses/none", "/healthz"]
            heads = [f"GET {target} HTTP/1.1\r\nHost: x\r\n" for target in targets]
            heads[-1] += "Connection: close\r\n"
            connection.sendall("".join(head + "\r\n" for head in heads).encode())
            text = b""
            while part := connection.recv(65536):
                text += part
            connection.close()
            statuses = [int(status) for status in re.findall(rb"HTTP/1\.1 (\d+)", text)]
            self.assertEqual(statuses, [200, 404, 200, 404, 200])


if __name__ == "__main__":
    unittest.main()
