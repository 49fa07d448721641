// SPDX-License-Identifier: Apache-2.0
//
// Places the lights, hands each to the layers that are asked for, and puts the layers' planes
// together.
#include "core/render/renderer.h"

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/render/bokeh_layer.h"
#include "core/render/ghost_layer.h"
#include "core/render/light_split.h"
#include "core/render/lights.h"
#include "core/render/photon_layer.h"
#include "core/render/quality_search.h"
#include "core/render/render_scene.h"
#include "core/render/starburst_layer.h"
#include "core/render/visible.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr std::size_t kMostReportedLights = 64;

class Job {
  public:
    Job(const FlareRequest& request, const RenderContext& context)
        : request_(request), context_(context), scene_(request) {
        const double before = context.now_ms();
        SetFacts();
        if (request.layers.ghosts && request.photon) photons_.emplace(scene_, context, report_);
        if (request.layers.ghosts && !request.photon) ghosts_.emplace(scene_, context, report_);
        if (request.layers.starburst) {
            starburst_.emplace(request, scene_.stop.semi_diameter_mm, scene_.window,
                               LeastStarburst());
        }
        if (request.layers.bokeh) bokeh_.emplace(scene_, context, report_);
        report_.work.setup_ms += context.now_ms() - before;
    }

    Result<Rendering> Run() {
        // Lights are placed first: a bad one is an error before any work is done.
        std::vector<PlacedLight> lights;
        for (std::size_t i = 0; i < request_.lights.size(); ++i) {
            Result<PlacedLight> light = PlaceLight(request_, i);
            if (!light) return light.error();
            lights.push_back(*light);
        }
        if (request_.split == SplitBy::kLight) {
            if (std::optional<Error> error = CheckSplitLayers(scene_, lights.size())) return *error;
            split_.emplace(scene_);
        }
        for (std::size_t i = 0; i < lights.size(); ++i) {
            const PlacedLight& light = lights[i];
            const bool reported = report_.facts.lights.size() < kMostReportedLights;
            if (reported) AddLightFacts(light);
            if (ghosts_) {
                if (std::optional<Error> error = ghosts_->Add(light, reported)) return *error;
            }
            if (photons_) photons_->Add(light, reported);
            if (starburst_) starburst_->Add(light, context_.threads, context_.cancel);
            if (bokeh_) bokeh_->Add(light);
            if (context_.cancel.cancelled())
                return Error{"cancelled", "the work was cancelled", ""};
            if (split_) TakeLight(i);
        }
        if (ghosts_) ghosts_->Finish();
        if (photons_) {
            if (std::optional<Error> error = photons_->Run()) return *error;
        }
        if (starburst_) report_.facts.starburst = starburst_->facts();
        if (starburst_ && request_.visible) {
            UnseenFacts& tails = report_.facts.visible->starburst;
            tails = starburst_->unseen();
            tails.peak *= Scale();
        }
        return Rendering{Resolve(), std::move(report_), request_.quality};
    }

  private:
    void SetFacts() {
        Facts& facts = report_.facts;
        if (request_.visible) facts.visible.emplace().floor = request_.visible->Floor();
        facts.f_number = scene_.stop.f_number;
        facts.working_f_number = scene_.working_f_number;
        facts.t_axis = scene_.t_axis;
        facts.scene_linear_factor = scene_.scene_linear_factor;
        facts.focus_m = request_.state.focus_m;
        facts.zoom_mm = request_.state.zoom_mm;
        facts.squeeze = scene_.lens.squeeze();
        for (const StateClamp& clamp : request_.state_clamped) {
            facts.clamped.push_back("/" + clamp.field + ": " + std::to_string(clamp.from) + " -> " +
                                    std::to_string(clamp.to));
        }
        if (scene_.stop.clamped) {
            facts.clamped.push_back("/f_number: " + std::to_string(*request_.f_number) + " -> " +
                                    std::to_string(scene_.stop.f_number));
        }
    }

    void AddLightFacts(const PlacedLight& light) {
        LightFacts facts;
        facts.direction = light.direction;
        facts.field_deg = DegreesFromRadians(light.field_rad);
        if (const std::optional<ChiefRay> chief =
                FindChiefRay(scene_.lens, BundleOf(scene_.lens, light), kLineD)) {
            facts.chief_ray_arrives = true;
            const Vec2d at = chief->sensor_mm;
            facts.sensor_mm = light.pose.LensSpace(at) * -1.0;
            facts.pixel = MapOf(request_, light.pose).Pixel(at.x, at.y);
        }
        report_.facts.lights.push_back(facts);
    }

    // The light in a pixel below which a starburst ends.
    double LeastStarburst() const {
        if (!request_.visible || request_.lights.empty()) return 0.0;
        const double floor =
            request_.visible->Floor() / static_cast<double>(request_.lights.size());
        return kUnseenTails * floor / Scale();
    }

    // From light a pixel to irradiance, and to scene radiance if asked.
    double Scale() const {
        const Vec2d pitch = PixelPitch(request_);
        return scene_.units_factor / (pitch.x * pitch.y);
    }

    // Each layer twice: in the root and under its own name.
    void AppendLayers(FlareImage& image) {
        const double scale = Scale();
        if (ghosts_) AppendLayer(scene_, "ghosts", ghosts_->Resolve(scale), image);
        if (photons_) AppendLayer(scene_, "ghosts", photons_->Resolve(scale), image);
        if (starburst_) AppendLayer(scene_, "starburst", starburst_->Resolve(scale), image);
        if (bokeh_) AppendLayer(scene_, "bokeh", bokeh_->Resolve(scale), image);
    }

    // What the layers have gathered is light `index` alone.
    void TakeLight(std::size_t index) {
        const double before = context_.now_ms();
        FlareImage picture;
        AppendLayers(picture);
        split_->Add(index, std::move(picture));
        if (ghosts_) ghosts_->Clear();
        if (starburst_) starburst_->Clear();
        if (bokeh_) bokeh_->Clear();
        report_.work.resolve_ms += context_.now_ms() - before;
    }

    FlareImage Resolve() {
        const double before = context_.now_ms();
        FlareImage image;
        image.full = {0, 0, request_.image.width, request_.image.height};
        image.data = scene_.window;
        image.pixel_aspect = ShownPixelAspect(request_);
        image.rec709 = request_.color == ColorMode::kLinRec709 && !request_.camera;
        if (!image.rec709 && !scene_.spectral() && !request_.camera) {
            image.chromaticities = ChromaticitiesOf(SpaceOf(request_.color));
        }
        if (split_ && !request_.lights.empty()) {
            split_->AppendTo(image);
        } else {
            AppendLayers(image);
        }
        if (ghosts_) ghosts_->AppendSplit(image, Scale());
        if (photons_) photons_->AppendErrorTo(image, Scale());
        report_.work.resolve_ms += context_.now_ms() - before;
        return image;
    }

    const FlareRequest& request_;
    const RenderContext& context_;
    Report report_;
    RenderScene scene_;
    std::optional<GhostLayer> ghosts_;  // one of these two
    std::optional<PhotonLayer> photons_;
    std::optional<StarburstLayer> starburst_;
    std::optional<BokehLayer> bokeh_;
    std::optional<LightSplit> split_;
};

}  // namespace

Result<Rendering> Render(const FlareRequest& request, const RenderContext& context) {
    if (const std::optional<Error> error = CheckRequest(request)) return *error;
    const auto draw = [](const FlareRequest& plan, const RenderContext& drawing) {
        return Job(plan, drawing).Run();
    };
    FLARE_CHECK(!request.settings || request.quality.IsPlan());
    if (request.quality.IsPlan()) return draw(request, context);
    return RenderSearched(request, context, draw);
}

}  // namespace flare
