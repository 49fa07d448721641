#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Computes primaries_table.cpp: three spectra b_r, b_g, b_b for the light of a linear Rec.709 value.

Run from the root of the source tree (standard library only, about seconds):

    python3 core/spectrum/make_primaries.py > core/spectrum/primaries_table.cpp

Problem (Mallett and Yuksel 2019, "Spectral Primary Decomposition for Rendering with sRGB
Reflectance"): minimise the sum of squared first differences of the three curves, subject to

    0 <= b_j(l) <= 1,   b_r + b_g + b_b = 1 at every sample l,
    sum_l response_k(l) D65(l) b_j(l) = [j = k].

b_b = 1 - b_r - b_g is eliminated (its colour follows from the other two), which leaves a convex
quadratic program with 162 unknowns, 6 equations and 243 inequalities. It is solved by a primal-dual
interior-point method, to a complementarity of 1e-17 and equations that hold to 1e-14.
"""
import math
import re
import sys

N = 81
PRIMARIES = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))  # ITU-R BT.709


def solve(a, rhs):
    """Gaussian elimination with partial pivoting; a and rhs are overwritten."""
    n = len(a)
    for i, row in enumerate(a):
        row.append(rhs[i])
    for c in range(n):
        p = max(range(c, n), key=lambda r: abs(a[r][c]))
        a[c], a[p] = a[p], a[c]
        pivot = a[c]
        for r in range(c + 1, n):
            f = a[r][c] / pivot[c]
            if f != 0.0:
                row = a[r]
                row[c:] = [x - f * y for x, y in zip(row[c:], pivot[c:])]
    x = [0.0] * n
    for r in range(n - 1, -1, -1):
        x[r] = (a[r][n] - math.fsum(a[r][k] * x[k] for k in range(r + 1, n))) / a[r][r]
    return x


def white_responses():
    """response_k(l) D65(l) for k = R, G, B: three lists, each of which sums to 1."""
    text = open("core/spectrum/cie_table.cpp", encoding="utf-8").read()
    number = r"([-+.0-9e]+)"
    rows = [tuple(map(float, m.groups()))
            for m in re.finditer(r"\{" + ", ".join([number] * 4) + r"\},  //", text)]
    assert len(rows) == N
    xyz = [[row[c] * row[3] for row in rows] for c in range(3)]
    luminance = math.fsum(xyz[1])
    xyz = [[v / luminance for v in channel] for channel in xyz]
    white = [math.fsum(channel) for channel in xyz]
    columns = [(x / y, 1.0, (1.0 - x - y) / y) for x, y in PRIMARIES]
    scale = solve([[columns[j][i] for j in range(3)] for i in range(3)], list(white))
    result = [[0.0] * N for _ in range(3)]
    for l in range(N):
        rgb = solve([[columns[j][i] * scale[j] for j in range(3)] for i in range(3)],
                    [xyz[c][l] for c in range(3)])
        for k in range(3):
            result[k][l] = rgb[k]
    return result


def difference_matrix():
    """Hessian of 1/2 sum of squared first differences of one curve."""
    h = [[0.0] * N for _ in range(N)]
    for i in range(N - 1):
        h[i][i] += 1.0
        h[i + 1][i + 1] += 1.0
        h[i][i + 1] -= 1.0
        h[i + 1][i] -= 1.0
    return h


def primaries(response):
    h = difference_matrix()
    n = 2 * N  # unknowns: b_r, then b_g
    # |D r|^2 + |D g|^2 + |D (r + g)|^2: the Hessian is h times [[2, 1], [1, 2]].
    q = [[h[i % N][j % N] * (2.0 if i // N == j // N else 1.0) for j in range(n)] for i in range(n)]
    equations = [([response[k][l] if j == m else 0.0 for m in range(2) for l in range(N)],
                  1.0 if j == k else 0.0) for j in range(2) for k in range(3)]
    rows = len(equations)
    x = [1.0 / 3.0] * n
    y = [0.0] * rows
    slack = [1.0 / 3.0] * (3 * N)  # r, g, 1 - r - g
    dual = [0.01] * (3 * N)

    def slacks(v):
        return v + [-v[i] - v[N + i] for i in range(N)]  # the linear part

    for iteration in range(100):
        mu = math.fsum(s * z for s, z in zip(slack, dual)) / (3 * N)
        gap_eq = [math.fsum(c * v for c, v in zip(row, x)) - b for row, b in equations]
        print(iteration, "mu", mu, "equations", max(map(abs, gap_eq)), file=sys.stderr)
        if mu < 1e-17 and max(map(abs, gap_eq)) < 1e-14:
            break
        lin = slacks(x)
        gap_slack = [slack[i] - lin[i] - (1.0 if i >= 2 * N else 0.0) for i in range(3 * N)]
        target = 0.1 * mu
        # Newton step with slacks and duals eliminated: dz = (target - z (s + ds)) / s.
        weight = [z / s for s, z in zip(slack, dual)]
        pull = [(target - z * s - z * -g) / s for s, z, g in zip(slack, dual, gap_slack)]
        kkt = [list(q[i]) + [row[i] for row, _ in equations] for i in range(n)]
        gradient = [math.fsum(q[i][j] * x[j] for j in range(n) if q[i][j] != 0.0)
                    + math.fsum(row[i] * y[k] for k, (row, _) in enumerate(equations))
                    for i in range(n)]
        rhs = []
        for i in range(n):
            third, other = weight[2 * N + i % N], (i + N) % n
            kkt[i][i] += weight[i] + third
            kkt[i][other] += third
            rhs.append(-gradient[i] + dual[i] - dual[2 * N + i % N] + pull[i] - pull[2 * N + i % N])
        for k, (row, _) in enumerate(equations):
            kkt.append(list(row) + [0.0] * rows)
            rhs.append(-gap_eq[k])
        step = solve(kkt, rhs)
        dx, dy = step[:n], step[n:]
        dlin = slacks(dx)
        ds = [d - g for d, g in zip(dlin, gap_slack)]
        dz = [(target - z * s - z * d) / s for s, z, d in zip(slack, dual, ds)]
        length = min([1.0] + [-0.95 * v / d for v, d in zip(slack + dual, ds + dz) if d < 0.0])
        x = [v + length * d for v, d in zip(x, dx)]
        y = [v + length * d for v, d in zip(y, dy)]
        slack = [v + length * d for v, d in zip(slack, ds)]
        dual = [v + length * d for v, d in zip(dual, dz)]
    return [(r, g, 1.0 - r - g) for r, g in zip(x[:N], x[N:])]


def main():
    table = primaries(white_responses())
    assert all(v >= 0.0 for row in table for v in row)
    print("""// SPDX-License-Identifier: Apache-2.0
//
// Written by make_primaries.py, which says what the numbers are; do not edit.
#include "core/spectrum/primaries_table.h"

namespace flare {
namespace {

// clang-format off
constexpr std::array<PrimariesRow, 81> kRows = {{""")
    for row in table:
        print("    {%r, %r, %r}," % row)
    print("""}};
// clang-format on

}  // namespace

const std::array<PrimariesRow, 81>& PrimariesTable() {
    return kRows;
}

}  // namespace flare""")


main()
