// SPDX-License-Identifier: Apache-2.0
//
// The PNG comes from libpng's one-call interface, which reports errors in a field instead of
// jumping past destructors.
#include "core/image/preview.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/check.h"
#include "core/base/half.h"
#include "core/image/channel_name.h"
#include "core/image/plane_values.h"
#include "core/image/saturated_pixels.h"

namespace flare {
namespace {

constexpr double kLitPercentile = 0.995;
constexpr int kCurveSteps = 1 << 15;
// Pixels of half planes that a thread takes at a time.
constexpr std::size_t kPixelsAtOnce = std::size_t{1} << 14;

// Linear value that sRGB shows as 80 % grey: what the percentile is set to, and the shoulder's
// start.
const float kKnee = static_cast<float>(std::pow((0.8 + 0.055) / 1.055, 2.4));

const ImagePlane* FindPlane(const FlareImage& image, const std::string& name) {
    for (const ImagePlane& plane : image.planes) {
        if (plane.name == name) return &plane;
    }
    return nullptr;
}

// R, G, B of the root or of the first layer that has all three; empty where there is none.
std::vector<const ImagePlane*> ColourPlanes(const FlareImage& image) {
    std::vector<std::string> prefixes = {""};
    for (const ImagePlane& plane : image.planes) {
        const std::string layer = LayerOfChannel(plane.name);
        if (!layer.empty()) prefixes.push_back(layer + ".");
    }
    for (const std::string& prefix : prefixes) {
        const ImagePlane* r = FindPlane(image, prefix + "R");
        const ImagePlane* g = FindPlane(image, prefix + "G");
        const ImagePlane* b = FindPlane(image, prefix + "B");
        if (r != nullptr && g != nullptr && b != nullptr) return {r, g, b};
    }
    return {};
}

// The shown channels, interleaved: three a pixel, or one.
struct Shown {
    int channels = 0;
    std::vector<float> values;
};

Shown ShownValues(const FlareImage& image) {
    const std::size_t pixels = image.data.pixels();
    const std::vector<const ImagePlane*> colours = ColourPlanes(image);
    Shown shown;
    if (!colours.empty()) {
        shown.channels = 3;
        shown.values.resize(3 * pixels);
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t i = 0; i < pixels; ++i) {
                shown.values[3 * i + c] = colours[c]->values[i];
            }
        }
    } else {
        shown.channels = 1;
        shown.values.assign(pixels, 0.0f);
        const std::string layer = LayerOfChannel(image.planes.front().name);
        float planes = 0.0f;
        for (const ImagePlane& plane : image.planes) {
            if (LayerOfChannel(plane.name) != layer) continue;
            planes += 1.0f;
            for (std::size_t i = 0; i < pixels; ++i) shown.values[i] += plane.values[i];
        }
        for (float& value : shown.values) value /= planes;
    }
    if (shown.channels == 3 && !image.rec709 && image.chromaticities) {
        const RgbMap map(*image.chromaticities, Rec709Chromaticities());
        for (std::size_t i = 0; i < shown.values.size(); i += 3) {
            float* const v = &shown.values[i];
            const Vec3d rgb = map(Vec3d(v[0], v[1], v[2]));
            for (int c = 0; c < 3; ++c) v[c] = static_cast<float>(rgb[c]);
        }
    }
    // A NaN fails the comparison and becomes 0 with the negative values.
    for (float& value : shown.values) value = value > 0.0f ? value : 0.0f;
    return shown;
}

float Exposure(const Shown& shown) {
    std::vector<float> lit;
    const auto step = static_cast<std::size_t>(shown.channels);
    for (std::size_t i = 0; i < shown.values.size(); i += step) {
        const float* pixel = shown.values.data() + i;
        const float largest = *std::max_element(pixel, pixel + step);
        if (largest > 0.0f && std::isfinite(largest)) lit.push_back(largest);
    }
    if (lit.empty()) return 1.0f;
    const auto rank = std::ceil(kLitPercentile * static_cast<double>(lit.size()));
    const auto at = lit.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
    std::nth_element(lit.begin(), at, lit.end());
    // Denormal light would need an infinite factor.
    return std::min(kKnee / *at, std::numeric_limits<float>::max());
}

// The identity up to the knee, then an exponential approach to 1 with the same slope.
float Shoulder(float value) {
    if (value <= kKnee) return value;
    return 1.0f - (1.0f - kKnee) * std::exp((kKnee - value) / (1.0f - kKnee));
}

// sRGB transfer (IEC 61966-2-1) of [0, 1] in equal steps, to 8 bits: a step is at most 0.1 code.
std::array<std::uint8_t, kCurveSteps + 1> SrgbCurve() {
    std::array<std::uint8_t, kCurveSteps + 1> curve{};
    for (std::size_t i = 0; i < curve.size(); ++i) {
        const double v = static_cast<double>(i) / kCurveSteps;
        const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
        curve[i] = static_cast<std::uint8_t>(std::lround(255.0 * s));
    }
    return curve;
}

void AppendU32(std::string& bytes, std::size_t value) {
    FLARE_CHECK(value <= UINT32_MAX);
    for (unsigned k = 0; k < 4; ++k) bytes.push_back(static_cast<char>((value >> (8 * k)) & 0xff));
}

}  // namespace

std::string EncodePng(const FlareImage& image) {
    FLARE_CHECK(image.data.pixels() > 0 && !image.planes.empty());
    static const auto curve = SrgbCurve();
    const Shown shown = ShownValues(image);
    const float exposure = Exposure(shown);
    std::vector<std::uint8_t> codes(shown.values.size());
    for (std::size_t i = 0; i < codes.size(); ++i) {
        const float seen = Shoulder(shown.values[i] * exposure);
        codes[i] = curve[static_cast<std::size_t>(std::lround(seen * kCurveSteps))];
    }

    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.data.width);
    png.height = static_cast<png_uint_32>(image.data.height);
    png.format = shown.channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
    png.flags = PNG_IMAGE_FLAG_FAST;
    std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
    png_alloc_size_t size = bytes.size();
    const int written =
        png_image_write_to_memory(&png, bytes.data(), &size, 0, codes.data(), 0, nullptr);
    FLARE_CHECK(written != 0);
    bytes.resize(size);
    return bytes;
}

HalfPlanes EncodeHalfPlanes(const FlareImage& image, ThreadPool& threads, std::string memory) {
    const std::size_t pixels = image.data.pixels();
    FLARE_CHECK(pixels > 0 && !image.planes.empty());
    static_assert(std::endian::native == std::endian::little, "halves are copied as they lie");
    std::string names;
    std::vector<const float*> planes;
    for (const ImagePlane& plane : image.planes) {
        FLARE_CHECK(plane.values.size() == pixels);
        names += plane.name + '\0';
        planes.push_back(plane.values.data());
    }
    std::string head = "FLRH";
    AppendU32(head, 1);
    AppendU32(head, static_cast<std::size_t>(image.data.width));
    AppendU32(head, static_cast<std::size_t>(image.data.height));
    AppendU32(head, planes.size());
    AppendU32(head, names.size());
    head.resize(64, '\0');
    head += names;
    const std::size_t first = head.size();
    HalfPlanes result{std::move(memory)};
    std::string& bytes = result.bytes;
    // Used memory is not cleared: every byte is written below.
    bytes.resize(first + 2 * planes.size() * pixels);
    std::memcpy(bytes.data(), head.data(), first);

    const std::size_t parts = (pixels - 1) / kPixelsAtOnce + 1;
    std::vector<std::uint64_t> saturated(parts, 0);
    threads.For(static_cast<int>(parts), [&](int part) {
        const std::size_t begin = static_cast<std::size_t>(part) * kPixelsAtOnce;
        const std::size_t count = std::min(kPixelsAtOnce, pixels - begin);
        std::vector<std::uint16_t> halves(count);
        bool any = false;
        for (std::size_t p = 0; p < planes.size(); ++p) {
            char* const to = bytes.data() + first + 2 * (p * pixels + begin);
            const std::size_t same = FirstEqual(planes, p);
            if (same < p) {
                std::memcpy(to, bytes.data() + first + 2 * (same * pixels + begin), 2 * count);
                continue;
            }
            any |= ConvertToHalf(planes[p] + begin, count, halves.data());
            std::memcpy(to, halves.data(), 2 * count);
        }
        if (!any) return;
        saturated[static_cast<std::size_t>(part)] =
            SaturatedPixels(planes, begin, count, kLargestHalf);
    });
    result.saturated_pixels = std::accumulate(saturated.begin(), saturated.end(), std::uint64_t{0});
    return result;
}

}  // namespace flare
