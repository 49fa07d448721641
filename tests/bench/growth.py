#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cost as the work grows: time and peak memory over the number of lights, of pixels and of ghosts.

    tests/bench/growth.py -o FOLDER [--only lights|pixels|ghosts] [--repeats N] [--quick]

Each case has a daemon of its own (build/release/bin/flared or $FLARED): asked once with nothing cached
and then again; its peak memory is the kernel's (VmHWM), meshes kept by the cache included. Writes
growth.csv and three drawings, and prints a table in which `exponent` is the slope from the case
before in double logarithm: 1 is linear growth.
"""
import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "scenario"))
from harness import FLARE, LENS, Daemon  # noqa: E402

STAGES = ("setup", "cull", "mesh", "raster", "resolve")
COLUMNS = ("series", "x", "ghosts_drawn", "cold_ms", "warm_ms", "peak_mb", "cache_mb")


def light(index):
    """Spread over the field, no two alike."""
    angle = 2.399963 * index
    radius = 0.03 + 0.2 * math.sqrt((index + 0.5) / 64)
    return {"direction": [radius * math.cos(angle), radius * math.sin(angle), 1.0],
            "irradiance": [1, 1, 1]}


def request(width=1920, height=1080, lights=1, **changes):
    return {"lens": LENS, "f_number": 4.0,
            "image": {"width": width, "height": height, "sensor_width_mm": 36.0},
            "lights": [light(20 + i) if lights == 1 else light(i) for i in range(lights)],
            "quality": {"preset": "preview"}, **changes}


def with_menisci(count):
    """The seed lens behind weak menisci: 10 + 2 count reflecting surfaces, each with its coating."""
    shown = subprocess.run([FLARE, "lens", "show", LENS, "--json"], capture_output=True, check=True)
    lens = json.loads(shown.stdout)
    front = []
    for number in range(count):
        radius_mm = 200.0 + 10.0 * number
        glass = {"nd": 1.5168, "vd": 64.2, "gap_mm": 1.5}
        for part in (glass, {"gap_mm": 0.7}):
            front.append({"kind": "sphere", "radius_mm": radius_mm, "semi_diameter_mm": 22, **part})
    return {"name": f"seed behind {count} menisci", "default_coating": lens["default_coating"],
            "surface": front + lens["surfaces"]}


def cases(quick):
    """(series, what grows, request)."""
    for lights in (1, 4, 16) if quick else (1, 2, 4, 8, 16, 32, 64):
        yield "lights", lights, request(480, 270, lights) if quick else request(lights=lights)
    sides = ((480, 270), (960, 540)) if quick else (
        (944, 531), (1336, 751), (1888, 1062), (2672, 1503), (3776, 2124))
    for width, height in sides:
        yield "pixels", width * height / 1e6, request(width, height)
    for menisci in (0, 5) if quick else (0, 2, 5, 10, 16):
        size = (480, 270) if quick else (1920, 1080)
        body = request(*size, prescription=with_menisci(menisci), model={"culling": "none"})
        del body["lens"]
        yield "ghosts", None, body


def peak_mb(daemon):
    with open(f"/proc/{daemon.process.pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024


def measure(series, x, body, repeats):
    text = json.dumps(body)
    with Daemon("--deadline-s", "600", tcp=False) as daemon:
        replies = [daemon.flare(text) for _ in range(repeats + 1)]
        for reply in replies:
            if reply.status != 200:
                raise SystemExit(reply.body.decode())
        times = [sum(reply.report["work"]["time_ms"][stage] for stage in STAGES)
                 for reply in replies]
        report = daemon.get("/v1/reports/" + replies[-1].report["id"]).json()
        drawn = sum(ghost["model"] != "culled" for ghost in report["ghosts"])
        return {"series": series, "x": len(report["ghosts"]) if x is None else x,
                "ghosts_drawn": drawn, "cold_ms": round(times[0], 1),
                "warm_ms": round(statistics.median(times[1:]), 1),
                "peak_mb": round(peak_mb(daemon)),
                "cache_mb": round(daemon.metric("flared_mesh_cache_bytes") / (1 << 20))}


def exponent(before, row, column):
    if before is None or before["series"] != row["series"] or before["x"] == row["x"]:
        return ""
    return f"{math.log(row[column] / before[column]) / math.log(row['x'] / before['x']):.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--only", choices=("lights", "pixels", "ghosts"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--quick", action="store_true", help="few cases, small pictures")
    options = parser.parse_args()
    os.makedirs(options.output, exist_ok=True)
    table = os.path.join(options.output, "growth.csv")
    print("| | | ghosts drawn | cold, ms | warm, ms | exponent | peak, MB | of it meshes |")
    print("|---|---|---|---|---|---|---|---|")
    before = None
    series_seen = []
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for series, x, body in cases(options.quick):
            if options.only and series != options.only:
                continue
            row = measure(series, x, body, options.repeats)
            writer.writerow(row)
            file.flush()
            print(f"| {series} | {row['x']:.3g} | {row['ghosts_drawn']} | {row['cold_ms']} "
                  f"| {row['warm_ms']} | {exponent(before, row, 'warm_ms')} | {row['peak_mb']} "
                  f"| {row['cache_mb']} |", flush=True)
            before = row
            if series not in series_seen:
                series_seen.append(series)
    for series in series_seen:
        part = os.path.join(options.output, f"growth_{series}.csv")
        with open(table, newline="", encoding="utf-8") as whole, \
                open(part, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(row for row in csv.DictReader(whole) if row["series"] == series)
        subprocess.run([sys.executable, os.path.join(HERE, "plot.py"), part, "x",
                        "cold_ms,warm_ms,peak_mb", "--log", "--title", f"over {series}",
                        "-o", part.replace(".csv", ".svg")], check=True)


if __name__ == "__main__":
    main()
