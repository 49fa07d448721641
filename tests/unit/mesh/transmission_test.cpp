// SPDX-License-Identifier: Apache-2.0
//
// The tables of R and T against the characteristic matrix they stand for: every built-in stack, on
// glasses from 1.45 to 2.0, over the visible, from both sides, to 89 degrees and beyond the
// critical angle. All of it goes through Path::Weight, as the renderer does.
#include "core/mesh/transmission.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/optics/coating_design.h"
#include "core/spectrum/wavelength_plan.h"

namespace flare {
namespace {

constexpr int kCoated = 1;

// Air, glass plate, air, glass plate, air. The coated face is number 0 or 1 of the first plate, so
// that one-bounce lists reach it from the air and from the glass.
std::shared_ptr<const Lens> Plates(double nd, const std::string& coating,
                                   const CoatingDefinitions& own) {
    Prescription lens;
    lens.name = "plates";
    lens.coatings = own;
    const auto add = [&](SurfaceKind kind, double radius, std::optional<double> index) {
        SurfacePrescription& surface = lens.surfaces.emplace_back();
        surface.kind = kind;
        surface.radius_mm = radius;
        surface.gap_mm = 2.0;
        surface.gap_given = true;
        surface.nd = index;
        surface.semi_diameter_mm = 5.0;
        if (kind != SurfaceKind::kStop) surface.coating = "bare";
    };
    add(SurfaceKind::kSphere, 100.0, nd);
    add(SurfaceKind::kSphere, -100.0, {});
    add(SurfaceKind::kStop, 0.0, {});
    add(SurfaceKind::kPlane, 0.0, nd);
    add(SurfaceKind::kPlane, 0.0, {});
    lens.surfaces[kCoated].coating = coating;
    const auto built = Lens::Build(lens);
    FLARE_CHECK(built.ok());
    return *built;
}

struct Worst {
    double transmittance = 0.0, from_air = 0.0, from_glass = 0.0;
    double largest_absorption = 0.0;
};

// Weights along the three paths that meet the coated face: through it; from the air, on the way
// back from face 3; from the glass, on the way to the front. What else stands on a path is bare
// and at normal incidence, and divided out.
class FaceProbe {
  public:
    FaceProbe(std::shared_ptr<const Lens> lens, const std::vector<double>& wavelengths_nm,
              ThreadPool& threads)
        : lens_(std::move(lens)), tables_(*lens_, wavelengths_nm, threads) {
        for (const BounceSequence& sequence : {BounceSequence{}, {3, 1}, {1, 0}}) {
            paths_.push_back(tables_.PathOf(*lens_, sequence));
            lists_.push_back(WriteOut(*lens_, sequence, wavelengths_nm.front()));
        }
    }

    double Transmittance(int band, double rare_cos2) const {
        return Weight(0, InteractionKind::kRefract, band, rare_cos2) / Bare(0, band);
    }
    double FromAir(int band, double rare_cos2) const {
        return Weight(1, InteractionKind::kReflect, band, rare_cos2) / Bare(1, band) /
               Transmittance(band, 1.0);
    }
    double FromGlass(int band, double rare_cos2) const {
        return Weight(2, InteractionKind::kReflect, band, rare_cos2) / Bare(2, band) /
               Transmittance(band, 1.0);
    }

  private:
    double Weight(std::size_t path, InteractionKind kind, int band, double rare_cos2) const {
        std::vector<double> cos2;
        for (const Interaction& step : lists_[path].steps) {
            const bool probed = step.surface == kCoated && step.kind == kind;
            cos2.push_back(probed ? rare_cos2 : 1.0);
        }
        return paths_[path].Weight(band, cos2);
    }

    // The bare faces by Fresnel at normal incidence.
    double Bare(std::size_t path, int band) const {
        const double n =
            lens_->surfaces()[0].behind.Index(tables_.wavelengths_nm()[static_cast<size_t>(band)]);
        const double r = std::pow((n - 1.0) / (n + 1.0), 2);
        double product = 1.0;
        for (const Interaction& step : lists_[path].steps) {
            if (step.kind == InteractionKind::kStop || step.surface == kCoated) continue;
            product *= step.kind == InteractionKind::kReflect ? r : 1.0 - r;
        }
        return product;
    }

    std::shared_ptr<const Lens> lens_;
    TransmissionTables tables_;
    std::vector<TransmissionTables::Path> paths_;
    std::vector<InteractionList> lists_;
};

void Compare(double nd, const std::string& name, const CoatingDefinitions& own,
             const std::vector<double>& bands, ThreadPool& threads, Worst& worst) {
    const FaceProbe probe(Plates(nd, name, own), bands, threads);
    const Glass air = Glass::Air(), glass = Glass::FromNdVd(nd, {});
    const Coating coating = CoatingDesignByName(name, own)->For(air, glass);
    const auto note = [](double& worst_so_far, double got, double want) {
        worst_so_far = std::max(worst_so_far, std::abs(got - want));
    };
    for (int band = 0; band < static_cast<int>(bands.size()); ++band) {
        const double wavelength = bands[static_cast<std::size_t>(band)];
        for (double angle = 0.0; angle < 89.25; angle += 0.5) {
            const double c = std::cos(RadiansFromDegrees(angle));
            const Reflection in = ReflectionOf(coating, false, 1.0, nd, c, wavelength);
            note(worst.transmittance, probe.Transmittance(band, c * c), in.transmittance);
            note(worst.from_air, probe.FromAir(band, c * c), in.reflectance);
            worst.largest_absorption =
                std::max(worst.largest_absorption, 1.0 - in.reflectance - in.transmittance);
            // The same angle inside the glass.
            const Reflection out = ReflectionOf(coating, true, nd, 1.0, c, wavelength);
            const double rare_cos2 = 1.0 - nd * nd * (1.0 - c * c);
            note(worst.from_glass, probe.FromGlass(band, rare_cos2), out.reflectance);
            note(worst.transmittance, probe.Transmittance(band, rare_cos2), out.transmittance);
        }
    }
}

TEST(TransmissionTables, HoldForEveryBuiltInStackOnEveryGlass) {
    ThreadPool threads(2);
    const std::vector<double> bands = EvenInWavelength(380.0, 780.0, 21);
    for (const char* name : {"mgf2-550", "mgf2-disp-480", "v-550", "broadband-550", "broadband-480",
                             "multi-550", "multi-620"}) {
        Worst worst;
        for (const double nd : {1.45, 1.52, 1.67, 1.85, 2.0}) {
            Compare(nd, name, {}, bands, threads, worst);
        }
        EXPECT_LT(worst.transmittance, 1e-7) << name;
        EXPECT_LT(worst.from_air, 1e-7) << name;
        EXPECT_LT(worst.from_glass, 1e-7) << name;
        std::printf("%-14s T %.1e  R from air %.1e  R from glass %.1e  absorbs up to %.1e\n", name,
                    worst.transmittance, worst.from_air, worst.from_glass,
                    worst.largest_absorption);
    }
}

// A beam-splitting metal, thick films with fringes, tunnelling: what no maker calls a coating.
TEST(TransmissionTables, HoldForStacksThatAbsorbAndForThickOnes) {
    using Complex = std::complex<double>;
    ThreadPool threads(2);
    const std::vector<double> bands = EvenInWavelength(380.0, 780.0, 5);
    CoatingDefinitions own;
    const auto define = [&](const char* name, std::vector<CoatingLayer> layers) {
        own[name] = *CoatingDesign::Stack(name, std::move(layers));
    };
    define("metal", {{1.38, 100.0}, {Complex(0.1, 3.5), 12.0}, {2.1, 40.0}});
    define("smoke", {{Complex(1.38, 0.05), 99.6}, {*MaterialByName("TiO2"), 60.0}});
    define("thick", {{1.46, 20'000.0}, {2.2, 3'000.0}});
    std::vector<CoatingLayer> mirror;
    for (int pair = 0; pair < 50; ++pair) {
        mirror.push_back({2.3, 59.8});
        mirror.push_back({1.46, 94.2});
    }
    define("mirror", mirror);
    for (const auto& [name, design] : own) {
        Worst worst;
        for (const double nd : {1.45, 1.67, 2.0}) Compare(nd, name, own, bands, threads, worst);
        EXPECT_LT(worst.transmittance, 1e-7) << name;
        EXPECT_LT(worst.from_air, 1e-7) << name;
        EXPECT_LT(worst.from_glass, 1e-7) << name;
        std::printf("%-14s T %.1e  R from air %.1e  R from glass %.1e  absorbs up to %.1e\n",
                    name.c_str(), worst.transmittance, worst.from_air, worst.from_glass,
                    worst.largest_absorption);
    }
}

// Two glasses of nearly one index: behind the d line the other is the denser one. The layers stay
// where they were laid, so light towards +z meets the smoky one first at every wavelength.
TEST(TransmissionTables, KeepTheOrderOfTheLayersWhereTwoGlassesChangePlaces) {
    Prescription prescription = Plates(1.6, "bare", {})->prescription();
    prescription.coatings["smoke"] =
        *CoatingDesign::Stack("smoke", {{std::complex<double>(1.8, 0.2), 60.0}, {1.4, 80.0}});
    prescription.surfaces[0].vd = 60.0;
    prescription.surfaces[1].nd = 1.601;
    prescription.surfaces[1].vd = 30.0;
    prescription.surfaces[1].coating = "smoke";
    prescription.surfaces.insert(prescription.surfaces.begin() + 2, prescription.surfaces[0]);
    prescription.surfaces[2].nd.reset();
    prescription.surfaces[2].vd.reset();
    const auto lens = *Lens::Build(prescription);
    const Coating& coating = lens->surfaces()[1].coating;
    const std::vector<double> bands{450.0, 700.0};
    const auto index = [&](int surface, double nm) {
        return lens->MediumBehind(surface).Index(nm);
    };
    ASSERT_GT(index(1, 450.0), index(0, 450.0));
    ASSERT_LT(index(1, 700.0), index(0, 700.0));

    ThreadPool threads(1);
    const TransmissionTables tables(*lens, bands, threads);
    for (int band = 0; band < 2; ++band) {
        const double nm = bands[static_cast<std::size_t>(band)];
        const auto bare = [](double n) { return std::pow((n - 1.0) / (n + 1.0), 2); };
        const double a = index(0, nm), b = index(1, nm), c = index(4, nm);
        const Reflection forward = ReflectionOf(coating, false, a, b, 1.0, nm);
        const Reflection backward = ReflectionOf(coating, true, b, a, 1.0, nm);
        ASSERT_GT(std::abs(forward.reflectance - backward.reflectance), 0.01);
        const double behind = (1.0 - bare(b)) * std::pow(1.0 - bare(c), 2);
        const auto weight = [&](const BounceSequence& sequence) {
            const std::vector<double> ones(WriteOut(*lens, sequence, nm).steps.size(), 1.0);
            return tables.PathOf(*lens, sequence).Weight(band, ones);
        };
        EXPECT_NEAR(
            weight({1, 0}),
            (1.0 - bare(a)) * forward.reflectance * bare(a) * forward.transmittance * behind, 1e-9);
        EXPECT_NEAR(
            weight({2, 1}),
            (1.0 - bare(a)) * forward.transmittance * bare(b) * backward.reflectance * behind,
            1e-9);
    }
}

}  // namespace
}  // namespace flare
