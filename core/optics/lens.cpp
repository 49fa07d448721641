// SPDX-License-Identifier: Apache-2.0
//
// Build goes from the simple to the derived: refuse what has a fault, lay out the surfaces, find
// the stop, compute the matrices, place the sensor, take the pupils, and last the fingerprints. A
// Lens that exists has finite vertices, one stop, a sensor behind the last vertex and a pupil.
#include "core/optics/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/optics/lens_coatings.h"
#include "core/optics/paraxial.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// Below this power (1/mm) a lens is afocal: its focal length exceeds a thousand kilometres.
constexpr double kAfocalPower = 1e-9;
// Below this the stop sits at a focus of the elements in front of it.
constexpr double kMinStopA1 = 1e-9;

Error BadLens(const std::string& message, const std::string& where = "") {
    return {"bad_lens", message, where};
}

std::vector<LensSurface> LayOut(const Prescription& prescription) {
    std::vector<LensSurface> surfaces;
    const std::size_t count = prescription.optical_count();
    surfaces.reserve(count);
    double z = 0.0;
    Glass before = Glass::Air();
    for (std::size_t i = 0; i < count; ++i) {
        const SurfacePrescription& from = prescription.surfaces[i];
        LensSurface to;
        to.kind = from.kind;
        to.shape = ShapeOf(from);
        if (to.kind == SurfaceKind::kSphere && to.shape.flat()) to.kind = SurfaceKind::kPlane;
        to.vertex_z_mm = z;
        to.semi_diameter_mm = from.semi_diameter_mm;
        to.behind = MediumOf(from).value();
        to.dense_in_front = before.nd() > to.behind.nd();
        to.coating = CoatingFor(prescription, from, before, to.behind);
        before = to.behind;
        z += from.gap_mm;
        surfaces.push_back(std::move(to));
    }
    return surfaces;
}

bool Finite(const Abcd& m) {
    return std::isfinite(m.a * m.d) && std::isfinite(m.b * m.c) && m.determinant() != 0.0;
}

// EFL, BFL, pupils and f-number of a lens whose surfaces and stop stand; the sensor may still be
// unplaced.
FirstOrder FirstOrderOf(const Lens& lens, Section section) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::vector<LensSurface>& surfaces = lens.surfaces();
    const double stop_diameter =
        2.0 * surfaces[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;

    FirstOrder out;
    const Abcd whole = FrontToBack(lens, kLineD, section);
    const bool afocal = std::abs(whole.c) < kAfocalPower;
    out.efl_mm = afocal ? kInfinity : -1.0 / whole.c;
    out.bfl_mm = afocal ? kInfinity : -whole.a / whole.c;

    // The entrance pupil is where a ray through the middle of the stop seems to cross the axis.
    const Abcd front = FrontToSurface(lens, lens.stop_index(), kLineD, section);
    out.stop_a1 = front.a;
    out.entrance.z_mm = front.b / front.a;
    out.entrance.diameter_mm = stop_diameter / std::abs(front.a);
    out.f_number = std::abs(out.efl_mm) / out.entrance.diameter_mm;

    const Abcd rear = StopToBack(lens, kLineD, section);
    const double last_z = surfaces.back().vertex_z_mm;
    const bool telecentric = std::abs(rear.d) < 1e-12;
    out.exit.z_mm = telecentric ? -kInfinity : last_z - rear.b / rear.d;
    out.exit.diameter_mm =
        telecentric ? kInfinity : stop_diameter * std::abs(rear.determinant() / rear.d);
    out.pupil_magnification = out.exit.diameter_mm / out.entrance.diameter_mm;
    return out;
}

// At infinity: where the file says, else at the paraxial focus, midway between the two sections' in
// an anamorphic lens.
Result<double> NominalSensorGap(const Prescription& prescription, const Lens& lens) {
    const SurfacePrescription& last = prescription.surfaces[prescription.optical_count() - 1];
    const double focus =
        0.5 * (lens.first_order(Section::kX).bfl_mm + lens.first_order(Section::kY).bfl_mm);
    if (!last.gap_given && !std::isfinite(focus)) {
        return BadLens(
            "the lens has no power (afocal), so it needs the distance of the sensor: "
            "gap_mm of the last surface",
            last.where);
    }
    const double nominal = last.gap_given ? last.gap_mm : focus;
    const double gap = nominal + prescription.focus_shift_mm;
    if (!(gap >= kMinLengthMm)) {
        return BadLens("the paraxial focus lies " + NumberText(-gap) +
                           " mm in front of the last vertex: no sensor can stand there",
                       last.where);
    }
    if (gap > kMaxGapMm) {
        return BadLens("the paraxial focus lies " + NumberText(gap) +
                           " mm behind the last vertex: give gap_mm of the last surface",
                       last.where);
    }
    return nominal;
}

}  // namespace

Result<std::shared_ptr<const Lens>> Lens::Build(const Prescription& prescription) {
    const std::vector<PrescriptionFault> faults = FindFaults(prescription);
    if (!faults.empty()) return BadLens(faults.front().message, faults.front().where);

    auto lens = std::make_shared<Lens>();
    lens->prescription_ = prescription;
    lens->surfaces_ = LayOut(prescription);
    while (!lens->surfaces_[static_cast<std::size_t>(lens->stop_index_)].is_stop()) {
        ++lens->stop_index_;
    }
    lens->rotational_ =
        std::all_of(lens->surfaces_.begin(), lens->surfaces_.end(),
                    [](const LensSurface& surface) { return surface.shape.rotational(); });
    const std::string& stop_where =
        prescription.surfaces[static_cast<std::size_t>(lens->stop_index_)].where;
    for (const Section section : {Section::kX, Section::kY}) {
        if (!Finite(FrontToBack(*lens, kLineD, section)) ||
            !Finite(StopToBack(*lens, kLineD, section))) {
            return BadLens("the numbers of the lens overflow: its focal length cannot be computed");
        }
        const Abcd front = FrontToSurface(*lens, lens->stop_index_, kLineD, section);
        if (std::abs(front.a) < kMinStopA1) {
            return BadLens(
                "the stop lies at a focus of the elements in front of it, so it limits no "
                "beam from infinity and the lens has no f-number",
                stop_where);
        }
        lens->first_order_[section == Section::kX ? 0 : 1] = FirstOrderOf(*lens, section);
    }

    const Result<double> nominal_gap = NominalSensorGap(prescription, *lens);
    if (!nominal_gap) return nominal_gap.error();
    lens->nominal_sensor_gap_mm_ = *nominal_gap;
    const double sensor_gap = *nominal_gap + prescription.focus_shift_mm;
    lens->sensor_z_mm_ = lens->surfaces_.back().vertex_z_mm + sensor_gap;
    if (prescription.surfaces.back().kind == SurfaceKind::kSensor) {
        const SurfacePrescription& sensor = prescription.surfaces.back();
        lens->sensor_ = LensSensor{sensor.reflectance, sensor.semi_diameter_mm};
    }

    for (const Section section : {Section::kX, Section::kY}) {
        const Abcd rear = StopToBack(*lens, kLineD, section);
        FirstOrder& first_order = lens->first_order_[section == Section::kX ? 0 : 1];
        first_order.projection_distance_mm =
            std::abs((sensor_gap * rear.d + rear.b) / (rear.determinant() * first_order.stop_a1));
    }
    lens->Seal();
    return std::shared_ptr<const Lens>(std::move(lens));
}

double Lens::sensor_gap_mm() const {
    return sensor_z_mm_ - surfaces_.back().vertex_z_mm;
}

double Lens::f_number() const {
    // Not the root of a square where both sections are one: the same number to the last bit.
    if (rotational_) return first_order_[1].f_number;
    return std::sqrt(first_order_[0].f_number * first_order_[1].f_number);
}

double Lens::squeeze() const {
    if (rotational_) return 1.0;
    const double ratio = std::abs(first_order_[1].efl_mm / first_order_[0].efl_mm);
    return std::isfinite(ratio) && ratio > 0.0 ? ratio : 1.0;
}

std::shared_ptr<const Lens> Lens::WithBareGlass() const {
    auto bare = std::make_shared<Lens>(*this);
    bare->prescription_.default_coating = "bare";
    for (SurfacePrescription& surface : bare->prescription_.surfaces) surface.coating.reset();
    for (LensSurface& surface : bare->surfaces_) surface.coating = {};
    bare->Seal();
    return bare;
}

const Glass& Lens::MediumBefore(int index) const {
    static const Glass air = Glass::Air();
    return index == 0 ? air : MediumBehind(index - 1);
}

const Glass& Lens::MediumBehind(int index) const {
    FLARE_CHECK(index >= 0 && static_cast<std::size_t>(index) < surfaces_.size());
    return surfaces_[static_cast<std::size_t>(index)].behind;
}

void Lens::Seal() {
    Fingerprinter geometry;
    geometry.Add("lens geometry 3").Add(static_cast<std::int64_t>(surfaces_.size()));
    geometry.Add(stop_index_).Add(nominal_sensor_gap_mm_);
    for (const LensSurface& surface : surfaces_) {
        geometry.Add(surface.is_stop() ? 1 : 0).Add(static_cast<int>(surface.shape.form()));
        geometry.Add(surface.shape.curvature_x()).Add(surface.shape.curvature_y());
        geometry.Add(surface.shape.conic());
        for (const double a : surface.shape.coefficients()) geometry.Add(a);
        geometry.Add(surface.vertex_z_mm).Add(surface.semi_diameter_mm);
        surface.behind.AddDispersionTo(geometry);
        // Whether, not how much: meshes keep the way through glass that absorbs.
        geometry.Add(surface.behind.absorbs() ? 1 : 0);
    }
    geometry_fingerprint_ = geometry.value();

    Fingerprinter whole;
    whole.Add("lens 3").Add(geometry_fingerprint_).Add(sensor_z_mm_);
    whole.Add(sensor_ ? sensor_->reflectance : -1.0);
    whole.Add(sensor_ ? sensor_->semi_diameter_mm : 0.0);
    for (const LensSurface& surface : surfaces_) {
        surface.behind.AddAbsorptionTo(whole);
        surface.coating.AddTo(whole);
    }
    fingerprint_ = whole.value();
}

}  // namespace flare
