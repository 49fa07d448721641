// SPDX-License-Identifier: Apache-2.0
//
// libpng's own reader, since its one-call interface converts 16-bit files from linear light. It
// leaves by longjmp: ReadRows owns nothing but libpng's two structures.
#include "core/image/mask_image.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/base/check.h"

namespace flare {
namespace {

// Signature, then the header chunk: length, name, width, height.
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kSampleBytes = 8;  // red, green, blue, opacity, two bytes each

struct Source {
    std::string_view left;
};

void ReadBytes(png_structp png, png_bytep to, std::size_t count) {
    Source& source = *static_cast<Source*>(png_get_io_ptr(png));
    if (count > source.left.size()) png_error(png, "the file ends early");
    std::memcpy(to, source.left.data(), count);
    source.left.remove_prefix(count);
}

// The message of the error that ended the reading.
struct Complaint {
    std::array<char, 120> text{};
};

void OnError(png_structp png, png_const_charp message) {
    auto& complaint = *static_cast<Complaint*>(png_get_error_ptr(png));
    std::strncpy(complaint.text.data(), message, complaint.text.size() - 1);
    png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}

// Fills rows of 16-bit samples; false with a complaint.
bool ReadRows(Source& source, png_bytepp rows, std::size_t row_bytes, int most_side,
              Complaint& complaint) {
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &complaint, OnError, OnWarning);
    if (png == nullptr) return false;
    png_infop info = png_create_info_struct(png);
    if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
        png_destroy_read_struct(&png, info == nullptr ? nullptr : &info, nullptr);
        return false;
    }
    const auto side = static_cast<png_uint_32>(most_side);
    png_set_user_limits(png, side, side);
    png_set_chunk_malloc_max(png, 1U << 20);
    png_set_read_fn(png, &source, ReadBytes);
    png_read_info(png, info);
    png_set_expand_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xFFFF, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "the header says two things");
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    png_destroy_read_struct(&png, &info, nullptr);
    return true;
}

std::uint32_t BigEndian(const char* at) {
    std::uint32_t value = 0;
    for (int k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(at[k]);
    return value;
}

Error BadImage(const std::string& why) {
    return {"bad_image", "the image is no PNG that can be read: " + why, ""};
}

}  // namespace

Result<MaskImage> DecodeMaskPng(std::string_view bytes, int most_side) {
    const bool signed_png = bytes.size() >= kHeaderBytes &&
                            png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0;
    if (!signed_png) return BadImage("it does not begin like one");
    const std::uint32_t width = BigEndian(bytes.data() + 16);
    const std::uint32_t height = BigEndian(bytes.data() + 20);
    if (width == 0 || height == 0) return BadImage("it has no pixels");
    if (std::max(width, height) > static_cast<std::uint32_t>(most_side)) {
        return Error{"limit",
                     "the image is larger than " + std::to_string(most_side) + " pixels a side",
                     ""};
    }
    const std::size_t row_bytes = width * kSampleBytes;
    std::vector<std::uint8_t> samples(row_bytes * height);
    std::vector<png_bytep> rows;
    for (std::size_t y = 0; y < height; ++y) rows.push_back(samples.data() + y * row_bytes);
    Source source{bytes};
    Complaint complaint;
    if (!ReadRows(source, rows.data(), row_bytes, most_side, complaint))
        return BadImage(complaint.text.data());

    MaskImage mask{static_cast<int>(width), static_cast<int>(height), {}};
    mask.values.reserve(samples.size() / kSampleBytes);
    for (std::size_t at = 0; at < samples.size(); at += kSampleBytes) {
        const auto sample = [&](std::size_t k) {
            return static_cast<float>(samples[at + 2 * k] << 8 | samples[at + 2 * k + 1]) /
                   65535.0F;
        };
        const float red = sample(0);
        const float green = sample(1);
        const float blue = sample(2);
        // Exact for greys.
        const float grey = green + 0.2126F * (red - green) + 0.0722F * (blue - green);
        mask.values.push_back(std::max(0.0F, grey) * sample(3));
    }
    return mask;
}

std::string EncodeMaskPng(const MaskImage& mask) {
    std::vector<std::uint16_t> samples;
    samples.reserve(mask.values.size());
    for (const float value : mask.values) {
        const float cut = value > 0.0F ? std::min(value, 1.0F) : 0.0F;  // not a number: dark
        samples.push_back(static_cast<std::uint16_t>(cut * 65535.0F + 0.5F));
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(mask.width);
    image.height = static_cast<png_uint_32>(mask.height);
    image.format = PNG_FORMAT_LINEAR_Y;
    png_alloc_size_t size = 0;
    bool written = png_image_write_get_memory_size(image, size, 0, samples.data(), 0, nullptr) != 0;
    std::string bytes(size, '\0');
    written = written && png_image_write_to_memory(&image, bytes.data(), &size, 0, samples.data(),
                                                   0, nullptr) != 0;
    FLARE_CHECK(written);
    bytes.resize(size);
    return bytes;
}

}  // namespace flare
