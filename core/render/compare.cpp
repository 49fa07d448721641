// SPDX-License-Identifier: Apache-2.0
//
// Every sum is made in index order in double precision. The blur takes what lies outside the window
// as black in both pictures, so that a window's own edge adds no error; it is linear, so E - Er is
// blurred, not E and Er apart.
#include "core/render/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <set>

#include "core/image/channel_name.h"

namespace flare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kBlurSigma_px = 2.0;
constexpr int kBlurRadius_px = 8;  // 4 sigma: 6e-5 of the weight lies outside

using Floats = std::vector<float>;

// What says how sure a picture is, not what is in it.
bool IsLight(const ImagePlane& plane) {
    return LayerOfChannel(plane.name) != "photon_error";
}

struct PlanePair {
    std::string layer;
    const Floats* image;
    const Floats* reference;
};

std::array<double, 2 * kBlurRadius_px + 1> BlurKernel() {
    std::array<double, 2 * kBlurRadius_px + 1> kernel{};
    double sum = 0.0;
    for (int k = -kBlurRadius_px; k <= kBlurRadius_px; ++k) {
        const double weight = std::exp(-0.5 * k * k / (kBlurSigma_px * kBlurSigma_px));
        kernel[static_cast<std::size_t>(k + kBlurRadius_px)] = weight;
        sum += weight;
    }
    for (double& weight : kernel) weight /= sum;
    return kernel;
}

// Sum of squares of the blurred plane: rows are blurred first, then columns, whose result is summed
// row by row and never stored.
double BlurredSquares(const std::vector<double>& plane, int width, int height) {
    static const auto kernel = BlurKernel();
    const auto columns = static_cast<std::size_t>(width);
    std::vector<double> rows(plane.size(), 0.0);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
        const double* in = plane.data() + y * columns;
        double* out = rows.data() + y * columns;
        for (int k = -kBlurRadius_px; k <= kBlurRadius_px; ++k) {
            const double weight = kernel[static_cast<std::size_t>(k + kBlurRadius_px)];
            const int last = std::min(width, width - k);
            for (int x = std::max(0, -k); x < last; ++x) out[x] += weight * in[x + k];
        }
    }
    double squares = 0.0;
    std::vector<double> line(columns);
    for (int y = 0; y < height; ++y) {
        std::fill(line.begin(), line.end(), 0.0);
        const int first = std::max(-kBlurRadius_px, -y);
        const int last = std::min(kBlurRadius_px, height - 1 - y);
        for (int k = first; k <= last; ++k) {
            const double weight = kernel[static_cast<std::size_t>(k + kBlurRadius_px)];
            const double* in = rows.data() + static_cast<std::size_t>(y + k) * columns;
            for (std::size_t x = 0; x < columns; ++x) line[x] += weight * in[x];
        }
        for (const double value : line) squares += value * value;
    }
    return squares;
}

template <class T>
T Percentile(std::vector<T>& values, double share) {
    const double rank = std::ceil(share * static_cast<double>(values.size()));
    const auto index = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    const auto at = values.begin() + index;
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// `error` relative to `size`, with 0 / 0 = 0.
double Relative(double error, double size) {
    if (size != 0.0) return error / size;
    return error == 0.0 ? 0.0 : std::copysign(kInfinity, error);
}

double LogErrorStops(float image, float reference, double epsilon) {
    const double e = std::max(static_cast<double>(image), 0.0) + epsilon;
    const double r = std::max(static_cast<double>(reference), 0.0) + epsilon;
    return e == r ? 0.0 : std::abs(std::log2(e / r));
}

void AddLogErrors(const std::vector<PlanePair>& planes, ErrorMetrics& metrics) {
    Floats image, reference;
    for (const PlanePair& plane : planes) {
        image.insert(image.end(), plane.image->begin(), plane.image->end());
        reference.insert(reference.end(), plane.reference->begin(), plane.reference->end());
    }
    const double p999 = static_cast<double>(Percentile(reference, 0.999));
    const double image_p999 = static_cast<double>(Percentile(image, 0.999));
    metrics.p999_ratio = image_p999 == p999 ? 1.0 : Relative(image_p999, p999);

    const float largest = *std::max_element(reference.begin(), reference.end());
    const double scale = p999 > 0.0 ? p999 : std::max(static_cast<double>(largest), 0.0);
    metrics.log_error_epsilon = 1e-4 * scale;

    Floats& stops =
        image;  // the percentile above left it without order, and it is not needed again
    double sum = 0.0;
    std::size_t n = 0;
    for (const PlanePair& plane : planes) {
        for (std::size_t i = 0; i < plane.image->size(); ++i, ++n) {
            const double stop =
                LogErrorStops((*plane.image)[i], (*plane.reference)[i], metrics.log_error_epsilon);
            stops[n] = static_cast<float>(stop);
            sum += stop;
        }
    }
    metrics.log_error_stops_mean = sum / static_cast<double>(n);
    metrics.log_error_stops_p99 = static_cast<double>(Percentile(stops, 0.99));
}

// What the sums over a layer are made of, for one plane.
struct PlaneSums {
    double difference = 0.0, image = 0.0, reference = 0.0, absolute_reference = 0.0;
    double blurred_difference = 0.0, blurred_reference = 0.0;  // of squares
    double max_abs = 0.0;
};

PlaneSums SumsOf(const PlanePair& plane, const PixelWindow& window) {
    PlaneSums sums;
    std::vector<double> difference(window.pixels()), reference(window.pixels());
    for (std::size_t i = 0; i < window.pixels(); ++i) {
        const auto e = static_cast<double>((*plane.image)[i]);
        reference[i] = static_cast<double>((*plane.reference)[i]);
        difference[i] = e - reference[i];
        const double distance = std::abs(difference[i]);
        sums.difference += distance;
        sums.image += e;
        sums.reference += reference[i];
        sums.absolute_reference += std::abs(reference[i]);
        sums.max_abs = std::max(sums.max_abs, distance);
    }
    sums.blurred_difference = BlurredSquares(difference, window.width, window.height);
    sums.blurred_reference = BlurredSquares(reference, window.width, window.height);
    return sums;
}

// Metrics of the planes of which `members` holds the indices.
ErrorMetrics Metrics(const std::vector<PlanePair>& pairs, const std::vector<PlaneSums>& sums,
                     const std::vector<std::size_t>& members) {
    PlaneSums total;
    std::vector<PlanePair> planes;
    for (const std::size_t i : members) {
        total.difference += sums[i].difference;
        total.image += sums[i].image;
        total.reference += sums[i].reference;
        total.absolute_reference += sums[i].absolute_reference;
        total.blurred_difference += sums[i].blurred_difference;
        total.blurred_reference += sums[i].blurred_reference;
        total.max_abs = std::max(total.max_abs, sums[i].max_abs);
        planes.push_back(pairs[i]);
    }
    ErrorMetrics metrics;
    metrics.rel_l1 = Relative(total.difference, total.absolute_reference);
    metrics.energy = Relative(total.image - total.reference, total.reference);
    metrics.rel_l2_blur2 = std::sqrt(Relative(total.blurred_difference, total.blurred_reference));
    metrics.max_abs = total.max_abs;
    AddLogErrors(planes, metrics);
    return metrics;
}

const ImagePlane* FindPlane(const FlareImage& image, const std::string& name) {
    for (const ImagePlane& plane : image.planes) {
        if (plane.name == name) return &plane;
    }
    return nullptr;
}

Error BadImage(std::string message, std::string where = "") {
    return {"bad_image", std::move(message), std::move(where)};
}

std::string Text(const PixelWindow& w) {
    return std::to_string(w.width) + " x " + std::to_string(w.height) + " at (" +
           std::to_string(w.x) + ", " + std::to_string(w.y) + ")";
}

Result<std::vector<PlanePair>> PairPlanes(const FlareImage& image, const FlareImage& reference) {
    if (image.data != reference.data) {
        return BadImage("the data windows differ: " + Text(image.data) + " against " +
                        Text(reference.data));
    }
    if (image.full != reference.full) {
        return BadImage("the frames differ: " + Text(image.full) + " against " +
                        Text(reference.full));
    }
    if (std::none_of(reference.planes.begin(), reference.planes.end(), IsLight) ||
        reference.data.pixels() == 0) {
        return BadImage("there is nothing to compare");
    }
    std::set<std::string> names;
    std::vector<PlanePair> pairs;
    for (const ImagePlane& plane : reference.planes) {
        if (!IsLight(plane)) continue;
        const ImagePlane* other = FindPlane(image, plane.name);
        if (other == nullptr) return BadImage("the image lacks a channel", plane.name);
        if (!names.insert(plane.name).second) return BadImage("a channel stands twice", plane.name);
        for (const ImagePlane* p : {other, &plane}) {
            if (p->values.size() != reference.data.pixels()) {
                return BadImage("a channel does not fill the data window", p->name);
            }
            if (!std::all_of(p->values.begin(), p->values.end(),
                             [](float v) { return std::isfinite(v); })) {
                return BadImage("a channel holds a value that is not finite", p->name);
            }
        }
        const std::vector<float>& samples = other->values;
        const std::vector<float>& truth = plane.values;
        pairs.push_back({LayerOfChannel(plane.name), &samples, &truth});
    }
    std::size_t lights = 0;
    for (const ImagePlane& plane : image.planes) {
        if (!IsLight(plane)) continue;
        ++lights;
        if (FindPlane(reference, plane.name) == nullptr) {
            return BadImage("the reference lacks a channel", plane.name);
        }
    }
    if (lights != pairs.size()) return BadImage("a channel of the image stands twice");
    return pairs;
}

}  // namespace

Result<Comparison> Compare(const FlareImage& image, const FlareImage& reference) {
    Result<std::vector<PlanePair>> paired = PairPlanes(image, reference);
    if (!paired) return paired.error();
    const std::vector<PlanePair>& pairs = *paired;

    std::vector<PlaneSums> sums;
    for (const PlanePair& pair : pairs) sums.push_back(SumsOf(pair, reference.data));

    std::vector<std::size_t> everything;
    std::vector<std::string> names;
    std::map<std::string, std::vector<std::size_t>> members;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const std::string& layer = pairs[i].layer;
        everything.push_back(i);
        if (!members.contains(layer)) names.push_back(layer);
        members[layer].push_back(i);
    }
    Comparison comparison;
    comparison.all = Metrics(pairs, sums, everything);
    for (const std::string& layer : names) {
        comparison.layers.push_back(
            {layer, names.size() == 1 ? comparison.all : Metrics(pairs, sums, members[layer])});
    }
    return comparison;
}

}  // namespace flare
