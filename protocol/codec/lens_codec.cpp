// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/lens_codec.h"

#include <charconv>

#include "protocol/limits.h"

namespace flare::wire {
namespace {

bool CheckPrescriptionSize(Reader& reader, const JsonView& at) {
    if (!(at.kind() == JsonKind::kObject)) {
        return reader.Refuse(at, "bad_type", "a prescription is an object");
    }
    const std::optional<JsonView> surfaces = at.Find("surface");
    if (surfaces && surfaces->kind() == JsonKind::kArray &&
        !reader.Array(*surfaces, limits::kSurfaces)) {
        return false;
    }
    return at.value_count() <= limits::kPrescriptionValues ||
           reader.Refuse(at, "limit",
                         "the prescription has more than " +
                             std::to_string(limits::kPrescriptionValues) + " values");
}

// "0" to "99" and no other writing of it: two members never mean one surface.
std::optional<int> SurfaceNumber(std::string_view key) {
    int number = 0;
    const auto [end, failed] = std::from_chars(key.data(), key.data() + key.size(), number);
    const bool canonical = failed == std::errc() && end == key.data() + key.size() && number >= 0 &&
                           (key.size() == 1 || key.front() != '0');
    if (!canonical || number >= static_cast<int>(limits::kSurfaces)) return std::nullopt;
    return number;
}

bool ReadSurfaceCoatings(Reader& reader, const JsonView& at, Coatings& coatings) {
    if (at.kind() != JsonKind::kObject) {
        return reader.Refuse(at, "bad_type", "expected an object: surface numbers and names");
    }
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        const std::optional<int> number = SurfaceNumber(child->key());
        if (!number) {
            return reader.Refuse(*child, "bad_value",
                                 "a surface is named by its number, \"0\" to \"" +
                                     std::to_string(limits::kSurfaces - 1) + "\"");
        }
        if (!reader.Text(*child, limits::kNameBytes, coatings.surfaces[*number])) return false;
    }
    return true;
}

// "none", a coating's name, or {"default", "surfaces"}.
bool ReadCoatings(Reader& reader, const JsonView& at, Coatings& coatings) {
    const auto read_default = [&](const JsonView& v) {
        coatings.default_where = v.Pointer();
        return reader.Text(v, limits::kNameBytes, coatings.default_name.emplace());
    };
    if (at.kind() == JsonKind::kString) {
        coatings.none = at.string() == "none";
        return coatings.none || read_default(at);
    }
    if (at.kind() != JsonKind::kObject) {
        return reader.Refuse(at, "bad_type",
                             "expected \"none\", a coating's name, or an object with "
                             "\"default\" and \"surfaces\"");
    }
    return reader.Object(at, {"default", "surfaces"}) && IfGiven(at, "default", read_default) &&
           IfGiven(at, "surfaces",
                   [&](const JsonView& v) { return ReadSurfaceCoatings(reader, v, coatings); });
}

// null, or a number above 0.
bool ReadSetting(Reader& reader, const JsonView& at, double limit, std::optional<double>& value) {
    if (at.kind() == JsonKind::kNull) return true;
    return reader.Number(at, AboveZeroUpTo(limit), value.emplace());
}

}  // namespace

bool ReadLensChoice(Reader& reader, const JsonView& root, LensChoice& choice, bool lens_may_lack) {
    const std::optional<JsonView> lens = root.Find("lens");
    const std::optional<JsonView> prescription = root.Find("prescription");
    if (!lens && !prescription && !lens_may_lack) {
        return reader.RefuseMember(root, "lens", "missing_field",
                                   "neither \"lens\" nor \"prescription\" is there");
    }
    if (lens && prescription) {
        return reader.Refuse(*prescription, "bad_value",
                             "\"lens\" and \"prescription\" exclude each other");
    }
    if (lens && !reader.Text(*lens, limits::kNameBytes, choice.name.emplace())) return false;
    if (prescription) {
        if (!CheckPrescriptionSize(reader, *prescription)) return false;
        choice.prescription = prescription->Tree();
    }
    return IfGiven(root, "coatings",
                   [&](const JsonView& v) { return ReadCoatings(reader, v, choice.coatings); }) &&
           IfGiven(root, "f_number",
                   [&](const JsonView& v) {
                       return reader.Number(v, FromUpTo(limits::kMinFNumber, limits::kMaxFNumber),
                                            choice.f_number.emplace());
                   }) &&
           IfGiven(root, "focus_m",
                   [&](const JsonView& v) {
                       return ReadSetting(reader, v, limits::kMaxDistance_m, choice.focus_m);
                   }) &&
           IfGiven(root, "zoom_mm", [&](const JsonView& v) {
               return ReadSetting(reader, v, limits::kMaxZoom_mm, choice.zoom_mm);
           });
}

}  // namespace flare::wire
