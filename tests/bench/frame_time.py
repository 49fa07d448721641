#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How long a frame of the seed lens takes from a request on the daemon's Unix socket to its report: the
stages of the reply's own report but for the encoding, medians.

  again    the light is as before: its ghosts are kept as they were drawn
  iris     the stop is another each time: meshes are in memory, ghosts are made anew
  moved    the light is 0.05 degrees farther each time: nothing is known of it

usage: frame_time.py [--frames N] [--ringing off|auto] [--lens NAME] [--f-numbers 2 4 8]
                     [--presets draft preview final]      (after a release build)
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/scenario"))

from harness import Daemon  # noqa: E402

STAGES = ("setup", "cull", "mesh", "raster", "resolve")


def request(options, preset, f_number, angle_deg):
    angle = math.radians(angle_deg)
    return {
        "lens": options.lens, "f_number": f_number, "layers": ["ghosts"],
        "model": {"ringing": options.ringing}, "quality": {"preset": preset},
        "image": {"width": options.width, "height": options.width * 9 // 16,
                  "sensor_width_mm": 36.0},
        "lights": [{"direction": [math.sin(angle), 0.0, math.cos(angle)],
                    "irradiance": [1.0, 1.0, 1.0]}],
        "output": {"compression": "none"},
    }


def render_ms(daemon, body):
    reply = daemon.flare(body)
    if reply.status != 200:
        sys.exit(reply.body[:500])
    times = daemon.get("/v1/reports/" + reply.report["id"]).json()["work"]["time_ms"]
    return [times[stage] for stage in STAGES]


def frames(daemon, options, preset, f_number, case):
    rows = []
    for n in range(options.frames + 1):
        angle = 5.0 + (0.05 * (n + 1) if case == "moved" else 0.0)
        f = f_number * (1.0 + 0.002 * (n + 1)) if case == "iris" else f_number
        rows.append(render_ms(daemon, request(options, preset, f, angle)))
    return rows[1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=9)
    parser.add_argument("--ringing", default="off")
    parser.add_argument("--lens", default="tronnier-double-gauss-50mm-f2")
    parser.add_argument("--width", type=int, default=1920)
    parser.add_argument("--f-numbers", type=float, nargs="+", default=[2.0, 4.0, 8.0])
    parser.add_argument("--presets", nargs="+", default=["draft", "preview", "final"])
    parser.add_argument("--cases", nargs="+", default=["again", "iris", "moved"])
    options = parser.parse_args()
    print("load of the machine:", " ".join(f"{x:.1f}" for x in os.getloadavg()),
          f"on {os.cpu_count()} cores")
    print("| preset | f | case | frame, ms | least | " + " | ".join(STAGES) + " |")
    print("|---" * (5 + len(STAGES)) + "|")
    for preset in options.presets:
        for f_number in options.f_numbers:
            with Daemon("--disk-cache", "") as daemon:
                for case in options.cases:
                    rows = frames(daemon, options, preset, f_number, case)
                    whole = [sum(row) for row in rows]
                    stages = [statistics.median(row[i] for row in rows)
                              for i in range(len(STAGES))]
                    print(f"| {preset} | {f_number:g} | {case} | {statistics.median(whole):.1f} "
                          f"| {min(whole):.1f} | "
                          + " | ".join(f"{stage:.1f}" for stage in stages) + " |", flush=True)


if __name__ == "__main__":
    main()
