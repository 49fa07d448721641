// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/image_codec.h"

#include <algorithm>

#include "protocol/codec/base64.h"
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

bool ReadMask(Reader& reader, const JsonView& at, IrisMask& mask) {
    if (at.kind() == JsonKind::kString || (at.kind() == JsonKind::kObject && at.Find("file"))) {
        return reader.Refuse(at, "bad_value",
                             "a mask is sent as {\"png_base64\": ...}; only flare render reads a "
                             "file named in its place");
    }
    std::optional<JsonView> png;
    if (!reader.Object(at, {"png_base64", "scale"}) || !reader.Require(at, "png_base64", png) ||
        !reader.Text(*png, limits::kMaskTextBytes, mask.png)) {
        return false;
    }
    std::optional<std::string> bytes = BytesFromBase64(mask.png);
    if (!bytes) return reader.Refuse(*png, "bad_value", "the text is not base64");
    mask.png = std::move(*bytes);
    return IfGiven(at, "scale", [&](const JsonView& v) {
        return reader.OneOf<IrisMaskScale>(
            v, {{"area", IrisMaskScale::kArea}, {"stop", IrisMaskScale::kStop}}, mask.scale);
    });
}

bool ReadMarks(Reader& reader, const JsonView& at, int& count, double& opacity, int& seed) {
    std::optional<JsonView> number;
    return reader.Require(at, "count", number) &&
           reader.Integer(*number, 0, limits::kMaxMarks, count) &&
           IfGiven(
               at, "opacity",
               [&](const JsonView& v) { return reader.Number(v, Between(0.0, 1.0), opacity); }) &&
           IfGiven(at, "seed",
                   [&](const JsonView& v) { return reader.Integer(v, 0, limits::kMaxSeed, seed); });
}

bool ReadLength(Reader& reader, const JsonView& at, const char* name, double& length_mm) {
    return IfGiven(at, name, [&](const JsonView& v) {
        return reader.Number(v, FromUpTo(limits::kMinMark_mm, limits::kMaxMark_mm), length_mm);
    });
}

bool ReadDirt(Reader& reader, const JsonView& at, Iris& iris) {
    return IfGiven(at, "dust",
                   [&](const JsonView& v) {
                       IrisDust& dust = iris.dust.emplace();
                       return reader.Object(v, {"count", "size_mm", "opacity", "seed"}) &&
                              ReadMarks(reader, v, dust.count, dust.opacity, dust.seed) &&
                              ReadLength(reader, v, "size_mm", dust.size_mm);
                   }) &&
           IfGiven(at, "scratches", [&](const JsonView& v) {
               IrisScratches& scratches = iris.scratches.emplace();
               return reader.Object(v, {"count", "length_mm", "width_mm", "opacity", "seed"}) &&
                      ReadMarks(reader, v, scratches.count, scratches.opacity, scratches.seed) &&
                      ReadLength(reader, v, "length_mm", scratches.length_mm) &&
                      ReadLength(reader, v, "width_mm", scratches.width_mm);
           });
}

bool CheckIris(Reader& reader, const JsonView& at, const Iris& iris) {
    if (iris.mask && iris.mask->scale == IrisMaskScale::kArea && iris.blades != 0) {
        return reader.RefuseMember(at, "blades", "bad_value",
                                   "a mask stands in place of blades, unless its scale is "
                                   "\"stop\"");
    }
    if (iris.mask && (iris.dust || iris.scratches)) {
        return reader.RefuseMember(at, iris.dust ? "dust" : "scratches", "unsupported",
                                   "dust and scratches on a mask are not built: draw them into it");
    }
    if (iris.irregularity > 0.0 && iris.blades == 0) {
        return reader.RefuseMember(at, "irregularity", "bad_value", "a round iris has no blades");
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
    const bool read =
        reader.Object(at, {"blades", "roundness", "rotation_deg", "irregularity", "seed", "mask",
                           "dust", "scratches"}) &&
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
        IfGiven(at, "rotation_deg",
                [&](const JsonView& v) {
                    return reader.Number(v, Within(limits::kMaxRotation_deg), iris.rotation_deg);
                }) &&
        IfGiven(at, "irregularity",
                [&](const JsonView& v) {
                    return reader.Number(v, Between(0.0, 1.0), iris.irregularity);
                }) &&
        IfGiven(
            at, "seed",
            [&](const JsonView& v) { return reader.Integer(v, 0, limits::kMaxSeed, iris.seed); }) &&
        IfGiven(at, "mask",
                [&](const JsonView& v) { return ReadMask(reader, v, iris.mask.emplace()); }) &&
        ReadDirt(reader, at, iris);
    return read && CheckIris(reader, at, iris);
}

}  // namespace flare::wire
