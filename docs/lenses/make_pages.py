#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the pages of the lens library: docs/lenses/NAME.md with the lens's drawing, prescription,
first-order and field data, strongest ghosts and a flare at two apertures, and README.md, their list.

Everything comes from the `flare` program; only Python's standard library is used. A page is made
anew where the lens file or this script is newer than it, or with --all.

usage: docs/lenses/make_pages.py [--all] [--flare PROGRAM] [LENS ...]
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LENSES = ROOT / "lenses"

WIDTH, HEIGHT = 224, 126
LIGHT_PIXEL = [62, 38]       # up and left of the middle
IRRADIANCE = 40.0
STOPPED_DOWN = 8.0
STRONGEST = 10               # ghosts in the list
MOST_PICTURE_BYTES = 60_000


class Progress:
    """One line that is rewritten, on standard error, if a person watches."""

    def __init__(self, count):
        self.count, self.done = count, 0
        self.watched = sys.stderr.isatty()

    def show(self, what):
        if self.watched:
            filled = 30 * self.done // max(1, self.count)
            bar = "#" * filled + "." * (30 - filled)
            print(f"\r[{bar}] {self.done}/{self.count} {what[:40]:40}", end="", file=sys.stderr)
        self.done += 1

    def end(self):
        if self.watched:
            print("\r" + " " * 90 + "\r", end="", file=sys.stderr)


def run(program, *arguments, text=None):
    done = subprocess.run([program, *arguments], input=text, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"make_pages: {program} {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def number(value, digits=3):
    if value is None:
        return ""
    text = f"{value:.{digits}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def frame_width(lens):
    """Of a 16:9 frame that the image circle just holds, mm."""
    circle = lens["design"].get("image_circle_mm") or 43.3
    return round(circle * 16 / (16 ** 2 + 9 ** 2) ** 0.5, 2)


def request_for(lens, f_number):
    return {"lens": lens["name"], "f_number": f_number,
            "iris": {"blades": 7, "roundness": 0.2},
            "image": {"width": WIDTH, "height": HEIGHT, "sensor_width_mm": frame_width(lens)},
            "lights": [{"pixel": LIGHT_PIXEL, "irradiance": [IRRADIANCE] * 3}]}


def render(program, lens, f_number, picture):
    """The picture at an f-number; returns the report."""
    report = run(program, "render", "-", "-o", str(picture), "--report", "-",
                 text=json.dumps(request_for(lens, f_number)))
    size = picture.stat().st_size
    if size > MOST_PICTURE_BYTES:
        sys.exit(f"make_pages: {picture.name} has {size} bytes")
    return json.loads(report)


def surfaces(lens):
    rows = []
    for i, surface in enumerate(lens["surfaces"]):
        radius = surface.get("radius_mm")
        radii = [number(r, 4) for r in (surface.get("radius_x_mm"), surface.get("radius_y_mm")) if r]
        glass = surface.get("glass", "")
        shape = number(radius, 4) if radius else " / ".join(radii)
        terms = ""
        if surface.get("conic"):
            terms += f" k {surface['conic']:g}"
        for k, term in enumerate(surface.get("asphere") or []):
            terms += f" a{2 * k + 4} {term:.4g}" if term else ""
        rows.append([i, surface.get("kind", "sphere") + terms, shape,
                     number(surface.get("gap_mm"), 4), glass or number(surface.get("nd"), 5),
                     number(surface.get("vd"), 2), number(surface.get("semi_diameter_mm"), 3),
                     surface.get("coating", "")])
    return table(["#", "kind", "radius mm", "gap mm", "n_d or glass", "V_d", "semi-diameter mm",
                  "coating"], rows)


def first_order(lens):
    rows = []
    for label, part in ([("", lens)] if lens["squeeze"] == 1
                        else [(" in x", lens["x"]), (" in y", lens["y"])]):
        rows += [["focal length" + label, number(part["efl_mm"], 4) + " mm"],
                 ["back focus" + label, number(part["bfl_mm"], 4) + " mm"],
                 ["entrance pupil" + label,
                  f"{number(part['entrance_pupil']['diameter_mm'])} mm wide, "
                  f"{number(part['entrance_pupil']['z_mm'])} mm behind vertex 0"],
                 ["exit pupil" + label,
                  f"{number(part['exit_pupil']['diameter_mm'])} mm wide"]]
    rows += [["f-number", f"{number(lens['f_number'], 4)}, with the rims "
                          f"{number(lens['working_f_number'], 4)}"],
             ["axial transmittance at the d line", number(lens["t_axis"], 4)]]
    if lens["squeeze"] != 1:
        rows.append(["squeeze", number(lens["squeeze"], 4)])
    for key, label in (("focal_mm", "focal length"), ("f_number", "f-number")):
        if key in lens["design"]:
            rows.append([label + " by design", number(lens["design"][key], 3)])
    return table(["", ""], rows)


def field(lens):
    rows = []
    for row in lens["field"]["tables"][0]["rows"][::2]:
        distortion = row.get("distortion")
        rows.append([number(row["field_deg"], 2), number(row["image_height_mm"], 2),
                     "" if distortion is None else f"{100 * distortion:.2f}",
                     f"{100 * row['relative_illumination']:.1f}",
                     f"{100 * row['beam_share']:.1f}"])
    return table(["field °", "image mm", "distortion %", "illumination %", "beam %"], rows)


def ghosts(report):
    ranked = sorted(report["ghosts"], key=lambda ghost: -ghost["flux_mm2"])[:STRONGEST]
    return table(["reflected at", "flux, mm² of E0"],
                 [[", ".join(map(str, ghost["sequence"])), f"{ghost['flux_mm2']:.3g}"]
                  for ghost in ranked])


def page(program, name):
    """Writes one page and its pictures; returns the lens for the list."""
    lens = json.loads(run(program, "lens", "show", name, "--json"))
    run(program, "lens", "draw", name, "-o", str(HERE / f"{name}.svg"))
    wide = lens["f_number"]
    reports = []
    for tag, f_number in (("wide", wide), ("f8", STOPPED_DOWN)):
        reports.append(render(program, lens, f_number, HERE / f"{name}-{tag}.png"))
    prose = lambda key: " ".join(lens.get(key, "").split())
    text = f"""# {name}

{lens.get("maker", "")}. Patent: {lens.get("patent", "")}.
[The lens file](../../lenses/{name}.toml)

![cross-section with rays]({name}.svg)

## Figures

{first_order(lens)}

## Surfaces

{surfaces(lens)}

Surfaces without a coating of their own have `{lens["default_coating"]}` where they meet air.

## Over the field, wide open

{field(lens)}

## A light up and left

A light at infinity at pixel {LIGHT_PIXEL} of a {WIDTH} × {HEIGHT} frame, {number(frame_width(lens), 2)} mm
wide; seven blades. Left wide open, right at f/8. Each PNG is exposed by itself; absolute numbers are in
EXR files.

![wide open]({name}-wide.png) ![f/8]({name}-f8.png)

The strongest of {reports[0]["ghost_count"]} ghosts wide open, under this light:

{ghosts(reports[0])}

## Commands

```sh
flare lens show {name} --field
flare lens draw {name} -o lens.svg
flare ghosts {name} --field-deg 5
flare render request.json -o flare.png     # with the request below
```

```json
{json.dumps(request_for(lens, STOPPED_DOWN))}
```

## Where the numbers come from

{prose("source")}

{prose("notes")}
"""
    (HERE / f"{name}.md").write_text(text, encoding="utf-8")


def write_list(program):
    rows = []
    for lens in json.loads(run(program, "lens", "list", "--json"))["lenses"]:
        name = lens["name"]
        if (HERE / f"{name}.md").exists():
            rows.append([f"[{name}]({name}.md)", lens.get("maker", ""),
                         number(lens["efl_mm"], 2), number(lens["f_number"], 2),
                         f"![{name}]({name}-f8.png)"])
    text = ("# The lenses of the library\n\nMade by `docs/lenses/make_pages.py`; the pictures are a "
            "light up and left at f/8, as each page says.\n\n"
            + table(["lens", "maker", "EFL mm", "f/", ""], rows) + "\n")
    (HERE / "README.md").write_text(text, encoding="utf-8")


def stale(name):
    made = HERE / f"{name}.md"
    if not made.exists():
        return True
    sources = (LENSES / f"{name}.toml", pathlib.Path(__file__))
    return any(source.stat().st_mtime > made.stat().st_mtime for source in sources)


def main():
    parser = argparse.ArgumentParser(description="Makes the pages of the lens library.")
    parser.add_argument("--all", action="store_true", help="make up-to-date pages anew as well")
    parser.add_argument("--flare", help="the program",
                        default=os.environ.get("FLARE", str(ROOT / "build/release/bin/flare")))
    parser.add_argument("lens", nargs="*", help="these alone")
    options = parser.parse_args()
    names = options.lens or sorted(path.stem for path in LENSES.glob("*.toml"))
    wanted = [name for name in names if options.all or options.lens or stale(name)]
    progress = Progress(len(wanted))
    for name in wanted:
        progress.show(name)
        page(options.flare, name)
    progress.end()
    write_list(options.flare)
    print(f"{len(wanted)} pages made, {len(names) - len(wanted)} were up to date")


if __name__ == "__main__":
    main()
