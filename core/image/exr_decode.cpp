// SPDX-License-Identifier: Apache-2.0
//
// Reading is left to OpenEXR's own classes, behind a look at the sizes that the header claims.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>

#include "core/image/exr.h"
#include "core/image/exr_prescan.h"

namespace flare {
namespace {

class ViewStream final : public Imf::IStream {
  public:
    explicit ViewStream(std::string_view bytes) : Imf::IStream("memory"), bytes_(bytes) {}

    bool read(char c[], int n) override {
        if (n < 0 || at_ > bytes_.size() || static_cast<std::size_t>(n) > bytes_.size() - at_) {
            throw std::runtime_error("the file ends too early");
        }
        std::memcpy(c, bytes_.data() + at_, static_cast<std::size_t>(n));
        at_ += static_cast<std::size_t>(n);
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t position) override { at_ = position; }

  private:
    std::string_view bytes_;
    std::size_t at_ = 0;
};

Error BadImage(std::string message) {
    return {"bad_image", std::move(message), ""};
}

PixelWindow WindowOf(const Imath::Box2i& box) {
    const std::int64_t width = std::int64_t{box.max.x} - box.min.x + 1;
    const std::int64_t height = std::int64_t{box.max.y} - box.min.y + 1;
    if (width < 1 || height < 1 || width > INT32_MAX || height > INT32_MAX) {
        throw std::runtime_error("a window of the header is out of range");
    }
    return {box.min.x, box.min.y, static_cast<int>(width), static_cast<int>(height)};
}

void ReadHeader(const Imf::Header& header, FlareImage& image) {
    image.full = WindowOf(header.displayWindow());
    image.data = WindowOf(header.dataWindow());
    image.pixel_aspect = static_cast<double>(header.pixelAspectRatio());
    if (Imf::hasChromaticities(header)) {
        const Imf::Chromaticities& c = Imf::chromaticities(header);
        image.rec709 = c == Imf::Chromaticities();
        if (!image.rec709) {
            image.chromaticities = {Vec2d(c.red), Vec2d(c.green), Vec2d(c.blue), Vec2d(c.white)};
        }
    } else {
        image.rec709 = false;
    }
    for (auto a = header.begin(); a != header.end(); ++a) {
        const Imf::Attribute* attribute = &a.attribute();
        const std::string name = a.name();
        if (name == "pixelAspectRatio" || name == "screenWindowWidth") continue;
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(attribute)) {
            image.text_attributes.emplace_back(name, text->value());
        } else if (const auto* f = dynamic_cast<const Imf::FloatAttribute*>(attribute)) {
            image.number_attributes.emplace_back(name, static_cast<double>(f->value()));
        } else if (const auto* d = dynamic_cast<const Imf::DoubleAttribute*>(attribute)) {
            image.number_attributes.emplace_back(name, d->value());
        } else if (const auto* i = dynamic_cast<const Imf::IntAttribute*>(attribute)) {
            image.number_attributes.emplace_back(name, static_cast<double>(i->value()));
        }
    }
}

FlareImage Read(std::string_view bytes) {
    ViewStream stream(bytes);
    Imf::InputFile file(stream);
    FlareImage image;
    ReadHeader(file.header(), image);
    const Imf::ChannelList& channels = file.header().channels();
    for (auto c = channels.begin(); c != channels.end(); ++c) {
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1) {
            throw std::runtime_error(std::string("channel ") + c.name() + " is subsampled");
        }
        image.planes.push_back({c.name(), std::vector<float>(image.data.pixels())});
    }
    Imf::FrameBuffer frame;
    for (ImagePlane& plane : image.planes) {
        frame.insert(plane.name, Imf::Slice::Make(Imf::FLOAT, plane.values.data(),
                                                  Imath::V2i(image.data.x, image.data.y),
                                                  image.data.width, image.data.height));
    }
    file.setFrameBuffer(frame);
    file.readPixels(image.data.y, image.data.y + image.data.height - 1);
    return image;
}

}  // namespace

Result<FlareImage> DecodeExr(std::string_view bytes) {
    if (std::optional<Error> refused = PrescanExr(bytes)) return *refused;
    try {
        return Read(bytes);
    } catch (const std::exception& e) {
        return BadImage(std::string("the EXR cannot be read: ") + e.what());
    }
}

}  // namespace flare
