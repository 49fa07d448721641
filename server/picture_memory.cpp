// SPDX-License-Identifier: Apache-2.0
//
// A channel's pixel is held as a double while light is added, then as two floats (in the root and
// in its layer), while the encoder's lines, what waits for its turn and the reply grow to another
// 24 bytes at the very most (two uncompressed floats, three times, in a picture of few lines).
#include "server/picture_memory.h"

#include <algorithm>
#include <variant>

#include "protocol/codec/flare_request_codec.h"
#include "protocol/limits.h"

namespace flare {
namespace {

constexpr std::uint64_t kBytesPerSample = 8 + 2 * 4 + 24;
// The starburst's own double and float, and its share of the encoder.
constexpr std::uint64_t kBytesPerStarburstSample = 8 + 4 + 12;
// Its transform and the tables of a light, whatever the picture's size.
constexpr std::uint64_t kStarburstBytes = std::uint64_t{192} << 20;
// Of the bokeh: four doubles a colour pixel, a float, and its share of the encoder.
constexpr std::uint64_t kBytesPerBokehSample = 11 + 4 + 12;
// Of a split layer: a float and its share of the encoder, which is one line's as a rule.
constexpr std::uint64_t kBytesPerSplitSample = 4 + 4;
// Ghosts of lights that are discs: floats of their own picture and of a ghost's, with its tiles and
// its copy while it is blurred, all with a margin.
constexpr std::uint64_t kBytesPerDiscSample = 48;
// The ghosts of one batch with their colour tables, whatever the picture's size.
constexpr std::uint64_t kBytesPerRequest = std::uint64_t{16} << 20;

// How many there may be: how many ghosts a lens has is not known here.
std::uint64_t SplitLayers(const wire::FlareRequest& request, std::uint64_t pixels,
                          std::uint64_t channels) {
    const std::uint64_t most = std::min<std::uint64_t>(
        limits::kSplitLayers,
        limits::kSplitPixels / std::max<std::uint64_t>(1, pixels * ((channels + 2) / 3)));
    if (request.split == wire::Split::kGhost) return most;
    return std::min<std::uint64_t>(most, request.lights.size());
}

}  // namespace

std::uint64_t PictureBytes(const wire::FlareRequest& request) {
    const wire::Image& image = request.image;
    std::int64_t width = image.width, height = image.height;
    if (image.crop) {
        width = (*image.crop)[2];
        height = (*image.crop)[3];
    } else {
        width += image.overscan[0] + image.overscan[2];
        height += image.overscan[1] + image.overscan[3];
    }
    const bool spectral = request.color_space == wire::ColorSpace::kSpectral;
    const std::uint64_t channels = spectral ? request.wavelengths_nm.size() : 3;
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    const std::uint64_t samples = pixels * channels;
    std::uint64_t bytes = kBytesPerRequest + samples * kBytesPerSample;
    const bool discs =
        std::any_of(request.lights.begin(), request.lights.end(),
                    [](const auto& light) { return light.angular_diameter_deg > 0.0; });
    if (discs && request.layers.ghosts) bytes += samples * kBytesPerDiscSample;
    if (request.layers.starburst) bytes += kStarburstBytes + samples * kBytesPerStarburstSample;
    if (request.layers.bokeh) bytes += samples * kBytesPerBokehSample;
    // The sums are gathered in doubles; and what is drawn alone needs a picture of its own.
    if (request.split != wire::Split::kNone) {
        bytes += samples * (kBytesPerSample + 8) +
                 SplitLayers(request, pixels, channels) * samples * kBytesPerSplitSample;
    }
    return bytes;
}

std::uint64_t PictureBytesOfBody(std::string_view body) {
    const wire::Decoded<wire::FlareRequest> decoded = wire::DecodeFlareRequest(body);
    const auto* request = std::get_if<wire::FlareRequest>(&decoded);
    return request ? PictureBytes(*request) : 0;
}

}  // namespace flare
