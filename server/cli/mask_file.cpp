// SPDX-License-Identifier: Apache-2.0
#include "server/cli/mask_file.h"

#include <filesystem>

#include "core/image/exr.h"
#include "core/image/mask_image.h"
#include "protocol/codec/base64.h"
#include "protocol/codec/json_document.h"
#include "protocol/codec/json_writer.h"
#include "server/cli/files.h"

namespace flare::cli {
namespace {

std::optional<wire::JsonView> Member(const std::optional<wire::JsonView>& object,
                                     std::string_view name, wire::JsonKind kind) {
    if (!object || object->kind() != wire::JsonKind::kObject) return std::nullopt;
    const std::optional<wire::JsonView> member = object->Find(name);
    return member && member->kind() == kind ? member : std::nullopt;
}

// Writes a document again, with one text in another member's place.
class Rewriter {
  public:
    Rewriter(std::string place, std::string_view key, std::string text)
        : place_(std::move(place)), key_(key), text_(std::move(text)) {}

    std::string Rewritten(const wire::JsonView& root) {
        Write(root);
        return json_.Take();
    }

  private:
    void Write(const wire::JsonView& value) {
        switch (value.kind()) {
            case wire::JsonKind::kObject:
                json_.BeginObject();
                for (auto child = value.FirstChild(); child; child = child->NextSibling())
                    WriteMember(*child);
                json_.End();
                return;
            case wire::JsonKind::kArray:
                json_.BeginArray();
                for (auto child = value.FirstChild(); child; child = child->NextSibling())
                    Write(*child);
                json_.End();
                return;
            case wire::JsonKind::kString:
                json_.Value(value.string());
                return;
            case wire::JsonKind::kNumber:
                json_.Value(value.number());
                return;
            case wire::JsonKind::kBoolean:
                json_.Value(value.boolean());
                return;
            case wire::JsonKind::kNull:
                json_.Null();
        }
    }

    void WriteMember(const wire::JsonView& member) {
        if (member.Pointer() != place_) {
            json_.Key(member.key());
            Write(member);
        } else if (key_.empty()) {
            json_.Key(member.key()).BeginObject().Member("png_base64", text_).End();
        } else {
            json_.Member(key_, text_);
        }
    }

    std::string place_;
    std::string_view key_;  // in place of the member's own; empty: an object
    std::string text_;
    wire::JsonWriter json_{wire::JsonWriter::Style::kCompact};
};

// An EXR as the PNG that takes its place: of Y, of the luminance of R, G and B, or of its first
// channel.
Result<std::string> PngOfExr(const std::string& bytes) {
    const Result<FlareImage> image = DecodeExr(bytes);
    if (!image) return image.error();
    const auto named = [&](std::string_view name) -> const ImagePlane* {
        for (const ImagePlane& plane : image->planes) {
            if (plane.name == name) return &plane;
        }
        return nullptr;
    };
    const ImagePlane* const r = named("R");
    const ImagePlane* const g = named("G");
    const ImagePlane* const b = named("B");
    const ImagePlane* const y = named("Y");
    const ImagePlane& grey = y ? *y : image->planes.front();
    MaskImage mask{image->data.width, image->data.height, {}};
    for (std::size_t n = 0; n < image->data.pixels(); ++n) {
        const bool colour = !y && r && g && b;
        mask.values.push_back(colour ? 0.2126F * r->values[n] + 0.7152F * g->values[n] +
                                           0.0722F * b->values[n]
                                     : grey.values[n]);
    }
    return EncodeMaskPng(mask);
}

}  // namespace

Result<std::string> WithMaskInside(const std::string& body, const std::string& request) {
    const auto parsed = wire::JsonDocument::Parse(body);
    const auto* document = std::get_if<wire::JsonDocument>(&parsed);
    if (!document) return body;
    const auto iris = Member(document->root(), "iris", wire::JsonKind::kObject);
    const auto plain = Member(iris, "mask", wire::JsonKind::kString);
    const auto named =
        Member(Member(iris, "mask", wire::JsonKind::kObject), "file", wire::JsonKind::kString);
    const auto file = plain ? plain : named;
    if (!file) return body;
    std::filesystem::path path(std::string(file->string()));
    if (path.is_relative() && request != "-")
        path = std::filesystem::path(request).parent_path() / path;
    Result<std::string> image = ReadInput(path.string());
    if (image && path.extension() == ".exr") image = PngOfExr(*image);
    if (!image) {
        Error error = image.error();
        error.where = file->Pointer();
        return error;
    }
    return Rewriter(file->Pointer(), plain ? "" : "png_base64", wire::Base64(*image))
        .Rewritten(document->root());
}

}  // namespace flare::cli
