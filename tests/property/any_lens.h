// SPDX-License-Identifier: Apache-2.0
//
// What the properties are tried on: numbers drawn by RapidCheck, which repeats and shrinks them,
// lenses made of them (random_lens.h) or, one in eight, taken from the library, and requests.
//
// Every property is tried a few times, from one seed, so that a run of CI is short and the same
// everywhere. RC_PARAMS in the environment says otherwise: RC_PARAMS="max_success=500 seed=3".
#pragma once

#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "tests/support/lenses.h"
#include "tests/support/random_lens.h"
#include "tests/support/rendering.h"

namespace flare::testing {

// RapidCheck reads it when the first property is tried.
inline const int kFewTries = setenv("RC_PARAMS", "max_success=8 seed=8 max_discard_ratio=100", 0);

class Drawn {
  public:
    double Uniform(double lo, double hi) { return lo + (hi - lo) * Below(100'001) * 1e-5; }
    int Below(int count) { return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, count)); }
};

struct LensChoice {
    bool rotational = false;
    int most_surfaces = 4;
    bool library = true;
};

inline std::shared_ptr<const Lens> AnyLens(Drawn& drawn, const LensChoice& choice = {}) {
    if (drawn.Below(8) == 0 && choice.library) {
        static const auto kLibrary = {LibraryLens("sasian-triplet-50mm-f4"),
                                      LibraryLens("petzval-portrait-86mm-f3_4"),
                                      LibraryLens(kHeliarName)};
        return kLibrary.begin()[drawn.Below(static_cast<int>(kLibrary.size()))];
    }
    RandomLensKind kind;
    kind.most_surfaces = choice.most_surfaces;
    kind.any_shape = !choice.rotational && drawn.Below(3) == 0;
    kind.dispersion = drawn.Below(2) == 0;
    kind.coatings = drawn.Below(2) == 0;
    return BuildLens(RandomPrescription(drawn, kind));
}

// A lens of next to no power has an f-number beyond all that may be asked.
inline double StoppedDown(const Lens& lens, double times) {
    return std::min(lens.f_number(), 1000.0) * times;
}

inline FlareRequest AnyRequest(Drawn& drawn, const LensChoice& choice = {}) {
    FlareRequest request;
    request.lens = AnyLens(drawn, choice);
    request.f_number = StoppedDown(*request.lens, drawn.Uniform(1.0, 4.0));
    request.image.width = request.image.height = 40;
    request.units = Units::kSensorIrradiance;
    request.model.culling = CullingRule::kNone;
    request.lights = {LightAt(drawn.Uniform(0.0, 15.0), drawn.Uniform(0.0, 360.0))};
    return request;
}

inline double LightIn(const FlareImage& image) {
    double sum = 0.0;
    for (const ImagePlane& plane : image.planes) sum += Sum(plane);
    return sum;
}

}  // namespace flare::testing
