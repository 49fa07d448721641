// SPDX-License-Identifier: Apache-2.0
//
// What rounding to steps does to a lens: as much as the closed form says, and nothing one can see.
#include "server/translate/ring_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>

#include "core/optics/glass.h"
#include "core/optics/lens_state.h"
#include "core/tracing/bounce_sequence.h"
#include "core/tracing/interaction_list.h"
#include "core/tracing/trace_reference.h"
#include "server/lens_library.h"

namespace flare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPixel_mm = 36.0 / 1920.0;

std::shared_ptr<const Lens> Named(const std::string& name) {
    return *LoadLensFile(FLARE_SOURCE_DIR "/lenses/" + name + ".toml");
}

wire::FlareRequest LitFrom(bool pixel) {
    wire::FlareRequest request;
    request.lights.resize(2);
    request.lights[0].direction = {0.0, 0.0, 1.0};
    if (pixel) request.lights[1].pixel = {10.0, 10.0};
    if (!pixel) request.lights[1].direction = {0.1, 0.0, 1.0};
    return request;
}

LensReading Reading(double focus_m, double zoom_mm) {
    LensReading reading;
    reading.values = {focus_m, 4.0, zoom_mm};
    return reading;
}

TEST(RingSteps, RoundOnlyWhatMeshesDependOn) {
    const LensReading read = Reading(2.3456789, 101.2345);
    const auto rounded = [&](const char* lens, bool pixel) {
        return RingSteps::For(*Named(lens), LitFrom(pixel)).Rounded(read);
    };
    EXPECT_EQ(rounded("tronnier-double-gauss-50mm-f2", false), read) << "focused as a whole";
    const LensReading pixel = rounded("tronnier-double-gauss-50mm-f2", true);
    EXPECT_NE(pixel[LensAxis::kFocus], read[LensAxis::kFocus]) << "directions follow the focus";
    EXPECT_EQ(pixel[LensAxis::kZoom], read[LensAxis::kZoom]);
    const LensReading inner = rounded("zeiss-master-prime-100mm-t1_3", false);
    EXPECT_NE(inner[LensAxis::kFocus], read[LensAxis::kFocus]);
    EXPECT_EQ(inner[LensAxis::kIris], read[LensAxis::kIris]);
    const LensReading zoom = rounded("canon-zoom-70-200mm-f2_8", false);
    EXPECT_EQ(zoom[LensAxis::kFocus], read[LensAxis::kFocus]);
    EXPECT_NE(zoom[LensAxis::kZoom], read[LensAxis::kZoom]);
    EXPECT_NEAR(*zoom[LensAxis::kZoom], 101.2345, 0.5 * kZoomStep * 101.3);
}

TEST(RingSteps, AreTheSameStateWhenRoundedAgain) {
    const RingSteps steps = RingSteps::For(*Named("zeiss-master-prime-100mm-t1_3"), LitFrom(false));
    for (const double focus_m : {0.99, 1.0, 1.37, 2.5, 40.0, 1e4, kInfinity}) {
        const LensReading once = steps.Rounded(Reading(focus_m, 100.0));
        EXPECT_EQ(steps.Rounded(once), once);
        EXPECT_EQ(steps.CellOf(once), steps.CellOf(Reading(focus_m, 100.0)));
    }
    EXPECT_EQ(*steps.Rounded(Reading(kInfinity, 100.0))[LensAxis::kFocus], kInfinity);
    EXPECT_EQ(*steps.Rounded(Reading(1e4, 100.0))[LensAxis::kFocus], kInfinity);
    EXPECT_EQ(steps.CellOf(LensReading{}), RingCell{});
}

TEST(RingSteps, HoldTheEndsOfTheLens) {
    const auto zoom = Named("canon-zoom-70-200mm-f2_8");
    const std::vector<double>& table = zoom->prescription().states.focal_mm;
    const RingSteps steps = RingSteps::For(*zoom, LitFrom(false));
    for (const double end_mm : {table.front(), table.back()}) {
        EXPECT_EQ(*steps.Rounded(Reading(3.0, end_mm))[LensAxis::kZoom], end_mm);
        EXPECT_NE(*steps.Rounded(Reading(3.0, 1.01 * end_mm))[LensAxis::kZoom], end_mm);
    }
    const auto prime = Named("zeiss-master-prime-100mm-t1_3");
    const std::vector<double>& focus = prime->prescription().states.focus_m;
    const double nearest_m = *std::min_element(focus.begin(), focus.end());
    const RingSteps inner = RingSteps::For(*prime, LitFrom(false));
    EXPECT_EQ(*inner.Rounded(Reading(nearest_m, 100.0))[LensAxis::kFocus], nearest_m);
    EXPECT_LT(*inner.Rounded(Reading(0.5 * nearest_m, 100.0))[LensAxis::kFocus], nearest_m);
}

// By the thin lens: the image of distance s lies f^2/(s - f) behind the focus.
TEST(RingSteps, MoveTheImageByNoMoreThanTheirHalf) {
    const auto lens = Named("zeiss-master-prime-100mm-t1_3");
    const RingSteps steps = RingSteps::For(*lens, LitFrom(false));
    const double f_mm = lens->first_order().efl_mm;
    const auto image_mm = [&](double focus_m) { return f_mm * f_mm / (1e3 * focus_m - f_mm); };
    double worst_mm = 0.0;
    for (double focus_m = 1.5; focus_m < 100.0; focus_m *= 1.0007) {
        const double rounded_m = *steps.Rounded(Reading(focus_m, 100.0))[LensAxis::kFocus];
        worst_mm = std::max(worst_mm, std::abs(image_mm(rounded_m) - image_mm(focus_m)));
    }
    EXPECT_GT(worst_mm, 0.4 * kImageStep_mm);
    EXPECT_LT(worst_mm, 0.6 * kImageStep_mm);  // (f/(s - f))^2 is a little above (f/s)^2
}

// How far half a step moves what a ghost makes of the ray through the centre of the pupil, over all
// ghosts: in pixels of a 1920-pixel frame 36 mm wide, and as a share of the ghost's own width,
// which is taken from a ray 5 mm beside. What moves by many pixels is a ghost that is far wider
// still.
struct Shift {
    double mean_px = 0.0, largest_share = 0.0;
};

Vec2d EndOf(const Lens& lens, const BounceSequence& sequence, double beside_mm, RayFate& fate) {
    constexpr double kField_rad = 0.12;
    const Vec3d direction(-std::sin(kField_rad), 0.0, std::cos(kField_rad));
    const Vec3d pupil(beside_mm, 0.0, lens.pupil_z_mm());
    TraceOptions options;
    options.clip = false;
    const TraceResult result = TraceRay(WriteOut(lens, sequence, kLineD),
                                        {pupil - direction * 500.0, direction}, options, nullptr);
    if (result.fate != RayFate::kArrived) fate = result.fate;
    return result.sensor_mm;
}

Shift ShiftBetween(const Lens& a, const Lens& b) {
    Shift shift;
    int count = 0;
    for (const BounceSequence& sequence : TwoReflectionSequences(a, false)) {
        RayFate fate = RayFate::kArrived;
        const Vec2d in_a = EndOf(a, sequence, 0.0, fate), in_b = EndOf(b, sequence, 0.0, fate);
        const double width_mm = 2.0 * (EndOf(a, sequence, 5.0, fate) - in_a).length();
        if (fate != RayFate::kArrived || in_a.length() > 21.6) continue;  // outside the frame
        const double shift_mm = (in_a - in_b).length();
        shift.mean_px += shift_mm / kPixel_mm;
        if (shift_mm > 0.5 * kPixel_mm) {
            shift.largest_share = std::max(shift.largest_share, shift_mm / width_mm);
        }
        ++count;
    }
    EXPECT_GT(count, 20);
    shift.mean_px /= count;
    return shift;
}

TEST(RingSteps, MoveGhostsByLittle) {
    for (const char* name : {"zeiss-master-prime-100mm-t1_3", "canon-rf-85mm-f1_2"}) {
        const auto lens = Named(name);
        const double half_per_m = 0.5 * RingSteps::For(*lens, LitFrom(false)).focus_per_m();
        Shift worst;
        for (const double focus_m : {1.0, 1.5, 3.0, 10.0}) {
            const Shift shift =
                ShiftBetween(*SetState(lens, {focus_m, {}})->lens,
                             *SetState(lens, {1.0 / (1.0 / focus_m - half_per_m), {}})->lens);
            worst.mean_px = std::max(worst.mean_px, shift.mean_px);
            worst.largest_share = std::max(worst.largest_share, shift.largest_share);
        }
        std::printf("%s: mean %.3f px, largest %.4f of its width\n", name, worst.mean_px,
                    worst.largest_share);
        EXPECT_LT(worst.mean_px, 0.3) << name;
        EXPECT_LT(worst.largest_share, 0.025) << name;
    }
    const auto zoom = Named("canon-zoom-70-200mm-f2_8");
    const Shift shift = ShiftBetween(*SetState(zoom, {{}, 100.0})->lens,
                                     *SetState(zoom, {{}, 100.0 * (1.0 + 0.5 * kZoomStep)})->lens);
    std::printf("zoom: mean %.3f px, largest %.4f of its width\n", shift.mean_px,
                shift.largest_share);
    EXPECT_LT(shift.mean_px, 0.3);
    EXPECT_LT(shift.largest_share, 0.02);
}

}  // namespace
}  // namespace flare
