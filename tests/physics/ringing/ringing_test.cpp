// SPDX-License-Identifier: Apache-2.0
//
// Pictures of ghosts that ring: the light they keep, and tiles against polygons.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

FlareRequest ColourRequest(double f_number, double field_deg, int width) {
    FlareRequest request = testing::SpectralRequest(testing::BuildLens(testing::SeedLens()),
                                                    f_number, width, width * 9 / 16);
    request.color = ColorMode::kLinRec709;
    request.wavelengths_nm.clear();
    request.lights = {LightAt(field_deg, 20.0)};
    request.model.ringing = true;
    return request;
}

double Light(const Rendering& rendering) {
    double sum = 0.0;
    for (const char* const name : {"R", "G", "B"})
        sum += testing::Sum(testing::PlaneNamed(rendering.image, name));
    return sum;
}

TEST(Ringing, KeepsTheLightOfThePicture) {
    Studio studio;
    for (const double f_number : {8.0, 16.0}) {
        for (const int blades : {0, 6}) {
            FlareRequest request = ColourRequest(f_number, 5.0, 960);
            request.image.sensor_width_mm = 72.0;
            request.iris.blades = blades;
            const double with = Light(studio.Shoot(request));
            request.model.ringing = false;
            const double without = Light(studio.Shoot(request));
            EXPECT_NEAR(with / without, 1.0, f_number < 10.0 ? 1.5e-3 : 7e-3)
                << f_number << ", " << blades;
        }
    }
}

TEST(Ringing, IsDrawnAlikeByTilesAndByPolygons) {
    Studio studio;
    FlareRequest request = ColourRequest(8.0, 5.0, 960);
    request.image.crop = {300, 200, 160, 120};
    request.quality = QualityPreset::kFinal;
    const Rendering tiles = studio.Shoot(request);
    request.quality = QualityPreset::kReference;
    const Rendering polygons = studio.Shoot(request);
    const double off = testing::RelL1(tiles.image, polygons.image);
    std::printf("rel_l1 of final against reference, fringes in both: %.4f\n", off);
    EXPECT_LT(off, 0.01);
}

}  // namespace
}  // namespace flare
