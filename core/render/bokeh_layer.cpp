// SPDX-License-Identifier: Apache-2.0
#include "core/render/bokeh_layer.h"

#include <algorithm>

#include "core/render/ghost_flux.h"

namespace flare {
namespace {

// Colours that part in a sharp image show as separate dots unless they lie within a pixel or so of
// each other; chords of this length take 0.015 % of a round beam away; and the exact polygons stay
// right where an image has no area.
RenderScene ForDirectImages(const RenderScene& scene) {
    constexpr double kWidestStep_px = 2.0, kClosestStep_px = 0.5;
    constexpr int kColours = 32;
    constexpr double kMaskStep = 0.03;
    RenderScene direct = scene;
    QualitySettings& settings = direct.settings;
    settings.dispersion_step_px =
        std::clamp(settings.dispersion_step_px / 8.0, kClosestStep_px, kWidestStep_px);
    settings.most_drawn = std::max(settings.most_drawn, kColours);
    settings.walk.mask_step = std::min(settings.walk.mask_step, kMaskStep);
    settings.tiles.reset();
    return direct;
}

}  // namespace

BokehLayer::BokehLayer(const RenderScene& scene, const RenderContext& context, Report& report)
    : scene_(ForDirectImages(scene)),
      context_(context),
      report_(report),
      builder_(scene_, context),
      flux_tables_(scene.lens, {scene.spectral() ? scene.request.wavelengths_nm.front() : kLineD},
                   context.threads),
      picture_(scene.window, scene.spectral() ? static_cast<int>(scene.channel_count()) : 0) {
    report_.facts.bokeh.emplace();
    builder_.MakeTables();
}

void BokehLayer::Add(const PlacedLight& light) {
    const Vec3d& e = light.irradiance;
    if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return;
    const double t0 = context_.now_ms();
    GhostBuilder::Built built =
        builder_.Build(light, {}, 1.0, false, GhostCanvas::Of(scene_, nullptr));
    report_.work.Add(built.work);
    const double t1 = context_.now_ms();
    report_.work.mesh_ms += t1 - t0;
    const std::shared_ptr<const GhostSurface> surface = built.ghost.light.surface;
    if (!surface || context_.cancel.cancelled()) return;

    const double flux = FluxOf(surface, BundleOf(scene_.lens, light), scene_.lens, flux_tables_,
                               scene_.iris, scene_.settings.walk, light.pose)
                            .flux_mm2;
    BokehFacts& facts = *report_.facts.bokeh;
    facts.flux_mm2 += flux;
    facts.lights += flux > 0.0 ? 1 : 0;
    std::vector<GhostLight> images;
    images.push_back(std::move(built.ghost.light));
    const Picture::Drawn drawn =
        picture_.Draw(images, scene_.iris, MapOf(scene_.request, light.pose), scene_.settings.walk,
                      context_.threads, context_.cancel);
    report_.work.polygons += drawn.pieces;
    report_.work.fragments += drawn.fragments;
    report_.work.raster_ms += context_.now_ms() - t1;
}

LayerPlanes BokehLayer::Resolve(double scale) const {
    LayerPlanes planes(scene_.channel_count());
    context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
        planes[static_cast<std::size_t>(c)] = picture_.Channel(c, scale);
    });
    return planes;
}

}  // namespace flare
