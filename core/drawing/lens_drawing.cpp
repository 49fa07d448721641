// SPDX-License-Identifier: Apache-2.0
//
// The sheet: a title, the sections one above the other at one scale and with one z below the other,
// then scale bar, key and the scale of indices. Everything on paper has a fixed size; only what is
// drawn to scale follows the lens.
#include "core/drawing/lens_drawing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/units.h"
#include "core/drawing/figure_svg.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr double kSheetWidth = 1200.0;
constexpr double kMargin = 36.0;
constexpr double kHeaderHeight = 66.0;
constexpr double kAboveFigure = 40.0, kBelowFigure = 60.0;  // rows of labels
constexpr double kTallestFigure = 600.0;                    // of all sections together
constexpr double kFarRow = 17.0, kSectionName = 18.0;
constexpr double kKeyRow = 18.0;
constexpr double kMaxFieldDeg = 180.0;
constexpr double kDefaultImageZone = 0.7;

// A row of the key.
struct KeyRow {
    std::string colour, text;
};

std::string FieldText(double field_rad) {
    return SvgWriter::Number(DegreesFromRadians(field_rad), 2) + "\u00B0";
}

class Sheet {
  public:
    Sheet(const Lens& lens, const DrawingOptions& options) : lens_(lens), options_(options) {
        const std::vector<Section> sections = lens.rotational()
                                                  ? std::vector<Section>{Section::kY}
                                                  : std::vector<Section>{Section::kX, Section::kY};
        for (const Section section : sections) {
            lights_.push_back(LightOf(section));
            figures_.push_back(FigureOf(lens, section, lights_.back()));
        }
        Place();
        MakeKey();
    }

    std::string Draw() {
        const double footer = std::max(kKeyRow * static_cast<double>(key_.size()), 44.0) + 28.0;
        const double height = figures_bottom_ + footer;
        svg_.Open("svg", {{"xmlns", "http://www.w3.org/2000/svg"},
                          {"width", SvgWriter::Number(kSheetWidth, 0)},
                          {"height", SvgWriter::Number(height, 0)},
                          {"viewBox", "0 0 " + SvgWriter::Number(kSheetWidth, 0) + " " +
                                          SvgWriter::Number(height, 0)},
                          {"role", "img"},
                          {"aria-labelledby", "title desc"},
                          {"font-family", "Helvetica, Arial, 'DejaVu Sans', sans-serif"}});
        svg_.Text("title", {{"id", "title"}}, lens_.name());
        svg_.Text("desc", {{"id", "desc"}}, Description());
        svg_.Empty("rect", {{"width", "100%"}, {"height", "100%"}, {"fill", "#ffffff"}});
        Text(kMargin, 32.0, 18.0, lens_.name(), "bold");
        Text(kMargin, 53.0, 12.0, Facts());
        for (std::size_t i = 0; i < figures_.size(); ++i) {
            if (figures_.size() > 1) {
                Text(kMargin, places_[i].name_row, 12.0,
                     std::string("section ") +
                         (figures_[i].section == Section::kX ? "x\u2013z" : "y\u2013z"),
                     "bold");
            }
            WriteFigure(figures_[i], places_[i], svg_);
        }
        ScaleBar();
        Key();
        IndexScale();
        svg_.Close();
        return svg_.text();
    }

  private:
    FigureLight LightOf(Section section) const {
        FigureLight light;
        const auto stop = static_cast<std::size_t>(lens_.stop_index());
        light.stop = options_.f_number
                         ? StopForFNumber(lens_, *options_.f_number)
                         : StopSetting{lens_.surfaces()[stop].semi_diameter_mm, lens_.f_number()};
        light.ghosts = options_.ghosts;
        if (options_.field_deg) {
            light.field_rad = RadiansFromDegrees(*options_.field_deg);
            light.ghost_field_rad = *light.field_rad;
        } else if (options_.ghosts.empty()) {
            light.field_rad = DefaultField(section);
        }
        return light;
    }

    std::optional<double> DefaultField(Section section) const {
        const std::optional<double> circle = lens_.prescription().design_image_circle_mm;
        if (!circle) return std::nullopt;
        const double radius = kDefaultImageZone * 0.5 * *circle;
        if (lens_.rotational()) return FieldOfImageRadius(lens_, radius, 0.0, kLineD);
        const Vec2d image = section == Section::kX ? Vec2d(radius, 0.0) : Vec2d(0.0, radius);
        const std::optional<Vec3d> travel = TravelToSensor(lens_, image, 0.0, kLineD);
        if (!travel) return std::nullopt;
        return std::acos(std::clamp(travel->z, -1.0, 1.0));
    }

    // One scale for all sections, and z at the same place in each.
    void Place() {
        FigureBox whole = figures_.front().box;
        double heights = 0.0;
        for (const SectionFigure& figure : figures_) {
            whole.Add({figure.box.z0, figure.box.low});
            whole.Add({figure.box.z1, figure.box.high});
            heights += figure.box.high - figure.box.low;
        }
        double labels = 0.0;
        for (const BounceSequence& sequence : options_.ghosts) {
            labels = std::max(labels, GhostLabelWidth(sequence));
        }
        const double room = kSheetWidth - 2.0 * kMargin - labels;
        const double scale = std::min(room / (whole.z1 - whole.z0), kTallestFigure / heights);
        const double unused = room - scale * (whole.z1 - whole.z0);
        double y = kHeaderHeight;
        for (const SectionFigure& figure : figures_) {
            FigurePlace place;
            place.name_row = y + 12.0;
            if (figures_.size() > 1) y += kSectionName;
            const bool far =
                std::any_of(figure.pupils.begin(), figure.pupils.end(),
                            [](const FigurePupil& pupil) { return !pupil.within_reach; });
            if (far) y += kFarRow;
            place.scale = scale;
            place.left = kMargin;
            place.right = kSheetWidth - kMargin;
            place.top_row = y + 14.0;
            place.far_row = place.top_row - kFarRow;
            place.top = y + kAboveFigure;
            place.bottom = place.top + scale * (figure.box.high - figure.box.low);
            place.bottom_row = place.bottom + 42.0;
            place.origin = {kMargin + 0.5 * unused - scale * whole.z0,
                            place.top + scale * figure.box.high};
            y = place.bottom + kBelowFigure;
            places_.push_back(place);
        }
        figures_bottom_ = y;
    }

    std::string Facts() const {
        const auto mm = [](double value) {
            return std::isfinite(value) ? SvgWriter::Number(value, 2) + " mm" : "infinite";
        };
        std::string text = "EFL ";
        if (lens_.rotational()) {
            text += mm(lens_.first_order().efl_mm);
        } else {
            text += mm(lens_.first_order(Section::kX).efl_mm) + " in x, " +
                    mm(lens_.first_order(Section::kY).efl_mm) + " in y";
        }
        const double f_number = lights_.front().stop.f_number;
        if (std::isfinite(f_number)) text += "  \u00B7  f/" + SvgWriter::Number(f_number, 2);
        const LensState& state = options_.state;
        if (state.zoom_mm) {
            text += "  \u00B7  zoom at " + SvgWriter::Number(*state.zoom_mm, 2) + " mm";
        }
        text += "  \u00B7  focus at ";
        const bool near = state.focus_m && std::isfinite(*state.focus_m);
        text += near ? SvgWriter::Number(*state.focus_m, 3) + " m" : "infinity";
        return text + "  \u00B7  rays of 587.56 nm";
    }

    std::string Description() const {
        std::string text = "Cross-section of the lens " + lens_.name();
        if (!lens_.prescription().maker.empty()) text += " (" + lens_.prescription().maker + ")";
        text += ", light from the left: " + std::to_string(figures_.front().elements.size()) +
                " elements, " + std::to_string(lens_.surfaces().size()) +
                " surfaces. Coordinates in the scaled groups are mm from the first vertex. " +
                Facts() + ".";
        for (const KeyRow& row : key_) text += " " + row.text + ".";
        return text;
    }

    // The field angle of the section, or of both.
    std::string FieldsText() const {
        std::string text;
        for (const FigureLight& light : lights_) {
            const bool first = text.empty();
            if (!first && light.field_rad == lights_.front().field_rad) continue;
            if (!first) text += " and ";
            text += light.field_rad ? FieldText(*light.field_rad) : "no angle";
        }
        return text;
    }

    void MakeKey() {
        const auto lacks = [&](auto&& missing) {
            std::string where;
            for (const SectionFigure& figure : figures_) {
                if (!missing(figure)) continue;
                where += where.empty() ? "" : " and ";
                where += figure.section == Section::kX ? "x" : "y";
            }
            if (where.empty() || figures_.size() == 1) return where.empty() ? where : " ";
            return " in " + where;
        };
        const auto say = [&](const std::string& what, auto&& missing) {
            const std::string where = lacks(missing);
            return where.empty() ? "" : "; " + what + (where == " " ? "" : where);
        };
        key_.push_back({ink::kAxial, "marginal rays of the axial beam, light at infinity" +
                                         say("none passes", [](const SectionFigure& f) {
                                             return !f.axial.upper;
                                         })});
        if (lights_.front().field_rad.value_or(0.0) != 0.0) {
            key_.push_back(
                {ink::kField,
                 "beam at " + FieldsText() + ": chief ray and outermost rays" +
                     say("no light passes", [](const SectionFigure& f) { return !f.field.upper; }) +
                     say("no chief ray", [](const SectionFigure& f) { return !f.field.chief; }) +
                     say("chief ray (dashed) stopped", [](const SectionFigure& f) {
                         return f.field.chief && !f.field.chief->passes;
                     })});
        }
        for (std::size_t k = 0; k < options_.ghosts.size(); ++k) {
            const std::string light = FieldText(lights_.front().ghost_field_rad);
            key_.push_back(
                {ink::kGhosts[k], "ghost " + SequenceName(options_.ghosts[k]) + ", light at " +
                                      light + ", dashed where it runs back" +
                                      say("no ray of it passes", [k](const SectionFigure& f) {
                                          return f.ghosts[k].fan.empty();
                                      })});
        }
    }

    void Text(double x, double y, double size, const std::string& text,
              const char* weight = "normal", const char* anchor = "start") {
        svg_.Text("text",
                  {{"x", SvgWriter::Number(x, 2)},
                   {"y", SvgWriter::Number(y, 2)},
                   {"font-size", SvgWriter::Number(size, 2)},
                   {"font-weight", weight},
                   {"text-anchor", anchor},
                   {"fill", ink::kText}},
                  text);
    }

    void Stroke(const char* kind, const std::vector<Vec2d>& points, const std::string& colour,
                double width) {
        svg_.Empty("polyline", {{"class", kind},
                                {"points", SvgWriter::Points(points)},
                                {"fill", "none"},
                                {"stroke", colour},
                                {"stroke-width", SvgWriter::Number(width, 2)}});
    }

    // 1, 2 or 5 times a power of ten, at most 180 pixels long.
    void ScaleBar() {
        const double scale = places_.front().scale;
        const double longest_mm = 180.0 / scale;
        double length_mm = std::pow(10.0, std::floor(std::log10(longest_mm)));
        for (const double step : {5.0, 2.0}) {
            if (step * length_mm <= longest_mm) {
                length_mm *= step;
                break;
            }
        }
        const double y = figures_bottom_ + 12.0;
        const double right = kMargin + scale * length_mm;
        Stroke("scale-bar",
               {{kMargin, y - 4.0},
                {kMargin, y + 4.0},
                {kMargin, y},
                {right, y},
                {right, y - 4.0},
                {right, y + 4.0}},
               ink::kText, 1.4);
        Text(kMargin, y + 20.0, 12.0, SvgWriter::Number(length_mm, 6) + " mm");
    }

    void Key() {
        const double x = 270.0;
        double y = figures_bottom_ + 12.0;
        for (const KeyRow& row : key_) {
            Stroke("key", {{x, y}, {x + 28.0, y}}, row.colour, 2.0);
            Text(x + 36.0, y + 4.0, 12.0, row.text);
            y += kKeyRow;
        }
    }

    void IndexScale() {
        const double width = 220.0, height = 11.0;
        const double x = kSheetWidth - kMargin - width - 6.0;
        const double y = figures_bottom_ + 6.0;
        const auto at = [&](double nd) {
            return x + width * std::clamp((nd - kPaleIndex) / (kDeepIndex - kPaleIndex), 0.0, 1.0);
        };
        svg_.Open("linearGradient", {{"id", "index-scale"}});
        svg_.Empty("stop", {{"offset", "0"}, {"stop-color", GlassColour(kPaleIndex)}});
        svg_.Empty("stop", {{"offset", "1"}, {"stop-color", GlassColour(kDeepIndex)}});
        svg_.Close();
        svg_.Empty("rect", {{"x", SvgWriter::Number(x, 2)},
                            {"y", SvgWriter::Number(y, 2)},
                            {"width", SvgWriter::Number(width, 2)},
                            {"height", SvgWriter::Number(height, 2)},
                            {"fill", "url(#index-scale)"},
                            {"stroke", ink::kLine},
                            {"stroke-width", "0.6"}});
        Text(x - 8.0, y + 10.0, 12.0, "n", "normal", "end");
        // The lens's own glasses stand out as ticks.
        for (const ElementOutline& element : figures_.front().elements) {
            Stroke("index-tick", {{at(element.nd), y}, {at(element.nd), y + height}}, ink::kLine,
                   0.8);
        }
        for (const auto& [nd, name] :
             {std::pair(1.4, "1.4"), {1.6, "1.6"}, {1.8, "1.8"}, {2.0, "2.0"}}) {
            Text(at(nd), y + height + 14.0, 11.0, name, "normal", "middle");
        }
    }

    const Lens& lens_;
    const DrawingOptions& options_;
    std::vector<FigureLight> lights_;  // one a section
    std::vector<SectionFigure> figures_;
    std::vector<FigurePlace> places_;
    std::vector<KeyRow> key_;
    double figures_bottom_ = 0.0;
    SvgWriter svg_;
};

std::optional<Error> CheckOptions(const Lens& lens, const DrawingOptions& options) {
    if (options.ghosts.size() > kMostDrawnGhosts) {
        return Error{"bad_value",
                     "a drawing shows at most " + std::to_string(kMostDrawnGhosts) +
                         " ghosts, not " + std::to_string(options.ghosts.size()),
                     "/ghosts"};
    }
    for (std::size_t k = 0; k < options.ghosts.size(); ++k) {
        const std::string where = "/ghosts/" + std::to_string(k);
        if (options.ghosts[k].empty()) {
            return Error{"bad_value", "a ghost has two or more reflections", where};
        }
        if (std::optional<Error> error = CheckSequence(lens, options.ghosts[k])) {
            error->where = where;
            return error;
        }
    }
    if (options.field_deg && !(std::abs(*options.field_deg) <= kMaxFieldDeg)) {
        return Error{"bad_value", "a field angle lies within +-180 degrees", "/field_deg"};
    }
    if (options.f_number && !(*options.f_number > 0.0 && std::isfinite(*options.f_number))) {
        return Error{"bad_value", "an f-number is above 0 and finite", "/f_number"};
    }
    return std::nullopt;
}

}  // namespace

Result<std::string> DrawLens(const Lens& lens, const DrawingOptions& options) {
    if (std::optional<Error> error = CheckOptions(lens, options)) return *error;
    return Sheet(lens, options).Draw();
}

}  // namespace flare
