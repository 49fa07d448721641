#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From a request to the last byte of its reply in a client on the Unix socket, against what rendering
took by the report of the same reply: what is left is reading the request, encoding and sending.

    tests/bench/reply_time.py [--f-number N] [--width W] [--height H] [--repeats N] [--preset P]

Starts build/release/bin/flared (or $FLARED) itself. Prints a Markdown table of medians, ms.
"""
import argparse
import json
import os
import socket
import statistics
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenario"))
from harness import LENS, Daemon  # noqa: E402

STAGES = ("setup", "cull", "mesh", "raster", "resolve")


class Client:
    """One connection, kept alive, that receives into the same memory again and again."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(path)
        self.buffer = memoryview(bytearray(256 << 20))

    def ask(self, body, accept):
        """(milliseconds, bytes of the body, work by the report)."""
        head = (f"POST /v1/flare HTTP/1.1\r\nHost: flared\r\nAccept: {accept}\r\n"
                f"Content-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n")
        start = time.perf_counter()
        self.socket.sendall(head.encode() + body)
        have = 0
        while b"\r\n\r\n" not in bytes(self.buffer[:min(have, 16384)]):
            have += self.received(have)
        fields = bytes(self.buffer[:have]).split(b"\r\n\r\n")[0]
        lines = dict(line.split(": ", 1) for line in fields.decode().split("\r\n")[1:])
        size = int(lines["Content-Length"])
        while have < len(fields) + 4 + size:
            have += self.received(have)
        wall_ms = 1e3 * (time.perf_counter() - start)
        return wall_ms, size, json.loads(lines["Flare-Report"])["work"]

    def received(self, have):
        count = self.socket.recv_into(self.buffer[have:])
        if count == 0:
            raise SystemExit("the daemon closed the connection")
        return count


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--f-number", type=float, default=4.0)
    parser.add_argument("--width", type=int, default=1920)
    parser.add_argument("--height", type=int, default=1080)
    parser.add_argument("--repeats", type=int, default=25)
    parser.add_argument("--preset", default="preview")
    options = parser.parse_args()
    request = {"lens": LENS, "f_number": options.f_number,
               "image": {"width": options.width, "height": options.height, "sensor_width_mm": 36},
               "lights": [{"direction": [-0.0872, 0, 0.9962], "irradiance": [1, 1, 1]}],
               "quality": {"preset": options.preset}}
    exr = "image/x-exr"
    cases = [("EXR none", exr, {"compression": "none"}), ("EXR zip", exr, {"compression": "zip"}),
             ("half planes", "application/x-flare-half", {})]
    print(f"{options.preset}, f/{options.f_number:g}, {options.width} x {options.height}, "
          f"medians of {options.repeats}, ms\n")
    print("| reply | bytes | whole | render | encode | whole less render | least |")
    print("|---|---|---|---|---|---|---|")
    with Daemon(tcp=False) as daemon:
        client = Client(daemon.socket_path)
        for name, accept, output in cases:
            body = json.dumps({**request, "output": output}).encode()
            for _ in range(3):
                client.ask(body, accept)
            asked = [client.ask(body, accept) for _ in range(options.repeats)]
            render = [sum(work["time_ms"][stage] for stage in STAGES) for _, _, work in asked]
            rest = [wall - ms for (wall, _, _), ms in zip(asked, render)]
            print(f"| {name} | {asked[0][1]} | {statistics.median(a[0] for a in asked):.1f} "
                  f"| {statistics.median(render):.1f} "
                  f"| {statistics.median(a[2]['time_ms']['encode'] for a in asked):.1f} "
                  f"| {statistics.median(rest):.1f} | {min(rest):.1f} |", flush=True)


if __name__ == "__main__":
    main()
