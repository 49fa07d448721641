// SPDX-License-Identifier: Apache-2.0
#include "core/image/cell_fits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/image/net_shape.h"

namespace flare {
namespace {

using Cubic = std::array<float, 4>;

// Powers of t from values and slopes at 0 and 1.
Cubic CubicOf(float at0, float slope0, float at1, float slope1) {
    return {at0, slope0, 3.0F * (at1 - at0) - 2.0F * slope0 - slope1,
            2.0F * (at0 - at1) + slope0 + slope1};
}

CellPolynomial PolynomialOf(const CellJets& jets) {
    const auto& [a, b, c, d] = jets;
    const Cubic low = CubicOf(a[0], a[1], b[0], b[1]);
    const Cubic low_slope = CubicOf(a[2], a[3], b[2], b[3]);
    const Cubic high = CubicOf(c[0], c[1], d[0], d[1]);
    const Cubic high_slope = CubicOf(c[2], c[3], d[2], d[3]);
    CellPolynomial out;
    for (std::size_t p = 0; p < 4; ++p) {
        const Cubic column = CubicOf(low[p], low_slope[p], high[p], high_slope[p]);
        for (std::size_t q = 0; q < 4; ++q) out[4 * q + p] = column[q];
    }
    return out;
}

// Surveys the fitted cells: a lattice of points over each tells of its parts.
class CellSurvey {
  public:
    CellSurvey(const MaskFields& masks, const Iris& iris, std::vector<FittedPart>& out)
        : crossings_(masks.crossings.size()),
          rims_(masks.rims.size()),
          outer_(static_cast<float>(iris.outer_radius())),
          inner_(static_cast<float>(iris.edges_inner_radius())),
          picture_(iris.picture()),
          out_(out) {}

    void Add(FittedCell& cell) {
        bool folds = false;
        for (std::size_t k = 0; k < kTracedInTiles; ++k) folds = SetStarts(cell, k) || folds;
        cell.parts_at = out_.size();
        AddParts(cell, {}, folds ? kManyParts : PartsFor(cell), 0);
        cell.part_count = out_.size() - cell.parts_at;
    }

  private:
    static constexpr int kManyParts = 8;

    // A small cell is one part: about a tile.
    static int PartsFor(const FittedCell& cell) {
        constexpr float kPart_px = 48.0F;
        constexpr int kMost = 3;
        float extent = 0.0F;
        for (const PixelBox& box : cell.boxes)
            extent = std::max({extent, box.x1 - box.x0, box.y1 - box.y0});
        return std::clamp(static_cast<int>(std::ceil(std::min(extent, 1e4F) / kPart_px)), 1, kMost);
    }

    // Parts that fold are cut further until they are as narrow as this.
    static constexpr float kNarrow_px = 8.0F;
    static constexpr int kMostDepth = 4;

    // From how many places Newton's method starts, so that the map is nearly affine around each, 0:
    // from each part; true if the cell folds.
    bool SetStarts(FittedCell& cell, std::size_t k) {
        constexpr float kEven = 0.4F;
        constexpr float kFolding = 0.02F;
        Evaluate(cell.fits[k], {}, 3, true, points_[k]);
        float least = 1e30F;
        float most = -1e30F;
        for (const Point& p : points_[k]) {
            least = std::min(least, p.det);
            most = std::max(most, p.det);
        }
        if (most < 0.0F) {
            std::swap(least, most);
            least = -least;
            most = -most;
        }
        const bool folds = !(least > kFolding * most);
        cell.starts[k] = folds ? 0 : least > kEven * most ? 1 : 2;
        return folds;
    }

    struct Point {
        float x, y, det;
        std::array<float, kTileFields> fields;
    };

    // A lattice of `side` points a side over a part of the cell.
    void Evaluate(const CellFit& fit, const CellPart& range, int side, bool without_masks,
                  std::vector<Point>& points) {
        const int count = side * side;
        points.resize(static_cast<std::size_t>(count));
        const float step_a = (range.a1 - range.a0) / static_cast<float>(side - 1);
        const float step_b = (range.b1 - range.b0) / static_cast<float>(side - 1);
        const int fields = without_masks ? 0 : fit.field_count;
        for (int first = 0; first < count; first += kTileNodes) {
            block_.count = std::min(kTileNodes, count - first);
            for (int n = 0; n < block_.count; ++n) {
                block_.a[n] = range.a0 + static_cast<float>((first + n) % side) * step_a;
                block_.b[n] = range.b0 + static_cast<float>((first + n) / side) * step_b;
            }
            EvaluatePoints(fit, fields, nullptr, block_);
            for (int n = 0; n < block_.count; ++n) {
                Point& p = points[static_cast<std::size_t>(first + n)];
                p.x = block_.px[n];
                p.y = block_.py[n];
                p.det = block_.det[n];
                for (int f = 0; f < fields; ++f)
                    p.fields[static_cast<std::size_t>(f)] = block_.fields[f][n];
            }
        }
    }

    // Cuts a part of the cell into cuts x cuts parts, those of them that fold into finer ones.
    void AddParts(const FittedCell& cell, const CellPart& range, int cuts, int depth) {
        const int side = 2 * cuts + 1;
        for (std::size_t k = 0; k < kTracedInTiles; ++k)
            Evaluate(cell.fits[k], range, side, cell.open, points_[k]);
        const float step_a = (range.a1 - range.a0) / static_cast<float>(cuts);
        const float step_b = (range.b1 - range.b0) / static_cast<float>(cuts);
        std::vector<CellPart> wide;
        for (int j = 0; j < cuts; ++j) {
            for (int i = 0; i < cuts; ++i) {
                FittedPart part;
                part.range = {range.a0 + static_cast<float>(i) * step_a,
                              range.a0 + static_cast<float>(i + 1) * step_a,
                              range.b0 + static_cast<float>(j) * step_b,
                              range.b0 + static_cast<float>(j + 1) * step_b};
                part.shut = !cell.open;
                bool split = false;
                for (std::size_t k = 0; k < kTracedInTiles; ++k) {
                    std::array<const Point*, 9> at{};
                    for (int n = 0; n < 9; ++n) {
                        at[static_cast<std::size_t>(n)] = &points_[k][static_cast<std::size_t>(
                            (2 * j + n / 3) * side + 2 * i + n % 3)];
                    }
                    const PartView& view = part.views[k] = ViewOf(at);
                    if (!cell.open) SetMasks(at, part);
                    split = split || (view.folds && (view.box.x1 - view.box.x0 > kNarrow_px ||
                                                     view.box.y1 - view.box.y0 > kNarrow_px));
                }
                if (split && !part.shut && depth < kMostDepth) {
                    wide.push_back(part.range);
                } else {
                    out_.push_back(part);
                }
            }
        }
        for (const CellPart& part : wide) AddParts(cell, part, 2, depth + 1);
    }

    static PartView ViewOf(const std::array<const Point*, 9>& at) {
        PartView view;
        float least = 1e30F;
        float most = -1e30F;
        for (const Point* p : at) {
            view.box.Join({p->x, p->y, p->x, p->y});
            least = std::min(least, p->det);
            most = std::max(most, p->det);
        }
        view.box = view.box.Grown(0.1F * (view.box.x1 - view.box.x0) + 0.1F,
                                  0.1F * (view.box.y1 - view.box.y0) + 0.1F);
        view.folds = least * most <= 0.0F;
        view.on_sheet = {most > 0.0F, least < 0.0F};
        return view;
    }

    // Do the masks shut out all nine points, and what lies between and around them, or let all of
    // it pass?
    void SetMasks(const std::array<const Point*, 9>& at, FittedPart& part) const {
        bool shut = false;
        for (std::size_t r = 0; r < rims_; ++r) {
            float lo = 1e30F;
            float hi = -1e30F;
            for (const Point* p : at) {
                lo = std::min(lo, p->fields[2 * crossings_ + r]);
                hi = std::max(hi, p->fields[2 * crossings_ + r]);
            }
            const float room = kBetween * (hi - lo);
            shut = shut || lo - room > 0.0F;
            part.open = part.open && hi + room < 0.0F;
        }
        for (std::size_t c = 0; c < crossings_; ++c) {
            PixelBox box;
            for (const Point* p : at) {
                const float x = p->fields[2 * c];
                const float y = p->fields[2 * c + 1];
                box.Join({x, y, x, y});
            }
            box = box.Grown(kBetween * (box.x1 - box.x0), kBetween * (box.y1 - box.y0));
            shut = shut || box.Nearest2() > outer_ * outer_;
            part.open = part.open && box.Farthest2() < inner_ * inner_;
            if (picture_ == nullptr) continue;
            const StopRange range =
                picture_->Over(static_cast<double>(box.x0), static_cast<double>(box.y0),
                               static_cast<double>(box.x1), static_cast<double>(box.y1));
            shut = shut || range.dark();
            part.open = part.open && range.clear();
        }
        part.shut = part.shut && shut;
    }

    // Room for what lies between the points and for wavelengths outside the traced ones.
    static constexpr float kBetween = 0.25F;

    std::size_t crossings_, rims_;
    float outer_, inner_;  // of the iris's edges
    const StopPicture* picture_;
    std::vector<FittedPart>& out_;
    NodeBlock block_;
    std::array<std::vector<Point>, kTracedInTiles> points_;
};

}  // namespace

void PixelBox::Join(const PixelBox& other) {
    x0 = std::min(x0, other.x0);
    y0 = std::min(y0, other.y0);
    x1 = std::max(x1, other.x1);
    y1 = std::max(y1, other.y1);
}

void PixelBox::Clip(const PixelBox& other) {
    x0 = std::max(x0, other.x0);
    y0 = std::max(y0, other.y0);
    x1 = std::min(x1, other.x1);
    y1 = std::min(y1, other.y1);
}

float PixelBox::Nearest2() const {
    const float x = std::max({x0, -x1, 0.0F});
    const float y = std::max({y0, -y1, 0.0F});
    return x * x + y * y;
}

float PixelBox::Farthest2() const {
    const float x = std::max(std::abs(x0), std::abs(x1));
    const float y = std::max(std::abs(y0), std::abs(y1));
    return x * x + y * y;
}

PixelBox BoxOf(const GhostLight::Cell& cell) {
    return {static_cast<float>(cell.x0), static_cast<float>(cell.y0), static_cast<float>(cell.x1),
            static_cast<float>(cell.y1)};
}

MaskFields MasksOf(const GhostSurface& surface, const std::vector<GhostLight::Cell>& cells,
                   const Iris& iris) {
    const GhostMesh& mesh = surface.mesh();
    std::vector<bool> stop(static_cast<std::size_t>(mesh.stop_crossings), false);
    std::vector<bool> rim(mesh.rims.size(), false);
    const double inner2 = iris.inner_radius() * iris.inner_radius() * 0.98;
    for (const GhostLight::Cell& cell : cells) {
        if (cell.open) continue;
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(cell.place.grid)];
        const auto stored = static_cast<std::size_t>(mesh.stored_count());
        for (int corner = 0; corner < 4; ++corner) {
            const std::size_t v = grid.Vertex(cell.place.i + corner % 2, cell.place.j + corner / 2);
            for (const MeshNode& node : grid.nodes) {
                const float* const at = &node.fields[v * stored];
                for (std::size_t c = 0; c < stop.size(); ++c) {
                    const auto f = static_cast<std::size_t>(mesh.stop_field(static_cast<int>(c)));
                    const double x = static_cast<double>(at[f]);
                    const double y = static_cast<double>(at[f + 1]);
                    if (x * x + y * y > inner2) stop[c] = true;
                }
                for (std::size_t r = 0; r < rim.size(); ++r) {
                    if (at[mesh.rim_field(static_cast<int>(r))] > -0.02F) rim[r] = true;
                }
            }
        }
    }
    MaskFields masks;
    for (std::size_t c = 0; c < stop.size(); ++c) {
        if (stop[c]) masks.crossings.push_back(static_cast<int>(c));
    }
    for (std::size_t r = 0; r < rim.size(); ++r) {
        if (rim[r]) masks.rims.push_back(static_cast<int>(r));
    }
    return masks;
}

FittedGhost::FittedGhost(const GhostLight& ghost, const Iris& iris, const PictureMap& map)
    : ghost_(ghost), map_(map) {
    const GhostSurface& surface = *ghost.surface;
    const GhostMesh& mesh = surface.mesh();
    cells_.reserve(ghost.cells.size());
    fields_ = std::make_unique_for_overwrite<CellPolynomial[]>(
        ghost.cells.size() * kTracedInTiles * static_cast<std::size_t>(ghost.masks.count()));
    CellSurvey survey(ghost.masks, iris, parts_);
    CellJets x, y;
    for (std::size_t n = 0; n < ghost.cells.size(); ++n) {
        const GhostLight::Cell& from = ghost.cells[n];
        if (surface.UseOf(from.place) == CellUse::kTriangle) {
            AddTriangle(from.place);
            continue;
        }
        FittedCell& cell = cells_.emplace_back();
        cell.cell = static_cast<int>(n);
        cell.ring = from.ring;
        cell.open = from.open;
        cell.box = BoxOf(from);
        const MeshGrid& main = mesh.grids.front();
        const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(from.place.grid)];
        cell.u =
            static_cast<float>((grid.u0 - main.u0) / main.du + from.place.i * grid.du / main.du);
        cell.v =
            static_cast<float>((grid.v0 - main.v0) / main.dv + from.place.j * grid.dv / main.dv);
        cell.step = static_cast<float>(grid.du / main.du);
        for (std::size_t k = 0; k < kTracedInTiles; ++k) {
            CellFit& fit = cell.fits[k];
            surface.Jets(from.place, k, 0, x);
            surface.Jets(from.place, k, 1, y);
            MapNets(x, y, map.px_per_x, map.px_per_y, map.offset_px);
            fit.x = PolynomialOf(x);
            fit.y = PolynomialOf(y);
            const NetRange rx = RangeOf(x);
            const NetRange ry = RangeOf(y);
            cell.boxes[k] = {static_cast<float>(rx.lo), static_cast<float>(ry.lo),
                             static_cast<float>(rx.hi), static_cast<float>(ry.hi)};
            cell.boxes[k].Clip(cell.box);
        }
        if (!cell.open) NeedMasks(cell);
        survey.Add(cell);
    }
}

void FittedGhost::AddTriangle(const CellPlace& place) {
    const GhostSurface& surface = *ghost_.surface;
    const GhostMesh& mesh = surface.mesh();
    const MeshGrid& grid = mesh.grids[static_cast<std::size_t>(place.grid)];
    const auto stored = static_cast<std::size_t>(mesh.stored_count());
    std::vector<std::array<Vec2d, kTracedInTiles>> corners;
    for (int corner = 0; corner < 4; ++corner) {
        const std::size_t v = grid.Vertex(place.i + corner % 2, place.j + corner / 2);
        if (grid.alive[v] == 0) continue;
        std::array<Vec2d, kTracedInTiles>& at = corners.emplace_back();
        for (std::size_t k = 0; k < kTracedInTiles; ++k) {
            const Vec2d place_mm =
                mesh.SensorPlace(&grid.nodes[k].fields[v * stored], surface.sensor_gap_mm());
            at[k] = map_.Pixel(place_mm.x, place_mm.y);
        }
    }
    std::vector<Triangle>& bands = triangles_.emplace_back();
    for (const GhostLight::Band& band : ghost_.bands) {
        Triangle& triangle = bands.emplace_back();
        for (std::size_t c = 0; c < corners.size(); ++c) {
            triangle[c] = Vec2d(0.0, 0.0);
            for (std::size_t k = 0; k < kTracedInTiles; ++k)
                triangle[c] += corners[c][k] * band.node_weights[k];
        }
    }
}

void FittedGhost::FitMasks(FittedCell& cell) {
    const MaskFields& masks = ghost_.masks;
    const GhostSurface& surface = *ghost_.surface;
    const GhostMesh& mesh = surface.mesh();
    const CellPlace& place = ghost_.cells[static_cast<std::size_t>(cell.cell)].place;
    CellPolynomial* field = &fields_[static_cast<std::size_t>(&cell - cells_.data()) *
                                     kTracedInTiles * static_cast<std::size_t>(masks.count())];
    CellJets x, y;
    for (std::size_t k = 0; k < kTracedInTiles; ++k) {
        CellFit& fit = cell.fits[k];
        fit.fields = field;
        fit.field_count = masks.count();
        for (const int crossing : masks.crossings) {
            const auto f = static_cast<std::size_t>(mesh.stop_field(crossing));
            surface.Jets(place, k, f, x);
            surface.Jets(place, k, f + 1, y);
            MapNets(x, y, map_.stop_per_x, map_.stop_per_y, {0.0, 0.0});
            *field++ = PolynomialOf(x);
            *field++ = PolynomialOf(y);
        }
        for (const int rim : masks.rims) {
            surface.Jets(place, k, static_cast<std::size_t>(mesh.rim_field(rim)), x);
            *field++ = PolynomialOf(x);
        }
    }
}

}  // namespace flare
