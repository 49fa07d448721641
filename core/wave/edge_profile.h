// SPDX-License-Identifier: Apache-2.0
//
// Light beside the edge of an aperture in the Fresnel approximation: the profile of a straight edge
// and the whole pattern of a disc, and tables of either as a ghost is drawn with it, averaged over
// a band of wavelengths and over the disc of the source.
//
// Places are t = d sqrt(2 / (lambda_0 |z|)), d being the distance from the edge, positive on the
// lit side, z the distance of propagation and lambda_0 one reference wavelength for all bands, so
// that a ghost's bands share one scale. Values are in units of the light without diffraction: 1 far
// inside, 0 far outside. A table keeps the light: over all t it holds as much as the sharp edge
// does, also around a bend (its first moment is that of the sharp edge, a disc's its area's).
#pragma once

#include <vector>

namespace flare {

// A half-plane: 1/2 [(C(v) + 1/2)^2 + (S(v) + 1/2)^2] with Fresnel's integrals C and S (Born and
// Wolf, Principles of Optics, 8.7).
double KnifeEdge(double v);

// A disc at `rho` radii from its axis, by Lommel's functions (Born and Wolf, 8.8).
// fresnel_number = a^2 / (lambda |z|) > 0; rho >= 0; the cost grows with their product.
double DiscPattern(double fresnel_number, double rho);

struct EdgeProfileSpec {
    double wavelength_ratio = 1.0;  // lambda_0 over the band's middle
    double relative_bandwidth = 0.0;
    double source_t = 0.0;             // half-width of the source's disc
    double weight = 1.0;               // of the pattern; the rest is a sharp edge
    double disc_fresnel_number = 0.0;  // at lambda_0; 0: a straight edge
    double dark_t = 4.5, lit_t = 7.0;  // how far the pattern goes outside and inside the edge
    double step_t = 0.03;
};

// Sums of the profile from -dark_t on, in steps: entry i is the integral up to -dark_t + i step_t,
// divided by step_t. Entries beyond the last grow by 1 a step.
std::vector<float> EdgeTable(const EdgeProfileSpec& spec);

// Mean of the profile over place -+ half_width, both in steps from the table's first entry.
double TableMean(const float* table, int entries, double place, double half_width);

}  // namespace flare
