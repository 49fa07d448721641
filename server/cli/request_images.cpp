// SPDX-License-Identifier: Apache-2.0
#include "server/cli/request_images.h"

#include <filesystem>
#include <map>

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

// What takes the place of a member: a text, under a key of its own or as an object's.
struct Replacement {
    std::string_view key;  // in place of the member's own; empty: an object
    std::string text;
};
using Replacements = std::map<std::string, Replacement>;  // by the member's place

// Writes a document again with them.
class Rewriter {
  public:
    explicit Rewriter(const Replacements& replacements) : replacements_(replacements) {}

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
        const auto found = replacements_.find(member.Pointer());
        if (found == replacements_.end()) {
            json_.Key(member.key());
            Write(member);
        } else if (found->second.key.empty()) {
            const std::string& text = found->second.text;
            json_.Key(member.key()).BeginObject().Member("png_base64", text).End();
        } else {
            json_.Member(found->second.key, found->second.text);
        }
    }

    const Replacements& replacements_;
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

// The PNG that a name stands for, as base64.
Result<std::string> ImageNamed(const wire::JsonView& file, const std::string& request) {
    std::filesystem::path path(std::string(file.string()));
    if (path.is_relative() && request != "-")
        path = std::filesystem::path(request).parent_path() / path;
    Result<std::string> image = ReadInput(path.string());
    if (image && path.extension() == ".exr") image = PngOfExr(*image);
    if (!image) {
        Error error = image.error();
        error.where = file.Pointer();
        return error;
    }
    return wire::Base64(*image);
}

// If member `name` of `object` names a file, puts the image in its place.
std::optional<Error> Replace(const std::optional<wire::JsonView>& object, std::string_view name,
                             const std::string& request, Replacements& replacements) {
    const auto plain = Member(object, name, wire::JsonKind::kString);
    const auto named =
        Member(Member(object, name, wire::JsonKind::kObject), "file", wire::JsonKind::kString);
    const auto file = plain ? plain : named;
    if (!file) return std::nullopt;
    Result<std::string> image = ImageNamed(*file, request);
    if (!image) return image.error();
    replacements[file->Pointer()] = {plain ? "" : "png_base64", std::move(*image)};
    return std::nullopt;
}

}  // namespace

Result<std::string> WithImagesInside(const std::string& body, const std::string& request) {
    const auto parsed = wire::JsonDocument::Parse(body);
    const auto* document = std::get_if<wire::JsonDocument>(&parsed);
    if (!document) return body;
    Replacements replacements;
    const auto iris = Member(document->root(), "iris", wire::JsonKind::kObject);
    if (std::optional<Error> error = Replace(iris, "mask", request, replacements)) return *error;
    const auto lights = Member(document->root(), "lights", wire::JsonKind::kArray);
    for (auto light = lights ? lights->FirstChild() : std::nullopt; light;
         light = light->NextSibling()) {
        if (std::optional<Error> error = Replace(light, "shape", request, replacements))
            return *error;
    }
    if (replacements.empty()) return body;
    return Rewriter(replacements).Rewritten(document->root());
}

}  // namespace flare::cli
