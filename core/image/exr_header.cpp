// SPDX-License-Identifier: Apache-2.0
//
// OpenEXR writes the attributes; of the file's frame it leaves the first eight bytes to us.
#include "core/image/exr_header.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVersion.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <set>

#include "core/base/check.h"

namespace flare {
namespace {

// Longer names need a flag in the version field.
constexpr std::size_t kShortName = 31;

class StringStream final : public Imf::OStream {
  public:
    explicit StringStream(std::string& bytes) : Imf::OStream("memory"), bytes_(bytes) {}

    void write(const char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (at_ + count > bytes_.size()) bytes_.resize(at_ + count);
        std::memcpy(bytes_.data() + at_, c, count);
        at_ += count;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t position) override { at_ = position; }

  private:
    std::string& bytes_;
    std::size_t at_ = 0;
};

Imath::Box2i BoxOf(const PixelWindow& w) {
    return {Imath::V2i(w.x, w.y), Imath::V2i(w.x + w.width - 1, w.y + w.height - 1)};
}

Imf::Header HeaderOf(const FlareImage& image, const ExrOptions& options) {
    Imf::Header header(BoxOf(image.full), BoxOf(image.data),
                       static_cast<float>(image.pixel_aspect));
    header.compression() =
        options.compression == ExrCompression::kZip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    const Imf::PixelType type = options.pixel == ExrPixel::kHalf ? Imf::HALF : Imf::FLOAT;
    std::set<std::string> names;
    for (const ImagePlane& plane : image.planes) {
        FLARE_CHECK(names.insert(plane.name).second);
        header.channels().insert(plane.name, Imf::Channel(type));
    }
    if (image.rec709) {
        Imf::addChromaticities(header, Imf::Chromaticities());
    } else if (image.chromaticities) {
        const Chromaticities& c = *image.chromaticities;
        Imf::addChromaticities(
            header, Imf::Chromaticities(Imath::V2f(c.red), Imath::V2f(c.green), Imath::V2f(c.blue),
                                        Imath::V2f(c.white)));
    }
    for (const auto& [name, text] : image.text_attributes) {
        header.insert(name, Imf::StringAttribute(text));
    }
    for (const auto& [name, number] : image.number_attributes) {
        header.insert(name, Imf::FloatAttribute(static_cast<float>(number)));
    }
    return header;
}

bool HasLongName(const Imf::Header& header) {
    for (auto a = header.begin(); a != header.end(); ++a) {
        if (std::strlen(a.name()) > kShortName) return true;
    }
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        if (std::strlen(c.name()) > kShortName) return true;
    }
    return false;
}

void AppendU32(std::string& bytes, std::uint32_t value) {
    for (unsigned k = 0; k < 4; ++k) bytes.push_back(static_cast<char>(value >> (8 * k) & 0xff));
}

}  // namespace

std::string ExrHeader(const FlareImage& image, const ExrOptions& options) {
    std::string bytes;
    try {
        const Imf::Header header = HeaderOf(image, options);
        header.sanityCheck();
        AppendU32(bytes, Imf::MAGIC);
        AppendU32(bytes, Imf::EXR_VERSION | (HasLongName(header) ? Imf::LONG_NAMES_FLAG : 0u));
        StringStream stream(bytes);
        stream.seekp(bytes.size());
        header.writeTo(stream);
    } catch (const std::exception& e) {
        // Only a broken invariant (a reserved attribute name, a window past OpenEXR's range).
        std::fprintf(stderr, "ExrHeader: %s\n", e.what());
        FLARE_CHECK(false && "OpenEXR refused an image of ours");
    }
    return bytes;
}

}  // namespace flare
