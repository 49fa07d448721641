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
#include <bit>
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
template <class D, class V = hn::Vec<D>>
HWY_INLINE V RowOf(D tag, const Bilinear& f, float j, V i) {
    return hn::MulAdd(hn::Set(tag, f.per_x + f.twist * j), i, hn::Set(tag, f.at + f.per_y * j));
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE V ArcAt(D tag, const ArcEdge& arc, const Bilinear& bx, const Bilinear& by, float j,
                   V i) {
    const V x = RowOf(tag, bx, j, i);
    const V y = RowOf(tag, by, j, i);
    const V over = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Set(tag, -arc.radius2)));
    const V gx =
        hn::Abs(hn::MulAdd(x, hn::Set(tag, arc.per_x_x), hn::Mul(y, hn::Set(tag, arc.per_x_y))));
    const V gy =
        hn::Abs(hn::MulAdd(x, hn::Set(tag, arc.per_y_x), hn::Mul(y, hn::Set(tag, arc.per_y_y))));
    const V slope = hn::Max(hn::Add(gx, gy), hn::Set(tag, 1e-20F));
    // A pixel's mean over a convex edge is less than its middle's value: the second term keeps the
    // area.
    return hn::MulAdd(slope, hn::Set(tag, 1.0F / (12.0F * arc.radius2)),
                      hn::Div(over, hn::Add(slope, slope)));
}

// The integral of a profile up to `place`, in steps of its table.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V ProfileSum(D tag, const float* table, float last, V place) {
    const hn::RebindToSigned<D> whole;
    const V zero = hn::Zero(tag);
    const V inner = hn::Min(hn::Max(place, zero), hn::Set(tag, last - 1e-3F));
    const auto i = hn::ConvertTo(whole, inner);
    const V f = hn::Sub(inner, hn::ConvertTo(tag, i));
    const V low = hn::GatherIndex(tag, table, i);
    const V high = hn::GatherIndex(tag, table + 1, i);
    return hn::Add(hn::MulAdd(hn::Sub(high, low), f, low),
                   hn::Max(hn::Sub(place, hn::Set(tag, last)), zero));
}

// Distances from the tile's edges with profiles, at each traced wavelength.
template <class D>
struct Fringes {
    using V = hn::Vec<D>;
    const EdgeShade& tile;
    Bilinear x[kTracedInTiles * kTileEdges], y[kTracedInTiles * kTileEdges];
    V over[kTracedInTiles * kTileEdges];

    explicit Fringes(const EdgeShade& shade) : tile(shade) {
        for (int e = 0; e < kTracedInTiles * tile.fringes; ++e) {
            x[e] = BilinearOf(tile.fringe_edges[e].x, tile.size);
            if (tile.fringe_edges[e].radius > 0.0F)
                y[e] = BilinearOf(tile.fringe_edges[e].y, tile.size);
        }
    }

    HWY_INLINE void SetRow(float j, V i) {
        const D tag;
        for (int e = 0; e < kTracedInTiles * tile.fringes; ++e) {
            over[e] = RowOf(tag, x[e], j, i);
            const float radius = tile.fringe_edges[e].radius;
            if (radius > 0.0F) {
                const V down = RowOf(tag, y[e], j, i);
                over[e] = hn::Sub(hn::Sqrt(hn::MulAdd(over[e], over[e], hn::Mul(down, down))),
                                  hn::Set(tag, radius));
            }
        }
    }

    // The product of the profiles at a band.
    HWY_INLINE V At(int band) const {
        const D tag;
        const float* const w = tile.band_weights + band * kTracedInTiles;
        const auto last = static_cast<float>(tile.fringe_entries - 1);
        V product = hn::Set(tag, 1.0F);
        for (int e = 0; e < tile.fringes; ++e) {
            const FringeEdge& edge = tile.fringe_edges[e];
            const V d =
                hn::MulAdd(hn::Set(tag, w[0]), over[e],
                           hn::MulAdd(hn::Set(tag, w[1]), over[tile.fringes + e],
                                      hn::Mul(hn::Set(tag, w[2]), over[2 * tile.fringes + e])));
            const V place =
                hn::NegMulAdd(d, hn::Set(tag, edge.per_mm), hn::Set(tag, tile.fringe_start));
            const float half = std::max(edge.half / tile.band_sharpness[band], 0.25F);
            const float* const table = tile.fringe_tables + edge.table +
                                       static_cast<std::ptrdiff_t>(band) * tile.fringe_entries;
            const V beyond = hn::Add(place, hn::Set(tag, half));
            const V before = hn::Sub(place, hn::Set(tag, half));
            // Where all fringes have died out nothing is lost.
            if (hn::AllTrue(tag, hn::Ge(before, hn::Set(tag, last)))) continue;
            const V sum =
                hn::Sub(ProfileSum(tag, table, last, beyond), ProfileSum(tag, table, last, before));
            product = hn::Mul(product, hn::Mul(sum, hn::Set(tag, 0.5F / half)));
        }
        return product;
    }
};

// What tells of a row of a dispersed tile, from its distances at the traced wavelengths alone, that
// every band is wholly within its edge there, or wholly without.
struct BandReach {
    float beyond = 0.0F;  // a band's distance lies within the traced ones', widened by this share
    float half = 0.0F;    // of the widest band's edge
    float whole[3] = {};  // light of all bands

    explicit BandReach(const EdgeShade& tile) {
        for (int b = 0; b < tile.bands; ++b) {
            float negative = 0.0F;
            for (int k = 0; k < kTracedInTiles; ++k)
                negative += std::max(0.0F, -tile.band_weights[b * kTracedInTiles + k]);
            // The weights add up to one but for their rounding.
            beyond = std::max(beyond, negative + 1e-3F);
            half = std::max(half, 0.5F / tile.band_sharpness[b]);
            for (int c = 0; c < 3; ++c) whole[c] += tile.band_rgb[3 * b + c];
        }
        half += 1e-3F;
    }

    enum class Side { kEdge, kWithin, kWithout };
    template <class D, class V = hn::Vec<D>>
    HWY_INLINE Side Of(D tag, const V* over) const {
        const V most = hn::Max(hn::Max(over[0], over[1]), over[2]);
        const V least = hn::Min(hn::Min(over[0], over[1]), over[2]);
        const V room = hn::MulAdd(hn::Sub(most, least), hn::Set(tag, beyond), hn::Set(tag, half));
        if (hn::AllTrue(tag, hn::Le(hn::Add(most, room), hn::Zero(tag)))) return Side::kWithin;
        if (hn::AllTrue(tag, hn::Ge(hn::Sub(least, room), hn::Zero(tag)))) return Side::kWithout;
        return Side::kEdge;
    }
};

template <int kSize>
HWY_INLINE void ShadeSize(const EdgeShade& tile, float* const* planes, std::ptrdiff_t stride) {
    const hn::CappedTag<float, kSize> tag;
    using D = hn::CappedTag<float, kSize>;
    using V = hn::Vec<D>;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    const int traced = tile.bands > 0 ? kTracedInTiles : 1;
    Bilinear straight[kTracedInTiles * kTileEdges];
    Bilinear arc_x[kTracedInTiles * kTileEdges];
    Bilinear arc_y[kTracedInTiles * kTileEdges];
    for (int e = 0; e < traced * tile.straight; ++e)
        straight[e] = BilinearOf(tile.straight_edges[e].corners, kSize);
    for (int e = 0; e < traced * tile.arcs; ++e) {
        arc_x[e] = BilinearOf(tile.arc_edges[e].x, kSize);
        arc_y[e] = BilinearOf(tile.arc_edges[e].y, kSize);
    }
    Bilinear light[3];
    for (int c = 0; c < 3; ++c) light[c] = BilinearOf(tile.light[c], kSize);
    Fringes<D> fringes(tile);
    const BandReach reach(tile);
    const bool plain = tile.fringes == 0 && tile.pass == nullptr;
    const V half = hn::Set(tag, 0.5F);
    const V one = hn::Set(tag, 1.0F);
    const V zero = hn::Zero(tag);
    for (int row = 0; row < kSize; ++row) {
        const float j = static_cast<float>(row) + 0.5F;
        for (int column = 0; column < kSize; column += lanes) {
            const V i = hn::Add(hn::Iota(tag, static_cast<float>(column)), half);
            const int at = row * kLargestEdgeTile + column;
            V over[kTracedInTiles];
            for (int k = 0; k < traced; ++k) {
                over[k] = hn::Set(tag, -1e6F);
                for (int e = 0; e < tile.straight; ++e)
                    over[k] = hn::Max(over[k], RowOf(tag, straight[k * tile.straight + e], j, i));
                for (int e = 0; e < tile.arcs; ++e) {
                    const int n = k * tile.arcs + e;
                    over[k] =
                        hn::Max(over[k], ArcAt(tag, tile.arc_edges[n], arc_x[n], arc_y[n], j, i));
                }
            }
            V rgb[3] = {zero, zero, zero};
            if (tile.fringes > 0) fringes.SetRow(j, i);
            if (tile.bands == 0) {
                V cover = hn::Min(hn::Max(hn::Sub(half, over[0]), zero), one);
                if (tile.pass != nullptr) cover = hn::Mul(cover, hn::LoadU(tag, tile.pass + at));
                for (int c = 0; c < 3; ++c) rgb[c] = hn::Mul(cover, RowOf(tag, light[c], j, i));
            } else {
                const auto side = plain ? reach.Of(tag, over) : BandReach::Side::kEdge;
                if (side == BandReach::Side::kWithout) continue;
                if (side == BandReach::Side::kWithin) {
                    for (int c = 0; c < 3; ++c) rgb[c] = hn::Set(tag, reach.whole[c]);
                }
                const int bands = side == BandReach::Side::kEdge ? tile.bands : 0;
                for (int b = 0; b < bands; ++b) {
                    const float* const w = tile.band_weights + b * kTracedInTiles;
                    const V sharp = hn::Set(tag, tile.band_sharpness[b]);
                    const V edge = hn::MulAdd(hn::Set(tag, w[0]), over[0],
                                              hn::MulAdd(hn::Set(tag, w[1]), over[1],
                                                         hn::Mul(hn::Set(tag, w[2]), over[2])));
                    V cover = hn::Min(hn::Max(hn::NegMulAdd(edge, sharp, half), zero), one);
                    if (tile.pass != nullptr) {
                        const float* const pass = tile.pass + b * kTilePixels;
                        cover = hn::Mul(cover, hn::LoadU(tag, pass + at));
                    }
                    if (tile.fringes > 0) cover = hn::Mul(cover, fringes.At(b));
                    const float* const share = tile.band_rgb + b * 3;
                    for (int c = 0; c < 3; ++c)
                        rgb[c] = hn::MulAdd(cover, hn::Set(tag, share[c]), rgb[c]);
                }
                for (int c = 0; c < 3; ++c) rgb[c] = hn::Mul(rgb[c], RowOf(tag, light[c], j, i));
            }
            for (int c = 0; c < 3; ++c) {
                float* const to = planes[c] + row * stride + column;
                hn::StoreU(hn::Add(hn::LoadU(tag, to), rgb[c]), tag, to);
            }
        }
    }
}

void Shade(const EdgeShade& tile, float* const* planes, std::ptrdiff_t stride) {
    if (tile.size == 16) {
        ShadeSize<16>(tile, planes, stride);
    } else if (tile.size == 8) {
        ShadeSize<8>(tile, planes, stride);
    } else {
        ShadeSize<4>(tile, planes, stride);
    }
}

template <int kSize>
HWY_INLINE void ExpandSize(const float* all, const std::uint64_t* lit, int words, int row,
                           float* const* planes) {
    const hn::CappedTag<float, std::min(kSize, 16)> tag;
    const int lanes = static_cast<int>(hn::Lanes(tag));
    constexpr float kStep = 1.0F / static_cast<float>(kSize);
    const float down = (static_cast<float>(row) + 0.5F) * kStep;
    for (int word = 0; word < words; ++word) {
        for (std::uint64_t bits = lit[word]; bits != 0; bits &= bits - 1) {
            const int t = 64 * word + std::countr_zero(bits);
            const float* const corners = all + std::ptrdiff_t{12} * t;
            for (int c = 0; c < 3; ++c) {
                const float left = corners[c] + (corners[6 + c] - corners[c]) * down;
                const float right = corners[3 + c] + (corners[9 + c] - corners[3 + c]) * down;
                const auto slope = hn::Set(tag, (right - left) * kStep);
                float* const at = planes[c] + std::ptrdiff_t{kSize} * t;
                for (int i = 0; i < kSize; i += lanes) {
                    const auto x = hn::Iota(tag, static_cast<float>(i) + 0.5F);
                    const auto light = hn::MulAdd(x, slope, hn::Set(tag, left));
                    hn::StoreU(hn::Add(hn::LoadU(tag, at + i), light), tag, at + i);
                }
            }
        }
    }
}

void Expand(const float* corners, const std::uint64_t* lit, int words, int size, int row,
            float* const* planes) {
    if (size == 64) {
        ExpandSize<64>(corners, lit, words, row, planes);
    } else if (size == 32) {
        ExpandSize<32>(corners, lit, words, row, planes);
    } else if (size == 16) {
        ExpandSize<16>(corners, lit, words, row, planes);
    } else if (size == 8) {
        ExpandSize<8>(corners, lit, words, row, planes);
    } else {
        ExpandSize<4>(corners, lit, words, row, planes);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace flare
HWY_AFTER_NAMESPACE();

#endif  // FLARE_TILE_KERNELS_TOGGLE_
