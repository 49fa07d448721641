// SPDX-License-Identifier: Apache-2.0
//
// For each light: mesh every ghost (or get it from the provider), find the cells that reach the
// picture, give their vertices light and colour, and draw. Ghosts go in batches to bound memory.
#include "core/render/renderer.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/optics/paraxial.h"
#include "core/render/ghost_flux.h"
#include "core/render/lights.h"
#include "core/render/picture.h"
#include "core/render/quality.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr int kGhostsPerBatch = 12;
constexpr std::size_t kMostReportedLights = 64;

PixelWindow DataWindow(const ImageSpec& image) {
    if (image.crop) {
        const auto& [x, y, w, h] = *image.crop;
        return {x, y, w, h};
    }
    const auto& [left, top, right, bottom] = image.overscan;
    return {-left, -top, image.width + left + right, image.height + top + bottom};
}

// "587.5618" -> "S0.587,5618nm": the spectral OpenEXR layout (Fichet, Pacanowski, Wilkie 2021).
std::string SpectralName(double wavelength_nm) {
    std::array<char, 40> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), wavelength_nm).ptr;
    std::string digits(text.data(), end);
    std::replace(digits.begin(), digits.end(), '.', ',');
    return "S0." + digits + "nm";
}

class Job {
  public:
    Job(const FlareRequest& request, const RenderContext& context)
        : request_(request),
          context_(context),
          lens_(*request.lens),
          settings_(SettingsOf(request.quality)),
          spectral_(request.color == ColorMode::kSpectral),
          stop_(StopForFNumber(lens_, request.f_number.value_or(lens_.first_order().f_number))),
          iris_(request.iris, stop_.semi_diameter_mm,
                lens_.surfaces()[static_cast<std::size_t>(lens_.stop_index())].semi_diameter_mm),
          sequences_(TwoReflectionSequences(lens_)),
          tables_(lens_,
                  spectral_
                      ? request.wavelengths_nm
                      : EvenInWavelength(kSpectrumFirst_nm, SampleWavelength(kSpectrumSamples - 1),
                                         settings_.colour_bands),
                  context.threads),
          flux_wavelength_nm_(spectral_ ? request.wavelengths_nm.front() : kLineD),
          flux_tables_(lens_, {flux_wavelength_nm_}, context.threads),
          picture_(DataWindow(request.image),
                   spectral_ ? static_cast<int>(request.wavelengths_nm.size()) : 0) {}

    Result<Rendering> Run() {
        SetFacts();
        // Lights are placed first: a bad one is an error before any work is done.
        std::vector<PlacedLight> lights;
        for (std::size_t i = 0; i < request_.lights.size(); ++i) {
            Result<PlacedLight> light = PlaceLight(request_, i);
            if (!light) return light.error();
            lights.push_back(*light);
        }
        for (const PlacedLight& light : lights) {
            reported_ = report_.facts.lights.size() < kMostReportedLights;
            if (reported_) AddLightFacts(light);
            if (std::optional<Error> error = DrawLight(light)) return *error;
        }
        return Rendering{Resolve(), std::move(report_)};
    }

  private:
    void SetFacts() {
        Facts& facts = report_.facts;
        facts.f_number = stop_.f_number;
        facts.working_f_number = WorkingBeam(lens_, stop_.semi_diameter_mm).working_f_number;
        facts.t_axis = AxialTransmittance(lens_, kLineD);
        facts.scene_linear_factor =
            4.0 * facts.working_f_number * facts.working_f_number / (kPi * facts.t_axis);
        if (stop_.clamped) {
            facts.clamped.push_back("/f_number: " + std::to_string(*request_.f_number) + " -> " +
                                    std::to_string(stop_.f_number));
        }
        for (const BounceSequence& sequence : sequences_) {
            facts.ghosts.push_back({sequence, "geometric", 0.0});
        }
    }

    void AddLightFacts(const PlacedLight& light) {
        LightFacts facts;
        facts.direction = light.direction;
        facts.field_deg = DegreesFromRadians(light.field_rad);
        const LightBundle bundle(lens_, light.field_rad, light.inverse_distance);
        if (const std::optional<ChiefRay> chief = FindChiefRay(lens_, bundle, kLineD)) {
            facts.chief_ray_arrives = true;
            const double x = chief->sensor_mm.x;
            facts.sensor_mm = {-x * std::cos(light.azimuth_rad), -x * std::sin(light.azimuth_rad)};
            facts.pixel = MapOf(request_.image, light.azimuth_rad).Pixel(x, 0.0);
        }
        report_.facts.lights.push_back(facts);
    }

    // Few wavelengths are traced exactly; for more, positions come from a few traced nodes.
    std::vector<double> TracedNodes() const {
        if (!spectral_)
            return ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, settings_.traced_wavelengths);
        const std::vector<double>& list = request_.wavelengths_nm;
        if (list.size() <= 3) return list;
        const auto [lo, hi] = std::minmax_element(list.begin(), list.end());
        return ChebyshevNodes(*lo, *hi, 4);
    }

    LightColour ColourOf(const PlacedLight& light) const {
        LightColour colour;
        colour.spectral = spectral_;
        colour.irradiance = light.irradiance.x;
        if (!spectral_) colour.power = LightSpectrum(light.irradiance);
        colour.dispersion_step_px = settings_.dispersion_step_px;
        colour.most_drawn = settings_.most_drawn;
        colour.light_tolerance = settings_.light_tolerance;
        return colour;
    }

    std::optional<Error> DrawLight(const PlacedLight& light) {
        const Vec3d& e = light.irradiance;
        if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return std::nullopt;
        const int count = static_cast<int>(sequences_.size());
        for (int first = 0; first < count; first += kGhostsPerBatch) {
            const int batch = std::min(kGhostsPerBatch, count - first);
            std::vector<GhostLight> ghosts(static_cast<std::size_t>(batch));
            std::vector<Work> work(static_cast<std::size_t>(batch));
            const double t0 = context_.now_ms();
            context_.threads.For(batch, [&](int i) {
                const auto n = static_cast<std::size_t>(i);
                ghosts[n] = Prepare(light, static_cast<std::size_t>(first + i), work[n]);
            });
            for (const Work& w : work) AddWork(w);
            const double t1 = context_.now_ms();
            if (!context_.cancel.cancelled()) {
                const Picture::Drawn drawn =
                    picture_.Draw(ghosts, iris_, MapOf(request_.image, light.azimuth_rad),
                                  settings_.walk, context_.threads, context_.cancel);
                report_.work.polygons += drawn.pieces;
                report_.work.fragments += drawn.fragments;
            }
            report_.work.mesh_ms += t1 - t0;
            report_.work.raster_ms += context_.now_ms() - t1;
            if (context_.cancel.cancelled())
                return Error{"cancelled", "the work was cancelled", ""};
        }
        return std::nullopt;
    }

    // One ghost of one light, ready to draw. Writes only its own slots.
    GhostLight Prepare(const PlacedLight& light, std::size_t index, Work& work) {
        if (context_.cancel.cancelled()) return {};
        MeshSpec spec;
        spec.sequence = sequences_[index];
        spec.field_rad = light.field_rad;
        spec.inverse_distance = light.inverse_distance;
        spec.wavelengths_nm = TracedNodes();
        spec.cells = settings_.mesh_cells;
        spec.patch_cells = settings_.patch_cells;
        spec.position_tolerance_mm = settings_.position_tolerance_mm;
        spec.mask_tolerance = settings_.mask_tolerance;
        const Result<MeshProvider::Found> found = context_.meshes.Get(
            MeshKey(lens_, spec), [&] { return BuildMesh(lens_, spec); }, context_.cancel);
        if (!found) return {};
        ++(found->hit ? work.mesh_hits : work.mesh_misses);
        if (!found->hit) {
            work.rays_traced += found->mesh->rays_traced;
            work.ray_surfaces += found->mesh->ray_surfaces;
        }
        const auto surface = std::make_shared<const GhostSurface>(found->mesh);
        if (surface->cells().empty()) return {};

        const LightBundle bundle(lens_, light.field_rad, light.inverse_distance);
        const PictureMap map = MapOf(request_.image, light.azimuth_rad);
        GhostFacts& facts = report_.facts.ghosts[index];
        if (reported_) {
            facts.flux_mm2 +=
                FluxOf(surface, bundle, lens_, flux_tables_, iris_, settings_.walk).flux_mm2;
        }
        const std::vector<double> bounded =
            spectral_ ? SpectralBounds()
                      : std::vector<double>{kDrawnLow_nm, 0.5 * (kDrawnLow_nm + kDrawnHigh_nm),
                                            kDrawnHigh_nm};
        std::vector<GhostLight::Cell> cells =
            CellsInWindow(*surface, bounded, iris_, map, WalkWindowOf(picture_.window()));
        work.cells += cells.size();
        LightColour colour = ColourOf(light);
        if (!spectral_ && !cells.empty()) {
            const PixelWindow frame{0, 0, request_.image.width, request_.image.height};
            const bool whole = picture_.window() == frame;
            colour.dispersion_px = DispersionPx(
                *found->mesh,
                whole ? cells : CellsInWindow(*surface, bounded, iris_, map, WalkWindowOf(frame)),
                map);
        }
        return PrepareGhost(surface, bundle, lens_, tables_, colour, std::move(cells));
    }

    std::vector<double> SpectralBounds() const {
        const std::vector<double>& list = request_.wavelengths_nm;
        if (list.size() == 1) return list;
        const auto [lo, hi] = std::minmax_element(list.begin(), list.end());
        return {*lo, 0.5 * (*lo + *hi), *hi};
    }

    void AddWork(const Work& w) {
        report_.work.rays_traced += w.rays_traced;
        report_.work.ray_surfaces += w.ray_surfaces;
        report_.work.cells += w.cells;
        report_.work.mesh_hits += w.mesh_hits;
        report_.work.mesh_misses += w.mesh_misses;
    }

    // Light a pixel to irradiance, and to scene radiance if asked; each layer twice: in the root
    // and under its own name.
    FlareImage Resolve() {
        const double t0 = context_.now_ms();
        FlareImage image;
        image.full = {0, 0, request_.image.width, request_.image.height};
        image.data = picture_.window();
        image.pixel_aspect = request_.image.pixel_aspect;
        image.rec709 = !spectral_;
        const Vec2d pitch = PixelPitch(request_.image);
        double scale = 1.0 / (pitch.x * pitch.y);
        if (request_.units == Units::kSceneLinear) scale *= report_.facts.scene_linear_factor;

        const int planes = picture_.channel_count();
        image.planes.resize(static_cast<std::size_t>(planes) * 2);
        context_.threads.For(planes, [&](int p) {
            static const char* const kRgb[] = {"R", "G", "B"};
            const auto n = static_cast<std::size_t>(p);
            const std::string name = spectral_ ? SpectralName(request_.wavelengths_nm[n]) : kRgb[p];
            ImagePlane& root = image.planes[n];
            root.name = name;
            root.values = picture_.Channel(p, scale);
            image.planes[n + static_cast<std::size_t>(planes)] = {"ghosts." + name, root.values};
        });
        report_.work.resolve_ms = context_.now_ms() - t0;
        return image;
    }

    const FlareRequest& request_;
    const RenderContext& context_;
    const Lens& lens_;
    QualitySettings settings_;
    bool spectral_;
    StopSetting stop_;
    Iris iris_;
    std::vector<BounceSequence> sequences_;
    TransmissionTables tables_;
    double flux_wavelength_nm_;
    TransmissionTables flux_tables_;
    Picture picture_;
    Report report_;
    bool reported_ = true;  // the light at hand stands in the report
};

}  // namespace

Result<Rendering> Render(const FlareRequest& request, const RenderContext& context) {
    if (const std::optional<Error> error = CheckRequest(request)) return *error;
    return Job(request, context).Run();
}

}  // namespace flare
