#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Designs the seven-layer antireflection coatings of multilayer.tsv.

usage: design_multilayer.py > multilayer.tsv        (about two minutes; standard library only)

For each substrate index the thicknesses of the fixed order of MATERIALS are found that make the mean
unpolarised reflectance over 400-700 nm and 0-45 degrees least: Levenberg-Marquardt on the complex
amplitudes, from random starts with a fixed seed, so every run gives the same table. The substrates
have no dispersion here; a real glass adds little to that. These are designs of this project, made to
behave like a coating of today. No maker's coating is copied: none is published.
"""
import cmath
import math
import pathlib
import random

MATERIALS = ["MgF2", "Ta2O5", "SiO2", "Ta2O5", "SiO2", "Ta2O5", "SiO2"]  # from the air
SUBSTRATES = [1.45, 1.52, 1.60, 1.68, 1.76, 1.85, 1.95]
WAVELENGTHS = [400.0 + 12.5 * i for i in range(25)]
ANGLES = [0.0, 15.0, 30.0, 45.0]
THINNEST_NM = 6.0  # thinner films do not close
THICKEST_NM = 380.0  # in all: makers do not lay more than they must
STARTS, STEPS = 40, 60


def read_materials():
    found = {}
    path = pathlib.Path(__file__).with_name("materials.tsv")
    for line in path.read_text(encoding="ascii").splitlines():
        if line.startswith("#"):
            continue
        name, _, kind, _, data = line.split("\t")
        if name in found:
            continue
        if kind == "table":
            found[name] = ("table", [tuple(map(float, p.split(":"))) for p in data.split()])
        else:
            found[name] = (kind, list(map(float, data.split())))
    return found


def index_of(material, wavelength):
    kind, data = material
    if kind == "table":
        for (w0, n0, k0), (w1, n1, k1) in zip(data, data[1:]):
            if w0 <= wavelength <= w1:
                t = (wavelength - w0) / (w1 - w0)
                return complex(n0 + t * (n1 - n0), k0 + t * (k1 - k0))
        raise ValueError(wavelength)
    if kind != "formula 1":
        raise ValueError(kind)
    um2 = (wavelength / 1000.0) ** 2
    return complex(math.sqrt(1.0 + data[0] + sum(
        data[i] * um2 / (um2 - data[i + 1] ** 2) for i in range(1, len(data), 2))))


class Target:
    """The amplitudes to be made small: one complex number a wavelength, angle and polarisation."""

    def __init__(self, substrate):
        materials = read_materials()
        self.cases = []
        for wavelength in WAVELENGTHS:
            for angle in ANGLES:
                sin2 = math.sin(math.radians(angle)) ** 2
                layers = [index_of(materials[name], wavelength) ** 2 for name in MATERIALS]
                roots = [cmath.sqrt(n2 - sin2) for n2 in layers]
                q_out = math.sqrt(substrate ** 2 - sin2)
                q_in = math.sqrt(1.0 - sin2)
                k = 2.0 * math.pi / wavelength
                self.cases.append((q_in, q_out, [k * q for q in roots], roots))
                self.cases.append((1.0 / q_in, substrate ** 2 / q_out, [k * q for q in roots],
                                   [n2 / q for n2, q in zip(layers, roots)]))

    def amplitudes(self, thicknesses):
        out = []
        for eta_in, eta_out, k, eta in self.cases:
            b, c = 1.0, eta_out
            for j in range(len(thicknesses) - 1, -1, -1):
                phase = k[j] * thicknesses[j]
                cosine, sine = cmath.cos(phase), -1j * cmath.sin(phase)
                b, c = cosine * b + sine / eta[j] * c, sine * eta[j] * b + cosine * c
            r = (eta_in * b - c) / (eta_in * b + c)
            out.append(r.real)
            out.append(r.imag)
        return out

    def mean(self, thicknesses):
        return sum(r * r for r in self.amplitudes(thicknesses)) / len(self.cases)


def solve(matrix, right):
    """Gaussian elimination with pivots."""
    rows = [row[:] + [value] for row, value in zip(matrix, right)]
    count = len(rows)
    for i in range(count):
        pivot = max(range(i, count), key=lambda r: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(i + 1, count):
            factor = rows[r][i] / rows[i][i]
            for c in range(i, count + 1):
                rows[r][c] -= factor * rows[i][c]
    out = [0.0] * count
    for i in range(count - 1, -1, -1):
        out[i] = (rows[i][count] - sum(rows[i][c] * out[c] for c in range(i + 1, count))) \
            / rows[i][i]
    return out


def descend(target, start):
    d, damping = start, 1e-2
    r = target.amplitudes(d)
    cost = sum(x * x for x in r)
    for _ in range(STEPS):
        columns = []
        for j in range(len(d)):
            moved = d[:]
            moved[j] += 0.01
            columns.append([(a - b) / 0.01 for a, b in zip(target.amplitudes(moved), r)])
        normal = [[sum(a * b for a, b in zip(p, q)) for q in columns] for p in columns]
        gradient = [-sum(a * b for a, b in zip(p, r)) for p in columns]
        for _ in range(6):
            damped = [[value * (1.0 + damping) if i == j else value
                       for j, value in enumerate(row)] for i, row in enumerate(normal)]
            new = [max(THINNEST_NM, x + step) for x, step in zip(d, solve(damped, gradient))]
            new_r = target.amplitudes(new)
            new_cost = sum(x * x for x in new_r)
            if new_cost < cost:
                break
            damping *= 5.0
        else:
            return d
        small = cost - new_cost < 1e-7 * cost
        d, r, cost, damping = new, new_r, new_cost, damping / 4.0
        if small:
            return d
    return d


def main():
    print("# Seven-layer antireflection coatings of this project. Made by design_multilayer.py; do "
          "not edit.")
    print("# Order from the air: " + " ".join(MATERIALS) + ". Centre wavelength 550 nm.")
    print("# substrate index, thicknesses in nm, mean reflectance over 400-700 nm and 0-45 degrees")
    for substrate in SUBSTRATES:
        chance = random.Random(7)
        target = Target(substrate)
        best = None
        for _ in range(STARTS):
            start = [chance.uniform(60.0, 120.0)] + [
                chance.uniform(8.0, 70.0) if name != "SiO2" else chance.uniform(8.0, 110.0)
                for name in MATERIALS[1:]]
            found = descend(target, start)
            if sum(found) < THICKEST_NM and (best is None or target.mean(found) < target.mean(best)):
                best = found
        best = [round(d, 2) for d in best]
        print(f"{substrate:.2f}\t" + " ".join(f"{d:.2f}" for d in best) +
              f"\t{target.mean(best):.6f}", flush=True)


main()
