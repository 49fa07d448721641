// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_picture.h"

#include <algorithm>
#include <utility>

namespace flare {
namespace {

double BrightestChannel(const std::vector<LightSpec>& lights) {
    double brightest = 0.0;
    for (const LightSpec& light : lights) {
        const Vec3d& e = light.irradiance;
        brightest = std::max({brightest, e.x, e.y, e.z});
    }
    return brightest > 0.0 ? brightest : 1.0;
}

}  // namespace

GhostPicture::GhostPicture(const RenderScene& scene, const RenderContext& context)
    : scene_(scene), context_(context) {
    const FlareRequest& request = scene.request;
    if (!scene.settings.tiles || scene.spectral()) {
        polygons_.emplace(scene.window,
                          scene.spectral() ? static_cast<int>(scene.channel_count()) : 0);
        return;
    }
    tiles_.emplace(scene.window, request.image.width, request.image.height,
                   BrightestChannel(request.lights));
}

void GhostPicture::Draw(std::vector<TiledGhost>& ghosts, const PictureMap& map, Work& work,
                        std::span<LeftPixels> kept) {
    const auto count = [&](const auto& drawn) {
        work.polygons += drawn.pieces;
        work.fragments += drawn.fragments;
    };
    if (tiles_) {
        count(tiles_->Draw(ghosts, scene_.iris, tiles_->MapFromMiddle(map), scene_.settings.walk,
                           context_.threads, context_.cancel, kept));
        return;
    }
    std::vector<GhostLight> lights;
    for (TiledGhost& ghost : ghosts) lights.push_back(std::move(ghost.light));
    count(polygons_->Draw(lights, scene_.iris, map, scene_.settings.walk, context_.threads,
                          context_.cancel));
    for (std::size_t n = 0; n < ghosts.size(); ++n) ghosts[n].light = std::move(lights[n]);
}

LayerPlanes GhostPicture::Resolve(double scale) const {
    LayerPlanes planes(scene_.channel_count());
    if (tiles_) {
        std::ranges::move(tiles_->Resolve(scale, context_.threads), planes.begin());
        return planes;
    }
    context_.threads.For(static_cast<int>(planes.size()), [&](int c) {
        planes[static_cast<std::size_t>(c)] = polygons_->Channel(c, scale);
    });
    return planes;
}

void GhostPicture::Clear() {
    if (tiles_) tiles_->Clear();
    if (polygons_) polygons_->Clear();
}

}  // namespace flare
