// SPDX-License-Identifier: Apache-2.0
#include "server/translate/mask_from_wire.h"

#include <algorithm>

#include "core/image/mask_image.h"
#include "protocol/limits.h"

namespace flare {

Result<std::shared_ptr<const StopPicture>> MaskFromWire(const wire::IrisMask& mask) {
    Result<MaskImage> image = DecodeMaskPng(mask.png, limits::kMaskSide);
    if (!image) {
        Error error = image.error();
        error.where = "/iris/mask/png_base64";
        return error;
    }
    StopGrid grid;
    grid.side = std::max(image->width, image->height);
    // Half the image's width, which is what spans the stop.
    grid.half_width_mm = static_cast<double>(grid.side) / image->width;
    grid.values.assign(static_cast<std::size_t>(grid.side) * static_cast<std::size_t>(grid.side),
                       0.0F);
    const int left = (grid.side - image->width) / 2;
    const int top = (grid.side - image->height) / 2;
    float most = 0.0F;
    for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
            const float value =
                image->values[static_cast<std::size_t>(y) * static_cast<std::size_t>(image->width) +
                              static_cast<std::size_t>(x)];
            most = std::max(most, value);
            const int j = grid.side - 1 - (top + y);
            grid.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.side) +
                        static_cast<std::size_t>(left + x)] = value;
        }
    }
    if (most == 0.0F) {
        return Error{"bad_value", "the mask lets no light pass", "/iris/mask/png_base64"};
    }
    return StopPicture::Sharp(std::move(grid));
}

Result<std::shared_ptr<const SourcePicture>> ShapeFromWire(const std::string& png,
                                                           std::size_t light) {
    const std::string where = "/lights/" + std::to_string(light) + "/shape/png_base64";
    Result<MaskImage> image = DecodeMaskPng(png, limits::kShapeSide);
    if (!image) {
        Error error = image.error();
        error.where = where;
        return error;
    }
    std::shared_ptr<const SourcePicture> shape =
        SourcePicture::Of(image->width, image->height, image->values);
    if (!shape) return Error{"bad_value", "the shape is all dark", where};
    return shape;
}

}  // namespace flare
