#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How long from a record that a USB encoder has ready to the state that requests see, and whether any
of 285 records a second from two devices is lost; idle, and while 64 requests are asked for at once.

The devices are played by tests/support/usb_simulator.cpp, whose own delays (every ioctl goes through a
socket and one thread) are part of what is measured. The count of the QSB is the time at which its record
was due. "late" is a record that was due and that GET /v1/encoders did not show yet, and for how long.

usage: encoder_latency.py    (after a release build)
"""
import os
import pathlib
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/scenario"))
os.environ.setdefault("USB_SIMULATOR", str(ROOT / "build/release/bin/usb_simulator"))

from encoder_checks import PERIOD_US, hardware_goes_first, latencies_ms  # noqa: E402
from harness import Daemon, at_once, eventually, small_request  # noqa: E402
from usb_encoder_scenario import Bus, COOKE, QSB  # noqa: E402

POLLS = 1000


def say(what, found):
    for name, times in zip(("due to read", "late"), found):
        print(f"{what}, {name}: median {times[len(times) // 2]:.2f} ms, "
              f"p99 {times[len(times) * 99 // 100]:.2f} ms, largest {times[-1]:.2f} ms")


def main():
    folder = os.path.join("/tmp", f"encoder_latency_{os.getpid()}.toml")
    pathlib.Path(folder).write_text(QSB + COOKE)
    with Bus() as bus, Daemon("--config", folder) as daemon:
        offset_s = time.time() - time.monotonic()
        if not hardware_goes_first(bus.process.pid):
            print("the devices are played without priority: their own delays count")
        bus("add q qsb 1")
        bus("clock q")
        bus("add c cooke FT0001")
        bus("set c 2500 280")
        for name in "qc":
            bus(f"period {name} {PERIOD_US}")
        both = lambda: all(e["health"] == "live"
                           for e in daemon.get("/v1/encoders").json()["encoders"])
        if not eventually(both):
            sys.exit("the encoders did not come up: " + daemon.log())
        print("load of the machine:", " ".join(f"{x:.1f}" for x in os.getloadavg()),
              f"on {os.cpu_count()} cores")
        say("idle", latencies_ms(daemon, offset_s, POLLS))
        stop = threading.Event()

        def load():
            while not stop.is_set():
                at_once(64, lambda i: daemon.flare(small_request(f_number=4 + i / 10)))

        loader = threading.Thread(target=load)
        loader.start()
        say("64 requests at once", latencies_ms(daemon, offset_s, POLLS))
        stop.set()
        loader.join()
        for name in "qc":
            bus(f"fault {name} silence")
        sent = {name: int(bus("sent " + name).split()[0]) for name in "qc"}
        for device, name in (("q", "ring"), ("c", "A-cam")):
            got = lambda n=name: daemon.metric(f"flared_encoder_samples_total{{name={n}}}")
            eventually(lambda d=device, g=got: g() == sent[d], 5)
            print(f"{name}: {sent[device]} records sent, {got():.0f} taken")
    os.unlink(folder)


if __name__ == "__main__":
    main()
