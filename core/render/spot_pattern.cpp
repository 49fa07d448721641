// SPDX-License-Identifier: Apache-2.0
#include "core/render/spot_pattern.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/image/polygon_raster.h"
#include "core/wave/coverage.h"
#include "core/wave/fourier.h"

namespace flare {
namespace {

// Near and far pattern change over between this share of the edge and the edge.
constexpr double kBlendFrom = 0.6;
constexpr double kDiscBlendFrom = 0.75;
// The middle of a disc's pattern reaches this many of its radii: farther out the disc matters only
// across spikes.
constexpr double kDiscRadii = 6.0;
// A near pattern that reaches no farther is narrower than what pixels see: the far one begins right
// at its square, also within a pixel.
constexpr double kLeastBlended_px = 2.5;
constexpr double kFineParts = 6.0;  // of a pixel, for the distance from the middle
constexpr double kPartsOfCut = 24.0, kMostFineParts = 48.0;
constexpr double kPointRadius_px = 0.05;  // a source this small is a point
constexpr int kPatchSide = 1024;          // cells, at most twice as many after rounding up
// Pixels so near to the middle that the far pattern is bent within them are cut up.
constexpr double kBentWithin_px = 16.0;
constexpr int kMostParts = 6;

double Smooth(double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

std::vector<PatternBand> PatternBands(const std::vector<SpotBand>& bands) {
    std::vector<PatternBand> out;
    for (const SpotBand& band : bands) out.push_back(band.band);
    return out;
}

// The light of a source in cells of `bin` pixels, cell (side / 2, side / 2) around its middle.
std::vector<double> SharesOf(const SpotSource& source, int side, int bin) {
    if (source.patches.empty()) {
        Loop ellipse;
        constexpr int kSides = 256;
        for (int i = 0; i < kSides; ++i) {
            const double angle = 2.0 * kPi * i / kSides;
            ellipse.push_back(source.ellipse.a * std::cos(angle) +
                              source.ellipse.b * std::sin(angle));
        }
        return Coverage({ellipse}, side, bin);
    }
    const auto n = static_cast<std::size_t>(side);
    std::vector<double> shares(n * n, 0.0);
    PolygonRaster raster({{shares.data()}, 0, 0, side, side}, 1);
    const double middle = side / 2 + 0.5;
    for (const SourcePatch& patch : source.patches) {
        std::vector<Vec2d> outline = patch.outline;
        for (Vec2d& p : outline) p = p / static_cast<double>(bin) + Vec2d(middle, middle);
        raster.Add(outline, {&patch.share, 1}, 0);
    }
    raster.Flush();
    return shares;
}

// How far from the middle far patterns are asked for: beyond, their tables stay as they are.
constexpr double kOutermost_px = 30'000.0;

}  // namespace

double SpotSource::reach() const {
    double reach = ellipse.radius();
    for (const SourcePatch& patch : patches) {
        for (const Vec2d& p : patch.outline) reach = std::max(reach, p.length());
    }
    return reach;
}

SpotPattern::SpotPattern(const std::vector<ApertureOutline>& outlines, const NearPattern& near,
                         const std::vector<SpotBand>& bands, const SpotSource& source, Vec2d middle,
                         double near_px, ThreadPool& threads)
    : near_(near),
      bands_(bands),
      middle_(middle),
      blended_(near_px >= kLeastBlended_px),
      point_edge_(near_px),
      point_far_(outlines, PatternBands(bands), {}, blended_ ? kBlendFrom * near_px : near_px,
                 kOutermost_px) {
    const double radius = source.reach();
    if (radius <= kPointRadius_px) return;
    disc_edge_ = std::max(kDiscRadii * radius, std::max(near_px, kLeastBlended_px) + 2.0 * radius);
    disc_far_.emplace(outlines, PatternBands(bands), source.ellipse, kDiscBlendFrom * disc_edge_,
                      kOutermost_px);
    BuildPatch(source, threads);
}

Vec3d SpotPattern::MeanFar(const FarPattern& far, Vec2d place, double size) const {
    const double bent = size * kBentWithin_px / std::max(place.length(), 1e-3);
    const int parts =
        std::max(static_cast<int>(size),
                 static_cast<int>(std::clamp(std::ceil(bent), 1.0, 1.0 * kMostParts)));
    if (parts == 1) return far.At(place);
    Vec3d sum(0.0, 0.0, 0.0);
    for (int j = 0; j < parts; ++j) {
        for (int i = 0; i < parts; ++i) {
            const Vec2d part(((i + 0.5) / parts - 0.5) * size, ((j + 0.5) / parts - 0.5) * size);
            sum += far.At(place + part);
        }
    }
    return sum / static_cast<double>(parts * parts);
}

// Of the part of a cell that lies outside the near pattern's square.
Vec3d SpotPattern::MeanOutside(Vec2d place, double size) const {
    const double half = 0.5 * size;
    const Vec2d off(std::abs(place.x), std::abs(place.y));
    const double farthest = std::max(off.x, off.y);
    if (farthest + half <= point_edge_) return Vec3d(0.0, 0.0, 0.0);
    const bool cut = farthest - half < point_edge_;
    const double nearest = std::hypot(std::max(off.x - half, 0.0), std::max(off.y - half, 0.0));
    const double fine = kFineParts * size / std::max(nearest, point_edge_);
    if (!cut && fine <= kMostParts) return MeanFar(point_far_, place, size);
    const int parts = static_cast<int>(
        std::clamp(std::ceil(fine), cut ? kPartsOfCut : 1.0, std::max(size, kMostFineParts)));
    Vec3d sum(0.0, 0.0, 0.0);
    for (int j = 0; j < parts; ++j) {
        for (int i = 0; i < parts; ++i) {
            const Vec2d at = place + Vec2d((i + 0.5) / parts - 0.5, (j + 0.5) / parts - 0.5) * size;
            if (std::max(std::abs(at.x), std::abs(at.y)) < point_edge_) continue;
            sum += point_far_.At(at);
        }
    }
    return sum / static_cast<double>(parts * parts);
}

// Band by band: the sums at the corners of the pixels that the near pattern reaches.
void SpotPattern::AddNear(const PixelWindow& cells, int bin, std::vector<Vec3d>& out) const {
    const double reach = point_edge_ + bin;
    const double square = blended_ ? 1e300 : point_edge_;
    const auto clip = [&](double at, int from, int size, int& lo, int& hi) {
        lo = std::clamp(static_cast<int>(std::floor((at - reach - from) / bin)), 0, size);
        hi = std::clamp(static_cast<int>(std::ceil((at + reach - from) / bin)), 0, size);
    };
    int i0 = 0, i1 = 0, j0 = 0, j1 = 0;
    clip(middle_.x, cells.x, cells.width, i0, i1);
    clip(middle_.y, cells.y, cells.height, j0, j1);
    if (i0 >= i1 || j0 >= j1) return;
    const auto columns = static_cast<std::size_t>(i1 - i0);
    std::vector<NearPattern::Line> lines(columns + 1);
    std::vector<double> above(columns + 1), below(columns + 1);
    for (const SpotBand& spot : bands_) {
        const double wavelength = spot.band.wavelength;
        for (int i = i0; i <= i1; ++i) {
            const double x = cells.x + static_cast<double>(i) * bin;
            lines[static_cast<std::size_t>(i - i0)] =
                near_.LineAt(std::clamp(x - spot.middle.x, -square, square) / wavelength);
        }
        const auto corners = [&](int j, std::vector<double>& sums) {
            const double y = cells.y + static_cast<double>(j) * bin;
            const NearPattern::Line line =
                near_.LineAt(std::clamp(y - spot.middle.y, -square, square) / wavelength);
            for (std::size_t i = 0; i <= columns; ++i) sums[i] = near_.Below(lines[i], line);
        };
        corners(j0, above);
        for (int j = j0; j < j1; ++j) {
            corners(j + 1, below);
            Vec3d* const row = out.data() +
                               static_cast<std::size_t>(j) * static_cast<std::size_t>(cells.width) +
                               static_cast<std::size_t>(i0);
            for (std::size_t i = 0; i < columns; ++i) {
                const double share = below[i + 1] - below[i] - above[i + 1] + above[i];
                row[i] += spot.band.weight * share;
            }
            std::swap(above, below);
        }
    }
}

// Of a point source, in cells of `bin` x `bin` pixels, `cells.x` and `cells.y` being pixels and its
// sides cells.
std::vector<Vec3d> SpotPattern::PointLight(const PixelWindow& cells, int bin) const {
    std::vector<Vec3d> light(cells.pixels(), Vec3d(0.0, 0.0, 0.0));
    AddNear(cells, bin, light);
    std::size_t k = 0;
    for (int j = 0; j < cells.height; ++j) {
        for (int i = 0; i < cells.width; ++i, ++k) {
            const Vec2d place =
                Vec2d(cells.x + (i + 0.5) * bin, cells.y + (j + 0.5) * bin) - middle_;
            if (!blended_) {
                light[k] += MeanOutside(place, bin) * (bin * bin);
                continue;
            }
            const double far_share =
                Smooth((place.length() / point_edge_ - kBlendFrom) / (1.0 - kBlendFrom));
            if (far_share <= 0.0) continue;
            light[k] = light[k] * (1.0 - far_share) +
                       MeanFar(point_far_, place, bin) * (far_share * bin * bin);
        }
    }
    return light;
}

void SpotPattern::BuildPatch(const SpotSource& source, ThreadPool& threads) {
    const double half = disc_edge_ + source.reach() + 2.0;
    patch_.bin = std::max(1, static_cast<int>(std::ceil(2.0 * half / kPatchSide)));
    patch_.side = 2;
    while (patch_.side * patch_.bin < 2.0 * half + 2.0 * patch_.bin) patch_.side *= 2;
    patch_.x0 = static_cast<int>(std::floor(middle_.x)) - patch_.side / 2 * patch_.bin;
    patch_.y0 = static_cast<int>(std::floor(middle_.y)) - patch_.side / 2 * patch_.bin;
    const auto n = static_cast<std::size_t>(patch_.side);

    // Two transforms hold three colours.
    std::vector<Complex> red_green(n * n), blue(n * n), kernel(n * n);
    constexpr int kRows = 16;
    threads.For((patch_.side + kRows - 1) / kRows, [&](int strip) {
        const int row = strip * kRows;
        const PixelWindow cells{patch_.x0, patch_.y0 + row * patch_.bin, patch_.side,
                                std::min(kRows, patch_.side - row)};
        const std::vector<Vec3d> light = PointLight(cells, patch_.bin);
        for (std::size_t k = 0; k < light.size(); ++k) {
            red_green[static_cast<std::size_t>(row) * n + k] = {light[k].x, light[k].y};
            blue[static_cast<std::size_t>(row) * n + k] = light[k].z;
        }
    });
    const std::vector<double> shares = SharesOf(source, patch_.side, patch_.bin);
    double sum = 0.0;
    for (const double share : shares) sum += share;
    // The kernel's middle comes first.
    for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < n; ++i) {
            kernel[(j + n / 2) % n * n + (i + n / 2) % n] = shares[j * n + i] / sum;
        }
    }
    const SquareFourier fourier(patch_.side);
    fourier.Forward(kernel, threads);
    for (std::vector<Complex>* field : {&red_green, &blue}) {
        fourier.Forward(*field, threads);
        for (std::size_t k = 0; k < kernel.size(); ++k) (*field)[k] *= kernel[k];
        fourier.Inverse(*field, threads);
    }
    patch_.light.resize(n * n);
    for (std::size_t k = 0; k < patch_.light.size(); ++k) {
        patch_.light[k] = Vec3d(red_green[k].real(), red_green[k].imag(), blue[k].real());
    }
}

// Light in the pixel whose middle is (x, y): linear between the cells' middles.
Vec3d SpotPattern::FromPatch(double x, double y) const {
    const double u = (x - patch_.x0) / patch_.bin - 0.5;
    const double v = (y - patch_.y0) / patch_.bin - 0.5;
    const auto n = static_cast<std::size_t>(patch_.side);
    const auto i = std::min(static_cast<std::size_t>(u), n - 2);
    const auto j = std::min(static_cast<std::size_t>(v), n - 2);
    const double s = u - static_cast<double>(i);
    const double t = v - static_cast<double>(j);
    const Vec3d* const at = patch_.light.data() + j * n + i;
    const Vec3d mean =
        (at[0] * (1.0 - s) + at[1] * s) * (1.0 - t) + (at[n] * (1.0 - s) + at[n + 1] * s) * t;
    return mean / static_cast<double>(patch_.bin * patch_.bin);
}

std::vector<Vec3d> SpotPattern::Light(const PixelWindow& window) const {
    if (!disc_far_) return PointLight(window, 1);
    std::vector<Vec3d> light(window.pixels(), Vec3d(0.0, 0.0, 0.0));
    std::size_t k = 0;
    for (int j = 0; j < window.height; ++j) {
        for (int i = 0; i < window.width; ++i, ++k) {
            const Vec2d at(window.x + i + 0.5, window.y + j + 0.5);
            const Vec2d place = at - middle_;
            const double far_share =
                Smooth((place.length() / disc_edge_ - kDiscBlendFrom) / (1.0 - kDiscBlendFrom));
            if (far_share < 1.0) light[k] = FromPatch(at.x, at.y) * (1.0 - far_share);
            if (far_share > 0.0) light[k] += disc_far_->At(place) * far_share;
        }
    }
    return light;
}

}  // namespace flare
