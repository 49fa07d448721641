# SPDX-License-Identifier: Apache-2.0
"""What the scenarios of lens encoders share."""
import json
import os
import socket
import threading
import time

from harness import Daemon, Scenario, exr_attributes


PERIOD_US = 3509  # between two records, 285 a second


def hardware_goes_first(pid):
    """Has the player of the devices go before everybody else; False where that may not be asked for."""
    for thread in os.listdir(f"/proc/{pid}/task"):
        try:
            os.sched_setscheduler(int(thread), os.SCHED_RR, os.sched_param(1))
        except PermissionError:
            return False
    return True


def latencies_ms(daemon, offset_s, polls):
    """Of the encoder "ring", whose counts are the times at which its records were due: from due to read
    of the newest record, and by how much the next is late. Both sorted."""
    taken, late = [], []
    for _ in range(polls):
        time.sleep(0.0071)
        ring = next(e for e in daemon.get("/v1/encoders").json()["encoders"]
                    if e["name"] == "ring")
        read_us = (ring["time_s"] - offset_s) * 1e6
        latency_ms = (read_us - ring["raw"]["focus"]) % 2**30 / 1e3
        taken.append(latency_ms)
        late.append(max(0.0, latency_ms + ring["age_ms"] - PERIOD_US / 1e3))
    return sorted(taken), sorted(late)


def without_encoder_attributes(body):
    """Header (as attributes) and everything behind the header of an EXR."""
    kept, at = [], 8
    while body[at]:
        name_end = body.index(b"\0", at)
        type_end = body.index(b"\0", name_end + 1)
        end = type_end + 5 + int.from_bytes(body[type_end + 1:type_end + 5], "little")
        if not body[at:name_end].startswith(b"encoder"):
            kept.append(body[at:end])
        at = end
    chunks = int.from_bytes(body[at + 1:at + 9], "little") - (at + 1)  # the table of offsets
    return kept, body[at + 1 + chunks:]


class EncoderChecks(Scenario):
    def daemon(self, config):
        return Daemon("--config", self.write("flared.toml", config))

    def encoder(self, daemon, name):
        listed = self.assert_ok(daemon.get("/v1/encoders")).json()["encoders"]
        return next(encoder for encoder in listed if encoder["name"] == name)

    def sender(self, port, make, interval_s=0.003):
        """Sends make(i) to the port, i = 0, 1, ..., until the test is over."""
        stop = threading.Event()
        link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

        def run():
            count = 0
            while not stop.wait(interval_s):
                link.sendto(make(count), ("127.0.0.1", port))
                count += 1

        thread = threading.Thread(target=run)

        def end():
            if stop.is_set():
                return
            stop.set()
            thread.join()
            link.close()

        thread.start()
        self.addCleanup(end)
        return end

    def assert_equals_numbers(self, daemon, request, reply):
        """The same picture, to the byte but for the encoder's attributes, from written numbers."""
        report = self.assert_ok(daemon.get("/v1/reports/" + reply.report["id"])).json()
        numbers = {key: value for key, value in request.items() if not key.startswith("encoder")}
        numbers["f_number"] = report["f_number"]
        for key in ("focus_m", "zoom_mm"):
            if report["encoder"].get(key) is not None:
                numbers[key] = report["encoder"][key]
        written = self.assert_ok(daemon.flare(numbers))
        self.assertEqual(without_encoder_attributes(reply.body),
                         without_encoder_attributes(written.body))
        # The header has the same numbers to the last digit.
        state = json.loads(exr_attributes(reply.body)["encoderState"])
        self.assertEqual({key: value for key, value in state.items() if value is not None},
                         {key: numbers[key] for key, value in state.items() if value is not None})
        return report
