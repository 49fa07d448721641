// SPDX-License-Identifier: Apache-2.0
//
// The diffraction fringes that the iris draws into one ghost: beside each edge of the iris light is
// multiplied by a profile over the distance from it, in place of being cut off (edge_profile.h).
// Where edges meet, their profiles multiply, which is exact for a right angle and near enough a few
// fringes away from any other.
//
// A profile's scale is local: what light near a place in the stop does on its way to the sensor is
// told by d(picture) / d(direction at the stop), kept as a polynomial over the stop, and by how the
// stop lies on the picture there (stop_jacobian.h). Immutable once made, shared by threads.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/optics/iris.h"

namespace flare {

struct GhostFringes {
    explicit GhostFringes(const Iris& sharp) : iris(sharp) {}

    // One passage through the stop.
    struct Crossing {
        bool rings = false;                // else its edges are sharp
        double weight = 1.0;               // of the fringes over the sharp edge
        double fringe_px = 0.0;            // from the edge to the first maximum, about
        double source_t = 0.0;             // half-width of the light's disc
        double disc_fresnel_number = 0.0;  // of a round iris; 0: by its edges
        // (x, y) in pixels for a direction along x, and for one along y; factors of 1, x, y, x^2,
        // x y, y^2 of the place in the stop over `unit_mm`.
        std::array<std::array<double, 4>, 6> spread{};
        double unit_mm = 1.0;
        double least_mm = 0.0, usual_mm = 1.0, most_mm = 0.0;  // of the distance z
    };

    // The request's, with room for the fringes: see Iris::Widened.
    Iris iris;
    std::vector<Crossing> crossings;  // as the mesh counts them

    double wavelength_mm = 550e-6;  // that t is measured in (edge_profile.h)
    double dark_t = 0.0, lit_t = 0.0, step_t = 1.0;
    // EdgeTable of each crossing and drawn band, one after another.
    int entries = 0, bands = 0;
    std::vector<float> tables;

    const float* Table(std::size_t crossing, std::size_t band) const {
        return tables.data() + (crossing * static_cast<std::size_t>(bands) + band) *
                                   static_cast<std::size_t>(entries);
    }
    // How the stop lies on the picture: mm for a pixel to the right, and down.
    struct StopOnPicture {
        Vec2d right{0.0, 0.0}, down{0.0, 0.0};
    };
    // Of t, for a mm away from an edge with this normal at a place in the stop.
    double PerMm(std::size_t crossing, Vec2d stop_mm, Vec2d normal, const StopOnPicture& on) const;
};

}  // namespace flare
