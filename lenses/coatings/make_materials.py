#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes materials.tsv, the optical constants of thin-film materials, from a larger table.

usage: make_materials.py INPUT > materials.tsv

INPUT has one material a line, from the refractiveindex.info database (CC0), tab-separated: name,
page, "formula N" or "tabulated nk", range in um, and coefficients or um:n:k;um:n:k;... Formulas are
carried over as they are. A table is cut to 360-800 nm and thinned: points are left out where a
straight line between the kept ones stays within N_ERROR of the index and K_ERROR of the extinction;
what was lost at most is printed on stderr. A table that leaves out part of 400-700 nm is dropped:
nothing outside its data would be known of it. The first line of a material is its default page.
"""
import sys

LOW_UM, HIGH_UM = 0.36, 0.8
N_ERROR, K_ERROR = 3e-5, 3e-6
HEAD = """\
# Optical constants of thin-film materials. Made by make_materials.py; do not edit.
# Source: the refractiveindex.info database (M. N. Polyanskiy, doi:10.1038/s41597-023-02898-2), CC0.
# material, page, kind, range in um, coefficients (formula numbers as in the database) or nm:n:k ...
# The first line of a material is what its plain name means. Tables: thinned to {n:g} in n, {k:g} in k.
"""


def line_error(rows, first, last):
    """Largest miss of the straight line from rows[first] to rows[last], in units of the limits."""
    (w0, n0, k0), (w1, n1, k1) = rows[first], rows[last]
    worst = 0.0
    for w, n, k in rows[first + 1:last]:
        t = (w - w0) / (w1 - w0)
        worst = max(worst, abs(n0 + t * (n1 - n0) - n) / N_ERROR,
                    abs(k0 + t * (k1 - k0) - k) / K_ERROR)
    return worst


def thinned(rows):
    kept, at = [rows[0]], 0
    while at < len(rows) - 1:
        to = at + 1
        while to + 1 < len(rows) and line_error(rows, at, to + 1) <= 0.95:
            to += 1
        kept.append(rows[to])
        at = to
    return kept


def worst_miss(rows, kept):
    miss_n = miss_k = 0.0
    for w, n, k in rows:
        for (w0, n0, k0), (w1, n1, k1) in zip(kept, kept[1:]):
            if w0 <= w <= w1:
                t = (w - w0) / (w1 - w0)
                miss_n = max(miss_n, abs(n0 + t * (n1 - n0) - n))
                miss_k = max(miss_k, abs(k0 + t * (k1 - k0) - k))
    return miss_n, miss_k


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = HEAD.format(n=N_ERROR, k=K_ERROR)
    for line in open(sys.argv[1], encoding="ascii"):
        if line.startswith("#"):
            continue
        name, page, kind, span, data = line.rstrip("\n").split("\t")
        if kind.startswith("formula"):
            out += "\t".join([name, page, kind, span, data]) + "\n"
            continue
        rows = [tuple(map(float, point.split(":"))) for point in data.split(";")]
        rows = [row for row in rows if LOW_UM <= row[0] <= HIGH_UM]
        if rows[0][0] > 0.4 or rows[-1][0] < 0.7:
            print(f"{name} {page}: only {rows[0][0]:g}-{rows[-1][0]:g} um, dropped",
                  file=sys.stderr)
            continue
        kept = [(round(w, 8), round(n, 6), float(f"{k:.5g}") if k > 1e-8 else 0.0)
                for w, n, k in thinned(rows)]
        miss_n, miss_k = worst_miss(rows, kept)
        assert miss_n <= N_ERROR and miss_k <= K_ERROR, (name, page, miss_n, miss_k)
        print(f"{name} {page}: {len(kept)} of {len(rows)} points, n within {miss_n:.1e}, "
              f"k within {miss_k:.1e}", file=sys.stderr)
        text = " ".join(f"{1000 * w:.9g}:{n:.7g}:{k:.5g}" for w, n, k in kept)
        out += "\t".join([name, page, "table", f"{kept[0][0]:g} {kept[-1][0]:g}", text]) + "\n"
    sys.stdout.write(out)


main()
