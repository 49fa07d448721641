// SPDX-License-Identifier: Apache-2.0
//
// Two beams a row. The one of the light from that angle gives area, flux and transmittance. The
// other is sent back from the place where the chief ray lands: radiance is the same all along a
// ray, so the solid angle in which it leaves the lens gives the irradiance there. The flux through
// the first beam over the chief ray's d(image) / d(angle) would say the same only without coma,
// which costs up to 2.5 %. docs/physics/field-data.md.
#include "core/tracing/field_data.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/optics/paraxial.h"
#include "core/tracing/chief_ray.h"
#include "core/tracing/passing_beam.h"

namespace flare {
namespace {

constexpr double kMostTangent_rad = RadiansFromDegrees(85.0);
// The angle that stands for one next to the axis.
constexpr double kNearAxis_rad = 1e-3;
// Rays across the d line's beam at each of the other wavelengths.
constexpr int kWavelengthSteps = 20;

StopSetting SettingFor(const Lens& lens, const FieldOptions& options) {
    if (options.f_number) return StopForFNumber(lens, *options.f_number);
    const LensSurface& stop = lens.surfaces()[static_cast<std::size_t>(lens.stop_index())];
    return {stop.semi_diameter_mm, lens.f_number(), false};
}

// The direct path from the sensor to the front.
InteractionList TurnedRound(const InteractionList& direct) {
    InteractionList back = direct;
    std::reverse(back.steps.begin(), back.steps.end());
    double absorption_per_mm = 0.0;  // of the air behind the lens
    for (Interaction& step : back.steps) {
        step.forward = !step.forward;
        std::swap(step.n_in, step.n_out);
        std::swap(step.absorption_per_mm, absorption_per_mm);
    }
    return back;
}

class SectionField {
  public:
    SectionField(const Lens& lens, const FieldOptions& options, const StopSetting& stop,
                 Section section)
        : lens_(lens),
          options_(options),
          section_(section),
          in_y_(!lens.rotational() && section == Section::kY),
          fisheye_(lens.prescription().fisheye),
          iris_({}, stop.semi_diameter_mm, stop.semi_diameter_mm),
          direct_(WriteOut(lens, {}, kLineD)),
          back_(TurnedRound(direct_)) {
        for (const double wavelength_nm : options.wavelengths_nm) {
            lists_.push_back(WriteOut(lens, {}, wavelength_nm));
        }
        if (options.focus_m) {
            const double depth_mm =
                *options.focus_m * kMmPerMetre - (lens.sensor_z_mm() - lens.pupil_z_mm());
            in_front_ = depth_mm > 0.0;
            inverse_depth_ = in_front_ ? 1.0 / depth_mm : 0.0;
        }
        const std::optional<ChiefRay> near = Chief(kNearAxis_rad);
        if (near && Along(*near) < 0.0) side_ = -1.0;
        if (near) axis_slope_mm_ = Along(*near) / kNearAxis_rad;
    }

    FieldTable Table() {
        FieldTable table;
        table.section = section_;
        table.edge = FieldEdge::kNoLight;
        if (!in_front_) return table;
        const double edge_rad = Edge(table.edge);
        for (int i = 0; i < options_.rows; ++i) {
            FieldRow row = Row(edge_rad * i / (options_.rows - 1));
            const FieldRow& axis = i == 0 ? row : table.rows.front();
            if (row.irradiance && axis.irradiance.value_or(0.0) > 0.0) {
                row.relative_illumination = *row.irradiance / *axis.irradiance;
            }
            if (axis.beam_area_mm2 > 0.0) row.beam_share = row.beam_area_mm2 / axis.beam_area_mm2;
            table.rows.push_back(std::move(row));
        }
        return table;
    }

  private:
    LightBundle Bundle(double field_rad) const {
        const double inverse =
            fisheye_ ? inverse_depth_ : inverse_depth_ * std::max(0.0, std::cos(field_rad));
        return LightBundle(lens_, field_rad, inverse, in_y_ ? 0.5 * kPi : 0.0);
    }

    std::optional<ChiefRay> Chief(double field_rad) const {
        return FindChiefRay(lens_, Bundle(field_rad), kLineD);
    }

    // Where it lands, along the section.
    double Along(const ChiefRay& chief) const {
        return side_ * (in_y_ ? chief.sensor_mm.y : chief.sensor_mm.x);
    }

    RayPlane PlaneOf(const LightBundle& bundle, const std::optional<ChiefRay>& chief) const {
        RayPlane plane;
        plane.passes = [this, &bundle](double u, double v) {
            const TraceResult ray =
                TraceRay(direct_, bundle.At(u, v), {true, &iris_, false}, nullptr);
            return ray.fate == RayFate::kArrived;
        };
        plane.centre_u = bundle.centre_u();
        plane.half_width = bundle.half_width();
        if (chief) plane.hint_u = chief->u;
        return plane;
    }

    // Is there anything to say about this angle? Names what is missing otherwise.
    bool Within(double field_rad, FieldEdge& edge) const {
        const LightBundle bundle = Bundle(field_rad);
        const std::optional<ChiefRay> chief = FindChiefRay(lens_, bundle, kLineD);
        edge = FieldEdge::kNoChiefRay;
        if (!chief) return false;
        const std::optional<double> circle_mm = lens_.prescription().design_image_circle_mm;
        if (circle_mm) {
            edge = FieldEdge::kImageCircle;
            return chief->sensor_mm.length() < 0.5 * *circle_mm;
        }
        edge = FieldEdge::kNoLight;
        return PassingPlace(PlaneOf(bundle, chief)).has_value();
    }

    // The largest field angle within, by marching out and halving.
    double Edge(FieldEdge& edge) const {
        constexpr double kStep_rad = RadiansFromDegrees(2.0);
        constexpr int kHalvings = 30;
        double inside = 0.0, outside = kStep_rad;
        while (outside < kPi && Within(outside, edge)) {
            inside = outside;
            outside += kStep_rad;
        }
        for (int i = 0; i < kHalvings; ++i) {
            const double mid = 0.5 * (inside + outside);
            FieldEdge at_mid = edge;
            if (Within(mid, at_mid)) {
                inside = mid;
            } else {
                outside = mid;
                edge = at_mid;
            }
        }
        return inside;
    }

    FieldRow Row(double field_rad) {
        FieldRow row;
        row.field_rad = field_rad;
        const LightBundle bundle = Bundle(field_rad);
        const std::optional<ChiefRay> chief = FindChiefRay(lens_, bundle, kLineD);
        if (chief) {
            row.image_height_mm = Along(*chief);
            row.irradiance = Irradiance(*chief);
        }
        WriteIdeal(row);
        WriteLight(row, bundle, FindPassingBeam(PlaneOf(bundle, chief)));
        return row;
    }

    void WriteIdeal(FieldRow& row) const {
        const double field_rad = row.field_rad;
        // Angles are measured from lens.pupil_z_mm(); the section's own pupil sees a near point of
        // an anamorphic lens under another one.
        const double pupil_offset = lens_.first_order(section_).entrance.z_mm - lens_.pupil_z_mm();
        const double distance_mm = lens_.first_order(section_).projection_distance_mm /
                                   (1.0 + pupil_offset * inverse_depth_);
        if (field_rad == 0.0) {
            row.ideal_height_mm = 0.0;
            if (axis_slope_mm_) row.distortion = *axis_slope_mm_ / distance_mm - 1.0;
            if (fisheye_) row.f_theta_distortion = row.distortion;
            return;
        }
        if (field_rad < kMostTangent_rad) {
            row.ideal_height_mm = distance_mm * std::tan(field_rad);
            if (row.image_height_mm) {
                row.distortion = *row.image_height_mm / *row.ideal_height_mm - 1.0;
            }
        }
        if (fisheye_ && row.image_height_mm) {
            row.f_theta_distortion = *row.image_height_mm / (distance_mm * field_rad) - 1.0;
        }
    }

    void WriteLight(FieldRow& row, const LightBundle& bundle, const PassingBeam& beam) {
        row.beam_area_mm2 = beam.area_mm2();
        if (beam.empty()) return;
        double light = 0.0;
        for (const PassingBeam::Node& node : beam.Nodes()) {
            const double density = bundle.FluxDensity(node.u, node.v) * node.area_mm2;
            light += density;
            row.flux_mm2 += density * Weight(direct_, bundle.At(node.u, node.v), false);
        }
        row.transmittance = row.flux_mm2 / light;
        for (const InteractionList& list : lists_) {
            row.transmittances.push_back(MeanTransmittance(list, bundle, beam.box));
        }
    }

    // Over the rays that pass at another wavelength, whose beam is not quite that of the d line. 0
    // if none does.
    double MeanTransmittance(const InteractionList& list, const LightBundle& bundle,
                             const PassingBeam::Box& box) {
        double light = 0.0, flux = 0.0;
        for (int j = 0; j < kWavelengthSteps / 2; ++j) {
            const double v = box.v1 * (j + 0.5) / (kWavelengthSteps / 2);
            for (int i = 0; i < kWavelengthSteps; ++i) {
                const double u = box.u0 + (box.u1 - box.u0) * (i + 0.5) / kWavelengthSteps;
                const double weight = Weight(list, bundle.At(u, v), true);
                if (weight == 0.0) continue;
                const double density = bundle.FluxDensity(u, v);
                light += density;
                flux += density * weight;
            }
        }
        return light > 0.0 ? flux / light : 0.0;
    }

    // E = integral of T cos(angle) dOmega over the rays that, sent back from the chief ray's place,
    // leave the lens at its front; (u, v) is a place in the tangent plane of the last vertex.
    double Irradiance(const ChiefRay& chief) {
        const double gap_mm = lens_.sensor_gap_mm();
        const Vec3d from(chief.sensor_mm.x, chief.sensor_mm.y, lens_.sensor_z_mm());
        const auto ray_to = [&](double u, double v) {
            const Vec2d at = in_y_ ? Vec2d(v, u) : Vec2d(u, v);
            const Vec3d to(at.x - from.x, at.y - from.y, -gap_mm);
            return Ray{from, to.normalized()};
        };
        RayPlane plane;
        plane.passes = [&](double u, double v) {
            return TraceRay(back_, ray_to(u, v), {true, &iris_, false}, nullptr).ended_at < 0;
        };
        // The last rim as it is seen from there, projected on the plane.
        const LensSurface& last = lens_.surfaces().back();
        const double sag = last.shape.SagRange(last.semi_diameter_mm)[1];
        const double nearer = std::max(1.0, gap_mm / std::max(gap_mm - sag, 0.02 * gap_mm));
        const double height = std::hypot(from.x, from.y);
        plane.half_width = 1.05 * last.semi_diameter_mm * nearer + height * (nearer - 1.0);
        const Vec3d exit =
            TraceRay(direct_, chief.ray, {false, nullptr, false}, nullptr).exit_direction;
        plane.hint_u =
            in_y_ ? from.y - exit.y / exit.z * gap_mm : from.x - exit.x / exit.z * gap_mm;

        double irradiance = 0.0;
        for (const PassingBeam::Node& node : FindPassingBeam(plane).Nodes()) {
            const Ray ray = ray_to(node.u, node.v);
            // dOmega = cos^3 dA / gap^2 and one more cosine.
            const double cosine2 = ray.direction.z * ray.direction.z;
            irradiance += Weight(back_, ray, false) * cosine2 * cosine2 * node.area_mm2;
        }
        return irradiance / (gap_mm * gap_mm);
    }

    // The share of a ray that surfaces and glass let through, 0 if it does not come to the end.
    // Rims need not be looked at inside a beam.
    double Weight(const InteractionList& list, const Ray& ray, bool clip) {
        const TraceResult result = TraceRay(list, ray, {clip, &iris_, false}, &record_);
        const bool through =
            list.steps.front().forward ? result.fate == RayFate::kArrived : result.ended_at < 0;
        return through ? PathWeight(lens_, list, record_) : 0.0;
    }

    const Lens& lens_;
    const FieldOptions& options_;
    Section section_;
    bool in_y_, fisheye_;  // the light stands in the y-z plane and not in the x-z plane
    Iris iris_;
    InteractionList direct_, back_;
    std::vector<InteractionList> lists_;  // direct, at the other wavelengths
    bool in_front_ = true;                // the scene, of the entrance pupil
    double inverse_depth_ = 0.0;
    double side_ =
        1.0;  // of the axis on which the image stands: -1 where the lens turns it upright
    std::optional<double> axis_slope_mm_;  // image height per angle, next to the axis
    RayRecord record_;
};

}  // namespace

std::string_view Name(FieldEdge edge) {
    switch (edge) {
        case FieldEdge::kImageCircle:
            return "image_circle";
        case FieldEdge::kNoChiefRay:
            return "no_chief_ray";
        case FieldEdge::kNoLight:
            return "no_light";
    }
    return "no_light";
}

FieldData FieldDataOf(const Lens& lens, const FieldOptions& options) {
    FLARE_CHECK(options.rows >= 2);
    const StopSetting stop = SettingFor(lens, options);
    FieldData data;
    data.f_number = stop.f_number;
    data.wavelengths_nm = options.wavelengths_nm;
    if (!lens.rotational()) {
        data.tables.push_back(SectionField(lens, options, stop, Section::kX).Table());
    }
    data.tables.push_back(SectionField(lens, options, stop, Section::kY).Table());
    return data;
}

}  // namespace flare
