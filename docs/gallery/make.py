#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders every picture of the gallery from the request files beside it, by `flare render`.

A picture is one request, or several in a row; those of a row share one exposure unless said
otherwise. The two pictures with rays beside them are bokeh.py's. Only Python's standard library is
used.

usage: docs/gallery/make.py [--flare PROGRAM] [--out FOLDER] [NAME ...]
"""

import argparse
import array
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
GAP = 4                                 # grey pixels between panels

# Name: panels by row; stops that the exposure is moved by; whether the panels share one exposure.
PICTURES = {
    "fringes": ([["fringes"]], 0.0, True),
    "sun": ([["sun"]], 1.0, True),
    "street-lamps": ([["street-lamps"]], 1.0, True),
    "two-lenses": ([["two-lenses-100", "two-lenses-85"]], 0.0, False),
    "star-iris": ([["star-iris"]], 0.0, True),
    "heart-iris": ([["heart-iris"]], 0.0, True),
    "anamorphic": ([["anamorphic"]], 0.0, True),
    "zoom": ([["zoom-70", "zoom-200"]], 0.0, False),
    "f-numbers": ([["f-numbers-2", "f-numbers-2_8", "f-numbers-4"],
                   ["f-numbers-8", "f-numbers-16", "f-numbers-22"]], 0.0, False),
    "source-size": ([["source-size-point", "source-size-sun", "source-size-2"]], 0.0, True),
    "coatings": ([["coatings-none", "coatings-own"]], 0.0, True),
    "fisheye": ([["fisheye"]], 0.0, True),
    "blades": ([["blades-5", "blades-6", "blades-9"]], 0.0, True),
    "bokeh-ghosts": ([["bokeh-ghosts"]], 0.0, True),
}


class Panel:
    """One request's R, G and B as half floats."""

    def __init__(self, flare, name):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "a.half"
            done = subprocess.run([flare, "render", str(HERE / f"{name}.json"), "-o", str(out)],
                                  capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise SystemExit(f"{name}: {done.stderr}")
            data = out.read_bytes()
        _, _, self.width, self.height, _, length = struct.unpack_from("<4s5I", data)
        names = data[64:64 + length].split(b"\0")
        count = self.width * self.height
        self.channels = []
        for wanted in (b"R", b"G", b"B"):
            first = 64 + length + 2 * count * names.index(wanted)
            self.channels.append(array.array("H", data[first:first + 2 * count]))

    def bright(self):
        """What one lit pixel in two hundred exceeds."""
        value = struct.unpack(f"<{1 << 16}e", struct.pack(f"<{1 << 16}H", *range(1 << 16)))
        lit = sorted(v for k in zip(*self.channels) if (v := max(value[c] for c in k)) > 0.0)
        return lit[int(0.995 * (len(lit) - 1))] if lit else 1.0

    def rows(self, white):
        """As sRGB bytes, with a shoulder in place of a clip; `white` comes out at 80 % grey."""
        table = bytearray(1 << 16)
        for bits, (value,) in enumerate(struct.iter_unpack("<e", struct.pack(
                f"<{1 << 16}H", *range(1 << 16)))):
            if value > 0.0:
                shown = 1.0 - math.exp(-min(value / white, 1e3))
                table[bits] = round(255 * (12.92 * shown if shown <= 0.0031308
                                           else 1.055 * shown ** (1 / 2.4) - 0.055))
        planes = [bytes(table[c] for c in channel) for channel in self.channels]
        every = bytearray(3 * self.width * self.height)
        for c, plane in enumerate(planes):
            every[c::3] = plane
        step = 3 * self.width
        return [bytes(every[j * step:(j + 1) * step]) for j in range(self.height)]


def filtered(row, above):
    """The row of a PNG as whichever of its filters leaves least."""
    left = bytes(3) + row[:-3]
    corner = bytes(3) + above[:-3]
    paeth = bytearray(len(row))
    for k, (x, a, b, c) in enumerate(zip(row, left, above, corner)):
        p, q, r = abs(b - c), abs(a - c), abs(a + b - 2 * c)
        paeth[k] = (x - (a if p <= q and p <= r else b if q <= r else c)) & 255
    tries = [(0, row), (1, bytes((x - a) & 255 for x, a in zip(row, left))),
             (2, bytes((x - b) & 255 for x, b in zip(row, above))), (4, bytes(paeth))]
    kind, best = min(tries, key=lambda t: sum(v if v < 128 else 256 - v for v in t[1]))
    return bytes([kind]) + best


def write_png(path, rows):
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    width = len(rows[0]) // 3
    raw = b"".join(filtered(row, rows[j - 1] if j else bytes(len(row)))
                   for j, row in enumerate(rows))
    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def make(flare, folder, name):
    grid, stops, shared = PICTURES[name]
    panels = [[Panel(flare, panel) for panel in row] for row in grid]
    brightest = max(panel.bright() for row in panels for panel in row)
    grey = bytes([90])
    rows = []
    for number, row in enumerate(panels):
        drawn = [p.rows((brightest if shared else p.bright()) / 1.6 * 2.0 ** -stops) for p in row]
        lines = [(grey * (3 * GAP)).join(parts) for parts in zip(*drawn)]
        if number:
            rows += [grey * len(lines[0])] * GAP
        rows += lines
    path = folder / f"{name}.png"
    write_png(path, rows)
    print(f"{name}.png {len(rows[0]) // 3} x {len(rows)}, {path.stat().st_size // 1024} kB",
          flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flare", default=str(ROOT / "build/release/bin/flare"))
    parser.add_argument("--out", type=pathlib.Path, default=HERE)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of pictures; none: all")
    options = parser.parse_args()
    for name in options.names or PICTURES:
        make(options.flare, options.out, name)
    if not options.names:
        subprocess.run([sys.executable, str(HERE / "bokeh.py"), "--flare", options.flare],
                       check=True)


if __name__ == "__main__":
    main()
