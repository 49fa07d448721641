#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws columns of a CSV file as lines in an SVG.

    tests/bench/plot.py FILE.csv X Y[,Y...] -o FILE.svg [--log] [--group COLUMN] [--title TEXT]

Empty fields are left out; `--log` makes both axes logarithmic; `--group` draws a line for each value of
that column.
"""
import argparse
import csv
import html
import math

WIDTH, HEIGHT = 720, 420
LEFT, RIGHT, TOP, BOTTOM = 70, 20, 40, 50
COLOURS = ("#1b6ca8", "#c0392b", "#2e8b57", "#8e44ad", "#b9770e", "#34495e", "#16a085", "#d35400")


def ticks(low, high, logarithmic):
    """Round values from low to high."""
    if logarithmic:
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        few = len(decades) > 3
        values = [m * 10.0 ** d for d in decades for m in ((1,) if few else (1, 2, 5))]
    else:
        step = 10.0 ** math.floor(math.log10((high - low) / 4 or 1))
        step *= next(m for m in (1, 2, 5, 10) if (high - low) / (step * m) <= 6)
        values = [step * k for k in range(math.floor(low / step), math.ceil(high / step) + 1)]
    return [v for v in values if low * (1 - 1e-9) - 1e-12 <= v <= high * (1 + 1e-9)]


class Axis:
    def __init__(self, values, start, end, logarithmic, from_zero=False):
        low, high = min(values), max(values)
        if from_zero and not logarithmic:
            low = min(low, 0.0)
        if low == high:
            high = low + (abs(low) or 1.0)
        self.low, self.high, self.start, self.end = low, high, start, end
        self.logarithmic = logarithmic

    def place(self, value):
        def scaled(v):
            return math.log10(v) if self.logarithmic else v
        share = (scaled(value) - scaled(self.low)) / (scaled(self.high) - scaled(self.low))
        return self.start + share * (self.end - self.start)

    def ticks(self):
        return ticks(self.low, self.high, self.logarithmic)


def draw(lines, x_name, y_name, title, logarithmic):
    """`lines` is {name: [(x, y), ...]}; the SVG's text."""
    points = [p for line in lines.values() for p in line]
    x = Axis([p[0] for p in points], LEFT, WIDTH - RIGHT, logarithmic)
    y = Axis([p[1] for p in points], HEIGHT - BOTTOM, TOP, logarithmic, from_zero=True)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="20" font-size="14">{html.escape(title)}</text>']
    for value in x.ticks():
        at = x.place(value)
        out.append(f'<path d="M{at:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                   f'<text x="{at:.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">'
                   f'{value:g}</text>')
    for value in y.ticks():
        at = y.place(value)
        out.append(f'<path d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{value:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 12}" text-anchor="middle">'
               f'{html.escape(x_name)}</text>')
    out.append(f'<text transform="translate(16 {(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)" '
               f'text-anchor="middle">{html.escape(y_name)}</text>')
    for n, (name, line) in enumerate(lines.items()):
        colour = COLOURS[n % len(COLOURS)]
        way = " ".join(f"{x.place(a):.1f},{y.place(b):.1f}" for a, b in line)
        if len(line) <= 30:
            out += [f'<circle cx="{x.place(a):.1f}" cy="{y.place(b):.1f}" r="2.5" '
                    f'fill="{colour}"/>' for a, b in line]
        out.append(f'<polyline points="{way}" fill="none" stroke="{colour}" stroke-width="1.3"/>')
        out.append(f'<text x="{LEFT + 10}" y="{TOP + 16 + 15 * n}" fill="{colour}">'
                   f'{html.escape(name)}</text>')
    return "\n".join(out) + "\n</svg>\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file")
    parser.add_argument("x")
    parser.add_argument("y")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--log", action="store_true")
    parser.add_argument("--group")
    parser.add_argument("--title", default="")
    options = parser.parse_args()
    lines = {}
    with open(options.file, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for column in options.y.split(","):
                name = f"{row[options.group]}" if options.group else column
                if options.group and "," in options.y:
                    name += " " + column
                if row[options.x] == "" or row[column] == "":
                    continue
                point = (float(row[options.x]), float(row[column]))
                if not options.log or min(point) > 0:
                    lines.setdefault(name, []).append(point)
    if not lines:
        raise SystemExit(f"{options.file}: nothing to draw")
    with open(options.output, "w", encoding="utf-8") as file:
        file.write(draw(lines, options.x, options.y, options.title or options.file, options.log))


if __name__ == "__main__":
    main()
