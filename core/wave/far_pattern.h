// SPDX-License-Identifier: Apache-2.0
//
// The outskirts of a Fraunhofer pattern, many fringes from the middle, as pixels see them: averaged
// over fringes, summed over wavelengths. There the light of different parts of the edge adds up
// without interference (stationary phase; docs/physics/starburst.md):
//   a straight side of length L        L^2 sinc^2(L k_t) k_n^2 / (4 pi^2 k^4)   a spike
//   an arc, dl of edge per dphi        (dl / dphi) / (4 pi^2 k^3)               a fan
//   a corner between sides 1 and 2     (tau_2 - tau_1)^2 / (16 pi^4 k^4)        haze
// with k_t, k_n along a side and across it and tau = k_n / k_t.
//
// Places are pixels from the middle, wavelengths and the outline such that place / wavelength is a
// frequency k of the outline. A source may be an ellipse: the image of its disc. The density is the
// light per pixel area; over all places the pattern's light is the sum of the bands' weights.
// Immutable once built.
#pragma once

#include <array>
#include <vector>

#include "core/base/vec.h"
#include "core/wave/aperture_outline.h"

namespace flare {

struct PatternBand {
    double wavelength = 0.0;
    Vec3d weight{0.0, 0.0, 0.0};  // light in three colours (or one: the others 0)
};

// The image of a disc: half axes as two conjugate vectors; both zero for a point.
struct SourceEllipse {
    Vec2d a{0.0, 0.0}, b{0.0, 0.0};
    // Half-width along a unit direction.
    double HalfWidth(Vec2d direction) const;
    double radius() const;  // no point of it lies farther from its middle
};

class FarPattern {
  public:
    // For places between `inner` and `outer` from the middle.
    FarPattern(const std::vector<ApertureOutline>& outlines, const std::vector<PatternBand>& bands,
               const SourceEllipse& source, double inner, double outer);

    // Mean light per area over the pixel around `place`, which is not the middle itself.
    Vec3d At(Vec2d place) const;

  private:
    // A straight side, or one bent too little to tell: the light across its spike.
    struct Spike {
        Vec2d tangent;
        double length = 0.0;
        double spread = 0.0;             // half the angle that its normals fill
        double step = 0.0, reach = 0.0;  // of the table, in places
        std::vector<Vec3d> sums;         // of the profile, from -reach on
    };
    struct Corner {
        Vec2d tangent1, tangent2;
        bool straight1 = false, straight2 = false;
        double width1 = 0.0, width2 = 0.0;  // of tau's pole, times the root of k (arcs) or k
    };
    struct Arc {  // a little part of an arc
        double length = 0.0, normal_rad = 0.0, half_angle = 0.0;
    };
    // Length of edge per angle of its normal, smoothed as far as diffraction does at a radius.
    struct Ring {
        std::vector<double> length_per_rad;
    };

    void AddLoop(const EdgeLoop& loop, double wavenumber);
    void AddArcs(const EdgePiece& piece, bool closed);
    void AddSpike(const EdgePiece& piece, double turn);
    void FillTable(Spike& spike, const std::vector<PatternBand>& bands,
                   const SourceEllipse& source) const;
    void BuildRings(double inner, double outer);
    double LengthPerRad(Vec2d place, double radius) const;
    Vec3d SpikeProfile(const Spike& spike, double along, double radius) const;

    std::vector<Spike> spikes_;
    std::vector<Corner> corners_;
    std::vector<Arc> arcs_;
    std::vector<Ring> rings_;
    double first_ring_ = 1.0;  // radius of the first; each next is kRingStep times as far
    double area_ = 0.0;        // of all outlines
    double mean_wavelength_ = 0.0;
    double source_radius2_ = 0.0;  // mean square, for the curvature of 1 / radius^n over it
    Vec3d light_, by_wavelength_, by_wavelength2_;  // sums of weight, times wavelength, squared
};

}  // namespace flare
