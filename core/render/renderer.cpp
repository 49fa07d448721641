// SPDX-License-Identifier: Apache-2.0
//
// For each light: mesh every ghost (or get it from the provider), find the cells that reach the
// picture, give their vertices light and colour, and draw. Ghosts go in batches to bound memory.
#include "core/render/renderer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/units.h"
#include "core/image/cell_fits.h"
#include "core/mesh/mesh_builder.h"
#include "core/optics/paraxial.h"
#include "core/render/error_estimate.h"
#include "core/render/ghost_choice.h"
#include "core/render/ghost_estimate.h"
#include "core/render/ghost_plan.h"
#include "core/render/light_meshes.h"
#include "core/render/lights.h"
#include "core/render/picture.h"
#include "core/render/quality.h"
#include "core/render/starburst_layer.h"
#include "core/render/tile_picture.h"
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
          stop_(StopForFNumber(lens_, request.f_number.value_or(lens_.f_number()))),
          iris_(request.iris, stop_.semi_diameter_mm,
                lens_.surfaces()[static_cast<std::size_t>(lens_.stop_index())].semi_diameter_mm),
          sequences_(TwoReflectionSequences(lens_, request.model.sensor_reflection)),
          tables_(lens_,
                  spectral_
                      ? request.wavelengths_nm
                      : EvenInWavelength(kSpectrumFirst_nm, SampleWavelength(kSpectrumSamples - 1),
                                         ColourBandsFor(lens_, settings_)),
                  context.threads),
          flux_wavelength_nm_(spectral_ ? request.wavelengths_nm.front() : kLineD),
          flux_tables_(lens_, {flux_wavelength_nm_}, context.threads),
          planner_(request, iris_, SceneFactor(), context.threads),
          error_(lens_, settings_, spectral_),
          window_(DataWindow(request.image)) {
        if (request.layers.starburst) {
            starburst_.emplace(request, stop_.semi_diameter_mm, window_);
        }
        if (!settings_.tiles || spectral_) {
            picture_.emplace(window_,
                             spectral_ ? static_cast<int>(request.wavelengths_nm.size()) : 0);
            return;
        }
        double brightest = 0.0;
        for (const LightSpec& light : request.lights) {
            const Vec3d& e = light.irradiance;
            brightest = std::max({brightest, e.x, e.y, e.z});
        }
        tile_picture_.emplace(window_, request.image.width, request.image.height,
                              brightest > 0.0 ? brightest : 1.0);
    }

    void AddSetup(double ms) { report_.work.setup_ms += ms; }

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
            if (starburst_) starburst_->Add(light, context_.threads, context_.cancel);
            if (context_.cancel.cancelled())
                return Error{"cancelled", "the work was cancelled", ""};
        }
        if (starburst_) report_.facts.starburst = starburst_->facts();
        for (std::size_t i = 0; i < drawn_.size(); ++i) {
            if (!lights.empty() && !drawn_[i]) report_.facts.ghosts[i].model = "culled";
        }
        report_.facts.estimated_error = error_.Value();
        return Rendering{Resolve(), std::move(report_)};
    }

  private:
    double SceneLinearFactor() const {
        const double n = WorkingBeam(lens_, stop_.semi_diameter_mm).working_f_number;
        return 4.0 * n * n / (kPi * AxialTransmittance(lens_, kLineD));
    }

    // From sensor irradiance to the request's units.
    double SceneFactor() const {
        return request_.units == Units::kSceneLinear ? SceneLinearFactor() : 1.0;
    }

    void SetFacts() {
        Facts& facts = report_.facts;
        facts.f_number = stop_.f_number;
        facts.working_f_number = WorkingBeam(lens_, stop_.semi_diameter_mm).working_f_number;
        facts.t_axis = AxialTransmittance(lens_, kLineD);
        facts.scene_linear_factor = SceneLinearFactor();
        facts.focus_m = request_.state.focus_m;
        facts.zoom_mm = request_.state.zoom_mm;
        facts.squeeze = lens_.squeeze();
        for (const StateClamp& clamp : request_.state_clamped) {
            facts.clamped.push_back("/" + clamp.field + ": " + std::to_string(clamp.from) + " -> " +
                                    std::to_string(clamp.to));
        }
        if (stop_.clamped) {
            facts.clamped.push_back("/f_number: " + std::to_string(*request_.f_number) + " -> " +
                                    std::to_string(stop_.f_number));
        }
        if (!request_.layers.ghosts) return;
        for (const BounceSequence& sequence : sequences_) {
            facts.ghosts.push_back({sequence, "geometric", 0.0});
        }
    }

    void AddLightFacts(const PlacedLight& light) {
        LightFacts facts;
        facts.direction = light.direction;
        facts.field_deg = DegreesFromRadians(light.field_rad);
        if (const std::optional<ChiefRay> chief =
                FindChiefRay(lens_, BundleOf(lens_, light), kLineD)) {
            facts.chief_ray_arrives = true;
            const Vec2d at = chief->sensor_mm;
            facts.sensor_mm = light.pose.LensSpace(at) * -1.0;
            facts.pixel = MapOf(request_, light.pose).Pixel(at.x, at.y);
        }
        report_.facts.lights.push_back(facts);
    }

    // Of a ghost that is drawn with a weight.
    LightColour ColourOf(const PlacedLight& light, double weight) const {
        LightColour colour;
        colour.spectral = spectral_;
        colour.irradiance = weight * light.irradiance.x;
        if (!spectral_) colour.power = LightSpectrum(light.irradiance * weight);
        colour.dispersion_step_px = settings_.dispersion_step_px;
        colour.most_drawn = settings_.most_drawn;
        colour.light_tolerance = settings_.light_tolerance;
        return colour;
    }

    std::optional<Error> DrawLight(const PlacedLight& light) {
        const Vec3d& e = light.irradiance;
        if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return std::nullopt;
        if (!request_.layers.ghosts) return std::nullopt;
        std::vector<std::size_t> ghosts_of_light(sequences_.size());
        std::iota(ghosts_of_light.begin(), ghosts_of_light.end(), std::size_t{0});
        if (request_.model.reflections == 4) {
            const double before = context_.now_ms();
            if (std::optional<Error> error = AddFourReflections(light, ghosts_of_light))
                return error;
            report_.work.mesh_ms += context_.now_ms() - before;
        }
        std::vector<PlannedGhost> planned = PlanGhosts(light, ghosts_of_light);
        if (context_.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
        const int count = static_cast<int>(planned.size());
        for (int first = 0; first < count; first += kGhostsPerBatch) {
            const int batch = std::min(kGhostsPerBatch, count - first);
            std::vector<TiledGhost> ghosts(static_cast<std::size_t>(batch));
            std::vector<Work> work(static_cast<std::size_t>(batch));
            const double t0 = context_.now_ms();
            context_.threads.For(batch, [&](int i) {
                const auto n = static_cast<std::size_t>(i);
                ghosts[n] = Prepare(light, planned[static_cast<std::size_t>(first + i)], work[n]);
            });
            for (const Work& w : work) AddWork(w);
            for (int i = first; i < first + batch; ++i) {
                const PlannedGhost& ghost = planned[static_cast<std::size_t>(i)];
                error_.AddDrawn(ghost.sample, ghost.weight, ghost.dispersion_step_px, ghost.miss);
            }
            const double t1 = context_.now_ms();
            if (!context_.cancel.cancelled()) {
                Draw(ghosts, MapOf(request_, light.pose));
            }
            report_.work.mesh_ms += t1 - t0;
            report_.work.raster_ms += context_.now_ms() - t1;
            if (context_.cancel.cancelled())
                return Error{"cancelled", "the work was cancelled", ""};
        }
        return std::nullopt;
    }

    void Draw(std::vector<TiledGhost>& ghosts, const PictureMap& map) {
        const auto count = [&](const auto& drawn) {
            report_.work.polygons += drawn.pieces;
            report_.work.fragments += drawn.fragments;
        };
        if (tile_picture_) {
            count(tile_picture_->Draw(ghosts, iris_, tile_picture_->MapFromMiddle(map),
                                      settings_.walk, context_.threads, context_.cancel));
        } else {
            std::vector<GhostLight> lights;
            for (TiledGhost& ghost : ghosts) lights.push_back(std::move(ghost.light));
            count(picture_->Draw(lights, iris_, map, settings_.walk, context_.threads,
                                 context_.cancel));
        }
    }

    // Leaves out the ghosts that need not be drawn, and says so.
    std::vector<PlannedGhost> PlanGhosts(const PlacedLight& light,
                                         const std::vector<std::size_t>& indices) {
        const double before = context_.now_ms();
        std::vector<BounceSequence> sequences;
        for (const std::size_t i : indices) {
            sequences.push_back(report_.facts.ghosts[i].sequence);
        }
        GhostPlan plan = planner_.Plan(light, sequences, context_);
        Facts& facts = report_.facts;
        facts.culling.culled += plan.facts.culled;
        facts.culling.faded += plan.facts.faded;
        facts.culling.frame_flux_mm2 += plan.facts.frame_flux_mm2;
        facts.culling.lost_flux_mm2 += plan.facts.lost_flux_mm2;
        facts.culled_flux_mm2 += plan.facts.lost_flux_mm2;
        error_.AddLight(plan.frame_light, plan.lost_light);
        drawn_.resize(facts.ghosts.size());
        for (PlannedGhost& ghost : plan.drawn) {
            ghost.index = indices[ghost.index];
            drawn_[ghost.index] = true;
        }
        for (const PlannedGhost& ghost : plan.left_out) {
            if (reported_) facts.ghosts[indices[ghost.index]].flux_mm2 += ghost.sample.flux_mm2;
        }
        report_.work.sampled_rays += plan.rays;
        report_.work.cull_ms += context_.now_ms() - before;
        return std::move(plan.drawn);
    }

    // The ghosts of four reflections that this light makes bright enough, by their places in the
    // report.
    std::optional<Error> AddFourReflections(const PlacedLight& light,
                                            std::vector<std::size_t>& ghosts_of_light) {
        const Result<GhostChoice> choice =
            ChooseFourReflections(lens_, request_.model, iris_, light, context_);
        if (!choice) return choice.error();
        Facts& facts = report_.facts;
        FourReflectionFacts four = choice->facts;
        if (facts.four_reflections) {
            four.rendered_flux_mm2 += facts.four_reflections->rendered_flux_mm2;
            four.lost_flux_mm2 += facts.four_reflections->lost_flux_mm2;
        }
        facts.culled_flux_mm2 += choice->facts.lost_flux_mm2;
        report_.work.rays_traced += choice->rays_traced;
        for (const BounceSequence& sequence : choice->sequences) {
            const auto [known, added] = fours_.emplace(sequence, facts.ghosts.size());
            if (added) facts.ghosts.push_back({sequence, "geometric", 0.0});
            ghosts_of_light.push_back(known->second);
        }
        four.rendered = fours_.size();
        facts.four_reflections = four;
        return std::nullopt;
    }

    // One ghost of one light, ready to draw. Writes only its own slots.
    TiledGhost Prepare(const PlacedLight& light, PlannedGhost& planned, Work& work) {
        if (context_.cancel.cancelled()) return {};
        const std::size_t index = planned.index;
        const MeshSpec spec = MeshSpecFor(request_, report_.facts.ghosts[index].sequence, light);
        const Result<MeshProvider::Found> found = context_.meshes.Get(
            MeshKey(lens_, spec), [&] { return BuildMesh(lens_, spec); }, context_.cancel);
        if (!found) return {};
        ++(found->hit ? work.mesh_hits : work.mesh_misses);
        if (found->from_disk) ++work.mesh_disk_hits;
        if (!found->hit) {
            work.rays_traced += found->mesh->rays_traced;
            work.ray_surfaces += found->mesh->ray_surfaces;
        }
        const auto surface = std::make_shared<const GhostSurface>(
            found->mesh, lens_.sensor_gap_mm(), iris_.outer_radius());
        if (surface->cells().empty()) return {};

        const LightBundle bundle = BundleOf(lens_, light);
        PictureMap map = MapOf(request_, light.pose);
        GhostFacts& facts = report_.facts.ghosts[index];
        if (reported_) {
            facts.flux_mm2 +=
                EstimateOf(*surface, bundle, lens_, flux_tables_, iris_, light.pose).flux_mm2;
        }
        const std::vector<double> bounded =
            spectral_ ? SpectralBounds()
                      : std::vector<double>{kDrawnLow_nm, 0.5 * (kDrawnLow_nm + kDrawnHigh_nm),
                                            kDrawnHigh_nm};
        if (tile_picture_) map = tile_picture_->MapFromMiddle(map);
        const WalkWindow window = WalkWindowOf(window_);
        std::vector<GhostLight::Cell> cells =
            CellsInWindow(*surface, bounded, iris_, map, tile_picture_ ? WalkWindow{} : window);
        work.cells += cells.size();
        LightColour colour = ColourOf(light, planned.weight);
        if (!cells.empty()) {
            const std::vector<GhostLight::Cell> in_frame = InFrame(*surface, bounded, map, cells);
            planned.miss = MeshMissOf(*surface, in_frame, map);
            if (!spectral_) colour.dispersion_px = DispersionPx(*surface, in_frame, map);
        }
        MaskFields masks;
        if (tile_picture_) {
            masks = MasksOf(*surface, cells, iris_);
            AddRing(*surface, map, tile_picture_->padded(), cells);
            const bool any = std::any_of(cells.begin(), cells.end(),
                                         [](const auto& cell) { return !cell.ring; });
            if (!any) return {};
        }
        TiledGhost ghost;
        ghost.light = PrepareGhost(surface, bundle, lens_, tables_, colour, std::move(cells));
        if (ghost.light.bands.size() > 1) {
            planned.dispersion_step_px =
                colour.dispersion_px / static_cast<double>(ghost.light.bands.size() - 1);
        }
        if (tile_picture_) {
            ghost.light.masks = std::move(masks);
            ghost.tiles = TilesOf(ghost.light, iris_, map, tile_picture_->padded(),
                                  *settings_.tiles, tile_picture_->unit());
        }
        return ghost;
    }

    // The cells of the whole frame, whatever window `cells` are those of.
    std::vector<GhostLight::Cell> InFrame(const GhostSurface& surface,
                                          const std::vector<double>& bounded, const PictureMap& map,
                                          const std::vector<GhostLight::Cell>& cells) const {
        const PixelWindow frame{0, 0, request_.image.width, request_.image.height};
        if (!tile_picture_) {
            return window_ == frame
                       ? cells
                       : CellsInWindow(surface, bounded, iris_, map, WalkWindowOf(frame));
        }
        const WalkWindow around = WalkWindowOf(tile_picture_->FromMiddle(frame));
        std::vector<GhostLight::Cell> touching;
        for (const GhostLight::Cell& cell : cells) {
            if (Touches(cell, around)) touching.push_back(cell);
        }
        return touching;
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
        report_.work.mesh_disk_hits += w.mesh_disk_hits;
    }

    // Light a pixel to irradiance, and to scene radiance if asked; each layer twice: in the root
    // and under its own name.
    FlareImage Resolve() {
        const double t0 = context_.now_ms();
        FlareImage image;
        image.full = {0, 0, request_.image.width, request_.image.height};
        image.data = window_;
        image.pixel_aspect = ShownPixelAspect(request_);
        image.rec709 = !spectral_;
        const Vec2d pitch = PixelPitch(request_);
        const double scale = SceneFactor() / (pitch.x * pitch.y);

        const auto channels = static_cast<std::size_t>(picture_ ? picture_->channel_count() : 3);
        std::vector<std::vector<float>> values(channels);
        if (tile_picture_) {
            std::ranges::move(tile_picture_->Resolve(scale, context_.threads), values.begin());
        } else {
            context_.threads.For(static_cast<int>(channels), [&](int c) {
                values[static_cast<std::size_t>(c)] = picture_->Channel(c, scale);
            });
        }
        image.planes.resize(channels * (request_.layers.ghosts ? 2 : 1));
        for (std::size_t c = 0; c < channels; ++c) {
            static const char* const kRgb[] = {"R", "G", "B"};
            const std::string name = spectral_ ? SpectralName(request_.wavelengths_nm[c]) : kRgb[c];
            image.planes[c] = {name, std::move(values[c])};
            if (!request_.layers.ghosts) continue;
            image.planes[channels + c] = {"ghosts." + name, image.planes[c].values};
        }
        if (starburst_) starburst_->AppendTo(image, scale);
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
    std::vector<BounceSequence> sequences_;        // of two reflections
    std::map<BounceSequence, std::size_t> fours_;  // of four: place in the report
    TransmissionTables tables_;
    double flux_wavelength_nm_;
    TransmissionTables flux_tables_;
    GhostPlanner planner_;
    ErrorEstimate error_;
    std::vector<bool> drawn_;  // each ghost of the report, for some light
    PixelWindow window_;
    // One of the two.
    std::optional<Picture> picture_;
    std::optional<TilePicture> tile_picture_;
    std::optional<StarburstLayer> starburst_;
    Report report_;
    bool reported_ = true;  // the light at hand stands in the report
};

}  // namespace

Result<Rendering> Render(const FlareRequest& request, const RenderContext& context) {
    if (const std::optional<Error> error = CheckRequest(request)) return *error;
    const double before = context.now_ms();
    Job job(request, context);
    job.AddSetup(context.now_ms() - before);
    return job.Run();
}

}  // namespace flare
