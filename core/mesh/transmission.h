// SPDX-License-Identifier: Apache-2.0
//
// The product of unpolarised reflectances and transmittances along a ghost's path, at any
// wavelength, from the cosines that the mesh keeps. For each interaction the mesh has c^2, the
// squared cosine of the ray in the *rarer* of the two media: R and T are smooth functions of c all
// the way to the critical angle (c = 0), and c^2 < 0 is total internal reflection. After these come
// the ways in mm through absorbing glass, one for each of AbsorbingSteps: together the ray's
// passage.
//
// Coated surfaces are tabulated over c, each table refined until a cubic through its points is
// within 1e-7 of the characteristic matrix; where a table would need more than 8192 points, or all
// of them more than 256 MB, the matrix itself is evaluated. Bare surfaces are always evaluated. A
// surface has one table of T, which is the same both ways, and two of R, which differ where a layer
// absorbs. Immutable once built, so safe from any thread.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/optics/lens.h"
#include "core/tracing/interaction_list.h"

namespace flare {

// The interactions of `sequence` that light reaches through glass with known absorption.
std::vector<int> AbsorbingSteps(const Lens& lens, const BounceSequence& sequence);

class TransmissionTables {
  public:
    TransmissionTables(const Lens& lens, std::vector<double> wavelengths_nm, ThreadPool& threads);

  private:
    // One quantity of a coated surface over c = 0 ... 1: a cubic in each of its equal intervals.
    struct Table {
        std::vector<std::array<double, 4>> cubics;  // empty: evaluate
        double At(double c) const;
    };

  public:
    // Everything that `sequence` needs, written out for every wavelength.
    class Path {
      public:
        // The product at wavelength number `band` for a ray's passage.
        double Weight(int band, std::span<const double> passage) const;

        // Its parts: the factor of one interaction, and what light loses a mm on each of the ways
        // through absorbing glass (the passage's last entries).
        double Factor(int band, std::size_t step, double rare_cos2) const;
        std::vector<double> AbsorptionsPerMm(int band) const;

        std::size_t steps() const { return lists_.front().steps.size(); }
        // Is there anything that reflects or refracts?
        bool Acts(std::size_t step) const {
            return lists_.front().steps[step].kind != InteractionKind::kStop;
        }

      private:
        friend class TransmissionTables;
        const TransmissionTables* tables_ = nullptr;
        std::vector<InteractionList> lists_;
        // For each band and interaction, row by row: the table that holds its factor; null where
        // there is none (a stop, a bare surface, a sensor).
        std::vector<const Table*> looked_up_;
        std::vector<int> absorbing_;
    };
    Path PathOf(const Lens& lens, const BounceSequence& sequence) const;

    const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }
    std::size_t bytes() const;

  private:
    enum Quantity { kTransmittance, kReflectanceFromRare, kReflectanceFromDense, kQuantities };

    std::size_t most_intervals_ = 0;  // of one table

    struct Face {
        Coating coating;
        bool dense_in_front = false;  // at the d line, which the order of the layers follows
    };

    void BuildTables(const Lens& lens, int surface, int band);
    const Table& TableOf(int surface, int band, Quantity quantity) const;
    const Table* TableFor(const Interaction& step, int band) const;
    double StepFactor(const Interaction& step, int band, double rare_cos2) const;

    std::vector<double> wavelengths_nm_;
    double sensor_reflectance_ = 0.0;
    std::vector<Face> faces_;    // by surface
    std::vector<Table> tables_;  // [surface][band][quantity]
};

}  // namespace flare
