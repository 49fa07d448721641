// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/figure_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "core/drawing/label_row.h"

namespace flare {
namespace {

constexpr double kLabelSize = 11.0;
constexpr double kNumberSize = 10.0;
constexpr double kPupilTick = 14.0;
constexpr double kGhostLabelGap = 10.0;  // behind the sensor

std::string GhostName(const BounceSequence& sequence) {
    return "ghost " + SequenceName(sequence);
}

class FigureWriter {
  public:
    FigureWriter(const SectionFigure& figure, const FigurePlace& place, SvgWriter& svg)
        : figure_(figure), place_(place), svg_(svg) {}

    void Run() {
        const std::string name = figure_.section == Section::kX ? "x" : "y";
        svg_.Open("g", {{"id", "section-" + name}});
        svg_.Open("g",
                  {{"class", "scaled"},
                   {"transform", "translate(" + Px(place_.origin.x) + " " + Px(place_.origin.y) +
                                     ") scale(" + SvgWriter::Number(place_.scale, 8) + " " +
                                     SvgWriter::Number(-place_.scale, 8) + ")"},
                   {"fill", "none"},
                   {"stroke-linejoin", "round"}});
        Elements();
        AxisLine();
        Stop();
        Sensor();
        Pupils();
        Beam("axial", figure_.axial, ink::kAxial);
        Beam("field", figure_.field, ink::kField);
        for (std::size_t k = 0; k < figure_.ghosts.size(); ++k) Ghost(k);
        svg_.Close();
        TopLabels();
        SurfaceNumbers();
        GhostLabels();
        svg_.Close();
    }

  private:
    static std::string Px(double pixels) { return SvgWriter::Number(pixels, 2); }
    // A length on paper, as a length in the scaled group.
    std::string Mm(double pixels) const { return SvgWriter::Number(pixels / place_.scale, 5); }
    std::string Dashes(double on, double off) const { return Mm(on) + " " + Mm(off); }
    Vec2d OnPaper(Vec2d p) const {
        return place_.origin + Vec2d(place_.scale * p.x, -place_.scale * p.y);
    }

    void Line(const char* kind, Vec2d from, Vec2d to, const char* colour, double width) {
        svg_.Empty("polyline", {{"class", kind},
                                {"points", SvgWriter::Points({from, to})},
                                {"stroke", colour},
                                {"stroke-width", Mm(width)}});
    }

    void Elements() {
        svg_.Open("g", {{"class", "elements"}, {"stroke", ink::kLine}, {"stroke-width", Mm(0.9)}});
        for (const ElementOutline& element : figure_.elements) {
            svg_.Empty("polygon", {{"class", "element"},
                                   {"points", SvgWriter::Points(element.outline)},
                                   {"fill", GlassColour(element.nd)}});
        }
        for (const int index : figure_.loose) {
            svg_.Empty(
                "polyline",
                {{"class", "loose"},
                 {"points", SvgWriter::Points(figure_.faces[static_cast<std::size_t>(index)])},
                 {"stroke-dasharray", Dashes(3.0, 2.0)}});
        }
        svg_.Close();
    }

    void AxisLine() {
        svg_.Empty(
            "polyline",
            {{"class", "axis"},
             {"points", SvgWriter::Points({{figure_.box.z0, 0.0}, {figure_.box.z1, 0.0}})},
             {"stroke", ink::kFaint},
             {"stroke-width", Mm(0.7)},
             {"stroke-dasharray", Mm(14.0) + " " + Mm(3.0) + " " + Mm(2.0) + " " + Mm(3.0)}});
    }

    void Stop() {
        const FigureStop& stop = figure_.stop;
        const double foot = 4.0 / place_.scale;
        for (const double side : {1.0, -1.0}) {
            Line("stop", {stop.z_mm, side * stop.opening_mm}, {stop.z_mm, side * stop.outer_mm},
                 "#000000", 2.4);
            Line("stop-edge", {stop.z_mm - foot, side * stop.opening_mm},
                 {stop.z_mm + foot, side * stop.opening_mm}, "#000000", 1.2);
        }
    }

    void Sensor() {
        const FigureSensor& sensor = figure_.sensor;
        Line("sensor", {sensor.z_mm, -sensor.semi_height_mm}, {sensor.z_mm, sensor.semi_height_mm},
             "#000000", 1.8);
        if (!sensor.reflects) return;
        // A mirror has strokes on its back.
        const double step = 6.0 / place_.scale;
        for (double at = -sensor.semi_height_mm; at < sensor.semi_height_mm; at += step) {
            Line("sensor-back", {sensor.z_mm, at}, {sensor.z_mm + 0.7 * step, at + 0.7 * step},
                 "#000000", 0.7);
        }
    }

    void Pupils() {
        const double tick = kPupilTick / place_.scale;
        const double foot = 4.0 / place_.scale;
        for (const FigurePupil& pupil : figure_.pupils) {
            if (!pupil.within_reach) continue;
            for (const double side : {1.0, -1.0}) {
                const double edge = side * pupil.semi_diameter_mm;
                svg_.Empty("polyline",
                           {{"class", "pupil"},
                            {"points", SvgWriter::Points({{pupil.z_mm - foot, edge},
                                                          {pupil.z_mm + foot, edge},
                                                          {pupil.z_mm, edge},
                                                          {pupil.z_mm, edge + side * tick}})},
                            {"stroke", "#000000"},
                            {"stroke-width", Mm(1.0)},
                            {"stroke-dasharray", Dashes(2.5, 1.5)}});
            }
        }
    }

    void Beam(const std::string& kind, const DirectBeam& beam, const char* colour) {
        svg_.Open("g", {{"class", kind},
                        {"stroke", colour},
                        {"stroke-width", Mm(1.0)},
                        {"stroke-opacity", figure_.ghosts.empty() ? "0.9" : "0.4"}});
        const auto ray = [&](const char* name, const std::optional<DrawnRay>& drawn) {
            if (!drawn) return;
            // A chief ray that rims or iris stop is only a thought.
            svg_.Empty("polyline",
                       {{"class", name},
                        {"points", SvgWriter::Points(drawn->points)},
                        {"stroke-dasharray", drawn->passes ? "none" : Dashes(4.0, 3.0)}});
        };
        ray("upper", beam.upper);
        ray("chief", beam.chief);
        ray("lower", beam.lower);
        svg_.Close();
    }

    void Ghost(std::size_t k) {
        const FigureGhost& ghost = figure_.ghosts[k];
        svg_.Open("g", {{"class", "ghost"},
                        {"data-sequence", SequenceName(ghost.sequence)},
                        {"stroke", ink::kGhosts[k]},
                        {"stroke-width", Mm(0.9)}});
        for (const int index : ghost.sequence) {
            // The sensor has no face of its own.
            const auto face = static_cast<std::size_t>(index);
            const Outline sensor{{figure_.sensor.z_mm, -figure_.sensor.semi_height_mm},
                                 {figure_.sensor.z_mm, figure_.sensor.semi_height_mm}};
            svg_.Empty("polyline",
                       {{"class", "reflector"},
                        {"points", SvgWriter::Points(
                                       face < figure_.faces.size() ? figure_.faces[face] : sensor)},
                        {"stroke-width", Mm(2.6)},
                        {"stroke-opacity", "0.75"}});
        }
        for (const DrawnRay& ray : ghost.fan) Legs(ray);
        if (!ghost.fan.empty()) Arrows(ghost.fan[ghost.fan.size() / 2], ink::kGhosts[k]);
        svg_.Close();
    }

    static Outline Leg(const DrawnRay& ray, std::size_t leg) {
        const std::size_t from = leg == 0 ? 0 : ray.turns[leg - 1];
        const std::size_t to = leg < ray.turns.size() ? ray.turns[leg] : ray.points.size() - 1;
        return {ray.points.begin() + static_cast<std::ptrdiff_t>(from),
                ray.points.begin() + static_cast<std::ptrdiff_t>(to) + 1};
    }

    // Between two reflections the light runs one way; what runs back is dashed.
    void Legs(const DrawnRay& ray) {
        svg_.Open("g", {{"class", "ray"}});
        for (std::size_t leg = 0; leg <= ray.turns.size(); ++leg) {
            const bool back = leg % 2 == 1;
            svg_.Empty("polyline", {{"class", "leg"},
                                    {"points", SvgWriter::Points(Leg(ray, leg))},
                                    {"stroke-dasharray", back ? Dashes(5.0, 2.5) : "none"}});
        }
        svg_.Close();
    }

    // One arrow a leg, in the middle of its longest straight part.
    void Arrows(const DrawnRay& ray, const char* colour) {
        for (std::size_t leg = 0; leg <= ray.turns.size(); ++leg) {
            const Outline points = Leg(ray, leg);
            std::size_t best = 1;
            for (std::size_t i = 1; i < points.size(); ++i) {
                const double length = (points[i] - points[i - 1]).length();
                if (length > (points[best] - points[best - 1]).length()) best = i;
            }
            const Vec2d along = points[best] - points[best - 1];
            if (along.length() * place_.scale < 8.0) continue;
            const Vec2d unit = along.normalized() / place_.scale;
            const Vec2d across(-unit.y, unit.x);
            const Vec2d tip = (points[best] + points[best - 1]) * 0.5 + unit * 4.5;
            svg_.Empty("polygon",
                       {{"class", "arrow"},
                        {"points", SvgWriter::Points({tip, tip - unit * 9.0 + across * 3.4,
                                                      tip - unit * 9.0 - across * 3.4})},
                        {"fill", colour},
                        {"stroke", "none"}});
        }
    }

    void TextAt(double x, double y, const char* anchor, const char* colour, double size,
                const std::string& text, bool bold = false) {
        svg_.Text("text",
                  {{"x", Px(x)},
                   {"y", Px(y)},
                   {"text-anchor", anchor},
                   {"font-size", Px(size)},
                   {"font-weight", bold ? "bold" : "normal"},
                   {"fill", colour}},
                  text);
    }

    void Leader(const std::vector<Vec2d>& points) {
        svg_.Empty("polyline", {{"class", "leader"},
                                {"points", SvgWriter::Points(points)},
                                {"fill", "none"},
                                {"stroke", ink::kFaint},
                                {"stroke-width", "0.5"}});
    }

    // Names above the drawing, with a line down to what they name.
    void TopLabels() {
        struct Named {
            std::string text;
            Vec2d at;  // on paper
        };
        std::vector<Named> named;
        for (const FigurePupil& pupil : figure_.pupils) {
            if (!pupil.within_reach) FarPupil(pupil);
        }
        named.push_back({"stop", OnPaper({figure_.stop.z_mm, figure_.stop.outer_mm})});
        named.push_back({figure_.sensor.reflects ? "sensor (reflects)" : "sensor",
                         OnPaper({figure_.sensor.z_mm, figure_.sensor.semi_height_mm})});
        for (const FigurePupil& pupil : figure_.pupils) {
            if (!pupil.within_reach) continue;
            const Vec2d edge = OnPaper({pupil.z_mm, pupil.semi_diameter_mm});
            named.push_back({pupil.name, edge - Vec2d(0.0, kPupilTick)});
        }
        std::vector<RowLabel> row;
        for (const Named& label : named) {
            row.push_back({label.at.x, TextWidth(label.text, kLabelSize) + 14.0});
        }
        const std::vector<double> x = SpreadLabels(row, place_.left, place_.right);
        for (std::size_t i = 0; i < named.size(); ++i) {
            TextAt(x[i], place_.top_row, "middle", ink::kText, kLabelSize, named[i].text);
            Leader({{x[i], place_.top_row + 4.0}, {named[i].at.x, place_.top - 2.0}, named[i].at});
        }
    }

    // Named at the edge of the sheet that it lies beyond.
    void FarPupil(const FigurePupil& pupil) {
        std::string text = pupil.name;
        if (std::isfinite(pupil.z_mm)) {
            text += " at z = " + SvgWriter::Number(pupil.z_mm, 0) + " mm, diameter " +
                    SvgWriter::Number(2.0 * pupil.semi_diameter_mm, 1) + " mm";
        } else {
            text += " at infinity";
        }
        if (pupil.z_mm > figure_.box.z0) {
            TextAt(place_.right, place_.far_row, "end", ink::kText, kLabelSize, text + " \u2192");
        } else {
            TextAt(place_.left, place_.far_row, "start", ink::kText, kLabelSize, "\u2190 " + text);
        }
    }

    // Every surface's number below the drawing, with a line up to its rim.
    void SurfaceNumbers() {
        std::vector<Vec2d> rims;
        for (std::size_t i = 0; i < figure_.faces.size(); ++i) {
            const bool stop = figure_.stop.surface == static_cast<int>(i);
            rims.push_back(OnPaper(stop ? Vec2d(figure_.stop.z_mm, -figure_.stop.outer_mm)
                                        : figure_.faces[i].front()));
        }
        if (figure_.sensor.reflects) {
            rims.push_back(OnPaper({figure_.sensor.z_mm, -figure_.sensor.semi_height_mm}));
        }
        std::vector<RowLabel> row;
        for (std::size_t i = 0; i < rims.size(); ++i) {
            row.push_back({rims[i].x, TextWidth(std::to_string(i), kNumberSize) + 4.0});
        }
        const std::vector<double> x = SpreadLabels(row, place_.left, place_.right);
        for (std::size_t i = 0; i < rims.size(); ++i) {
            Leader({rims[i], {rims[i].x, place_.bottom + 3.0}, {x[i], place_.bottom_row - 10.0}});
            const char* colour = ink::kText;
            bool turns = false;
            for (std::size_t k = figure_.ghosts.size(); k-- > 0;) {
                const BounceSequence& s = figure_.ghosts[k].sequence;
                if (std::find(s.begin(), s.end(), static_cast<int>(i)) == s.end()) continue;
                colour = ink::kGhosts[k];
                turns = true;
            }
            TextAt(x[i], place_.bottom_row, "middle", colour, kNumberSize, std::to_string(i),
                   turns);
        }
    }

    // Each ghost's name beside the place where its fan ends.
    void GhostLabels() {
        std::vector<RowLabel> column;
        std::vector<std::size_t> shown;
        for (std::size_t k = 0; k < figure_.ghosts.size(); ++k) {
            const std::vector<DrawnRay>& fan = figure_.ghosts[k].fan;
            if (fan.empty()) continue;
            const Vec2d end = OnPaper(fan[fan.size() / 2].points.back());
            column.push_back({end.y, kLabelSize + 4.0});
            shown.push_back(k);
        }
        const std::vector<double> y = SpreadLabels(column, place_.top, place_.bottom);
        const double x = OnPaper({figure_.sensor.z_mm, 0.0}).x + kGhostLabelGap;
        for (std::size_t i = 0; i < shown.size(); ++i) {
            TextAt(x, y[i] + 0.35 * kLabelSize, "start", ink::kGhosts[shown[i]], kLabelSize,
                   GhostName(figure_.ghosts[shown[i]].sequence), true);
        }
    }

    const SectionFigure& figure_;
    const FigurePlace& place_;
    SvgWriter& svg_;
};

}  // namespace

std::string GlassColour(double nd) {
    constexpr std::array<double, 3> kPale{240.0, 246.0, 251.0};
    constexpr std::array<double, 3> kDeep{140.0, 176.0, 205.0};
    const double share = std::clamp((nd - kPaleIndex) / (kDeepIndex - kPaleIndex), 0.0, 1.0);
    std::array<int, 3> rgb{};
    for (std::size_t i = 0; i < 3; ++i) {
        rgb[i] = static_cast<int>(std::lround(kPale[i] + (kDeep[i] - kPale[i]) * share));
    }
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<unsigned>(rgb[0]) & 0xFFU,
                  static_cast<unsigned>(rgb[1]) & 0xFFU, static_cast<unsigned>(rgb[2]) & 0xFFU);
    return text;
}

std::string SequenceName(const BounceSequence& sequence) {
    std::string text = "(";
    for (const int surface : sequence) {
        if (text.size() > 1) text += ',';
        text += std::to_string(surface);
    }
    return text + ")";
}

double GhostLabelWidth(const BounceSequence& sequence) {
    constexpr double kBold = 1.15;  // wider than the plain face
    return kGhostLabelGap + kBold * TextWidth(GhostName(sequence), kLabelSize);
}

void WriteFigure(const SectionFigure& figure, const FigurePlace& place, SvgWriter& svg) {
    FigureWriter(figure, place, svg).Run();
}

}  // namespace flare
