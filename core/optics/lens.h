// SPDX-License-Identifier: Apache-2.0
//
// A lens ready to be traced: the checked, immutable form of a prescription, with every vertex in
// lens space and its first-order (paraxial) data at the d line. Cheap to share between threads.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "core/optics/coating.h"
#include "core/optics/glass.h"
#include "core/optics/prescription.h"
#include "core/optics/surface_shape.h"

namespace flare {

struct CoatingOverride;

struct LensSurface {
    SurfaceKind kind = SurfaceKind::kSphere;
    SurfaceShape shape;
    double vertex_z_mm = 0.0;
    double semi_diameter_mm = 0.0;
    Glass behind = Glass::Air();  // the medium behind; in front of surface 0 there is air
    Coating coating;
    // The medium in front has the higher index (d line): light that travels towards +z meets the
    // coating's layers reversed.
    bool dense_in_front = false;

    bool is_stop() const { return kind == SurfaceKind::kStop; }
};

struct Pupil {
    double z_mm = 0.0;         // from vertex 0
    double diameter_mm = 0.0;  // limited by the stop alone, wide open
};

// The sensor as a mirror, where the lens file has one.
struct LensSensor {
    double reflectance = 0.0;  // at any angle and wavelength
    double semi_diameter_mm = 0.0;
};

// First-order data of one section at 587.5618 nm, light from infinity.
struct FirstOrder {
    double efl_mm = 0.0;    // infinite for an afocal lens, and then the next two as well
    double bfl_mm = 0.0;    // last vertex to paraxial focus
    double f_number = 0.0;  // EFL / entrance pupil diameter, wide open
    double stop_a1 = 0.0;   // height at the stop of a ray that enters parallel at height 1
    Pupil entrance, exit;   // images of the stop; a telecentric exit pupil is at -infinity
    double pupil_magnification = 0.0;  // exit / entrance diameter (signed magnification's size)
    // (z_sensor - z_exit) / pupil_magnification, finite for a telecentric lens too: the distance d'
    // of the rectilinear projection; EFL where the sensor is at the focus.
    double projection_distance_mm = 0.0;
};

class Lens {
  public:
    // The lens as its surfaces stand in the prescription: at infinity (or focus_shift_mm from it)
    // and in the first zoom position; LensInState (lens_state.h) gives the others. Fails with code
    // "bad_lens" (and the surface's place) where a lens cannot be traced: no glass,
    // none or several stops (a later capability), semi-diameter above the radius, sensor in
    // front of the last vertex, zero power without an explicit sensor distance, ...
    static Result<std::shared_ptr<const Lens>> Build(const Prescription& prescription);

    const Prescription& prescription() const { return prescription_; }
    const std::string& name() const { return prescription_.name; }
    const std::vector<LensSurface>& surfaces() const { return surfaces_; }
    int stop_index() const { return stop_index_; }
    double sensor_z_mm() const { return sensor_z_mm_; }
    // The distance of the sensor from the last vertex; nominal: when focused at infinity.
    double sensor_gap_mm() const;
    // The same to the last bit however the lens is focused by moving the sensor.
    double nominal_sensor_gap_mm() const { return nominal_sensor_gap_mm_; }
    // A mirror in the sensor's place. Bounce sequences know it as surface sensor_index().
    const std::optional<LensSensor>& sensor() const { return sensor_; }
    int sensor_index() const { return static_cast<int>(surfaces_.size()); }

    // An anamorphic lens has its own in x and in y. y is the section that such lenses are named by:
    // as a rule they squeeze the picture in x.
    const FirstOrder& first_order(Section section = Section::kY) const {
        return first_order_[section == Section::kX ? 0 : 1];
    }
    // Is every surface the same all around the axis?
    bool rotational() const { return rotational_; }
    // EFL in y over EFL in x, as sizes: how much narrower than it is the scene stands on the
    // sensor. 1 for a rotational lens and where a section has no focal length.
    double squeeze() const;
    // The centre of the entrance pupil, from which directions and distances are measured; between
    // the two sections' pupils in an anamorphic lens.
    double pupil_z_mm() const {
        return 0.5 * (first_order_[0].entrance.z_mm + first_order_[1].entrance.z_mm);
    }
    // Wide open; the geometric mean of both sections'.
    double f_number() const;

    // The same lens with every surface bare ("coatings": "none").
    std::shared_ptr<const Lens> WithBareGlass() const;
    // The same lens with other coatings (lens_coatings.h).
    Result<std::shared_ptr<const Lens>> WithCoatings(const CoatingOverride& coatings) const;

    // Names everything that bends rays or clips them up to the last surface (shape, glass, rims),
    // not the coatings: one traced mesh serves every coating and every place of the sensor.
    const Fingerprint& geometry_fingerprint() const { return geometry_fingerprint_; }
    // The above, the coatings, absorption and the sensor.
    const Fingerprint& fingerprint() const { return fingerprint_; }

    // Medium in front of / behind surface `index`.
    const Glass& MediumBefore(int index) const;
    const Glass& MediumBehind(int index) const;

    Lens() = default;  // use Build

  private:
    void Seal();

    Prescription prescription_;
    std::vector<LensSurface> surfaces_;
    int stop_index_ = 0;
    double sensor_z_mm_ = 0.0;
    double nominal_sensor_gap_mm_ = 0.0;
    std::optional<LensSensor> sensor_;
    std::array<FirstOrder, 2> first_order_;  // x, y
    bool rotational_ = true;
    Fingerprint geometry_fingerprint_, fingerprint_;
};

}  // namespace flare
