#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Are a request's max_error and time_budget_ms kept? Random requests from a seed (lens, lights, iris),
each asked for by an error, by a time and at `reference`; the pictures are compared.

    tests/bench/plan_check.py [--requests N] [--seed S] [--width W] [--height H] [-o FILE.csv]
    tests/bench/plan_check.py --errors-only --lens NAME ... [-o FILE.csv]
    tests/bench/plan_check.py --summarise FILE.csv ...

Starts build/release/bin/flared (or $FLARED) itself. A reference picture takes seconds to minutes, so
300 requests take hours; Ctrl-C ends it early. Prints a Markdown table and writes one CSV row a
request. --errors-only asks for no times, which a busy machine does not keep; --summarise makes one
table of the files of several runs.
"""
import argparse
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenario"))
from harness import FLARE, Daemon, Reply, UnixConnection  # noqa: E402


def lenses():
    """Name, widest f-number and half field in degrees of every lens of the library."""
    names = subprocess.run([FLARE, "lens", "list"], check=True, capture_output=True, text=True)
    found = []
    for line in names.stdout.splitlines():
        name = line.split()[0]
        shown = subprocess.run([FLARE, "lens", "show", name, "--json"], capture_output=True, text=True)
        if shown.returncode == 0:
            lens = json.loads(shown.stdout)
            found.append((name, lens["f_number"], lens["efl_mm"]))
    return found


def random_request(draw, lens, width, height):
    name, widest, efl_mm = lens
    half_deg = math.degrees(math.atan(18.0 / abs(efl_mm)))
    lights = []
    for _ in range(draw.choice([1, 1, 2, 3])):
        field = math.radians(draw.uniform(0.0, 1.2 * half_deg))
        turn = draw.uniform(-math.pi, math.pi)
        light = {"direction": [math.sin(field) * math.cos(turn), math.sin(field) * math.sin(turn),
                               math.cos(field)],
                 "irradiance": [round(10.0 ** draw.uniform(-1, 1), 3) for _ in range(3)]}
        if draw.random() < 0.25:
            light["distance_m"] = round(10.0 ** draw.uniform(0.3, 2), 2)
        lights.append(light)
    return {"lens": name, "f_number": round(widest * 2.0 ** draw.uniform(0.0, 4.0), 2),
            "iris": {"blades": draw.choice([0, 5, 6, 7, 8, 9]), "roundness": draw.choice([0, 0.3]),
                     "rotation_deg": round(draw.uniform(0, 60), 1)},
            "image": {"width": width, "height": height, "sensor_width_mm": 36.0}, "lights": lights,
            "output": {"pixel": "float"}}


def ask(daemon, request, quality, path):
    """The report of a picture that is left in the file; None if the request is refused."""
    connection = UnixConnection(daemon.socket_path, timeout=3600)
    connection.request("POST", "/v1/flare", body=json.dumps({**request, "quality": quality}),
                       headers={"Content-Type": "application/json"})
    reply = Reply(connection.getresponse())
    connection.close()
    if reply.status != 200:
        return None
    with open(path, "wb") as out:
        out.write(reply.body)
    return reply.report


def rel_l1(path, reference):
    compared = subprocess.run([FLARE, "compare", path, reference, "--json"], check=True,
                              capture_output=True, text=True)
    metrics = json.loads(compared.stdout)
    return metrics.get("all", metrics)["rel_l1"]


def check(daemon, request, draw, folder, with_time, truth):
    error = round(10.0 ** draw.uniform(math.log10(0.005), -1.0), 4)
    shorten = 10.0 ** draw.uniform(-0.5, 0.7)
    reference, by_error, by_time = (os.path.join(folder, f"{n}.exr") for n in ("r", "e", "t"))
    if ask(daemon, request, truth, reference) is None:
        return None
    of_error = ask(daemon, request, {"max_error": error}, by_error)
    row = {"lens": request["lens"], "f_number": request["f_number"], "max_error": error,
           "error": rel_l1(by_error, reference), "estimated": of_error["estimated_error"]["rel_l1"],
           "tolerance": of_error["plan"]["tolerance"],
           "pictures": of_error["work"]["search"]["pictures"],
           "took_ms": of_error["work"]["search"]["total_ms"]}
    if not with_time:
        return row
    preview = ask(daemon, request, {"preset": "preview"}, by_time)
    preview = ask(daemon, request, {"preset": "preview"}, by_time)  # warm
    preview_ms = sum(v for k, v in preview["work"]["time_ms"].items() if k != "encode")
    budget = round(preview_ms * shorten, 2)
    ask(daemon, request, {"time_budget_ms": budget}, by_time)  # finds its meshes
    of_time = ask(daemon, request, {"time_budget_ms": budget}, by_time)
    return {**row, "preview_ms": preview_ms, "budget_ms": budget,
            "used_ms": of_time["work"]["search"]["total_ms"],
            "budget_tolerance": of_time["plan"]["tolerance"],
            "budget_error": rel_l1(by_time, reference),
            "overruns": of_time["work"]["search"]["overruns"]}


def share(rows, kept):
    return sum(1 for row in rows if kept(row)) / len(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--requests", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--height", type=int, default=270)
    parser.add_argument("--lens", action="append", help="one of these instead of any")
    parser.add_argument("-o", "--output", default="plan_check.csv")
    parser.add_argument("--errors-only", action="store_true", help="no requests by time")
    parser.add_argument("--truth", type=float, metavar="TOLERANCE",
                        help="compare with this instead of `reference`, which takes longer")
    parser.add_argument("--summarise", nargs="+", metavar="CSV", help="of earlier runs; asks nothing")
    options = parser.parse_args()
    if options.summarise:
        summarise([row for path in options.summarise for row in read_rows(path)])
        return
    truth = {"tolerance": options.truth} if options.truth else {"preset": "reference"}
    draw = random.Random(options.seed)
    library = [l for l in lenses() if not options.lens or l[0] in options.lens]
    rows = []
    with tempfile.TemporaryDirectory() as folder, Daemon(tcp=False) as daemon, \
            open(options.output, "w", newline="") as out:
        table = None
        try:
            for n in range(options.requests):
                request = random_request(draw, draw.choice(library), options.width, options.height)
                row = check(daemon, request, draw, folder, not options.errors_only, truth)
                print(f"\r{n + 1} of {options.requests}", end="", file=sys.stderr)
                if row is None:
                    continue
                table = table or csv.DictWriter(out, row.keys())
                if not rows:
                    table.writeheader()
                table.writerow(row)
                out.flush()
                rows.append(row)
        except KeyboardInterrupt:
            pass
    print(file=sys.stderr)
    summarise(rows)


def read_rows(path):
    """As they were written: numbers as numbers."""
    with open(path, newline="") as file:
        return [{key: value if key == "lens" else float(value) for key, value in row.items()}
                for row in csv.DictReader(file)]


def summarise(rows):
    lit = [row for row in rows if math.isfinite(row["error"])]
    if not lit:
        print("no request had light in its picture")
        return
    print(f"| {len(lit)} requests | |\n|---|---|")
    print(f"| error within max_error | {share(lit, lambda r: r['error'] <= r['max_error']):.1%} |")
    print(f"| within twice that | {share(lit, lambda r: r['error'] <= 2 * r['max_error']):.1%} |")
    print(f"| estimate within max_error | "
          f"{share(lit, lambda r: r['estimated'] <= r['max_error']):.1%} |")
    timed = [row for row in rows if "budget_ms" in row]
    if timed:
        print(f"| time within 1.15 budgets | "
              f"{share(timed, lambda r: r['used_ms'] <= 1.15 * r['budget_ms']):.1%} |")


if __name__ == "__main__":
    main()
