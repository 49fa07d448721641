// SPDX-License-Identifier: Apache-2.0
//
// OpenLensFlare's XML and that of its descendants: <opticalSystem> with <elements>, each a surface
// of height (semi-diameter), thickness, radius, index, Abbe number and a single layer given by its
// index and the wavelength at which it is a quarter wave thick.
#include <cmath>
#include <pugixml.hpp>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

class OpenLensFlareReader {
  public:
    explicit OpenLensFlareReader(std::string_view text) : text_(text) {}

    Result<LensDraft> Read() {
        pugi::xml_document document;
        const pugi::xml_parse_result parsed = document.load_buffer(
            text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
        if (!parsed) {
            return Error{"bad_lens", std::string("not XML: ") + parsed.description(),
                         PlaceOf(parsed.offset)};
        }
        const pugi::xml_node system = document.child("opticalSystem");
        if (!system) return Error{"bad_lens", "there is no <opticalSystem>", "line 1"};
        const pugi::xml_node elements = system.child("elements");
        if (!elements) {
            return Error{"bad_lens", "<opticalSystem> has no <elements>", PlaceOf(system)};
        }
        draft_.title = system.child_value("name");
        if (const std::optional<double> focal =
                NumberIn(system.child_value("effectiveFocalLength"));
            focal && *focal > 0.0) {
            draft_.lens.design_focal_mm = *focal;
        }
        for (const pugi::xml_node element : elements.children("element")) {
            if (draft_.lens.surfaces.size() >= static_cast<std::size_t>(kMaxSurfaces)) {
                return Error{"bad_lens",
                             "the lens has more than " + std::to_string(kMaxSurfaces) + " surfaces",
                             PlaceOf(element)};
            }
            if (const std::optional<Error> error = AddElement(element)) return *error;
        }
        if (draft_.lens.surfaces.empty()) {
            return Error{"bad_lens", "<elements> has no <element>", PlaceOf(elements)};
        }
        Explain(system);
        return std::move(draft_);
    }

  private:
    std::string PlaceOf(std::ptrdiff_t offset) const {
        const auto end = static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0));
        int line = 1;
        for (const char c : text_.substr(0, end)) line += c == '\n' ? 1 : 0;
        return LinePlace(line);
    }
    std::string PlaceOf(const pugi::xml_node& node) const { return PlaceOf(node.offset_debug()); }

    Result<double> Number(const pugi::xml_node& element, const char* name) const {
        const pugi::xml_node child = element.child(name);
        if (!child) {
            return Error{"bad_lens", std::string("this element has no <") + name + ">",
                         PlaceOf(element)};
        }
        const std::vector<std::string_view> words = WordsOf(child.child_value(), "\r\n");
        if (words.size() == 1) {
            if (const std::optional<double> value = NumberIn(words.front())) return *value;
        }
        return Error{"bad_lens",
                     std::string("<") + name + "> is " + Quoted(child.child_value()) +
                         ", which is no finite number",
                     PlaceOf(child)};
    }

    std::optional<Error> AddElement(const pugi::xml_node& element) {
        const std::string type = element.child_value("type");
        if (type == "sensor") return std::nullopt;
        SurfacePrescription surface;
        surface.where = PlaceOf(element);
        surface.gap_given = true;
        if (type == "apertureStop") {
            surface.kind = SurfaceKind::kStop;
        } else if (type != "lensSpherical") {
            return Error{"unsupported", "elements of the type " + Quoted(type) + " cannot be read",
                         PlaceOf(element)};
        }
        const Result<double> height = Number(element, "height");
        if (!height) return height.error();
        surface.semi_diameter_mm = *height;
        const Result<double> gap = Number(element, "thickness");
        if (!gap) return gap.error();
        surface.gap_mm = *gap;
        const Result<double> nd = Number(element, "refractiveIndex");
        if (!nd) return nd.error();
        const Result<double> vd = Number(element, "abbeNumber");
        if (!vd) return vd.error();
        SetMedium(surface, *nd, *vd);
        if (surface.kind != SurfaceKind::kStop) {
            const Result<double> radius = Number(element, "radius");
            if (!radius) return radius.error();
            surface.radius_mm = *radius;
            SetCoating(element, surface);
        }
        draft_.lens.surfaces.push_back(std::move(surface));
        return std::nullopt;
    }

    void SetCoating(const pugi::xml_node& element, SurfacePrescription& surface) {
        const std::optional<double> nm = NumberIn(element.child_value("coatingLambda"));
        const std::optional<double> index = NumberIn(element.child_value("coatingIor"));
        if (!nm || !index || *nm == 0.0 || *index <= 1.0) return;
        const bool glass_in_front =
            !draft_.lens.surfaces.empty() && draft_.lens.surfaces.back().nd.has_value();
        if (glass_in_front && surface.nd) {
            cemented_.push_back(draft_.lens.surfaces.size());
            return;
        }
        const double whole = std::round(*nm);
        if (*index == 1.38 && whole == *nm && *nm >= 300.0 && *nm <= 1100.0) {
            surface.coating = "mgf2-" + std::to_string(static_cast<int>(whole));
        } else {
            odd_.push_back(draft_.lens.surfaces.size());
        }
    }

    void Explain(const pugi::xml_node& system) {
        if (!cemented_.empty()) {
            draft_.Remark("The coatings of " + SurfaceList(cemented_) +
                          " are not carried over: glass lies on both sides.");
        }
        if (!odd_.empty()) {
            draft_.Remark("The coatings of " + SurfaceList(odd_) +
                          " are not carried over: they are no quarter wave of n = 1.38 at a whole "
                          "number of nm.");
        }
        if (const std::string multiplier = system.child_value("heightMultiplier");
            !multiplier.empty()) {
            draft_.Remark("heightMultiplier " + Quoted(multiplier) +
                          ", which narrows all rims, is not carried over.");
        }
        if (const std::string f_number = system.child_value("fnumber"); !f_number.empty()) {
            draft_.Remark("fnumber " + Quoted(f_number) +
                          " is a setting of the picture and not taken for the design's.");
        }
        draft_.Remark("Field of view, film size and the masks of the stop are not carried over.");
    }

    std::string_view text_;
    LensDraft draft_;
    std::vector<std::size_t> cemented_, odd_;
};

}  // namespace

Result<LensDraft> ReadOpenLensFlare(std::string_view text) {
    return OpenLensFlareReader(text).Read();
}

}  // namespace flare
