// SPDX-License-Identifier: Apache-2.0
//
// Build goes from the simple to the derived: refuse what has a fault, lay out the surfaces, find
// the stop, compute the matrices, place the sensor, take the pupils, and last the fingerprints. A
// Lens that exists has finite vertices, one stop, a sensor behind the last vertex and a pupil.
#include "core/optics/lens.h"

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
    surfaces.reserve(prescription.surfaces.size());
    double z = 0.0;
    Glass before = Glass::Air();
    for (const SurfacePrescription& from : prescription.surfaces) {
        LensSurface to;
        to.kind = from.kind;
        if (to.kind == SurfaceKind::kSphere) {
            to.curvature = from.radius_mm == 0.0 ? 0.0 : 1.0 / from.radius_mm;
            if (to.curvature == 0.0) to.kind = SurfaceKind::kPlane;
        }
        to.vertex_z_mm = z;
        to.semi_diameter_mm = from.semi_diameter_mm;
        if (from.nd.has_value()) to.behind = Glass::FromNdVd(*from.nd, from.vd);
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
FirstOrder FirstOrderOf(const Lens& lens) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::vector<LensSurface>& surfaces = lens.surfaces();
    const double stop_diameter =
        2.0 * surfaces[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;

    FirstOrder out;
    const Abcd whole = FrontToBack(lens, kLineD);
    const bool afocal = std::abs(whole.c) < kAfocalPower;
    out.efl_mm = afocal ? kInfinity : -1.0 / whole.c;
    out.bfl_mm = afocal ? kInfinity : -whole.a / whole.c;

    // The entrance pupil is where a ray through the middle of the stop seems to cross the axis.
    const Abcd front = FrontToSurface(lens, lens.stop_index(), kLineD);
    out.stop_a1 = front.a;
    out.entrance.z_mm = front.b / front.a;
    out.entrance.diameter_mm = stop_diameter / std::abs(front.a);
    out.f_number = std::abs(out.efl_mm) / out.entrance.diameter_mm;

    const Abcd rear = StopToBack(lens, kLineD);
    const double last_z = surfaces.back().vertex_z_mm;
    const bool telecentric = std::abs(rear.d) < 1e-12;
    out.exit.z_mm = telecentric ? -kInfinity : last_z - rear.b / rear.d;
    out.exit.diameter_mm =
        telecentric ? kInfinity : stop_diameter * std::abs(rear.determinant() / rear.d);
    out.pupil_magnification = out.exit.diameter_mm / out.entrance.diameter_mm;
    return out;
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
    if (!Finite(FrontToBack(*lens, kLineD)) || !Finite(StopToBack(*lens, kLineD))) {
        return BadLens("the numbers of the lens overflow: its focal length cannot be computed");
    }
    const std::string& stop_where =
        prescription.surfaces[static_cast<std::size_t>(lens->stop_index_)].where;
    if (std::abs(FrontToSurface(*lens, lens->stop_index_, kLineD).a) < kMinStopA1) {
        return BadLens(
            "the stop lies at a focus of the elements in front of it, so it limits no "
            "beam from infinity and the lens has no f-number",
            stop_where);
    }
    lens->first_order_ = FirstOrderOf(*lens);

    // Place the sensor: where the file says, else at the paraxial focus.
    const SurfacePrescription& last = prescription.surfaces.back();
    const double sensor_gap = last.gap_given ? last.gap_mm : lens->first_order_.bfl_mm;
    if (!last.gap_given && std::isinf(sensor_gap)) {
        return BadLens(
            "the lens has no power (afocal), so it needs the distance of the sensor: "
            "gap_mm of the last surface",
            last.where);
    }
    if (!(sensor_gap >= kMinLengthMm)) {
        return BadLens("the paraxial focus lies " + NumberText(-sensor_gap) +
                           " mm in front of the last vertex: no sensor can stand there",
                       last.where);
    }
    if (sensor_gap > kMaxGapMm) {
        return BadLens("the paraxial focus lies " + NumberText(sensor_gap) +
                           " mm behind the last vertex: give gap_mm of the last surface",
                       last.where);
    }
    lens->sensor_z_mm_ = lens->surfaces_.back().vertex_z_mm + sensor_gap;

    const Abcd rear = StopToBack(*lens, kLineD);
    lens->first_order_.projection_distance_mm = std::abs(
        (sensor_gap * rear.d + rear.b) / (rear.determinant() * lens->first_order_.stop_a1));
    lens->Seal();
    return std::shared_ptr<const Lens>(std::move(lens));
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
    geometry.Add("lens geometry 1").Add(static_cast<std::int64_t>(surfaces_.size()));
    geometry.Add(stop_index_).Add(sensor_z_mm_);
    for (const LensSurface& surface : surfaces_) {
        geometry.Add(static_cast<int>(surface.kind)).Add(surface.curvature);
        geometry.Add(surface.vertex_z_mm).Add(surface.semi_diameter_mm);
        geometry.Add(surface.behind.cauchy_a()).Add(surface.behind.cauchy_b_nm2());
    }
    geometry_fingerprint_ = geometry.value();

    Fingerprinter whole;
    whole.Add("lens 1").Add(geometry_fingerprint_);
    for (const LensSurface& surface : surfaces_) surface.coating.AddTo(whole);
    fingerprint_ = whole.value();
}

}  // namespace flare
