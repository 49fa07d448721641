// SPDX-License-Identifier: Apache-2.0
//
// Pictures in every RGB space: white stays white, spaces agree with each other, and all of them
// with the integral of a spectral picture over the CIE table, done here.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/optics/lens_coatings.h"
#include "core/spectrum/cie_table.h"
#include "core/spectrum/light_spectrum.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"

namespace flare {
namespace {

using testing::PlaneNamed;

constexpr std::array kSpaces{ColorMode::kLinRec709, ColorMode::kAcesCg, ColorMode::kAces2065};

FlareRequest SmallRequest(std::shared_ptr<const Lens> lens, QualityPreset quality) {
    FlareRequest request = testing::SpectralRequest(std::move(lens), 4.0, 24, 16);
    request.color = ColorMode::kLinRec709;
    request.wavelengths_nm.clear();
    request.quality = quality;
    request.lights = {testing::LightAt(6.0, 20.0)};
    return request;
}

Vec3d Pixel(const FlareImage& image, std::size_t i) {
    return {static_cast<double>(PlaneNamed(image, "R").values[i]),
            static_cast<double>(PlaneNamed(image, "G").values[i]),
            static_cast<double>(PlaneNamed(image, "B").values[i])};
}

double Largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

std::shared_ptr<const ColorResponse> SomeCamera() {
    return std::make_shared<const ColorResponse>(
        *ResponseOf(CameraSensitivity{{400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0},
                                      {0.0, 0.1, 0.1, 0.3, 1.0, 0.6, 0.0},
                                      {0.0, 0.2, 0.8, 1.0, 0.4, 0.1, 0.0},
                                      {0.2, 1.0, 0.7, 0.1, 0.0, 0.0, 0.0}}));
}

// Glass without dispersion or coating is colourless: what it makes of a light has its colour.
TEST(ColourlessLens, GivesWhiteLightEqualChannelsInEverySpace) {
    Prescription prescription = testing::LibraryPrescription(testing::kHeliarName);
    for (SurfacePrescription& surface : prescription.surfaces) {
        surface.vd.reset();
        if (!surface.glass) continue;
        surface.glass.reset();
        surface.nd = 1.6;
    }
    const auto lens = *testing::BuildLens(prescription)->WithCoatings({"bare", {}, {}});
    testing::Studio studio;
    FlareRequest request = SmallRequest(lens, QualityPreset::kPreview);
    const auto check = [&](const char* what) {
        const FlareImage image = studio.Shoot(request).image;
        double worst = 0.0, brightest = 0.0;
        for (std::size_t i = 0; i < image.data.pixels(); ++i) {
            brightest = std::max(brightest, Largest(Pixel(image, i)));
        }
        for (std::size_t i = 0; i < image.data.pixels(); ++i) {
            const Vec3d rgb = Pixel(image, i);
            if (Largest(rgb) < 1e-6 * brightest) continue;
            worst = std::max(worst, Largest(rgb - Vec3d(rgb.y, rgb.y, rgb.y)) / Largest(rgb));
        }
        EXPECT_GT(brightest, 0.0);
        EXPECT_LT(worst, 1e-4) << what;
    };
    for (const ColorMode space : kSpaces) {
        request.color = space;
        check("space");
    }
    request.camera = SomeCamera();
    check("camera");
}

TEST(ColourSpaces, OfOnePictureDifferByTheirMatrixAlone) {
    testing::Studio studio;
    FlareRequest request =
        SmallRequest(testing::LibraryLens(testing::kHeliarName), QualityPreset::kDraft);
    request.layers.starburst = true;
    request.lights[0].irradiance = Vec3d(0.6, 0.3, 0.9);
    const FlareImage plain = studio.Shoot(request).image;
    for (const ColorMode mode : {ColorMode::kAcesCg, ColorMode::kAces2065}) {
        FlareRequest wide = request;
        wide.color = mode;
        wide.lights[0].irradiance = SpaceFromRec709(SpaceOf(mode), request.lights[0].irradiance);
        const FlareImage image = studio.Shoot(wide).image;
        ASSERT_TRUE(image.chromaticities);
        EXPECT_EQ(*image.chromaticities, ChromaticitiesOf(SpaceOf(mode)));
        EXPECT_FALSE(image.rec709);
        double off = 0.0, all = 0.0;
        for (std::size_t i = 0; i < image.data.pixels(); ++i) {
            const Vec3d want = SpaceFromRec709(SpaceOf(mode), Pixel(plain, i));
            off += (Pixel(image, i) - want).length();
            all += want.length();
        }
        EXPECT_LT(off, 1e-5 * all);
    }
}

// A picture at each wavelength of the CIE table.
FlareImage SpectralPicture(FlareRequest request, testing::Studio& studio) {
    request.color = ColorMode::kSpectral;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        request.wavelengths_nm.push_back(SampleWavelength(i));
    }
    return studio.Shoot(request).image;
}

// Its pixels for light of this power, added up with the CIE observer outside the renderer: linear
// Rec.709.
std::vector<Vec3d> IntegralOf(const FlareImage& image, const Spectrum& power) {
    // IEC 61966-2-1, rounded to four decimals there.
    const Vec3d to_r(3.2406, -1.5372, -0.4986), to_g(-0.9689, 1.8758, 0.0415),
        to_b(0.0557, -0.2040, 1.0570);
    std::vector<Vec3d> pixels;
    for (std::size_t i = 0; i < image.data.pixels(); ++i) {
        Vec3d xyz(0.0);
        for (std::size_t k = 0; k < kSpectrumSamples; ++k) {
            const CieRow& row = CieTable()[k];
            xyz += Vec3d(row.x_bar, row.y_bar, row.z_bar) *
                   (power[k] * static_cast<double>(image.planes[k].values[i]));
        }
        pixels.emplace_back(to_r.dot(xyz), to_g.dot(xyz), to_b.dot(xyz));
    }
    return pixels;
}

Vec2d Chromaticity(const Vec3d& rgb) {
    const Vec3d xyz(0.4124 * rgb.x + 0.3576 * rgb.y + 0.1805 * rgb.z,
                    0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z,
                    0.0193 * rgb.x + 0.1192 * rgb.y + 0.9505 * rgb.z);
    return Vec2d(xyz.x, xyz.y) / (xyz.x + xyz.y + xyz.z);
}

struct ColourCase {
    QualityPreset quality;
    double total, pixels;  // errors allowed, of the whole light and per pixel (rel_l1)
};

TEST(CoatedSeedLens, HasThePurpleGhostsOfTheSpectralIntegral) {
    testing::Studio studio;
    const FlareImage spectral = SpectralPicture(
        SmallRequest(testing::LibraryLens(testing::kSeedName), QualityPreset::kFinal), studio);
    for (const double kelvin : {0.0, 3200.0}) {
        for (const ColourCase& limit : {ColourCase{QualityPreset::kPreview, 6e-3, 2e-2},
                                        ColourCase{QualityPreset::kFinal, 2e-3, 1e-2}}) {
            FlareRequest request =
                SmallRequest(testing::LibraryLens(testing::kSeedName), limit.quality);
            if (kelvin > 0.0) request.lights[0].temperature_k = kelvin;
            const Spectrum power = kelvin > 0.0 ? BlackbodySpectrum(kelvin) : WhiteSpectrum();
            const FlareImage image = studio.Shoot(request).image;
            const std::vector<Vec3d> integral = IntegralOf(spectral, power);
            Vec3d got(0.0), want(0.0);
            double off = 0.0, all = 0.0;
            for (std::size_t i = 0; i < integral.size(); ++i) {
                const Vec3d a = Pixel(image, i), b = integral[i];
                got += a;
                want += b;
                off += std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z);
                all += std::abs(b.x) + std::abs(b.y) + std::abs(b.z);
            }
            const Vec2d xy = Chromaticity(got), truth = Chromaticity(want);
            std::printf(
                "%s, %4.0f K: rgb %.5f %.5f %.5f, integral %.5f %.5f %.5f; xy (%.4f, %.4f) "
                "against (%.4f, %.4f); rel_l1 %.4f\n",
                limit.quality == QualityPreset::kPreview ? "preview" : "final  ", kelvin, got.x,
                got.y, got.z, want.x, want.y, want.z, xy.x, xy.y, truth.x, truth.y, off / all);
            EXPECT_LT(Largest(got - want), limit.total * Largest(want));
            EXPECT_LT((xy - truth).length(), 2e-3);
            EXPECT_LT(off, limit.pixels * all);
            if (kelvin == 0.0) {
                EXPECT_GT(got.x, 1.2 * got.y);  // purple
                EXPECT_GT(got.z, 1.2 * got.y);
            }
        }
    }
}

// What a saturated ACEScg light becomes: a real spectrum, not a mix with negative parts, and its
// flare has no more light than it has.
TEST(SaturatedLights, AreRenderedInTheirOwnColour) {
    testing::Studio studio;
    const auto bare = *testing::LibraryLens(testing::kHeliarName)->WithCoatings({"bare", {}, {}});
    FlareRequest request = SmallRequest(bare, QualityPreset::kDraft);
    request.color = ColorMode::kAcesCg;
    for (const Vec3d& light : {Vec3d(1.0, 0.05, 0.05), Vec3d(0.1, 1.0, 0.1)}) {
        request.lights[0].irradiance = light;
        const FlareImage image = studio.Shoot(request).image;
        Vec3d sum(0.0);
        for (std::size_t i = 0; i < image.data.pixels(); ++i) sum += Pixel(image, i);
        // Bare glass reflects blue a little more than red; the colour is the light's within that.
        EXPECT_LT(Largest(sum / Largest(sum) - light), 0.05);
    }
}

}  // namespace
}  // namespace flare
