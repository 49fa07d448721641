// SPDX-License-Identifier: Apache-2.0
#include "core/image/cell_bounds.h"

#include <algorithm>
#include <limits>

#include "core/image/net_shape.h"

namespace flare {
namespace {

// One field over a cell at several wavelengths, in single precision as the mesh is.
class FieldRanges {
  public:
    FieldRanges(const GhostSurface& surface, const CellPlace& cell,
                const std::vector<std::vector<double>>& node_weights)
        : surface_(surface), cell_(cell), weights_(node_weights), jets_(node_weights.size()) {}

    // At each wavelength.
    const std::vector<CellJets>& Jets(std::size_t field) {
        for (CellJets& jets : jets_) jets = {};
        const std::size_t nodes = surface_.mesh().grids.front().nodes.size();
        CellJets traced;
        for (std::size_t k = 0; k < nodes; ++k) {
            surface_.Jets(cell_, k, field, traced);
            for (std::size_t w = 0; w < weights_.size(); ++w) {
                const auto share = static_cast<float>(weights_[w][k]);
                for (std::size_t corner = 0; corner < 4; ++corner) {
                    for (std::size_t d = 0; d < 4; ++d)
                        jets_[w][corner][d] += share * traced[corner][d];
                }
            }
        }
        return jets_;
    }

  private:
    const GhostSurface& surface_;
    const CellPlace& cell_;
    const std::vector<std::vector<double>>& weights_;
    std::vector<CellJets> jets_;
};

}  // namespace

CellBounds BoundCell(const GhostSurface& surface,
                     const std::vector<std::vector<double>>& node_weights, const CellPlace& cell,
                     const Iris& iris, const PictureMap& map) {
    // Between the wavelengths that are looked at masks may move by a little.
    constexpr double kOpenMargin = 1e-3;
    CellBounds bounds;
    const GhostMesh& mesh = surface.mesh();
    if (surface.FarOutsideStop(cell, iris.outer_radius())) return bounds;
    bounds.open = surface.UseOf(cell) != CellUse::kTriangle;
    bounds.x0 = bounds.y0 = std::numeric_limits<double>::infinity();
    bounds.x1 = bounds.y1 = -bounds.x0;
    FieldRanges ranges(surface, cell, node_weights);
    const std::size_t count = node_weights.size();
    std::vector<bool> shut(count, false);
    for (int c = 0; c < mesh.stop_crossings; ++c) {
        // A box in canonical coordinates; the distance from the axis is the same in the camera's.
        const auto f = static_cast<std::size_t>(mesh.stop_field(c));
        const std::vector<CellJets> xs = ranges.Jets(f);
        const std::vector<CellJets>& ys = ranges.Jets(f + 1);
        for (std::size_t w = 0; w < count; ++w) {
            const NetRange x = RangeOf(xs[w]);
            const NetRange y = RangeOf(ys[w]);
            shut[w] = shut[w] || NearestToOrigin(x, y) > iris.outer_radius();
            bounds.open =
                bounds.open && FarthestFromOrigin(x, y) < iris.inner_radius() * (1.0 - kOpenMargin);
        }
    }
    for (int r = 0; r < static_cast<int>(mesh.rims.size()); ++r) {
        const std::vector<CellJets>& rims =
            ranges.Jets(static_cast<std::size_t>(mesh.rim_field(r)));
        for (std::size_t w = 0; w < count; ++w) {
            const NetRange rim = RangeOf(rims[w]);
            shut[w] = shut[w] || rim.lo > 0.0;
            bounds.open = bounds.open && rim.hi < -kOpenMargin;
        }
    }
    // Also where it is shut: a wavelength in between may pass.
    std::vector<CellJets> xs = ranges.Jets(0);
    std::vector<CellJets> ys = ranges.Jets(1);
    for (std::size_t w = 0; w < count; ++w) {
        MapNets(xs[w], ys[w], map.px_per_x, map.px_per_y, map.offset_px);
        const NetRange x = RangeOf(xs[w]);
        const NetRange y = RangeOf(ys[w]);
        bounds.x0 = std::min(bounds.x0, x.lo);
        bounds.x1 = std::max(bounds.x1, x.hi);
        bounds.y0 = std::min(bounds.y0, y.lo);
        bounds.y1 = std::max(bounds.y1, y.hi);
        bounds.passes = bounds.passes || !shut[w];
    }
    return bounds;
}

}  // namespace flare
