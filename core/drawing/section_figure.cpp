// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/section_figure.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flare {
namespace {

// Shares of the distance from the first vertex to the sensor.
constexpr double kLead = 0.16;
constexpr double kPupilReach = 0.25;
// Rays that leave the picture are cut at this many times the height of everything else.
constexpr double kRayReach = 1.3;

double Rim(const Lens& lens, int index) {
    return lens.surfaces()[static_cast<std::size_t>(index)].semi_diameter_mm;
}

FigureStop StopOf(const Lens& lens, const FigureLight& light) {
    const int at = lens.stop_index();
    const double rim = Rim(lens, at);
    double outer = 1.2 * rim;
    if (at > 0) outer = std::max(outer, Rim(lens, at - 1));
    if (at + 1 < static_cast<int>(lens.surfaces().size())) {
        outer = std::max(outer, Rim(lens, at + 1));
    }
    return {at, lens.surfaces()[static_cast<std::size_t>(at)].vertex_z_mm,
            light.stop.semi_diameter_mm, outer};
}

FigureSensor SensorOf(const Lens& lens, const SectionFigure& figure) {
    FigureSensor sensor{lens.sensor_z_mm(), 0.0, lens.sensor().has_value()};
    if (const auto circle = lens.prescription().design_image_circle_mm) {
        sensor.semi_height_mm = 0.5 * *circle;
    } else if (lens.sensor()) {
        sensor.semi_height_mm = lens.sensor()->semi_diameter_mm;
    } else {
        sensor.semi_height_mm = 0.5 * Rim(lens, static_cast<int>(lens.surfaces().size()) - 1);
        if (figure.field.chief) {
            const double image = std::abs(figure.field.chief->points.back().y);
            sensor.semi_height_mm = std::max(sensor.semi_height_mm, 1.1 * image);
        }
    }
    return sensor;
}

void AddPupils(const Lens& lens, const FigureLight& light, SectionFigure& figure) {
    const FirstOrder& first = lens.first_order(figure.section);
    const double open = light.stop.semi_diameter_mm / Rim(lens, lens.stop_index());
    const double length = figure.box.z1 - figure.box.z0;
    const double height = 1.5 * std::max(figure.box.high, -figure.box.low);
    for (const auto& [name, pupil] :
         {std::pair("entrance pupil", first.entrance), std::pair("exit pupil", first.exit)}) {
        const double semi = 0.5 * pupil.diameter_mm * open;
        const bool near = pupil.z_mm >= figure.box.z0 - kPupilReach * length &&
                          pupil.z_mm <= figure.box.z1 + kPupilReach * length && semi <= height;
        figure.pupils.push_back({name, pupil.z_mm, semi, near});
    }
}

// Ends the last stretch of a ray at the height `limit`.
void CutAt(double limit, DrawnRay& ray) {
    Vec2d& end = ray.points.back();
    if (std::abs(end.y) <= limit) return;
    const Vec2d from = ray.points[ray.points.size() - 2];
    const double edge = end.y > 0.0 ? limit : -limit;
    // The rims of all surfaces lie within the limit, so the ray starts within it.
    const double share = std::clamp((edge - from.y) / (end.y - from.y), 0.0, 1.0);
    end = from + (end - from) * share;
}

std::vector<DrawnRay*> RaysOf(SectionFigure& figure) {
    std::vector<DrawnRay*> rays;
    for (DirectBeam* beam : {&figure.axial, &figure.field}) {
        for (std::optional<DrawnRay>* ray : {&beam->upper, &beam->lower, &beam->chief}) {
            if (*ray) rays.push_back(&**ray);
        }
    }
    for (FigureGhost& ghost : figure.ghosts) {
        for (DrawnRay& ray : ghost.fan) rays.push_back(&ray);
    }
    return rays;
}

void Trace(const Lens& lens, const FigureLight& light, SectionFigure& figure) {
    const Iris iris(IrisShape{}, light.stop.semi_diameter_mm, Rim(lens, lens.stop_index()));
    const BeamView view{lens, figure.section, iris, kLead * lens.sensor_z_mm()};
    figure.axial = TraceDirectBeam(view, 0.0, light.wavelength_nm);
    // On the axis the chief ray is the axis.
    figure.axial.chief.reset();
    if (light.field_rad.value_or(0.0) != 0.0) {
        figure.field = TraceDirectBeam(view, *light.field_rad, light.wavelength_nm);
    }
    for (const BounceSequence& sequence : light.ghosts) {
        figure.ghosts.push_back(
            {sequence, TraceGhostFan(view, sequence, light.ghost_field_rad, light.wavelength_nm)});
    }
}

}  // namespace

void FigureBox::Add(Vec2d p) {
    z0 = std::min(z0, p.x);
    z1 = std::max(z1, p.x);
    low = std::min(low, p.y);
    high = std::max(high, p.y);
}

SectionFigure FigureOf(const Lens& lens, Section section, const FigureLight& light) {
    SectionFigure figure;
    figure.section = section;
    figure.elements = ElementOutlines(lens, section);
    for (int i = 0; i < static_cast<int>(lens.surfaces().size()); ++i) {
        figure.faces.push_back(FaceOutline(lens, i, section));
        const bool loose = lens.MediumBefore(i).is_air() && lens.MediumBehind(i).is_air();
        if (loose && i != lens.stop_index()) figure.loose.push_back(i);
    }
    figure.stop = StopOf(lens, light);
    Trace(lens, light, figure);
    figure.sensor = SensorOf(lens, figure);

    for (const ElementOutline& element : figure.elements) {
        for (const Vec2d& p : element.outline) figure.box.Add(p);
    }
    for (const Outline& face : figure.faces) {
        for (const Vec2d& p : face) figure.box.Add(p);
    }
    for (const double side : {-1.0, 1.0}) {
        figure.box.Add({figure.stop.z_mm, side * figure.stop.outer_mm});
        figure.box.Add({figure.sensor.z_mm, side * figure.sensor.semi_height_mm});
    }
    AddPupils(lens, light, figure);
    for (const FigurePupil& pupil : figure.pupils) {
        if (!pupil.within_reach) continue;
        for (const double side : {-1.0, 1.0}) {
            figure.box.Add({pupil.z_mm, side * pupil.semi_diameter_mm});
        }
    }
    const double limit = kRayReach * std::max(figure.box.high, -figure.box.low);
    for (DrawnRay* ray : RaysOf(figure)) {
        CutAt(limit, *ray);
        for (const Vec2d& p : ray->points) figure.box.Add(p);
    }
    return figure;
}

}  // namespace flare
