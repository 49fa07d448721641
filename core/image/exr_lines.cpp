// SPDX-License-Identifier: Apache-2.0
//
// ZIP in EXR (OpenEXR File Layout and its ImfZip.cpp): of a chunk's bytes first those at even, then
// those at odd places; then of each the difference to the one before, plus 128; then zlib. A chunk
// that does not become smaller is stored as it was.
#include "core/image/exr_lines.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <string_view>

#include "core/base/check.h"
#include "core/base/half.h"
#include "core/image/saturated_pixels.h"

namespace flare {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are copied as they lie");

constexpr int kBandLines = 16;
// In front of a chunk: line number and size, each of four bytes.
constexpr std::size_t kChunkHead = 8;

void PutChunkHead(unsigned char* to, int y, std::size_t size) {
    const auto line = static_cast<std::int32_t>(y);
    const auto bytes = static_cast<std::int32_t>(size);
    std::memcpy(to, &line, 4);
    std::memcpy(to + 4, &bytes, 4);
}

// The bytes of `count` units (from units[1] on) apart, low and high, each as the difference to the
// unit before.
void SplitUnits(const std::uint16_t* units, std::size_t count, unsigned char* low,
                unsigned char* high) {
    for (std::size_t i = 0; i < count; ++i) {
        const unsigned before = units[i], unit = units[i + 1];
        low[i] = static_cast<unsigned char>(unit - before + 128u);
        high[i] = static_cast<unsigned char>((unit >> 8) - (before >> 8) + 128u);
    }
}

// True if one of the values is infinite.
bool ConvertToFloat(const float* samples, std::size_t count, std::uint16_t* units) {
    constexpr float kLargest = std::numeric_limits<float>::max();
    bool saturated = false;
    for (std::size_t i = 0; i < count; ++i) {
        const float value = std::clamp(samples[i], -kLargest, kLargest);
        // A NaN is neither below nor above.
        saturated = saturated || samples[i] < -kLargest || samples[i] > kLargest;
        std::memcpy(units + 2 * i, &value, 4);
    }
    return saturated;
}

}  // namespace

ExrPlan::ExrPlan(const FlareImage& picture, const ExrOptions& how) : image(picture), options(how) {
    FLARE_CHECK(image.data.width > 0 && image.data.height > 0);
    FLARE_CHECK(!image.planes.empty());
    std::vector<const ImagePlane*> planes;
    for (const ImagePlane& plane : image.planes) {
        FLARE_CHECK(plane.values.size() == image.data.pixels());
        planes.push_back(&plane);
    }
    // As OpenEXR sorts them: by their bytes, unsigned.
    std::sort(planes.begin(), planes.end(), [](const ImagePlane* a, const ImagePlane* b) {
        return std::string_view(a->name) < std::string_view(b->name);
    });
    for (const ImagePlane* plane : planes) channels.push_back(plane->values.data());
    for (std::size_t c = 0; c < channels.size(); ++c) {
        first_equal.push_back(FirstEqual(channels, c));
    }
    FLARE_CHECK(line_bytes() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) /
                                    static_cast<std::size_t>(band_lines(0)));
}

std::size_t ExrPlan::line_bytes() const {
    const std::size_t sample = options.pixel == ExrPixel::kHalf ? 2 : 4;
    return sample * channels.size() * static_cast<std::size_t>(image.data.width);
}

std::size_t ExrPlan::stored_bytes() const {
    return static_cast<std::size_t>(image.data.height) * line_bytes() +
           static_cast<std::size_t>(chunk_count()) * kChunkHead;
}

int ExrPlan::chunk_count() const {
    return zip() ? band_count() : image.data.height;
}

int ExrPlan::band_count() const {
    return (image.data.height - 1) / kBandLines + 1;
}

int ExrPlan::band_lines(int band) const {
    return std::min(kBandLines, image.data.height - band * kBandLines);
}

ExrBandEncoder::ExrBandEncoder(const ExrPlan& plan) : plan_(plan) {
    const std::size_t units_a_sample = plan.options.pixel == ExrPixel::kHalf ? 1 : 2;
    units_.resize(1 + units_a_sample * static_cast<std::size_t>(plan.image.data.width));
    if (!plan.zip()) return;
    arranged_.resize(plan.line_bytes() * static_cast<std::size_t>(plan.band_lines(0)));
}

void ExrBandEncoder::Encode(int band, ExrBand& to) {
    const int line = band * kBandLines;
    const int lines = plan_.band_lines(band);
    const std::size_t most =
        plan_.line_bytes() * static_cast<std::size_t>(lines) + kChunkHead + LineDeflater::kSlack;
    if (to.bytes.size() < most) to.bytes.resize(most);
    to.saturated_pixels = Deflate(line, lines, to) ? SaturatedIn(line, lines) : 0;
}

std::uint64_t ExrBandEncoder::StoreInFile(int band, unsigned char* chunks) {
    const int line = band * kBandLines;
    const int lines = plan_.band_lines(band);
    bool saturated = false;
    Store(line, lines, chunks + static_cast<std::size_t>(line) * (kChunkHead + plan_.line_bytes()),
          saturated);
    return saturated ? SaturatedIn(line, lines) : 0;
}

std::uint64_t ExrBandEncoder::SaturatedIn(int line, int lines) const {
    const auto width = static_cast<std::size_t>(plan_.image.data.width);
    return SaturatedPixels(
        plan_.channels, static_cast<std::size_t>(line) * width,
        static_cast<std::size_t>(lines) * width,
        plan_.options.pixel == ExrPixel::kHalf ? kLargestHalf : std::numeric_limits<float>::max());
}

bool ExrBandEncoder::ConvertLine(const float* samples) {
    const auto width = static_cast<std::size_t>(plan_.image.data.width);
    return plan_.options.pixel == ExrPixel::kHalf
               ? ConvertToHalf(samples, width, units_.data() + 1)
               : ConvertToFloat(samples, width, units_.data() + 1);
}

// Lines as they are: one chunk each, or with ZIP all in one.
unsigned char* ExrBandEncoder::Store(int line, int lines, unsigned char* out, bool& saturated) {
    const auto width = static_cast<std::size_t>(plan_.image.data.width);
    const std::size_t line_bytes = plan_.line_bytes();
    const std::size_t channel_bytes = 2 * (units_.size() - 1);
    const int lines_in_chunk = plan_.zip() ? lines : 1;
    for (int k = 0; k < lines; ++k) {
        if (k % lines_in_chunk == 0) {
            PutChunkHead(out, plan_.image.data.y + line + k,
                         line_bytes * static_cast<std::size_t>(lines_in_chunk));
            out += kChunkHead;
        }
        unsigned char* const first = out;
        for (std::size_t c = 0; c < plan_.channels.size(); ++c, out += channel_bytes) {
            const std::size_t same = plan_.first_equal[c];
            if (same < c) {
                std::memcpy(out, first + same * channel_bytes, channel_bytes);
                continue;
            }
            saturated |=
                ConvertLine(plan_.channels[c] + static_cast<std::size_t>(line + k) * width);
            std::memcpy(out, units_.data() + 1, channel_bytes);
        }
    }
    return out;
}

bool ExrBandEncoder::Deflate(int line, int lines, ExrBand& to) {
    const bool saturated = Arrange(line, lines);
    const std::size_t stored = plan_.line_bytes() * static_cast<std::size_t>(lines);
    const std::size_t segment = units_.size() - 1;
    // Where a layer is the whole picture, its channels follow the root's in the same order.
    const std::size_t channels = plan_.channels.size();
    const std::size_t repeat = channels % 2 == 0 ? channels / 2 * segment : 0;
    const std::size_t deflated = deflater_.Deflate(arranged_.data(), stored, segment, repeat,
                                                   to.bytes.data() + kChunkHead, stored - 1);
    if (deflated == 0) {
        bool known = saturated;
        to.size =
            static_cast<std::size_t>(Store(line, lines, to.bytes.data(), known) - to.bytes.data());
        return saturated;
    }
    PutChunkHead(to.bytes.data(), plan_.image.data.y + line, deflated);
    to.size = kChunkHead + deflated;
    return saturated;
}

bool ExrBandEncoder::Arrange(int line, int lines) {
    const auto width = static_cast<std::size_t>(plan_.image.data.width);
    const std::size_t units = units_.size() - 1;
    const std::size_t half = plan_.line_bytes() * static_cast<std::size_t>(lines) / 2;
    unsigned char* low = arranged_.data();
    unsigned char* high = low + half;
    bool saturated = false;
    units_[0] = 0;
    for (int k = 0; k < lines; ++k) {
        for (const float* channel : plan_.channels) {
            saturated |= ConvertLine(channel + static_cast<std::size_t>(line + k) * width);
            SplitUnits(units_.data(), units, low, high);
            units_[0] = units_[units];
            low += units;
            high += units;
        }
    }
    // The very first byte stands for itself, and the first high one follows the last low one.
    arranged_[0] = static_cast<unsigned char>(arranged_[0] - 128u);
    arranged_[half] = static_cast<unsigned char>(arranged_[half] - (units_[0] & 0xffu));
    return saturated;
}

}  // namespace flare
