#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes catalogue.tsv from a table of the glass pages of refractiveindex.info.

Run from the root of the source tree (standard library only):

    python3 lenses/glass/make_catalogue.py TABLE > lenses/glass/catalogue.tsv

TABLE has one page a line, separated by tabs: maker, page, formula, range_um, coefficients, nd, Vd,
code, status, k; formulas and points as in README.md. Pages that cannot serve a lens in visible light
are left out, and stderr says how many of whom and why.
"""
import collections
import sys

MAKERS = ("cdgm", "hikari", "hoya", "ohara", "schott", "sumita")
OTHERS = ("misc", "vitron", "ami")
LINES_UM = (0.4861327, 0.6562725)  # F and C
VISIBLE_UM = (0.4, 0.7)
COLUMNS = ("maker", "glass", "formula", "range_um", "coefficients", "nd", "Vd", "code", "status", "k")


def reason_to_leave_out(maker, low, high):
    """A maker's glass must reach both lines of its V-number; others have no n_d and V_d of their own
    to be checked by, and must at least cover the visible."""
    need = LINES_UM if maker in MAKERS else VISIBLE_UM
    if low > need[0] or high < need[1]:
        return f"not given from {need[0]:g} to {need[1]:g} um"
    return None


def points(text):
    """Absorption points in order. A repeated point is kept once; one below zero is no absorption;
    and where every point is zero nobody has measured any."""
    kept = {}
    for item in filter(None, text.split(";")):
        um, k = item.split(":")
        if float(k) == 0:
            k = "0"
        if float(k) >= 0 and kept.setdefault(float(um), (um, k))[1] != k:
            raise ValueError(f"two values of k at {um} um")
    if all(k == "0" for _, k in kept.values()):
        return ""
    return ";".join(f"{um}:{k}" for _, (um, k) in sorted(kept.items()))


def main():
    rows, left_out = [], collections.Counter()
    with open(sys.argv[1], encoding="ascii") as table:
        for line in table:
            if line.startswith("#") or line.startswith("maker\t"):
                continue
            maker, page, formula, span, coefficients, nd, vd, code, status, k = \
                line.rstrip("\n").split("\t")
            if maker not in MAKERS + OTHERS:
                raise ValueError(f"unknown maker {maker}")
            low, high = map(float, span.split())
            why = reason_to_leave_out(maker, low, high)
            if why:
                left_out[f"{maker}: {why}"] += 1
                continue
            group, _, name = page.rpartition("/")
            if maker in OTHERS and group:
                name = f"{group}-{name}"  # the group names the glass, the page who measured it
            rows.append((maker.upper(), name, formula, span, coefficients, nd, vd, code,
                         status or group, points(k)))
    rows.sort(key=lambda row: (row[0], row[1].upper()))
    print("# Optical glasses: see README.md. Data: refractiveindex.info, CC0 1.0.")
    print("# Made by make_catalogue.py; do not edit.")
    print("\t".join(COLUMNS))
    for row in rows:
        print("\t".join(row))
    print(f"{len(rows)} glasses", *(f"left out {n}: {why}" for why, n in sorted(left_out.items())),
          sep="\n", file=sys.stderr)


if __name__ == "__main__":
    main()
