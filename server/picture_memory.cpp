// SPDX-License-Identifier: Apache-2.0
//
// A channel's pixel is held as a double while light is added, then as two floats (in the root and
// in its layer), while the encoder's lines, what waits for its turn and the reply grow to another
// 24 bytes at the very most (two uncompressed floats, three times, in a picture of few lines).
#include "server/picture_memory.h"

#include <algorithm>
#include <variant>

#include "protocol/codec/flare_request_codec.h"

namespace flare {
namespace {

constexpr std::uint64_t kBytesPerSample = 8 + 2 * 4 + 24;
// The starburst's own double and float, and its share of the encoder.
constexpr std::uint64_t kBytesPerStarburstSample = 8 + 4 + 12;
// Its transform and the tables of a light, whatever the picture's size.
constexpr std::uint64_t kStarburstBytes = std::uint64_t{192} << 20;
// Ghosts of lights that are discs: floats of their own picture and of a ghost's, with its tiles and
// its copy while it is blurred, all with a margin.
constexpr std::uint64_t kBytesPerDiscSample = 48;
// The ghosts of one batch with their colour tables, whatever the picture's size.
constexpr std::uint64_t kBytesPerRequest = std::uint64_t{16} << 20;

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
    std::uint64_t ghosts = kBytesPerRequest + pixels * channels * kBytesPerSample;
    const bool discs =
        std::any_of(request.lights.begin(), request.lights.end(),
                    [](const auto& light) { return light.angular_diameter_deg > 0.0; });
    if (discs && request.layers.ghosts) ghosts += pixels * channels * kBytesPerDiscSample;
    if (!request.layers.starburst) return ghosts;
    return ghosts + kStarburstBytes + pixels * channels * kBytesPerStarburstSample;
}

std::uint64_t PictureBytesOfBody(std::string_view body) {
    const wire::Decoded<wire::FlareRequest> decoded = wire::DecodeFlareRequest(body);
    const auto* request = std::get_if<wire::FlareRequest>(&decoded);
    return request ? PictureBytes(*request) : 0;
}

}  // namespace flare
