// SPDX-License-Identifier: Apache-2.0
//
// Field data of real lenses against other ways to the same figures: a second tracer, counted rays,
// the balance of energy between scene and sensor, and a scene of many rays.
#include "core/tracing/field_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/optics/paraxial.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/scalar_tracer.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::BuildLens;
using testing::Real;

Iris OpenIris(const Lens& lens) {
    const double rim =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    return {{}, rim, rim};
}

// Where the ray through the middle of the stop lands, by bisection with the tests' own tracer.
double ScalarChiefImage(const Prescription& lens, double sensor_z, double field_rad) {
    const auto surfaces = testing::ScalarSurfaces(lens, 587.5618L);
    const Real field = field_rad;
    const auto trace = [&](Real offset) {
        const testing::Real3 at{std::cos(field) * offset, 0, 20 - std::sin(field) * offset};
        return ScalarTrace(surfaces, sensor_z, {}, at, {std::sin(field), 0, std::cos(field)},
                           false);
    };
    Real lo = -6, hi = 6;
    EXPECT_LT(trace(lo).stops.at(0).x * trace(hi).stops.at(0).x, 0);
    for (int i = 0; i < 80; ++i) {
        const Real mid = (lo + hi) / 2;
        (trace(mid).stops.at(0).x > 0 ? hi : lo) = mid;
    }
    return static_cast<double>(trace((lo + hi) / 2).x_mm);
}

TEST(FieldOfTheSeedLens, LandsWhereASecondTracerLands) {
    Prescription prescription = testing::SeedLens();
    prescription.design_image_circle_mm = 43.3;
    const auto lens = BuildLens(prescription);
    const FieldData data = FieldDataOf(*lens, {.rows = 6});
    EXPECT_NEAR(*data.tables[0].rows.back().image_height_mm, 21.65, 1e-6);
    for (const FieldRow& row : data.tables[0].rows) {
        EXPECT_NEAR(*row.image_height_mm,
                    ScalarChiefImage(prescription, lens->sensor_z_mm(), row.field_rad), 1e-9);
        // 50.3582 mm: the focal length by an independent program.
        EXPECT_NEAR(*row.ideal_height_mm, 50.3582 * std::tan(row.field_rad), 2e-5);
    }
}

// Figures of an independent program for 5 degrees: f tan 4.40577 mm, the centroid of all rays
// 4.40492 mm (coma takes it a little off the chief ray), 258 mm^2 of light through bare glass.
TEST(FieldOfTheSeedLens, HasTheKnownFiguresAtFiveDegrees) {
    Prescription prescription = testing::SeedLens();
    const double sensor_z = BuildLens(prescription)->sensor_z_mm();
    prescription.design_image_circle_mm =
        2.0 * ScalarChiefImage(prescription, sensor_z, RadiansFromDegrees(5.0));
    const auto lens = BuildLens(prescription)->WithBareGlass();
    const FieldRow row = FieldDataOf(*lens, {.rows = 2}).tables[0].rows.back();
    EXPECT_NEAR(DegreesFromRadians(row.field_rad), 5.0, 1e-6);
    EXPECT_NEAR(*row.ideal_height_mm, 4.40577, 1e-5);
    EXPECT_NEAR(*row.image_height_mm, 4.40492, 2e-3);
    EXPECT_NEAR(row.flux_mm2, 258.0, 2.58);
}

// In a narrow beam along the axis all rays are axial.
TEST(FieldOfTheSeedLens, HasTheAxialTransmittanceOnTheAxis) {
    Prescription prescription = testing::SeedLens();
    prescription.design_image_circle_mm = 20.0;
    const auto coated = BuildLens(prescription);
    const auto bare = coated->WithBareGlass();
    const FieldOptions options{.rows = 2, .f_number = 22.0};
    EXPECT_NEAR(*FieldDataOf(*bare, options).tables[0].rows[0].transmittance, 0.589977, 1e-4);
    const FieldData data = FieldDataOf(*coated, options);
    for (std::size_t i = 0; i < data.wavelengths_nm.size(); ++i) {
        EXPECT_NEAR(data.tables[0].rows[0].transmittances[i],
                    AxialTransmittance(*coated, data.wavelengths_nm[i]), 5e-4)
            << data.wavelengths_nm[i];
    }
}

class FieldOfLibraryLens : public ::testing::TestWithParam<const char*> {};

// The mean over the rays of a grid that arrive.
double CountedTransmittance(const Lens& lens, const LightBundle& bundle, double wavelength_nm) {
    const InteractionList list = WriteOut(lens, {}, wavelength_nm);
    const TraceOptions options;
    const double half = bundle.half_width();
    testing::ArrivalBox box{bundle.centre_u() - half, bundle.centre_u() + half, 0.0, half, false};
    for (int look = 0; look < 2; ++look) {
        box = testing::LookForArrivals(list, bundle, options, box, 240);
    }
    constexpr int kSide = 80;
    RayRecord record;
    double sum = 0.0;
    int count = 0;
    for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kSide; ++i) {
            const double u = box.u0 + (box.u1 - box.u0) * (i + 0.5) / kSide;
            const double v = box.v1 * (j + 0.5) / kSide;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, &record);
            if (ray.fate != RayFate::kArrived) continue;
            sum += PathWeight(lens, list, record);
            ++count;
        }
    }
    return sum / count;
}

// Every ray of a fine grid, traced and weighed on its own.
TEST_P(FieldOfLibraryLens, CarriesTheFluxOfCountedRays) {
    const auto lens = testing::LibraryLens(GetParam());
    const FieldData data = FieldDataOf(*lens, {.rows = 2, .wavelengths_nm = {420.0}});
    for (const FieldTable& table : data.tables) {
        const double azimuth = lens->rotational() || table.section == Section::kX ? 0.0 : 0.5 * kPi;
        for (const FieldRow& row : table.rows) {
            const LightBundle bundle(*lens, row.field_rad, 0.0, azimuth);
            const testing::CountedFlux counted = testing::CountFlux(
                *lens, bundle, {}, kLineD, OpenIris(*lens), 160, [](Vec2d, double) {});
            EXPECT_NEAR(row.flux_mm2 / counted.flux_mm2, 1.0, 3e-3) << row.field_rad;
            EXPECT_NEAR(row.flux_mm2, row.beam_area_mm2 * *row.transmittance, 1e-9);
            EXPECT_NEAR(row.transmittances.at(0), CountedTransmittance(*lens, bundle, 420.0), 2e-3)
                << row.field_rad;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Library, FieldOfLibraryLens,
                         ::testing::Values(testing::kSeedName, testing::kFisheyeName,
                                           "schneider-anamorphic-31mm-f2"));

// What a scene of radiance 1 sends in, integral of flux 2 pi sin(field) dfield, is what the sensor
// gets, integral of E 2 pi r dr.
TEST(Energy, OfTheSceneIsThatOnTheSensor) {
    for (const char* name : {testing::kSeedName, testing::kRetrofocusName, testing::kFisheyeName}) {
        const auto lens = testing::LibraryLens(name);
        const FieldData data = FieldDataOf(*lens, {.rows = 26, .wavelengths_nm = {}});
        const std::vector<FieldRow>& rows = data.tables[0].rows;
        const auto scene = [](const FieldRow& row) {
            return row.flux_mm2 * std::sin(row.field_rad);
        };
        const auto sensor = [](const FieldRow& row) {
            return *row.irradiance * *row.image_height_mm;
        };
        double entered = 0.0, arrived = 0.0;
        for (std::size_t i = 1; i < rows.size(); ++i) {
            const FieldRow& a = rows[i - 1];
            const FieldRow& b = rows[i];
            entered += kPi * (scene(a) + scene(b)) * (b.field_rad - a.field_rad);
            arrived += kPi * (sensor(a) + sensor(b)) * (*b.image_height_mm - *a.image_height_mm);
        }
        RecordProperty(name, std::to_string(arrived / entered));
        EXPECT_NEAR(arrived / entered, 1.0, 5e-3) << name;
    }
}

// Irradiance by counting what rays of many directions and places, from a scene of radiance 1, put
// into a small square of the sensor about `at_mm`.
double CountedIrradiance(const Lens& lens, double field_rad, double azimuth_rad, Vec2d at_mm,
                         double square_mm) {
    const LightBundle bundle(lens, field_rad, 0.0, azimuth_rad);
    const InteractionList list = WriteOut(lens, {}, kLineD);
    const TraceOptions options;
    const double reach = bundle.half_width();
    testing::ArrivalBox box{bundle.centre_u() - reach, bundle.centre_u() + reach, 0.0, reach,
                            false};
    for (int look = 0; look < 2; ++look) {
        box = testing::LookForArrivals(list, bundle, options, box, 240);
    }
    // Light from a little beside comes in a little beside.
    const double margin = 0.4 * (box.u1 - box.u0);
    box = {box.u0 - margin, box.u1 + margin, 0.0, box.v1 + margin, false};
    const bool in_y = azimuth_rad != 0.0;
    const auto tilt_for = [&](Section section) {
        return 1.3 * square_mm / lens.first_order(section).projection_distance_mm;
    };
    const double tilt_along = tilt_for(in_y ? Section::kY : Section::kX);
    const double tilt_across = tilt_for(in_y ? Section::kX : Section::kY);
    const Vec3d travel = bundle.At(0.0, 0.0).direction;
    const Vec3d along = (bundle.At(1.0, 0.0).origin - bundle.At(0.0, 0.0).origin).normalized();
    const Vec3d across = travel.cross(along);
    // Evenly spread in four dimensions: multiples of the powers of 1 / g, g^5 = g + 1.
    constexpr double kG = 1.1673039782614187;
    const auto spread = [&](int i, int power, double lo, double hi) {
        const double at = 0.5 + i * std::pow(kG, -power);
        return lo + (hi - lo) * (at - std::floor(at));
    };
    RayRecord record;
    constexpr int kRays = 250'000;
    double sum = 0.0;
    for (int i = 0; i < kRays; ++i) {
        const double a = spread(i, 1, -tilt_along, tilt_along);
        const double b = spread(i, 2, -tilt_across, tilt_across);
        const Ray from = bundle.At(spread(i, 3, box.u0, box.u1), spread(i, 4, -box.v1, box.v1));
        const Vec3d direction = (travel + along * a + across * b).normalized();
        const TraceResult ray = TraceRay(list, {from.origin, direction}, options, &record);
        if (ray.fate != RayFate::kArrived) continue;
        const Vec2d off = ray.sensor_mm - at_mm;
        if (std::max(std::abs(off.x), std::abs(off.y)) > 0.5 * square_mm) continue;
        // dOmega = cos^3 da db, and the plane is met under the same cosine.
        sum += PathWeight(lens, list, record) * std::pow(direction.dot(travel), 4);
    }
    const double rays_over =
        2.0 * tilt_along * 2.0 * tilt_across * (box.u1 - box.u0) * 2.0 * box.v1;
    return sum * rays_over / kRays / (square_mm * square_mm);
}

class FieldOfAScene : public ::testing::TestWithParam<const char*> {};

TEST_P(FieldOfAScene, HasTheIrradianceOfCountedRays) {
    const auto lens = testing::LibraryLens(GetParam());
    const double square_mm = 0.04 * lens->first_order(Section::kX).efl_mm;
    const FieldData data = FieldDataOf(*lens, {.rows = 4, .wavelengths_nm = {}});
    for (const FieldTable& table : data.tables) {
        const bool in_y = !lens->rotational() && table.section == Section::kY;
        const FieldRow& row = table.rows[2];
        const double r = *row.image_height_mm;
        const double counted = CountedIrradiance(*lens, row.field_rad, in_y ? 0.5 * kPi : 0.0,
                                                 in_y ? Vec2d(0.0, r) : Vec2d(r, 0.0), square_mm);
        EXPECT_NEAR(*row.irradiance / counted, 1.0, 0.006) << row.field_rad;
        RecordProperty(in_y ? "y" : "x", std::to_string(*row.irradiance / counted));
    }
}

INSTANTIATE_TEST_SUITE_P(Library, FieldOfAScene,
                         ::testing::Values(testing::kRetrofocusName, testing::kFisheyeName,
                                           "schneider-anamorphic-31mm-f2"));

// f theta would give 10.1 to 12.0 mm.
TEST(Fisheye, PutsLightFromBehindWhereTheDesignSays) {
    const auto lens = testing::LibraryLens(testing::kFisheyeName);
    const FieldTable table = FieldDataOf(*lens, {.rows = 23, .wavelengths_nm = {}}).tables[0];
    int behind = 0;
    for (const FieldRow& row : table.rows) {
        const double field_deg = DegreesFromRadians(row.field_rad);
        if (field_deg < 92.0 || field_deg > 109.0) continue;
        ++behind;
        EXPECT_GT(*row.image_height_mm, 9.79);
        EXPECT_LT(*row.image_height_mm, 11.52);
        EXPECT_FALSE(row.distortion.has_value());
        const double f_theta = 6.3 * row.field_rad;
        EXPECT_NEAR(*row.f_theta_distortion, *row.image_height_mm / f_theta - 1.0, 2e-3);
        EXPECT_GT(*row.relative_illumination, 0.0);
    }
    EXPECT_GE(behind, 3);
}

}  // namespace
}  // namespace flare
