// SPDX-License-Identifier: Apache-2.0
//
// The diffraction fringes that the iris draws into one ghost: beside each edge of the iris light is
// multiplied by a profile over the distance from it, in place of being cut off (edge_profile.h).
// Where edges meet, their profiles multiply, which is exact for a right angle and near enough a few
// fringes away from any other.
//
// A profile's scale is local: over which distance the light near a place in the stop spreads is
// told by the second derivative of the optical path there, kept as a polynomial over the stop
// (stop_jacobian.h). Between a place and the edge it is taken a third of the way to the edge: the
// path from the edge differs by the integral of (distance from the edge) x (second derivative).
// Immutable once made, shared by threads.
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
        // By row the 2 x 2 second derivative of the path, 1/mm; factors of 1, x, y, x^2, x y, y^2
        // of the place in the stop over `unit_mm`.
        std::array<std::array<double, 4>, 6> bend{};
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
    // Of t, for a mm of distance from an edge: at a place in the stop which is `distance_mm`
    // outside the edge (inside: negative), `normal` pointing out.
    double PerMm(std::size_t crossing, Vec2d stop_mm, Vec2d normal, double distance_mm) const;
};

}  // namespace flare
