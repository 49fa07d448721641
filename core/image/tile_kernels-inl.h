// SPDX-License-Identifier: Apache-2.0
//
// The kernels of tile_kernels.cpp, compiled once for each instruction set.
#if defined(FLARE_TILE_KERNELS_TOGGLE_) == defined(HWY_TARGET_TOGGLE)
#ifdef FLARE_TILE_KERNELS_TOGGLE_
#undef FLARE_TILE_KERNELS_TOGGLE_
#else
#define FLARE_TILE_KERNELS_TOGGLE_
#endif

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/image/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace flare {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using FloatTag = hn::CappedTag<float, kLargestEdgeTile>;
using Floats = hn::Vec<FloatTag>;

constexpr int kMostSteps = 8;
constexpr float kSolved_px = 4e-3F;
constexpr float kOverlap = 1e-3F;  // of neighbouring parts, in cells

HWY_INLINE Floats Constant(float value) {
    return hn::Set(FloatTag(), value);
}

HWY_INLINE Floats Cubic(const float* c, Floats t) {
    const Floats high = hn::MulAdd(Constant(c[3]), t, Constant(c[2]));
    return hn::MulAdd(hn::MulAdd(high, t, Constant(c[1])), t, Constant(c[0]));
}

HWY_INLINE Floats CubicSlope(const float* c, Floats t) {
    const Floats high = hn::MulAdd(Constant(3.0F * c[3]), t, Constant(2.0F * c[2]));
    return hn::MulAdd(high, t, Constant(c[1]));
}

HWY_INLINE Floats Horner(Floats r0, Floats r1, Floats r2, Floats r3, Floats t) {
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(r3, t, r2), t, r1), t, r0);
}

HWY_INLINE Floats ValueAt(const CellPolynomial& p, Floats a, Floats b) {
    return Horner(Cubic(&p[0], a), Cubic(&p[4], a), Cubic(&p[8], a), Cubic(&p[12], a), b);
}

struct Jet {
    Floats value, per_a, per_b;
};

HWY_INLINE Jet JetAt(const CellPolynomial& p, Floats a, Floats b) {
    const Floats r0 = Cubic(&p[0], a);
    const Floats r1 = Cubic(&p[4], a);
    const Floats r2 = Cubic(&p[8], a);
    const Floats r3 = Cubic(&p[12], a);
    Jet jet;
    jet.value = Horner(r0, r1, r2, r3, b);
    jet.per_a = Horner(CubicSlope(&p[0], a), CubicSlope(&p[4], a), CubicSlope(&p[8], a),
                       CubicSlope(&p[12], a), b);
    const Floats high = hn::MulAdd(hn::Mul(Constant(3.0F), r3), b, hn::Add(r2, r2));
    jet.per_b = hn::MulAdd(high, b, r1);
    return jet;
}

HWY_INLINE Floats Determinant(const Jet& x, const Jet& y) {
    return hn::Sub(hn::Mul(x.per_a, y.per_b), hn::Mul(x.per_b, y.per_a));
}

// Masks and light of one vector of points.
HWY_INLINE void StoreFacts(const CellFit& cell, int fields, const LightCorners* light, Floats a,
                           Floats b, Floats det, int n, NodeBlock& block) {
    const FloatTag tag;
    hn::Store(det, tag, block.det + n);
    for (int f = 0; f < fields; ++f) {
        hn::Store(ValueAt(cell.fields[f], a, b), tag, block.fields[f] + n);
    }
    if (light == nullptr) return;
    const Floats a_pixel = hn::Div(Constant(1.0F), hn::Abs(det));
    for (std::size_t c = 0; c < static_cast<std::size_t>(light->count); ++c) {
        const float at = light->at[0][c];
        const float per_a = light->at[1][c] - at;
        const float per_b = light->at[2][c] - at;
        const float twist = light->at[3][c] - light->at[2][c] - per_a;
        const Floats low = hn::MulAdd(Constant(per_a), a, Constant(at));
        const Floats slope = hn::MulAdd(Constant(twist), a, Constant(per_b));
        hn::Store(hn::Mul(a_pixel, hn::MulAdd(slope, b, low)), tag, block.light[c] + n);
    }
}

void Solve(const CellFit& cell, const CellPart& part, int fields, const LightCorners* light,
           NodeBlock& block) {
    const FloatTag tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    // A step may leave the part for a while, but not go astray.
    const float slack_a = part.a1 - part.a0;
    const float slack_b = part.b1 - part.b0;
    const Floats lo_a = Constant(part.a0 - slack_a);
    const Floats hi_a = Constant(part.a1 + slack_a);
    const Floats lo_b = Constant(part.b0 - slack_b);
    const Floats hi_b = Constant(part.b1 + slack_b);
    block.found = 0;
    for (int n = 0; n < block.count; n += lanes) {
        const Floats px = hn::Load(tag, block.px + n);
        const Floats py = hn::Load(tag, block.py + n);
        Floats a = Constant(0.5F * (part.a0 + part.a1));
        Floats b = Constant(0.5F * (part.b0 + part.b1));
        Jet x = JetAt(cell.x, a, b);
        Jet y = JetAt(cell.y, a, b);
        Floats det = Determinant(x, y);
        auto solved = hn::FirstN(tag, 0);
        for (int step = 0; step < kMostSteps; ++step) {
            const Floats ex = hn::Sub(px, x.value);
            const Floats ey = hn::Sub(py, y.value);
            const Floats inverse = hn::Div(Constant(1.0F), det);
            const Floats da = hn::Mul(hn::Sub(hn::Mul(ex, y.per_b), hn::Mul(ey, x.per_b)), inverse);
            const Floats db = hn::Mul(hn::Sub(hn::Mul(ey, x.per_a), hn::Mul(ex, y.per_a)), inverse);
            // What is solved stays: a result does not depend on its neighbours in the vector.
            a = hn::IfThenElse(solved, a, hn::Min(hn::Max(hn::Add(a, da), lo_a), hi_a));
            b = hn::IfThenElse(solved, b, hn::Min(hn::Max(hn::Add(b, db), lo_b), hi_b));
            x = JetAt(cell.x, a, b);
            y = JetAt(cell.y, a, b);
            det = Determinant(x, y);
            const Floats miss =
                hn::Max(hn::Abs(hn::Sub(px, x.value)), hn::Abs(hn::Sub(py, y.value)));
            solved = hn::Lt(miss, Constant(kSolved_px));
            if (hn::AllTrue(tag, solved)) break;
        }
        const auto within = hn::And(hn::And(hn::Ge(a, Constant(part.a0 - kOverlap)),
                                            hn::Lt(a, Constant(part.a1 + kOverlap))),
                                    hn::And(hn::Ge(b, Constant(part.b0 - kOverlap)),
                                            hn::Lt(b, Constant(part.b1 + kOverlap))));
        hn::Store(a, tag, block.a + n);
        hn::Store(b, tag, block.b + n);
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(tag, hn::And(solved, within), bits);
        std::uint64_t word = 0;
        std::memcpy(&word, bits, sizeof(word));
        block.found |= word << n;
        StoreFacts(cell, fields, light, a, b, det, n, block);
    }
    if (block.count < kTileNodes) {
        const std::uint64_t used = (std::uint64_t{1} << block.count) - 1;
        block.found &= used;
    }
}

void Points(const CellFit& cell, int fields, const LightCorners* light, NodeBlock& block) {
    const FloatTag tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    for (int n = 0; n < block.count; n += lanes) {
        const Floats a = hn::Load(tag, block.a + n);
        const Floats b = hn::Load(tag, block.b + n);
        const Jet x = JetAt(cell.x, a, b);
        const Jet y = JetAt(cell.y, a, b);
        hn::Store(x.value, tag, block.px + n);
        hn::Store(y.value, tag, block.py + n);
        StoreFacts(cell, fields, light, a, b, Determinant(x, y), n, block);
    }
}

// Corner values as a function of the place in the tile: at + per_x i + per_y j + twist i j.
struct Bilinear {
    float at, per_x, per_y, twist;
};

HWY_INLINE Bilinear BilinearOf(const float* corners, int size) {
    const float step = 1.0F / static_cast<float>(size);
    const float dx = (corners[1] - corners[0]) * step;
    const float dy = (corners[2] - corners[0]) * step;
    const float twist = (corners[3] - corners[2] - corners[1] + corners[0]) * step * step;
    return {corners[0], dx, dy, twist};
}

// Along row j (pixel centres): values at columns `i`.
HWY_INLINE Floats RowOf(const Bilinear& f, float j, Floats i) {
    return hn::MulAdd(Constant(f.per_x + f.twist * j), i, Constant(f.at + f.per_y * j));
}

HWY_INLINE Floats ArcAt(const ArcEdge& arc, const Bilinear& bx, const Bilinear& by, float j,
                        Floats i) {
    const Floats x = RowOf(bx, j, i);
    const Floats y = RowOf(by, j, i);
    const Floats over = hn::MulAdd(x, x, hn::MulAdd(y, y, Constant(-arc.radius2)));
    const Floats gx =
        hn::Abs(hn::MulAdd(x, Constant(arc.per_x_x), hn::Mul(y, Constant(arc.per_x_y))));
    const Floats gy =
        hn::Abs(hn::MulAdd(x, Constant(arc.per_y_x), hn::Mul(y, Constant(arc.per_y_y))));
    const Floats slope = hn::Max(hn::Add(gx, gy), Constant(1e-20F));
    // A pixel's mean over a convex edge is less than its middle's value: the second term keeps the
    // area.
    return hn::MulAdd(slope, Constant(1.0F / (12.0F * arc.radius2)),
                      hn::Div(over, hn::Add(slope, slope)));
}

// The integral of a profile up to `place`, in steps of its table.
HWY_INLINE Floats ProfileSum(const float* table, float last, Floats place) {
    const FloatTag tag;
    const hn::RebindToSigned<FloatTag> whole;
    const Floats zero = hn::Zero(tag);
    const Floats inner = hn::Min(hn::Max(place, zero), Constant(last - 1e-3F));
    const auto i = hn::ConvertTo(whole, inner);
    const Floats f = hn::Sub(inner, hn::ConvertTo(tag, i));
    const Floats low = hn::GatherIndex(tag, table, i);
    const Floats high = hn::GatherIndex(tag, table + 1, i);
    return hn::Add(hn::MulAdd(hn::Sub(high, low), f, low),
                   hn::Max(hn::Sub(place, Constant(last)), zero));
}

// Distances from the tile's edges with profiles, at each traced wavelength.
struct Fringes {
    const EdgeShade& tile;
    Bilinear x[kTracedInTiles * kTileEdges], y[kTracedInTiles * kTileEdges];
    Floats over[kTracedInTiles * kTileEdges];

    explicit Fringes(const EdgeShade& shade) : tile(shade) {
        for (int e = 0; e < kTracedInTiles * tile.fringes; ++e) {
            x[e] = BilinearOf(tile.fringe_edges[e].x, tile.size);
            if (tile.fringe_edges[e].radius > 0.0F)
                y[e] = BilinearOf(tile.fringe_edges[e].y, tile.size);
        }
    }

    HWY_INLINE void SetRow(float j, Floats i) {
        for (int e = 0; e < kTracedInTiles * tile.fringes; ++e) {
            over[e] = RowOf(x[e], j, i);
            const float radius = tile.fringe_edges[e].radius;
            if (radius > 0.0F) {
                const Floats down = RowOf(y[e], j, i);
                over[e] = hn::Sub(hn::Sqrt(hn::MulAdd(over[e], over[e], hn::Mul(down, down))),
                                  Constant(radius));
            }
        }
    }

    // The product of the profiles at a band.
    HWY_INLINE Floats At(int band) const {
        const float* const w = tile.band_weights + band * kTracedInTiles;
        const auto last = static_cast<float>(tile.fringe_entries - 1);
        Floats product = Constant(1.0F);
        for (int e = 0; e < tile.fringes; ++e) {
            const FringeEdge& edge = tile.fringe_edges[e];
            const Floats d =
                hn::MulAdd(Constant(w[0]), over[e],
                           hn::MulAdd(Constant(w[1]), over[tile.fringes + e],
                                      hn::Mul(Constant(w[2]), over[2 * tile.fringes + e])));
            const Floats place =
                hn::NegMulAdd(d, Constant(edge.per_mm), Constant(tile.fringe_start));
            const float half = std::max(edge.half / tile.band_sharpness[band], 0.25F);
            const float* const table = tile.fringe_tables + edge.table +
                                       static_cast<std::ptrdiff_t>(band) * tile.fringe_entries;
            const Floats sum = hn::Sub(ProfileSum(table, last, hn::Add(place, Constant(half))),
                                       ProfileSum(table, last, hn::Sub(place, Constant(half))));
            product = hn::Mul(product, hn::Mul(sum, Constant(0.5F / half)));
        }
        return product;
    }
};

void Shade(const EdgeShade& tile, TilePixels& out) {
    const FloatTag tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    const int size = tile.size;
    const int traced = tile.bands > 0 ? kTracedInTiles : 1;
    Bilinear straight[kTracedInTiles * kTileEdges];
    Bilinear arc_x[kTracedInTiles * kTileEdges];
    Bilinear arc_y[kTracedInTiles * kTileEdges];
    for (int e = 0; e < traced * tile.straight; ++e)
        straight[e] = BilinearOf(tile.straight_edges[e].corners, size);
    for (int e = 0; e < traced * tile.arcs; ++e) {
        arc_x[e] = BilinearOf(tile.arc_edges[e].x, size);
        arc_y[e] = BilinearOf(tile.arc_edges[e].y, size);
    }
    Bilinear light[3];
    for (int c = 0; c < 3; ++c) light[c] = BilinearOf(tile.light[c], size);
    Fringes fringes(tile);
    const Floats half = Constant(0.5F);
    const Floats one = Constant(1.0F);
    const Floats zero = hn::Zero(tag);
    for (int row = 0; row < size; ++row) {
        const float j = static_cast<float>(row) + 0.5F;
        for (int column = 0; column < size; column += lanes) {
            const Floats i = hn::Add(hn::Iota(tag, static_cast<float>(column)), half);
            const int at = row * kLargestEdgeTile + column;
            Floats over[kTracedInTiles];
            for (int k = 0; k < traced; ++k) {
                over[k] = Constant(-1e6F);
                for (int e = 0; e < tile.straight; ++e)
                    over[k] = hn::Max(over[k], RowOf(straight[k * tile.straight + e], j, i));
                for (int e = 0; e < tile.arcs; ++e) {
                    const int n = k * tile.arcs + e;
                    over[k] = hn::Max(over[k], ArcAt(tile.arc_edges[n], arc_x[n], arc_y[n], j, i));
                }
            }
            Floats rgb[3] = {zero, zero, zero};
            if (tile.fringes > 0) fringes.SetRow(j, i);
            if (tile.bands == 0) {
                Floats cover = hn::Min(hn::Max(hn::Sub(half, over[0]), zero), one);
                if (tile.pass != nullptr) cover = hn::Mul(cover, hn::LoadU(tag, tile.pass + at));
                for (int c = 0; c < 3; ++c) rgb[c] = hn::Mul(cover, RowOf(light[c], j, i));
            } else {
                for (int b = 0; b < tile.bands; ++b) {
                    const float* const w = tile.band_weights + b * kTracedInTiles;
                    const Floats sharp = Constant(tile.band_sharpness[b]);
                    const Floats edge = hn::MulAdd(
                        Constant(w[0]), over[0],
                        hn::MulAdd(Constant(w[1]), over[1], hn::Mul(Constant(w[2]), over[2])));
                    Floats cover = hn::Min(hn::Max(hn::NegMulAdd(edge, sharp, half), zero), one);
                    if (tile.pass != nullptr) {
                        const float* const pass = tile.pass + b * kTilePixels;
                        cover = hn::Mul(cover, hn::LoadU(tag, pass + at));
                    }
                    if (tile.fringes > 0) cover = hn::Mul(cover, fringes.At(b));
                    const float* const share = tile.band_rgb + b * 3;
                    for (int c = 0; c < 3; ++c)
                        rgb[c] = hn::MulAdd(cover, Constant(share[c]), rgb[c]);
                }
                for (int c = 0; c < 3; ++c) rgb[c] = hn::Mul(rgb[c], RowOf(light[c], j, i));
            }
            for (int c = 0; c < 3; ++c) {
                hn::StoreU(rgb[c], tag, out.rgb[c] + at);
            }
        }
    }
}

template <int kSize>
HWY_INLINE void ExpandSize(const float* corners, int tiles, int row, float* const* planes) {
    const hn::CappedTag<float, std::min(kSize, 16)> tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    constexpr float kStep = 1.0F / static_cast<float>(kSize);
    const float down = (static_cast<float>(row) + 0.5F) * kStep;
    for (int t = 0; t < tiles; ++t, corners += 12) {
        for (int c = 0; c < 3; ++c) {
            const float left = corners[c] + (corners[6 + c] - corners[c]) * down;
            const float right = corners[3 + c] + (corners[9 + c] - corners[3 + c]) * down;
            if (left == 0.0F && right == 0.0F) continue;
            const auto slope = hn::Set(tag, (right - left) * kStep);
            float* const at = planes[c] + t * kSize;
            for (int i = 0; i < kSize; i += lanes) {
                const auto x = hn::Iota(tag, static_cast<float>(i) + 0.5F);
                const auto light = hn::MulAdd(x, slope, hn::Set(tag, left));
                hn::StoreU(hn::Add(hn::LoadU(tag, at + i), light), tag, at + i);
            }
        }
    }
}

void Expand(const float* corners, int tiles, int size, int row, float* const* planes) {
    if (size == 64) {
        ExpandSize<64>(corners, tiles, row, planes);
    } else if (size == 32) {
        ExpandSize<32>(corners, tiles, row, planes);
    } else if (size == 16) {
        ExpandSize<16>(corners, tiles, row, planes);
    } else if (size == 8) {
        ExpandSize<8>(corners, tiles, row, planes);
    } else {
        ExpandSize<4>(corners, tiles, row, planes);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace flare
HWY_AFTER_NAMESPACE();

#endif  // FLARE_TILE_KERNELS_TOGGLE_
