// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_peak.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "core/render/ghost_estimate.h"
#include "core/render/ghost_light.h"

namespace flare {
namespace {

// In pixels of kPeakPixel_mm. Wide dim parts need no care.
constexpr WalkTolerance kTolerance{0.5, 0.3, 1.0, 4096.0, 0.3};
constexpr double kSmall_px2 = 4.0;    // pieces below are added up pixel by pixel
constexpr double kFarthest_px = 1e6;  // 19 m: what lands beyond is no peak

class PeakSink final : public PieceSink {
  public:
    void Add(std::span<const Vec2d> points, std::span<const double> light, int /*band*/) override {
        double twice_area = 0.0;
        Vec2d middle(0.0, 0.0);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec2d& p = points[i];
            const Vec2d& q = points[(i + 1) % points.size()];
            twice_area += p.x * q.y - p.y * q.x;
            middle += p / static_cast<double>(points.size());
        }
        const double area = 0.5 * std::abs(twice_area);
        if (area >= kSmall_px2) {
            peak_ = std::max(peak_, light[0] / area);
            return;
        }
        if (!(std::abs(middle.x) < kFarthest_px && std::abs(middle.y) < kFarthest_px)) return;
        const auto x = static_cast<std::int64_t>(std::floor(middle.x));
        const auto y = static_cast<std::int64_t>(std::floor(middle.y));
        double& pixel = pixels_[x * 4'000'000 + y];
        pixel += light[0];
        peak_ = std::max(peak_, pixel);
    }
    void EndOfPiece() override {}

    double peak() const { return peak_; }  // light a pixel

  private:
    double peak_ = 0.0;
    std::unordered_map<std::int64_t, double> pixels_;
};

}  // namespace

double PeakOfPieces(const std::shared_ptr<const GhostSurface>& surface, const LightBundle& bundle,
                    const Lens& lens, const TransmissionTables& tables, const Iris& iris,
                    const CanonicalPose& pose) {
    PictureMap map;
    map.px_per_x = {1.0 / kPeakPixel_mm, 0.0};
    map.px_per_y = {0.0, 1.0 / kPeakPixel_mm};
    map.stop_per_x = pose.x_axis;
    map.stop_per_y = pose.y_axis;
    LightColour colour;
    colour.spectral = true;
    const GhostLight prepared =
        PrepareGhost(surface, bundle, lens, tables, colour,
                     CellsInWindow(*surface, {tables.wavelengths_nm().front()}, iris, map, {}));
    if (prepared.cells.empty()) return 0.0;
    PeakSink sink;
    GhostWalk walk(prepared, iris, map, kTolerance);
    for (const GhostLight::Cell& cell : prepared.cells) walk.Cell(cell, {}, sink);
    return sink.peak() / (kPeakPixel_mm * kPeakPixel_mm);
}

}  // namespace flare
