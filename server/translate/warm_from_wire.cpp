// SPDX-License-Identifier: Apache-2.0
#include "server/translate/warm_from_wire.h"

#include <cmath>

#include "core/base/units.h"
#include "core/render/renderer.h"
#include "protocol/codec/warm_request_codec.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

// Where lights are directions, the picture's frame names no mesh.
wire::Image AnyImage() {
    wire::Image image;
    image.width = image.height = 1;
    image.sensor_width_mm = 36.0;
    return image;
}

// Light that travels along (sin a cos b, sin a sin b, cos a) in lens space, as in the ghost list.
std::vector<wire::Light> LightsOf(const wire::FieldAngles& field, double azimuth_deg) {
    const double b = RadiansFromDegrees(azimuth_deg);
    std::vector<wire::Light> lights(static_cast<std::size_t>(field.count));
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const double a =
            RadiansFromDegrees(field.from_deg + static_cast<double>(i) * field.step_deg);
        lights[i].direction = {-std::sin(a) * std::cos(b), -std::sin(a) * std::sin(b), std::cos(a)};
    }
    return lights;
}

}  // namespace

Result<FlareRequest> WarmFromWire(std::string_view body, const LensLibrary& library) {
    const wire::Decoded<wire::WarmRequest> decoded = wire::DecodeWarmRequest(body);
    if (const wire::Refusal* refusal = wire::RefusalOf(decoded)) {
        return Error{refusal->code, refusal->message, refusal->where};
    }
    const auto& warm = std::get<wire::WarmRequest>(decoded);
    wire::FlareRequest picture;
    picture.lens = warm.lens;
    picture.quality = warm.quality;
    picture.model = warm.model;
    picture.image = warm.image ? *warm.image : AnyImage();
    picture.lights = warm.field ? LightsOf(*warm.field, warm.azimuth_deg) : warm.lights;
    Result<FlareRequest> request = RequestFromWire(picture, library);
    if (!request) return request;
    if (std::optional<Error> error = CheckRequest(*request)) return *error;
    return request;
}

}  // namespace flare
