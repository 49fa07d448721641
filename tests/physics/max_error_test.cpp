// SPDX-License-Identifier: Apache-2.0
//
// A picture asked for by its error, against the converged one.
#include <gtest/gtest.h>

#include "core/render/renderer.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest Scene() {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::SeedLens());
    request.f_number = 8.0;
    request.image.width = 64;
    request.image.height = 36;
    request.lights = {LightAt(6.0, 70.0)};
    return request;
}

TEST(MaxError, IsKeptByThePicture) {
    Studio studio;
    FlareRequest request = Scene();
    request.quality = QualityPreset::kReference;
    const Rendering reference = studio.Shoot(request);
    double before = 0.0;
    for (const double max_error : {0.03, 0.1, 0.2}) {
        request.quality = {};
        request.quality.max_error = max_error;
        const Rendering found = studio.Shoot(request);
        EXPECT_LE(found.report.facts.estimated_error.rel_l1, max_error);
        EXPECT_LE(testing::RelL1(found.image, reference.image), max_error);
        EXPECT_EQ(found.report.work.search->pictures, 1U) << "the survey's estimate was off";
        EXPECT_GT(*found.quality.tolerance, before);
        before = *found.quality.tolerance;

        request.quality = found.quality;
        const Rendering again = studio.Shoot(request);
        EXPECT_TRUE(again.image.planes[1].values == found.image.planes[1].values);
    }
}

}  // namespace
}  // namespace flare
