// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/image_codec.h"

#include <algorithm>

#include "protocol/limits.h"

namespace flare::wire {
namespace {

using limits::kImageSide;

bool CheckCrop(Reader& reader, const JsonView& at, const Image& image) {
    const std::array<int, 4>& crop = *image.crop;
    const bool inside = crop[2] >= 1 && crop[3] >= 1 && crop[0] + crop[2] <= image.width &&
                        crop[1] + crop[3] <= image.height;
    return inside || reader.Refuse(at, "bad_value",
                                   "the crop [x, y, width, height] is empty or leaves the frame");
}

bool CheckSides(Reader& reader, const JsonView& at, const Image& image) {
    const std::array<int, 4>& over = image.overscan;
    const std::int64_t width = std::int64_t{image.width} + over[0] + over[2];
    const std::int64_t height = std::int64_t{image.height} + over[1] + over[3];
    if (image.crop && over != std::array<int, 4>{}) {
        return reader.RefuseMember(at, "overscan", "bad_value",
                                   "crop and overscan exclude each other");
    }
    if (width > kImageSide || height > kImageSide) {
        return reader.RefuseMember(
            at, "overscan", "limit",
            "frame and overscan are larger than " + std::to_string(kImageSide) + " pixels a side");
    }
    return true;
}

}  // namespace

bool ReadImage(Reader& reader, const JsonView& at, Image& image) {
    std::optional<JsonView> width, height, sensor_width;
    const bool read =
        reader.Object(at, {"width", "height", "sensor_width_mm", "crop", "overscan",
                           "center_offset_mm", "pixel_aspect", "projection", "desqueeze"}) &&
        reader.Require(at, "width", width) && reader.Integer(*width, 1, kImageSide, image.width) &&
        reader.Require(at, "height", height) &&
        reader.Integer(*height, 1, kImageSide, image.height) &&
        reader.Require(at, "sensor_width_mm", sensor_width) &&
        reader.Number(*sensor_width,
                      FromUpTo(limits::kMinSensorWidth_mm, limits::kMaxSensorWidth_mm),
                      image.sensor_width_mm) &&
        IfGiven(at, "center_offset_mm",
                [&](const JsonView& v) {
                    return reader.Numbers(v, Within(limits::kMaxCenterOffset_mm),
                                          image.center_offset_mm);
                }) &&
        IfGiven(at, "pixel_aspect",
                [&](const JsonView& v) {
                    return reader.Number(v,
                                         FromUpTo(limits::kMinPixelAspect, limits::kMaxPixelAspect),
                                         image.pixel_aspect);
                }) &&
        IfGiven(
            at, "overscan",
            [&](const JsonView& v) { return reader.Integers(v, 0, kImageSide, image.overscan); }) &&
        IfGiven(at, "crop",
                [&](const JsonView& v) {
                    return reader.Integers(v, 0, kImageSide, image.crop.emplace()) &&
                           CheckCrop(reader, v, image);
                }) &&
        IfGiven(at, "projection",
                [&](const JsonView& v) {
                    return reader.OneOf<Projection>(
                        v, {{"rectilinear", Projection::kRectilinear}, {"lens", Projection::kLens}},
                        image.projection);
                }) &&
        IfGiven(at, "desqueeze",
                [&](const JsonView& v) { return reader.Boolean(v, image.desqueeze); });
    return read && CheckSides(reader, at, image);
}

bool CheckPictureSize(Reader& reader, const JsonView& at, const Image& image,
                      std::size_t channels) {
    const std::array<int, 4>& over = image.overscan;
    const std::int64_t width = image.crop ? (*image.crop)[2] : image.width + over[0] + over[2];
    const std::int64_t height = image.crop ? (*image.crop)[3] : image.height + over[1] + over[3];
    const auto triples = static_cast<std::int64_t>(std::max<std::size_t>(1, channels / 3));
    if (width * height * triples <= limits::kImagePixels) return true;
    return reader.Refuse(at, "limit",
                         "the picture has more than " + std::to_string(limits::kImagePixels) +
                             " pixels (counted once for each three channels)");
}

bool ReadIris(Reader& reader, const JsonView& at, Iris& iris) {
    return reader.Object(at, {"blades", "roundness", "rotation_deg"}, {"mask"}) &&
           IfGiven(at, "blades",
                   [&](const JsonView& v) {
                       if (!reader.Integer(v, 0, limits::kMaxBlades, iris.blades)) return false;
                       return iris.blades == 0 || iris.blades >= limits::kMinBlades ||
                              reader.Refuse(v, "bad_value",
                                            "an iris has no blades (round) or at least " +
                                                std::to_string(limits::kMinBlades));
                   }) &&
           IfGiven(at, "roundness",
                   [&](const JsonView& v) {
                       return reader.Number(v, Between(0.0, 1.0), iris.roundness);
                   }) &&
           IfGiven(at, "rotation_deg", [&](const JsonView& v) {
               return reader.Number(v, Within(limits::kMaxRotation_deg), iris.rotation_deg);
           });
}

}  // namespace flare::wire
