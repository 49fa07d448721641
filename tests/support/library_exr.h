// SPDX-License-Identifier: Apache-2.0
//
// A FlareImage written by OpenEXR's own classes alone: what EncodeExr is held against, in its
// pixels and in its time. Deflates at OpenEXR's level 2, on the library's global threads.
#pragma once

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "core/image/exr.h"

namespace flare {

inline Imf::Header LibraryHeader(const FlareImage& image, const ExrOptions& options) {
    const auto box = [](const PixelWindow& w) {
        return Imath::Box2i({w.x, w.y}, {w.x + w.width - 1, w.y + w.height - 1});
    };
    Imf::Header header(box(image.full), box(image.data), static_cast<float>(image.pixel_aspect));
    header.zipCompressionLevel() = 2;
    header.compression() =
        options.compression == ExrCompression::kZip ? Imf::ZIP_COMPRESSION : Imf::NO_COMPRESSION;
    for (const ImagePlane& plane : image.planes) {
        header.channels().insert(
            plane.name, Imf::Channel(options.pixel == ExrPixel::kHalf ? Imf::HALF : Imf::FLOAT));
    }
    if (image.rec709) Imf::addChromaticities(header, Imf::Chromaticities());
    for (const auto& [name, text] : image.text_attributes) {
        header.insert(name, Imf::StringAttribute(text));
    }
    for (const auto& [name, number] : image.number_attributes) {
        header.insert(name, Imf::FloatAttribute(static_cast<float>(number)));
    }
    return header;
}

// `Sample` is Imath::half or float; converts 256 lines at a time.
template <class Sample>
void WriteByLibrary(const FlareImage& image, Imf::PixelType type, Imf::OutputFile& file) {
    constexpr int kLines = 256;
    const auto largest = static_cast<float>(std::numeric_limits<Sample>::max());
    const PixelWindow& w = image.data;
    const auto width = static_cast<std::size_t>(w.width);
    for (int line = 0; line < w.height; line += kLines) {
        const int count = std::min(kLines, w.height - line);
        const std::size_t first = static_cast<std::size_t>(line) * width;
        const std::size_t pixels = static_cast<std::size_t>(count) * width;
        std::vector<Sample> samples(pixels * image.planes.size());
        Imf::FrameBuffer frame;
        for (std::size_t p = 0; p < image.planes.size(); ++p) {
            const float* in = image.planes[p].values.data() + first;
            Sample* out = samples.data() + p * pixels;
            for (std::size_t i = 0; i < pixels; ++i) {
                out[i] = Sample(std::clamp(in[i], -largest, largest));
            }
            frame.insert(image.planes[p].name,
                         Imf::Slice::Make(type, out, Imath::V2i(w.x, w.y + line), w.width, count));
        }
        file.setFrameBuffer(frame);
        file.writePixels(count);
    }
}

inline std::string EncodeByLibrary(const FlareImage& image, const ExrOptions& options) {
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, LibraryHeader(image, options));
        if (options.pixel == ExrPixel::kHalf) {
            WriteByLibrary<Imath::half>(image, Imf::HALF, file);
        } else {
            WriteByLibrary<float>(image, Imf::FLOAT, file);
        }
    }
    return stream.str();
}

}  // namespace flare
