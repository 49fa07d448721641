// SPDX-License-Identifier: Apache-2.0
#include "core/image/source_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/image/blur_rows.h"
#include "core/image/polygon_raster.h"

namespace flare {
namespace {

constexpr int kRows = 16;
constexpr double kPixel = 1.0 / 12.0;               // second moment of a pixel
constexpr double kSmall_px = 1.0, kLarge_px = 3.0;  // semi-axes

// A symmetric matrix [xx xy; xy yy].
struct Moments {
    double xx = 0.0, xy = 0.0, yy = 0.0;
};

// f of the eigenvalues, eigenvectors kept.
template <class F>
Moments OfEigenvalues(const Moments& m, F f) {
    const double mean = 0.5 * (m.xx + m.yy);
    const double half = 0.5 * (m.xx - m.yy);
    const double radius = std::hypot(half, m.xy);
    const double hi = f(mean + radius);
    const double lo = f(std::max(0.0, mean - radius));
    if (!(radius > 0.0)) return {hi, 0.0, hi};
    const double c = half / radius;
    const double s = m.xy / radius;
    const double middle = 0.5 * (hi + lo);
    const double spread = 0.5 * (hi - lo);
    return {middle + spread * c, spread * s, middle - spread * c};
}

// What drawing on pixels of 2^coarse and opening them out again (coarse_levels.h) blurs, beyond
// a picture of pixels of 1: second moment along each axis.
double DrawnBlur(int coarse) {
    return (1.0 - std::pow(0.25, coarse)) / 3.0;
}

// The second moment of the kernel's outline, for an image of moment l of which pixels make `by`
// more: smooth in l, and 0 at 0.
double Shrunk(double l, double by) {
    return l >= 2.0 * by ? l - by : l * l / (4.0 * by);
}

class KernelRaster {
  public:
    KernelRaster(int half_x, int half_y)
        : half_x_(half_x),
          half_y_(half_y),
          width_(2 * half_x + 1),
          weights_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(2 * half_y + 1)) {}

    void Draw(const std::vector<SourcePatch>& patches) {
        const RasterTarget target{{weights_.data()}, -half_x_, -half_y_, width_, 2 * half_y_ + 1};
        PolygonRaster raster(target, 1);
        for (const SourcePatch& patch : patches) raster.Add(patch.outline, {&patch.share, 1}, 0);
        raster.Flush();
    }

    // Gives the weights a sum of 1, a mean of 0 and, as far as `share` says, these second moments,
    // by differences at 0.
    void Correct(const Moments& wanted, double share) {
        double sum = 0.0;
        Vec2d mean(0.0, 0.0);
        Moments has;
        for (int y = -half_y_; y <= half_y_; ++y) {
            for (int x = -half_x_; x <= half_x_; ++x) {
                const double w = At(x, y);
                sum += w;
                mean += Vec2d(x, y) * w;
                has.xx += w * x * x;
                has.xy += w * x * y;
                has.yy += w * y * y;
            }
        }
        const double x2 = 0.5 * share * (wanted.xx - has.xx);
        const double y2 = 0.5 * share * (wanted.yy - has.yy);
        const double xy = 0.25 * share * (wanted.xy - has.xy);
        At(1, 0) += x2 - 0.5 * mean.x;
        At(-1, 0) += x2 + 0.5 * mean.x;
        At(0, 1) += y2 - 0.5 * mean.y;
        At(0, -1) += y2 + 0.5 * mean.y;
        At(0, 0) += 1.0 - sum - 2.0 * (x2 + y2);
        At(1, 1) += xy;
        At(-1, -1) += xy;
        At(1, -1) -= xy;
        At(-1, 1) -= xy;
    }

    BlurKernel Finish() const {
        BlurKernel kernel{-half_x_, -half_y_, width_, 2 * half_y_ + 1, {}, {}, {}};
        kernel.weights.assign(weights_.begin(), weights_.end());
        for (int y = 0; y < kernel.height; ++y) {
            const float* const row = &kernel.weights[static_cast<std::size_t>(y * width_)];
            int first = 0;
            int end = width_;
            while (first < end && row[first] == 0.0F) ++first;
            while (end > first && row[end - 1] == 0.0F) --end;
            kernel.first.push_back(first);
            kernel.end.push_back(end);
        }
        return kernel;
    }

  private:
    double& At(int x, int y) {
        return weights_[static_cast<std::size_t>((y + half_y_) * width_ + x + half_x_)];
    }

    int half_x_, half_y_, width_;
    std::vector<double> weights_;
};

// Calls f(a, b, a x b) for each side of an outline.
template <class F>
void EachSide(const std::vector<Vec2d>& outline, F f) {
    FLARE_CHECK(outline.size() >= 3);
    for (std::size_t k = 0; k < outline.size(); ++k) {
        const Vec2d& a = outline[k];
        const Vec2d& b = outline[(k + 1) % outline.size()];
        f(a, b, a.x * b.y - a.y * b.x);
    }
}

// The columns of each row that are not black in all channels.
struct LitColumns {
    std::vector<int> first, end;
};

LitColumns LitColumnsOf(const LightPlanes& light) {
    const PixelWindow& w = light.window;
    LitColumns lit;
    for (int y = 0; y < w.height; ++y) {
        int first = w.width;
        int end = 0;
        for (const std::vector<float>& channel : light.channels) {
            const float* const row =
                channel.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w.width);
            int from = 0;
            while (from < first && row[from] == 0.0F) ++from;
            first = from;
            int to = w.width;
            while (to > end && row[to - 1] == 0.0F) --to;
            end = to;
        }
        lit.first.push_back(w.x + first);
        lit.end.push_back(w.x + std::max(first, end));
    }
    return lit;
}

// The rows that kBlurRun pixels from (x, y) on are summed from; what is black adds nothing, so
// leaving it out changes no bit.
void GatherRows(const LightPlanes& from, const LitColumns& lit, const BlurKernel& kernel, int x,
                int y, std::vector<BlurRow>& rows) {
    rows.clear();
    for (int j = 0; j < kernel.height; ++j) {
        const int row = y - (kernel.y0 + j) - from.window.y;
        if (row < 0 || row >= from.window.height) continue;
        const auto r = static_cast<std::size_t>(row);
        const int first = kernel.first[static_cast<std::size_t>(j)];
        const int end = kernel.end[static_cast<std::size_t>(j)];
        if (lit.first[r] >= x + kBlurRun - (kernel.x0 + first) ||
            lit.end[r] <= x - (kernel.x0 + end - 1)) {
            continue;
        }
        rows.push_back({from.channels.front().data() +
                            r * static_cast<std::size_t>(from.window.width) +
                            (x - kernel.x0 - from.window.x),
                        &kernel.weights[static_cast<std::size_t>(j * kernel.width)], first, end});
    }
}

}  // namespace

SourceCell CellOfPatches(std::vector<SourcePatch> patches, Vec2d& centroid) {
    double shares = 0.0;
    for (const SourcePatch& patch : patches) shares += patch.share;
    FLARE_CHECK(shares > 0.0);
    centroid = Vec2d(0.0, 0.0);
    for (SourcePatch& patch : patches) {
        patch.share /= shares;
        double area = 0.0;
        Vec2d first(0.0, 0.0);
        EachSide(patch.outline, [&](const Vec2d& a, const Vec2d& b, double cross) {
            area += 0.5 * cross;
            first += (a + b) * (cross / 6.0);
        });
        FLARE_CHECK(area != 0.0);
        centroid += first * (patch.share / area);
    }
    SourceCell cell;
    for (SourcePatch& patch : patches) {
        for (Vec2d& p : patch.outline) p -= centroid;
        double area = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
        EachSide(patch.outline, [&](const Vec2d& a, const Vec2d& b, double cross) {
            area += 0.5 * cross;
            xx += cross * (a.x * a.x + a.x * b.x + b.x * b.x);
            yy += cross * (a.y * a.y + a.y * b.y + b.y * b.y);
            xy += 0.5 * cross * (2.0 * a.x * a.y + a.x * b.y + b.x * a.y + 2.0 * b.x * b.y);
        });
        const double w = patch.share / (12.0 * area);
        cell.xx += w * xx;
        cell.xy += w * xy;
        cell.yy += w * yy;
    }
    cell.patches = std::move(patches);
    return cell;
}

BlurKernel KernelOf(const SourceCell& cell, const SourceImage& image) {
    const Vec2d& u = image.along_u;
    const Vec2d& v = image.along_v;
    const auto moment = [&](double ux, double vx, double uy, double vy) {
        return ux * uy * cell.xx + (ux * vy + vx * uy) * cell.xy + vx * vy * cell.yy;
    };
    const Moments whole{moment(u.x, v.x, u.x, v.x), moment(u.x, v.x, u.y, v.y),
                        moment(u.y, v.y, u.y, v.y)};
    const double drawn = DrawnBlur(image.coarse);
    const Moments scale = OfEigenvalues(
        whole, [&](double l) { return l > 0.0 ? std::sqrt(Shrunk(l, kPixel + drawn) / l) : 0.0; });
    const Moments wanted = OfEigenvalues(
        whole, [&](double l) { return std::max(l - drawn, Shrunk(l, kPixel + drawn)); });

    std::vector<SourcePatch> patches = cell.patches;
    double reach_x = 0.0, reach_y = 0.0;
    for (SourcePatch& patch : patches) {
        for (Vec2d& p : patch.outline) {
            const Vec2d at = u * p.x + v * p.y;
            const Vec2d small(scale.xx * at.x + scale.xy * at.y, scale.xy * at.x + scale.yy * at.y);
            reach_x = std::max(reach_x, std::abs(small.x));
            reach_y = std::max(reach_y, std::abs(small.y));
            p = small + Vec2d(0.5, 0.5);
        }
    }
    KernelRaster raster(static_cast<int>(std::ceil(reach_x + 0.5)) + 1,
                        static_cast<int>(std::ceil(reach_y + 0.5)) + 1);
    raster.Draw(patches);
    // How pixels lie on a larger outline makes its moments swing a little about the right ones,
    // which is better left than mended in the middle.
    const double semi = 2.0 * std::sqrt(std::max(0.0, 0.5 * (whole.xx + whole.yy)));
    raster.Correct(wanted, std::clamp((kLarge_px - semi) / (kLarge_px - kSmall_px), 0.0, 1.0));
    return raster.Finish();
}

PixelWindow WithBlurMargin(const PixelWindow& window, const BlurKernel& kernel) {
    const int margin = kernel.width + kBlurRun;
    return {window.x - margin, window.y, window.width + 2 * margin, window.height};
}

void AddBlurred(const LightPlanes& from, const BlurKernel& kernel, LightPlanes& to,
                ThreadPool& threads) {
    const PixelWindow& out = to.window;
    const int margin = kernel.width + kBlurRun;
    const int x0 = std::max(out.x, from.window.x + margin + kernel.x0);
    const int y0 = std::max(out.y, from.window.y + kernel.y0);
    const int x1 = std::min(out.x + out.width, from.window.x + from.window.width - margin +
                                                   kernel.x0 + kernel.width - 1);
    const int y1 = std::min(out.y + out.height,
                            from.window.y + from.window.height + kernel.y0 + kernel.height - 1);
    if (x0 >= x1 || y0 >= y1) return;
    const auto channels = from.channels.size();
    const LitColumns lit = LitColumnsOf(from);
    threads.For((y1 - y0 + kRows - 1) / kRows, [&](int strip) {
        const int end = std::min(y1, y0 + (strip + 1) * kRows);
        std::vector<BlurRow> rows;
        std::array<float, kBlurRun> sums{};
        for (int y = y0 + strip * kRows; y < end; ++y) {
            for (int x = x0; x < x1; x += kBlurRun) {
                GatherRows(from, lit, kernel, x, y, rows);
                if (rows.empty()) continue;
                const int count = std::min(kBlurRun, x1 - x);
                for (std::size_t c = 0; c < channels; ++c) {
                    if (c > 0) {
                        for (BlurRow& row : rows) {
                            row.light =
                                from.channels[c].data() + (row.light - from.channels[c - 1].data());
                        }
                    }
                    SumBlurRows(rows, sums.data());
                    float* const row =
                        to.channels[c].data() +
                        static_cast<std::size_t>(y - out.y) * static_cast<std::size_t>(out.width) +
                        (x - out.x);
                    for (int k = 0; k < count; ++k) row[k] += sums[static_cast<std::size_t>(k)];
                }
            }
        }
    });
}

}  // namespace flare
