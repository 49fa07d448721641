// SPDX-License-Identifier: Apache-2.0
#include "core/image/tile_edges.h"

#include <algorithm>
#include <cmath>

namespace flare {

TileEdges::Scalar TileEdges::InPixels(std::array<float, 4> at, int size) {
    const float per_x = 0.5F * (at[1] - at[0] + at[3] - at[2]) / static_cast<float>(size);
    const float per_y = 0.5F * (at[2] - at[0] + at[3] - at[1]) / static_cast<float>(size);
    const float inverse = 1.0F / std::max(std::abs(per_x) + std::abs(per_y), 1e-20F);
    Scalar out;
    for (std::size_t c = 0; c < 4; ++c) out.at[c] = std::clamp(at[c] * inverse, -1e6F, 1e6F);
    out.lo = *std::min_element(out.at.begin(), out.at.end()) - 0.5F;
    out.hi = *std::max_element(out.at.begin(), out.at.end()) + 0.5F;
    return out;
}

// Adds a straight edge if it cuts the tile; false if it shuts it out. `at(k)` gives its corner
// values at a traced wavelength.
template <class At>
bool TileEdges::AddStraight(At at) {
    std::array<Scalar, kTraced> edge;
    float lo = 1e30F;
    float hi = -1e30F;
    for (std::size_t k = 0; k < kTraced; ++k) {
        edge[k] = InPixels(at(k), size_);
        lo = std::min(lo, edge[k].lo);
        hi = std::max(hi, edge[k].hi);
    }
    const float room = 0.1F * (hi - lo);
    if (lo - room > 0.5F) return false;
    if (hi + room < -0.5F) return true;
    straight_.push_back(edge);
    return true;
}

// The same for an arc of the iris at crossing c.
bool TileEdges::AddArc(const Iris::Edge& edge, std::size_t c, const TileLevel::Sheet& sheet,
                       const std::array<std::size_t, 4>& corners) {
    std::array<ArcEdge, kTraced> arcs;
    bool shut = true;
    bool open = true;
    const auto r = static_cast<float>(edge.radius);
    for (std::size_t k = 0; k < kTraced; ++k) {
        ArcEdge& arc = arcs[k];
        PixelBox box;
        for (std::size_t n = 0; n < 4; ++n) {
            arc.x[n] = Field(sheet, corners[n], k, 2 * c) - static_cast<float>(edge.centre.x);
            arc.y[n] = Field(sheet, corners[n], k, 2 * c + 1) - static_cast<float>(edge.centre.y);
            box.Join({arc.x[n], arc.y[n], arc.x[n], arc.y[n]});
        }
        arc.radius2 = r * r;
        const float step = 0.5F / static_cast<float>(size_);
        arc.per_x_x = step * (arc.x[1] - arc.x[0] + arc.x[3] - arc.x[2]);
        arc.per_x_y = step * (arc.y[1] - arc.y[0] + arc.y[3] - arc.y[2]);
        arc.per_y_x = step * (arc.x[2] - arc.x[0] + arc.x[3] - arc.x[1]);
        arc.per_y_y = step * (arc.y[2] - arc.y[0] + arc.y[3] - arc.y[1]);
        // A pixel and a tenth of the tile on all sides, in mm.
        const float room_x = std::abs(arc.per_x_x) + std::abs(arc.per_y_x);
        const float room_y = std::abs(arc.per_x_y) + std::abs(arc.per_y_y);
        box = box.Grown(room_x, room_y);
        shut = shut && box.Nearest2() > r * r;
        open = open && box.Farthest2() < r * r;
    }
    if (shut) return false;
    if (!open) arcs_.push_back(arcs);
    return true;
}

// The same for an edge with fringes.
bool TileEdges::AddFringe(const Iris::Edge& edge, std::size_t c, const TileLevel::Sheet& sheet,
                          const std::array<std::size_t, 4>& corners) {
    const GhostFringes& fringes = *ghost_.fringes;
    const auto crossing = static_cast<std::size_t>(masks_.crossings[c]);
    std::array<FringeEdge, kTraced> out;
    Vec2d middle(0.0, 0.0);
    Vec2d right(0.0, 0.0), down(0.0, 0.0);  // mm in the stop, a pixel
    float least = 1e30F;
    float most = -1e30F;
    const auto radius = static_cast<float>(edge.radius);
    for (std::size_t k = 0; k < kTraced; ++k) {
        FringeEdge& fringe = out[k];
        fringe.radius = radius;
        PixelBox box;
        for (std::size_t n = 0; n < 4; ++n) {
            const float x = Field(sheet, corners[n], k, 2 * c);
            const float y = Field(sheet, corners[n], k, 2 * c + 1);
            if (k == kTraced / 2) {
                const Vec2d p(static_cast<double>(x), static_cast<double>(y));
                const double step = 0.5 / size_;
                middle += p * 0.25;
                right += p * (n % 2 == 1 ? step : -step);
                down += p * (n / 2 == 1 ? step : -step);
            }
            if (edge.radius > 0.0) {
                fringe.x[n] = x - static_cast<float>(edge.centre.x);
                fringe.y[n] = y - static_cast<float>(edge.centre.y);
                box.Join({fringe.x[n], fringe.y[n], fringe.x[n], fringe.y[n]});
                continue;
            }
            fringe.x[n] = x * static_cast<float>(edge.normal.x) +
                          y * static_cast<float>(edge.normal.y) - static_cast<float>(edge.offset);
            fringe.y[n] = 0.0F;
            least = std::min(least, fringe.x[n]);
            most = std::max(most, fringe.x[n]);
        }
        if (edge.radius > 0.0) {
            least = std::min(least, std::sqrt(box.Nearest2()) - radius);
            most = std::max(most, std::sqrt(box.Farthest2()) - radius);
        }
    }
    Vec2d normal = edge.normal;
    if (edge.radius > 0.0) {
        const Vec2d away = middle - edge.centre;
        normal = away.length() > 0.0 ? away.normalized() : Vec2d(1.0, 0.0);
    }
    const double distance = edge.radius > 0.0 ? (middle - edge.centre).length() - edge.radius
                                              : middle.dot(edge.normal) - edge.offset;
    const double per_mm = fringes.PerMm(crossing, middle, normal, distance);
    const double pixel_mm = std::abs(normal.dot(right)) + std::abs(normal.dot(down));
    const auto room = static_cast<float>(pixel_mm) + 0.1F * (most - least);
    if (static_cast<double>(least - room) * per_mm > fringes.dark_t) return false;
    if (static_cast<double>(most + room) * per_mm < -fringes.lit_t) return true;
    for (FringeEdge& fringe : out) {
        fringe.per_mm = static_cast<float>(per_mm / fringes.step_t);
        fringe.half = static_cast<float>(0.5 * pixel_mm * per_mm / fringes.step_t);
        fringe.table = fringes.Table(crossing, 0) - fringes.tables.data();
    }
    fringes_.push_back(out);
    return true;
}

// The edges of the iris at crossing c.
bool TileEdges::AddIris(std::size_t c, const TileLevel::Sheet& sheet,
                        const std::array<std::size_t, 4>& corners) {
    for (int e = 0; e < iris_.edge_count(); ++e) {
        const Iris::Edge& edge = iris_.edge(e);
        if (ghost_.fringes &&
            ghost_.fringes->crossings[static_cast<std::size_t>(masks_.crossings[c])].rings) {
            if (!AddFringe(edge, c, sheet, corners)) {
                dark_ = true;
                return false;
            }
            continue;
        }
        if (edge.radius > 0.0) {
            if (!AddArc(edge, c, sheet, corners)) return false;
            continue;
        }
        const auto x = static_cast<float>(edge.normal.x);
        const auto y = static_cast<float>(edge.normal.y);
        const auto offset = static_cast<float>(edge.offset);
        const auto at = [&](std::size_t k) {
            std::array<float, 4> values{};
            for (std::size_t n = 0; n < 4; ++n) {
                values[n] = Field(sheet, corners[n], k, 2 * c) * x +
                            Field(sheet, corners[n], k, 2 * c + 1) * y - offset;
            }
            return values;
        };
        if (!AddStraight(at)) return false;
    }
    return true;
}

// The iris's picture at crossing c, unless it is clear all over the tile; false if it is dark.
bool TileEdges::AddPicture(std::size_t c, const TileLevel::Sheet& sheet,
                           const std::array<std::size_t, 4>& corners) {
    if (iris_.picture() == nullptr) return true;
    std::array<TileAtStop, kTraced> at;
    PixelBox box;
    for (std::size_t k = 0; k < kTraced; ++k) {
        for (std::size_t n = 0; n < 4; ++n) {
            const float x = at[k].x[n] = Field(sheet, corners[n], k, 2 * c);
            const float y = at[k].y[n] = Field(sheet, corners[n], k, 2 * c + 1);
            box.Join({x, y, x, y});
        }
    }
    // For drawn wavelengths beyond the traced ones, and what pixels at the tile's sides look at.
    const float room = 0.1F + 0.5F / static_cast<float>(size_);
    box = box.Grown(room * (box.x1 - box.x0), room * (box.y1 - box.y0));
    const StopRange range =
        iris_.picture()->Over(static_cast<double>(box.x0), static_cast<double>(box.y0),
                              static_cast<double>(box.x1), static_cast<double>(box.y1));
    if (range.dark()) return false;
    if (!range.clear()) pictured_.push_back(at);
    return true;
}

TileEdges::Outcome TileEdges::Emit(int level, int x, int y, const TileLevel::Sheet& sheet,
                                   const std::array<std::size_t, 4>& corners,
                                   const TileColour& scale, bool cut) {
    size_ = TileSize(level);
    straight_.clear();
    arcs_.clear();
    pictured_.clear();
    fringes_.clear();
    dark_ = false;
    const std::size_t crossings = masks_.crossings.size();
    for (std::size_t c = 0; c < crossings && cut; ++c) {
        if (!AddIris(c, sheet, corners) || !AddPicture(c, sheet, corners))
            return dark_ ? Outcome::kDark : Outcome::kShut;
    }
    // The nearest edge is not all that covers a pixel in which many blades meet.
    constexpr std::size_t kMostBlades = 4;
    if (straight_.size() > kMostBlades) return Outcome::kTooMany;
    for (std::size_t r = 0; r < masks_.rims.size() && cut; ++r) {
        const auto at = [&](std::size_t k) {
            std::array<float, 4> values{};
            for (std::size_t n = 0; n < 4; ++n)
                values[n] = Field(sheet, corners[n], k, 2 * crossings + r);
            return values;
        };
        if (!AddStraight(at)) return Outcome::kShut;
    }
    if (size_ > kLargestEdgeTile && !whole()) return Outcome::kTooLarge;
    constexpr std::size_t kMost = kTileEdges;
    if (straight_.size() > kMost || arcs_.size() > kMost || fringes_.size() > kMost)
        return Outcome::kTooMany;
    TileCorners light{};
    for (std::size_t n = 0; n < 4; ++n) {
        for (std::size_t c = 0; c < 3; ++c) light[n][c] = scale[c] * sheet.rgb[3 * corners[n] + c];
    }
    if (whole()) {
        Rescale(light);
        out_.smooth.push_back({static_cast<std::int16_t>(level), x, y, light});
        return Outcome::kAdded;
    }
    EmitEdge(level, x, y, sheet, corners, light);
    return Outcome::kAdded;
}

void TileEdges::EmitEdge(int l, int x, int y, const TileLevel::Sheet& sheet,
                         const std::array<std::size_t, 4>& corners, const TileCorners& light) {
    EdgeTile tile;
    tile.level = static_cast<std::int16_t>(l);
    tile.x = x;
    tile.y = y;
    tile.straight = static_cast<int>(straight_.size());
    tile.arcs = static_cast<int>(arcs_.size());
    tile.pictured = static_cast<int>(pictured_.size());
    tile.fringes = static_cast<int>(fringes_.size());
    tile.corners = light;
    tile.straight_at = out_.straight_edges.size();
    tile.arcs_at = out_.arc_edges.size();
    tile.fringes_at = out_.fringe_edges.size();
    tile.pictured_at = out_.pictured.size();
    tile.bands_at = out_.band_sharpness.size();
    tile.dispersed = !fringes_.empty() || Disperses();
    const std::size_t first = tile.dispersed ? 0 : kTraced / 2;
    const std::size_t end = tile.dispersed ? kTraced : first + 1;
    for (std::size_t k = first; k < end; ++k) {
        for (const auto& edge : straight_) {
            out_.straight_edges.push_back(
                {{edge[k].at[0], edge[k].at[1], edge[k].at[2], edge[k].at[3]}});
        }
        for (const auto& arc : arcs_) out_.arc_edges.push_back(arc[k]);
        for (const auto& fringe : fringes_) out_.fringe_edges.push_back(fringe[k]);
    }
    for (const auto& crossing : pictured_) {
        for (std::size_t k = first; k < end; ++k) out_.pictured.push_back(crossing[k]);
    }
    if (tile.dispersed) AddBands(tile, sheet, corners);
    Rescale(tile.corners);
    out_.edges.push_back(tile);
}

void TileEdges::Rescale(TileCorners& light) const {
    const double factor = light_.scale() / unit_;
    for (auto& corner : light) {
        for (float& value : corner) value = static_cast<float>(value * factor);
    }
}

// Do the wavelengths' edges lie apart?
bool TileEdges::Disperses() const {
    constexpr float kTogether_px = 0.1F;
    if (ghost_.bands.size() < 2) return false;
    if (!arcs_.empty()) {
        for (const auto& arc : arcs_) {
            for (std::size_t n = 0; n < 4; ++n) {
                const float dx = std::abs(arc[0].x[n] - arc[kTraced - 1].x[n]);
                const float dy = std::abs(arc[0].y[n] - arc[kTraced - 1].y[n]);
                const float mm = std::hypot(arc[1].per_x_x, arc[1].per_x_y);
                if (std::max(dx, dy) > kTogether_px * mm) return true;
            }
        }
    }
    for (const auto& crossing : pictured_) {
        const TileAtStop& first = crossing[0];
        const TileAtStop& last = crossing[kTraced - 1];
        const auto size = static_cast<float>(size_);
        const float mm = std::min(std::hypot(first.x[1] - first.x[0], first.y[1] - first.y[0]),
                                  std::hypot(first.x[2] - first.x[0], first.y[2] - first.y[0])) /
                         size;
        for (std::size_t n = 0; n < 4; ++n) {
            const float apart = std::hypot(first.x[n] - last.x[n], first.y[n] - last.y[n]);
            if (apart > kTogether_px * mm) return true;
        }
    }
    for (const auto& edge : straight_) {
        for (std::size_t n = 0; n < 4; ++n) {
            if (std::abs(edge[0].at[n] - edge[kTraced - 1].at[n]) > kTogether_px) return true;
        }
    }
    return false;
}

// Each band's share of the tile's light, and how wide its edge is: a band stands for the
// wavelengths around it, whose edges lie side by side.
void TileEdges::AddBands(EdgeTile& tile, const TileLevel::Sheet& sheet,
                         const std::array<std::size_t, 4>& corners) {
    const std::size_t bands = ghost_.bands.size();
    out_.band_rgb.resize(out_.band_rgb.size() + 3 * bands, 0.0F);
    float* const rgb = &out_.band_rgb[3 * tile.bands_at];
    std::array<float, 3> sum{};
    std::array<float, 3> all{};
    for (std::size_t b = 0; b < bands; ++b) {
        for (const std::size_t n : corners) {
            const FittedCell& cell = cells_[static_cast<std::size_t>(sheet.cell[kTraced / 2][n])];
            const TileColour at =
                light_.OfBand(b, cell, sheet.at[kTraced / 2][n][0], sheet.at[kTraced / 2][n][1]);
            for (std::size_t c = 0; c < 3; ++c) rgb[3 * b + c] += at[c];
        }
        for (std::size_t c = 0; c < 3; ++c) {
            sum[c] += rgb[3 * b + c];
            all[c] += std::abs(rgb[3 * b + c]);
        }
    }
    // Fully covered pixels get the light of the corners. A channel whose bands cancel takes the
    // luminance's factor.
    std::array<float, 4> whole{};
    for (std::size_t n = 0; n < 4; ++n) whole[n] = Luminance(tile.corners[n]);
    const float luminance = std::max(Luminance(sum), 1e-30F);
    for (std::size_t c = 0; c < 3; ++c) {
        const bool steady = std::abs(sum[c]) > 0.2F * all[c];
        for (std::size_t n = 0; n < 4; ++n) {
            tile.corners[n][c] = steady ? tile.corners[n][c] / sum[c] : whole[n] / luminance;
        }
    }
    AddSharpness();
}

// From how far each band's edge lies from its neighbours', at the middle of the tile.
void TileEdges::AddSharpness() {
    const std::size_t bands = ghost_.bands.size();
    std::array<float, kTraced> over{};
    over.fill(-1e6F);
    for (std::size_t k = 0; k < kTraced; ++k) {
        for (const auto& edge : straight_) {
            const auto& at = edge[k].at;
            over[k] = std::max(over[k], 0.25F * (at[0] + at[1] + at[2] + at[3]));
        }
        for (const auto& arcs : arcs_) {
            const ArcEdge& arc = arcs[k];
            const float x = 0.25F * (arc.x[0] + arc.x[1] + arc.x[2] + arc.x[3]);
            const float y = 0.25F * (arc.y[0] + arc.y[1] + arc.y[2] + arc.y[3]);
            const float slope = std::abs(x * arc.per_x_x + y * arc.per_x_y) +
                                std::abs(x * arc.per_y_x + y * arc.per_y_y);
            over[k] =
                std::max(over[k], (x * x + y * y - arc.radius2) / std::max(2.0F * slope, 1e-20F));
        }
        for (const auto& edges : fringes_) {
            const FringeEdge& edge = edges[k];
            const float x = 0.25F * (edge.x[0] + edge.x[1] + edge.x[2] + edge.x[3]);
            const float y = 0.25F * (edge.y[0] + edge.y[1] + edge.y[2] + edge.y[3]);
            const float d = edge.radius > 0.0F ? std::hypot(x, y) - edge.radius : x;
            over[k] = std::max(over[k], 0.5F * d * edge.per_mm / std::max(edge.half, 1e-20F));
        }
    }
    const auto at = [&](std::size_t b) {
        float sum = 0.0F;
        for (std::size_t k = 0; k < kTraced; ++k)
            sum += static_cast<float>(ghost_.bands[b].node_weights[k]) * over[k];
        return sum;
    };
    for (std::size_t b = 0; b < bands; ++b) {
        const std::size_t lo = b > 0 ? b - 1 : 0;
        const std::size_t hi = std::min(b + 1, bands - 1);
        const float step = (at(hi) - at(lo)) / static_cast<float>(hi - lo);
        out_.band_sharpness.push_back(1.0F / std::sqrt(1.0F + step * step));
    }
}

}  // namespace flare
