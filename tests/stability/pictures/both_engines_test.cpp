// SPDX-License-Identifier: Apache-2.0
//
// Scenes at the edge, each drawn by the fast engine (floats, tiles, interpolated meshes: `preview`)
// and by the reference (doubles, polygons): both pictures are finite, and their distance stays
// within what a preview promises or what the scene allows. The measured distances stand in
// docs/stability.md; --gtest_output=json writes them as properties.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "tests/support/extreme_lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/stop_masks.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Singlet;

struct Scene {
    const char* name;
    double limit;  // of rel_l1, preview against reference
    std::function<FlareRequest()> request;
};

FlareRequest Of(const Prescription& prescription, double field_deg = 6.0) {
    FlareRequest request;
    request.lens = testing::BuildLens(prescription);
    request.f_number = 5.6;
    request.image.width = 96;
    request.image.height = 54;
    request.units = Units::kSensorIrradiance;
    request.model.culling = CullingRule::kNone;
    request.lights = {LightAt(field_deg, 25.0)};
    return request;
}

FlareRequest With(const std::function<void(FlareRequest&)>& change) {
    FlareRequest request = Of(Singlet());
    change(request);
    return request;
}

FlareRequest Coated(const CoatingDesign& coating) {
    Prescription lens = Singlet();
    lens.coatings["own"] = coating;
    lens.default_coating = "own";
    return Of(lens);
}

FlareRequest HundredLayers() {
    std::vector<CoatingLayer> stack;
    for (int i = 0; i < 50; ++i) {
        stack.push_back({1.46, 550.0 / 4.0 / 1.46});
        stack.push_back({1.60, 550.0 / 4.0 / 1.60});
    }
    // In colour the reference would take minutes.
    FlareRequest request = Coated(*CoatingDesign::Stack("own", stack));
    request.color = ColorMode::kSpectral;
    request.wavelengths_nm = {kLineD};
    return request;
}

FlareRequest Absorbing() {
    return Coated(
        *CoatingDesign::Stack("own", {{std::complex<double>(2.0, 1.5), 12.0}, {1.46, 90.0}}));
}

template <class Inside>
FlareRequest Masked(int side, Inside inside) {
    FlareRequest request = Of(Singlet());
    request.iris.mask = StopPicture::Sharp(testing::Drawn(side, 10.0, inside));
    return request;
}

FlareRequest OneCellMask() {
    FlareRequest request = Of(Singlet());
    request.iris.mask = StopPicture::Smooth({1, 1.0, {1.0F}});
    return request;
}

FlareRequest Blades(int blades, double roundness) {
    return With([&](FlareRequest& r) { r.iris = {blades, roundness, 17.0}; });
}

FlareRequest Frame(int width, int height, double pixel_aspect = 1.0) {
    return With([&](FlareRequest& r) {
        r.image.width = width;
        r.image.height = height;
        r.image.pixel_aspect = pixel_aspect;
    });
}

FlareRequest Distance(double distance_mm, double field_deg) {
    return With([&](FlareRequest& r) {
        r.lights = {LightAt(field_deg, 25.0)};
        r.lights[0].distance_m = (r.lens->pupil_z_mm() + distance_mm) / 1000.0;
    });
}

FlareRequest Radiance(double e) {
    return With([&](FlareRequest& r) { r.lights[0].irradiance = Vec3d(e, e, e); });
}

FlareRequest FNumber(double f_number) {
    return With([&](FlareRequest& r) { r.f_number = f_number; });
}

FlareRequest StopLast() {
    Prescription lens = Singlet();
    const SurfacePrescription stop = lens.surfaces[0];
    lens.surfaces.erase(lens.surfaces.begin());
    lens.surfaces.back().gap_mm = 3.0;
    lens.surfaces.back().gap_given = true;
    lens.surfaces.push_back(stop);
    lens.surfaces.back().gap_mm = 44.0;
    return Of(lens);
}

FlareRequest AsPlane(double radius_mm) {
    return Of(testing::BehindAPlate(radius_mm, -radius_mm));
}

// Where more than 0.02 is allowed a preview is too coarse for the scene; what a final leaves stands
// in docs/stability.md.
const std::vector<Scene>& Scenes() {
    static const std::vector<Scene> scenes = {
        {"StopFirst", 0.02, [] { return Of(Singlet()); }},
        {"PlanesOfRadius0", 0.02, [] { return AsPlane(0.0); }},
        {"PlanesOfRadius1e30", 0.02, [] { return AsPlane(1e30); }},
        {"RadiusOf1e7", 0.02, [] { return AsPlane(1e7); }},
        {"ConcentricShell", 0.02, [] { return Of(testing::BehindAPlate(40.0, 38.0)); }},
        {"NearlyConcentricShell", 0.02,
         [] { return Of(testing::BehindAPlate(40.0, 38.0 + 1e-6)); }},
        {"SurfacesInContact", 0.02, [] { return Of(testing::BehindAPlate(0.0, -60.0, 0.0)); }},
        {"CementOfOneGlass", 0.02, [] { return Of(testing::CementedSinglet(1.6, 1.6)); }},
        {"IndexStepOf1e7", 0.02, [] { return Of(testing::CementedSinglet(1.6, 1.6 + 1e-7)); }},
        {"GrazingFront", 0.02, [] { return Of(testing::BehindAPlate(14.0, 12.0, 12.0), 35.0); }},
        {"TotalReflection", 0.02, [] { return Of(testing::BehindAPlate(0.0, 13.0, 9.0), 40.0); }},
        {"GhostInFocus", 0.02, [] { return Of(testing::GhostInFocus()); }},
        {"GhostFocusedInTheStop", 0.02, [] { return Of(testing::GhostFocusedInTheStop()); }},
        {"GhostOfTheStopsImage", 0.02, [] { return Of(testing::GhostOfTheStopsImage()); }},
        {"StopLast", 0.02, [] { return StopLast(); }},
        {"LightOnTheAxis", 0.02, [] { return Of(Singlet(), 0.0); }},
        {"Light1e6DegreesOff", 0.02, [] { return Of(Singlet(), 1e-6); }},
        {"LightAt60Degrees", 0.02, [] { return Of(Singlet(), 60.0); }},
        {"LightAt89_9Degrees", 0.02, [] { return Of(Singlet(), 89.9); }},
        {"LightAt90Degrees", 0.02, [] { return Of(Singlet(), 90.0); }},
        {"LightBehind", 0.02, [] { return Of(Singlet(), 140.0); }},
        {"LightAt5mm", 0.02, [] { return Distance(5.0, 10.0); }},
        {"LightAt1mm", 0.08, [] { return Distance(1.0, 3.0); }},
        {"LightAt1e12mm", 0.02, [] { return Distance(1e12, 6.0); }},
        {"FNumber0_7", 0.02, [] { return FNumber(0.7); }},
        {"FNumber22", 0.03, [] { return FNumber(22.0); }},
        {"FNumber128", 0.1, [] { return FNumber(128.0); }},
        {"HundredLayers", 0.2, [] { return HundredLayers(); }},
        {"AbsorbingCoating", 0.02, [] { return Absorbing(); }},
        {"ThreeBlades", 0.02, [] { return Blades(3, 0.0); }},
        {"ThirtyTwoBlades", 0.02, [] { return Blades(32, 0.0); }},
        {"RoundedBlades", 0.02, [] { return Blades(5, 0.7); }},
        {"IrregularBlades", 0.02,
         [] { return With([](FlareRequest& r) {
                  r.iris = {7, 0.0, 17.0, 1.0, 3};
              }); }},
        {"StarMask", 0.02, [] { return Masked(64, testing::InStar); }},
        {"MaskWithAHole", 0.02,
         [] { return Masked(64, [](Vec2d p) { return p.length() > 4.0 && p.length() < 8.0; }); }},
        {"SlitMask", 0.02,
         [] {
             return Masked(64, [](Vec2d p) { return std::abs(p.x) < 0.6 && std::abs(p.y) < 8.0; });
         }},
        {"MaskOfOneCell", 0.02, [] { return OneCellMask(); }},
        {"OnePixel", 0.02, [] { return Frame(1, 1); }},
        {"OneColumn", 0.02, [] { return Frame(1, 512); }},
        {"OneRow", 0.02, [] { return Frame(512, 1); }},
        {"PixelsOfAspect100", 0.02, [] { return Frame(32, 1800, 100.0); }},
        {"Radiance1e30", 0.02, [] { return Radiance(1e30); }},
        {"Radiance1eMinus30", 0.02, [] { return Radiance(1e-30); }},
    };
    return scenes;
}

class BothEngines : public ::testing::TestWithParam<std::size_t> {};

double SoundSum(const FlareImage& image) {
    double sum = 0.0;
    for (const ImagePlane& plane : image.planes) {
        for (const float value : plane.values) {
            if (!std::isfinite(value)) ADD_FAILURE() << "a pixel is not finite";
            sum += value;
        }
    }
    return sum;
}

TEST_P(BothEngines, DrawTheSamePicture) {
    const Scene& scene = Scenes()[GetParam()];
    testing::Studio studio;
    FlareRequest request = scene.request();
    const Rendering fast = studio.Shoot(request);
    request.quality = QualityPreset::kReference;
    const Rendering reference = studio.Shoot(request);
    const double light = SoundSum(reference.image);
    SoundSum(fast.image);
    const double distance = testing::RelL1(fast.image, reference.image);
    RecordProperty("rel_l1", std::to_string(distance));
    RecordProperty("light", std::to_string(light));
    EXPECT_LE(distance, scene.limit);
}

INSTANTIATE_TEST_SUITE_P(Scenes, BothEngines, ::testing::Range(std::size_t{0}, Scenes().size()),
                         [](const auto& tested) { return Scenes()[tested.param].name; });

}  // namespace
}  // namespace flare
