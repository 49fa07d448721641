// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_builder.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/image/cell_fits.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/fringe_plan.h"
#include "core/render/ghost_estimate.h"
#include "core/render/kept_tables.h"
#include "core/render/light_meshes.h"
#include "core/render/picture.h"

namespace flare {
namespace {

// Wavelengths that colour fringes are drawn at, at least.
constexpr int kFringeBands = 9;

std::vector<double> BoundingWavelengths(const RenderScene& scene) {
    if (!scene.spectral()) {
        return {kDrawnLow_nm, 0.5 * (kDrawnLow_nm + kDrawnHigh_nm), kDrawnHigh_nm};
    }
    const std::vector<double>& list = scene.request.wavelengths_nm;
    if (list.size() == 1) return list;
    const auto [lo, hi] = std::minmax_element(list.begin(), list.end());
    return {*lo, 0.5 * (*lo + *hi), *hi};
}

}  // namespace

GhostCanvas GhostCanvas::Of(const RenderScene& scene, const TilePicture* tile_picture) {
    GhostCanvas canvas;
    canvas.window = scene.window;
    canvas.frame = {0, 0, scene.request.image.width, scene.request.image.height};
    if (!tile_picture) return canvas;
    canvas.origin_x = tile_picture->middle_x();
    canvas.origin_y = tile_picture->middle_y();
    canvas.window = tile_picture->padded();
    canvas.frame = tile_picture->FromMiddle(canvas.frame);
    canvas.tiles = true;
    canvas.unit = tile_picture->unit();
    return canvas;
}

PictureMap GhostCanvas::MapOnto(PictureMap map) const {
    const double size = std::ldexp(1.0, -coarse);
    map.offset_px = (map.offset_px - Vec2d(origin_x, origin_y)) * size;
    map.px_per_x *= size;
    map.px_per_y *= size;
    return map;
}

GhostBuilder::GhostBuilder(const RenderScene& scene, const RenderContext& context)
    : scene_(scene), context_(context), bounded_nm_(BoundingWavelengths(scene)) {}

void GhostBuilder::MakeTables() {
    if (tables_) return;
    const std::vector<double>& asked = scene_.request.wavelengths_nm;
    const bool spectral = scene_.spectral();
    const std::vector<double> bands =
        spectral ? asked
                 : EvenInWavelength(kSpectrumFirst_nm, SampleWavelength(kSpectrumSamples - 1),
                                    ColourBandsFor(scene_.lens, scene_.settings));
    tables_ = TablesOf(scene_.lens, bands, context_);
    flux_tables_ = TablesOf(scene_.lens, {spectral ? asked.front() : kLineD}, context_);
}

// Of a ghost that is drawn with a weight, and with what an artist asks of it.
LightColour GhostBuilder::ColourOf(const PlacedLight& light, const BounceSequence& sequence,
                                   double weight) const {
    LightColour colour;
    if (const ArtistGhost* artist = ArtistOf(scene_.request, sequence)) {
        weight *= artist->gain;
        colour.tint = artist->tint;
    }
    colour.spectral = scene_.spectral();
    colour.irradiance = weight * light.irradiance.x;
    if (!colour.spectral) colour.power = PowerOf(light, weight);
    colour.response = &ResponseOf(scene_.request);
    colour.dispersion_step_px = scene_.settings.dispersion_step_px;
    colour.most_drawn = scene_.settings.most_drawn;
    colour.light_tolerance = scene_.settings.light_tolerance;
    return colour;
}

GhostBuilder::Located GhostBuilder::Locate(const PlacedLight& light, const BounceSequence& sequence,
                                           const GhostCanvas& canvas, bool plain) const {
    Located located;
    if (context_.cancel.cancelled()) return located;
    const Lens& lens = scene_.lens;
    const MeshSpec spec = MeshSpecFor(scene_.request, sequence, light);
    const Result<MeshProvider::Found> found = context_.meshes.Get(
        MeshKey(lens, spec), [&] { return BuildMesh(lens, spec); }, context_.cancel);
    if (!found) return located;
    Work& work = located.work;
    ++(found->hit ? work.mesh_hits : work.mesh_misses);
    if (found->from_disk) ++work.mesh_disk_hits;
    if (!found->hit) {
        work.rays_traced = found->mesh->rays_traced;
        work.ray_surfaces = found->mesh->ray_surfaces;
    }
    const PictureMap map = canvas.MapOnto(MapOf(scene_.request, light.pose));
    FringePlan& plan = located.plan;
    if (scene_.request.model.ringing && !plain && !sequence.empty()) {
        plan = PlanFringes(lens, *found->mesh, light, scene_.iris, map, scene_.spectral());
        // What is blurred by the source afterwards must not be blurred by it before.
        if (plan.fringes && canvas.blurred) {
            for (GhostFringes::Crossing& crossing : plan.fringes->crossings) {
                crossing.source_t = 0.0;
            }
        }
    }
    const Iris& iris = plan.fringes ? plan.fringes->iris : scene_.iris;
    auto surface = std::make_shared<const GhostSurface>(found->mesh, lens.sensor_gap_mm(),
                                                        iris.outer_radius(), scene_.settings.cubic);
    if (surface->cells().empty()) return located;

    located.cells = CellsInWindow(*surface, bounded_nm_, iris, map,
                                  canvas.tiles ? WalkWindow{} : WalkWindowOf(canvas.window));
    work.cells = located.cells.size();
    if (!located.cells.empty()) {
        const std::vector<GhostLight::Cell> in_frame =
            InFrame(*surface, iris, map, canvas, located.cells);
        located.miss = MeshMissOf(*surface, in_frame, map);
        if (!scene_.spectral()) located.dispersion_px = DispersionPx(*surface, in_frame, map);
    }
    located.surface = std::move(surface);
    return located;
}

GhostBuilder::Built GhostBuilder::Build(const PlacedLight& light, const BounceSequence& sequence,
                                        double weight, bool with_flux, const GhostCanvas& canvas,
                                        bool plain) const {
    FLARE_CHECK(tables_);
    Located located = Locate(light, sequence, canvas, plain);
    Built built;
    built.work = located.work;
    built.miss = located.miss;
    FringePlan& plan = located.plan;
    built.ringing = plan.facts;
    if (!located.surface) return built;
    const GhostSurface& surface = *located.surface;
    std::vector<GhostLight::Cell>& cells = located.cells;
    const Lens& lens = scene_.lens;
    const Iris& iris = plan.fringes ? plan.fringes->iris : scene_.iris;
    const LightBundle bundle = BundleOf(lens, light);
    if (with_flux) {
        built.flux_mm2 =
            EstimateOf(surface, bundle, lens, *flux_tables_, scene_.iris, light.pose).flux_mm2;
    }
    const PictureMap map = canvas.MapOnto(MapOf(scene_.request, light.pose));
    MaskFields masks;
    if (canvas.tiles) {
        masks = MasksOf(surface, cells, iris);
        AddRing(surface, map, canvas.window, cells);
        const bool any =
            std::any_of(cells.begin(), cells.end(), [](const auto& cell) { return !cell.ring; });
        if (!any) return built;
    }
    LightColour colour = ColourOf(light, sequence, weight);
    colour.dispersion_px = plain ? 0.0 : located.dispersion_px;
    if (plan.fringes) colour.least_drawn = std::min(kFringeBands, colour.most_drawn);
    GhostLight& ghost = built.ghost.light;
    ghost = PrepareGhost(located.surface, bundle, lens, *tables_, colour, std::move(cells));
    if (plan.fringes) {
        FillTables(scene_.iris, ghost, scene_.spectral(), *plan.fringes);
        ghost.fringes = std::move(plan.fringes);
    }
    if (ghost.bands.size() > 1) {
        built.dispersion_step_px =
            colour.dispersion_px / static_cast<double>(ghost.bands.size() - 1);
    }
    if (canvas.tiles) {
        ghost.masks = std::move(masks);
        built.ghost.tiles = std::make_shared<const GhostTiles>(
            TilesOf(ghost, scene_.iris, map, canvas.window, *scene_.settings.tiles, canvas.unit));
    }
    return built;
}

// The cells of the whole frame, whatever window `cells` are those of.
std::vector<GhostLight::Cell> GhostBuilder::InFrame(
    const GhostSurface& surface, const Iris& iris, const PictureMap& map, const GhostCanvas& canvas,
    const std::vector<GhostLight::Cell>& cells) const {
    const WalkWindow around = WalkWindowOf(canvas.frame);
    if (!canvas.tiles) {
        return canvas.window == canvas.frame
                   ? cells
                   : CellsInWindow(surface, bounded_nm_, iris, map, around);
    }
    std::vector<GhostLight::Cell> touching;
    for (const GhostLight::Cell& cell : cells) {
        if (Touches(cell, around)) touching.push_back(cell);
    }
    return touching;
}

}  // namespace flare
