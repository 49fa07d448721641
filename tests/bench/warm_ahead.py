#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What warming ahead of a lens ring is worth: a ring that turns evenly, at some steps a second, while a
draft is asked for three times a second. The light stands at a pixel, so that its direction follows the
focus and each step of the ring has its own meshes. The share of pictures that had to trace no mesh, and how long
they took; "still" is a ring that stands, "jumps" one that is somewhere else each time, which nobody can
foresee. Then what that does to others: how long a small picture takes that has its meshes, asked for again
and again, while the ring stands and while it turns, with nothing to trace and always something to trace.

usage: warm_ahead.py    (after a release build)
"""
import os
import pathlib
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/scenario"))

from harness import Daemon  # noqa: E402

LENS, EFL_MM = "tronnier-double-gauss-50mm-f2", 50.35816695831366
STEP = 1e3 * 0.01 / EFL_MM**2  # of 1/m, server/translate/ring_steps.h
SECONDS, RATE_HZ = 8, 3


def script(folder, name, cell_at):
    """A ring for the time of the measurement, from cell_at(seconds) in steps."""
    path = folder / name
    lines = ["time_s,focus_m"]
    for i in range(200 * (SECONDS + 8)):
        lines.append(f"{i / 200},{1 / (STEP * cell_at(i / 200))}")
    path.write_text("\n".join(lines) + "\n")
    return f'[[encoder]]\nname = "ring"\nkind = "script"\nfile = "{path}"\n'


def measure(what, config, folder):
    path = folder / "flared.toml"
    path.write_text(config)
    request = {"lens": LENS, "encoder": "ring", "quality": {"preset": "draft"}, "f_number": 4,
               "image": {"width": 480, "height": 270, "sensor_width_mm": 36},
               "lights": [{"pixel": [150, 90]}], "model": {"ringing": "off"},
               "output": {"compression": "none"}}
    with Daemon("--config", str(path)) as daemon:
        for _ in range(3):
            daemon.flare(request)
        times, hits = [], 0
        next_s = time.monotonic()
        end_s = next_s + SECONDS
        while time.monotonic() < end_s:
            next_s = max(next_s + 1 / RATE_HZ, time.monotonic())
            time.sleep(max(0.0, next_s - time.monotonic()))
            start = time.monotonic()
            reply = daemon.flare(request)
            times.append(1e3 * (time.monotonic() - start))
            hits += reply.report["work"]["mesh_cache_misses"] == 0
        warmed = daemon.metric("flared_encoder_states_warmed_total{name=ring}")
    times.sort()
    print(f"{what:>20}: {100 * hits / len(times):3.0f} % traced nothing, median "
          f"{times[len(times) // 2]:4.0f} ms, p99 {times[len(times) * 99 // 100]:4.0f} ms, "
          f"{warmed:.0f} states warmed", flush=True)


def beside(what, config, folder):
    """A picture of other numbers every 30 ms; the encoder is named once a second, to be followed."""
    path = folder / "flared.toml"
    path.write_text(config)
    ring = {"lens": LENS, "encoder": "ring", "quality": {"preset": "draft"}, "f_number": 4,
            "image": {"width": 32, "height": 18, "sensor_width_mm": 36},
            "lights": [{"pixel": [10, 6]}], "model": {"ringing": "off"}}
    other = {**ring, "focus_m": 7}
    del other["encoder"]
    with Daemon("--config", str(path)) as daemon:
        daemon.flare(other)
        times, end_s, named_s = [], time.monotonic() + SECONDS, 0.0
        while time.monotonic() < end_s:
            if time.monotonic() > named_s + 1:
                named_s = time.monotonic()
                daemon.flare(ring)
            time.sleep(0.03)
            start = time.monotonic()
            daemon.flare(other)
            times.append(1e3 * (time.monotonic() - start))
        traced = daemon.metric("flared_mesh_cache_misses_total")
    times.sort()
    print(f"{what:>20}: a picture beside it: median {times[len(times) // 2]:4.1f} ms, p99 "
          f"{times[len(times) * 99 // 100]:4.1f} ms, {traced:.0f} meshes traced", flush=True)


def main():
    print("load of the machine:", " ".join(f"{x:.1f}" for x in os.getloadavg()),
          f"on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        measure("still", script(folder, "still.csv", lambda t: 200.1), folder)
        for speed in (1, 3, 10, 30):
            measure(f"{speed} steps a second",
                    script(folder, f"{speed}.csv", lambda t, v=speed: 100.1 + v * t % 380), folder)
        measure("jumps", script(folder, "jumps.csv",
                                lambda t: 20.1 + int(t * 20) * 137 % 460), folder)
        beside("still", script(folder, "still.csv", lambda t: 200.1), folder)
        beside("3 steps a second", script(folder, "3.csv", lambda t: 100.1 + 3 * t), folder)
        beside("10 steps a second", script(folder, "10.csv", lambda t: 100.1 + 10 * t), folder)


if __name__ == "__main__":
    main()
