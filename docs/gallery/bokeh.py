#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of docs/bokeh.md: each rendered by `flare render` and, below it, splatted from
exact rays of `flare trace`, which knows neither meshes nor polygons nor the renderer's bundle of
rays. Prints how far the two differ.

Writes the request files beside itself. Only Python's standard library is used.

usage: docs/gallery/bokeh.py [--flare PROGRAM] [--rays COUNT]
"""

import argparse
import json
import math
import pathlib
import random
import struct
import subprocess
import tempfile
import tomllib
import zlib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LENS = "zeiss-master-prime-100mm-t1_3"
WAVELENGTH = 587.5618
SHIFTS_MM = [-8.0, -3.0, 0.0, 3.0, 8.0]   # of the sensor from the paraxial image
IRRADIANCE = 0.05                           # so that half floats hold the sharpest image
BLOCK = 6                                   # pixels a side over which pictures are compared


def run(program, *arguments, text=None):
    done = subprocess.run([program, *arguments], input=text, capture_output=True, text=True,
                          check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(arguments)}: {done.stderr}")
    return done.stdout


class Lens:
    """The lens of the library without its focusing groups: the sensor moves, as far as asked."""

    def __init__(self, flare):
        file = tomllib.loads((ROOT / "lenses" / f"{LENS}.toml").read_text())
        self.prescription = {"name": "master prime 100 mm, unit focusing",
                             "default_coating": file["default_coating"],
                             "surface": file["surface"]}
        self.flare = flare
        far, near = self.show(None), self.show(1.0)
        self.efl, self.sensor_z = far["efl_mm"], far["sensor_z_mm"]
        self.pupil = far["entrance_pupil"]
        image = self.efl + near["sensor_z_mm"] - self.sensor_z
        self.between = 1000.0 - self.conjugates(image)      # the principal planes
        ray = {"origin": [0, 1e-3, -10], "direction": [0, 0, 1]}
        self.a1 = self.trace([ray], None)[0]["stops_mm"][0][1] / 1e-3

    def show(self, focus_m):
        """First-order data, of the lens as a file."""
        lines = [f'name = "{self.prescription["name"]}"',
                 f'default_coating = "{self.prescription["default_coating"]}"']
        for surface in self.prescription["surface"]:
            lines.append("[[surface]]")
            lines += [f"{key} = {json.dumps(value)}" for key, value in surface.items()]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "lens.toml"
            path.write_text("\n".join(lines) + "\n")
            focus = [] if focus_m is None else ["--focus-m", repr(focus_m)]
            return json.loads(run(self.flare, "lens", "show", str(path), "--json", *focus))

    def trace(self, rays, focus_m):
        found = []
        for first in range(0, len(rays), 100_000):
            request = {"prescription": self.prescription, "wavelength_nm": WAVELENGTH,
                       "sequence": [], "focus_m": focus_m, "rays": rays[first:first + 100_000]}
            found += json.loads(run(self.flare, "trace", text=json.dumps(request)))["rays"]
        return found

    def conjugates(self, image):
        """Object and image distance together, from their principal planes."""
        return image ** 2 / (image - self.efl)

    def focus_for(self, distance_mm, shift_mm):
        """The focus distance at which the sensor stands `shift_mm` behind the image of a light so
        far from the entrance pupil."""
        light_z = self.pupil["z_mm"] - distance_mm
        low, high = 1.05 * self.efl, 2.0 * self.efl
        for _ in range(60):
            image = 0.5 * (low + high)
            room = self.sensor_z + image - self.efl - light_z - self.between
            low, high = (image, high) if self.conjugates(image) > room else (low, image)
        return (self.conjugates(image + shift_mm) + self.between) / 1000.0


def request_for(lens, focus_m, f_number, iris, image, lights):
    return {"prescription": lens.prescription, "focus_m": focus_m, "f_number": f_number,
            "iris": iris, "image": image, "lights": lights, "layers": ["bokeh"],
            "units": "sensor_irradiance", "color_space": "spectral",
            "wavelengths_nm": [WAVELENGTH], "output": {"pixel": "float"}}


def render(flare, request, name):
    path = HERE / f"{name}.json"
    head = json.dumps({k: v for k, v in request.items() if k != "prescription"})
    surfaces = ",\n    ".join(json.dumps(s) for s in request["prescription"]["surface"])
    rest = json.dumps({k: v for k, v in request["prescription"].items() if k != "surface"})
    path.write_text(f'{{"prescription": {rest[:-1]}, "surface": [\n    {surfaces}]}},\n '
                    f"{head[1:]}\n")
    with tempfile.TemporaryDirectory() as folder:
        out, report = pathlib.Path(folder) / "a.half", pathlib.Path(folder) / "r.json"
        run(flare, "render", str(path), "-o", str(out), "--report", str(report))
        data = out.read_bytes()
        facts = json.loads(report.read_text())
    _, _, width, height, _, names = struct.unpack_from("<4s5I", data)
    values = struct.unpack_from(f"<{width * height}e", data, 64 + names)
    return list(values), facts


def splat(lens, request, facts, rays):
    """Light in each pixel, E0 mm^2, of rays to a grid over the front vertex's plane."""
    image, iris = request["image"], request["iris"]
    width, height = image["width"], image["height"]
    pitch = image["sensor_width_mm"] / width
    pupil = lens.pupil["z_mm"]
    reach = 1.5 * lens.pupil["diameter_mm"] / 2
    side = int(math.sqrt(rays))
    # The polygon has the area of the circle that the f-number asks for.
    circle = lens.a1 * lens.efl / request["f_number"] / 2
    blades = iris["blades"]
    inner = circle * math.sqrt(math.pi / (blades * math.tan(math.pi / blades)))
    edges = [math.radians(90 + iris["rotation_deg"] + 360 * (k + 0.5) / blades)
             for k in range(blades)]
    picture = [0.0] * (width * height)
    chance = random.Random(1)
    for light, placed in zip(request["lights"], facts["lights"]):
        distance = 1000 * light["distance_m"]
        x, y, z = (distance * c for c in placed["direction"])
        place = (x, y, pupil - z)
        # Towards the light the plane through the pupil is met off the axis.
        off = (x * pupil / z, y * pupil / z)
        rows, areas = [], []
        step = 2 * reach / side
        for j in range(side):
            for i in range(side):
                ax = off[0] - reach + (i + chance.random()) * step
                ay = off[1] - reach + (j + chance.random()) * step
                way = (ax - place[0], ay - place[1], -place[2])
                length = math.sqrt(sum(c * c for c in way))
                rows.append({"origin": [ax - 0.5 * way[0], ay - 0.5 * way[1], -0.5 * way[2]],
                             "direction": list(way)})
                # E0 d^2 times the solid angle.
                areas.append(distance ** 2 * step * step * way[2] / length ** 3)
        for ray, area in zip(lens.trace(rows, request["focus_m"]), areas):
            if ray["fate"] != "arrived":
                continue
            sx, sy = ray["stops_mm"][0]
            if any(sx * math.cos(e) + sy * math.sin(e) > inner for e in edges):
                continue
            px = math.floor(width / 2 - ray["sensor_mm"][0] / pitch)
            py = math.floor(height / 2 + ray["sensor_mm"][1] / pitch)
            if 0 <= px < width and 0 <= py < height:
                picture[py * width + px] += ray["weight"] * area
    return picture


def compare(name, ours, rays, width):
    light, counted = sum(ours), sum(rays)
    blocks = {}
    for k, (a, b) in enumerate(zip(ours, rays)):
        at = (k // width // BLOCK, k % width // BLOCK)
        old = blocks.get(at, (0.0, 0.0))
        blocks[at] = (old[0] + a, old[1] + b)
    difference = sum(abs(a - b) for a, b in blocks.values()) / counted
    print(f"{name:16} light {light:9.4f} E0 mm^2, rays {counted:9.4f}, "
          f"{100 * (light / counted - 1):+.3f} %, rel_l1 of {BLOCK} x {BLOCK} blocks "
          f"{difference:.4f}")


def grey(values, top):
    return [round(255 * min(1.0, max(0.0, v) / top) ** (1 / 2.2)) for v in values]


def write_png(path, width, height, rows):
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    raw = b"".join(b"\0" + bytes(row) for row in rows)
    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def pair(ours, rays, width, height):
    """Both as rows of grey pixels, in one scale, with a line between."""
    lit = sorted(v for v in ours if v > 0)
    top = 1.25 * lit[int(0.99 * (len(lit) - 1))]
    rows = []
    for values in (ours, rays):
        shades = grey(values, top)
        rows += [shades[j * width:(j + 1) * width] for j in range(height)]
        rows.append([90] * width)
    return rows[:-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flare", default=str(ROOT / "build/release/bin/flare"))
    parser.add_argument("--rays", type=int, default=300_000, help="for each light")
    options = parser.parse_args()
    lens = Lens(options.flare)

    panels = []
    size, sensor = 150, 5.4
    for number, shift in enumerate(SHIFTS_MM, 1):
        request = request_for(
            lens, lens.focus_for(400.0, shift), 2.0, {"blades": 6, "rotation_deg": 10},
            {"width": size, "height": size, "sensor_width_mm": sensor},
            [{"direction": [0, 0, 1], "distance_m": 0.4, "irradiance": IRRADIANCE}])
        values, facts = render(options.flare, request, f"bokeh-focus-{number}")
        ours = [v * (sensor / size) ** 2 / IRRADIANCE for v in values]
        rays = splat(lens, request, facts, options.rays)
        compare(f"focus {shift:+.0f} mm", ours, rays, size)
        panels.append(pair(ours, rays, size, size))
    rows = [[p for k, panel in enumerate(panels) for p in ([90] if k else []) + panel[j]]
            for j in range(len(panels[0]))]
    write_png(HERE / "bokeh-focus.png", len(rows[0]), len(rows), rows)

    width, height, sensor = 780, 130, 31.2
    places = [-13, -8.8, -4.4, 0, 4.4, 8.8, 13]
    request = request_for(
        lens, lens.focus_for(420.0, -8.0), 2.0, {"blades": 3, "rotation_deg": 0},
        {"width": width, "height": height, "sensor_width_mm": sensor},
        [{"pixel": [width / 2 + x / sensor * width, height / 2], "distance_m": 0.42,
          "irradiance": IRRADIANCE} for x in places])
    values, facts = render(options.flare, request, "bokeh-field")
    ours = [v * (sensor / width) ** 2 / IRRADIANCE for v in values]
    rays = splat(lens, request, facts, options.rays)
    compare("field", ours, rays, width)
    rows = pair(ours, rays, width, height)
    write_png(HERE / "bokeh-field.png", width, len(rows), rows)


if __name__ == "__main__":
    main()
