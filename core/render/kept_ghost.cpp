// SPDX-License-Identifier: Apache-2.0
#include "core/render/kept_ghost.h"

#include "core/render/light_meshes.h"
#include "core/render/source_picture.h"

namespace flare {
namespace {

template <class Value>
std::size_t BytesOf(const std::vector<Value>& values) {
    return values.capacity() * sizeof(Value);
}

// The names below leave out nothing: a new member does not compile until it is added here.

void Add(const WalkTolerance& walk, Fingerprinter& to) {
    const auto& [position_px, density_step, smallest_px, largest_px, mask_step] = walk;
    to.Add(position_px).Add(density_step).Add(smallest_px).Add(largest_px).Add(mask_step);
}

void Add(const QualitySettings& settings, Fingerprinter& to) {
    const auto& [mesh_cells, patch_cells, position_tolerance_mm, mask_tolerance, traced_wavelengths,
                 colour_bands, dispersion_step_px, most_drawn, light_tolerance, walk, tiles,
                 arithmetic, tolerance, culled_share, blur_tolerance, most_blur_side, least_blur_px,
                 cubic] = settings;
    to.Add(mesh_cells).Add(patch_cells).Add(position_tolerance_mm).Add(mask_tolerance);
    to.Add(traced_wavelengths).Add(colour_bands).Add(dispersion_step_px).Add(most_drawn);
    to.Add(light_tolerance).Add(tiles.has_value()).Add(static_cast<int>(arithmetic));
    to.Add(tolerance).Add(culled_share).Add(blur_tolerance).Add(most_blur_side);
    to.Add(least_blur_px).Add(cubic);
    Add(walk, to);
    if (tiles) {
        const auto& [light, edge_px] = *tiles;
        to.Add(light).Add(edge_px);
    }
}

void Add(Vec2d v, Fingerprinter& to) {
    to.Add(v.x).Add(v.y);
}

void Add(const Vec3d& v, Fingerprinter& to) {
    to.Add(v.x).Add(v.y).Add(v.z);
}

void Add(const PixelWindow& window, Fingerprinter& to) {
    const auto& [x, y, width, height] = window;
    to.Add(x).Add(y).Add(width).Add(height);
}

void Add(const PictureMap& map, Fingerprinter& to) {
    const auto& [px_per_x, px_per_y, offset_px, stop_per_x, stop_per_y] = map;
    for (const Vec2d& v : {px_per_x, px_per_y, offset_px, stop_per_x, stop_per_y}) Add(v, to);
}

void Add(const GhostCanvas& canvas, Fingerprinter& to) {
    const auto& [origin_x, origin_y, coarse, blurred, window, frame, tiles, unit] = canvas;
    to.Add(origin_x).Add(origin_y).Add(coarse).Add(blurred).Add(tiles).Add(unit);
    Add(window, to);
    Add(frame, to);
}

void Add(const PlacedLight& light, Fingerprinter& to) {
    const auto& [direction, field_rad, pose, inverse_distance, irradiance, power,
                 angular_diameter_rad, shape, detail_rad, share] = light;
    Add(direction, to);
    to.Add(field_rad).Add(pose.azimuth_rad).Add(inverse_distance).Add(angular_diameter_rad);
    to.Add(share).Add(power != nullptr);
    Add(pose.x_axis, to);
    Add(pose.y_axis, to);
    Add(irradiance, to);
    if (power) {
        for (const double value : *power) to.Add(value);
    }
    to.Add(shape ? shape->side() : 0).Add(detail_rad.value_or(-1.0));
    for (int k = 0; shape && k < shape->side() * shape->side(); ++k)
        to.Add(shape->At(k % shape->side(), k / shape->side()));
}

void Add(const IrisShape& shape, Fingerprinter& to) {
    const auto& [blades, roundness, rotation_deg, irregularity, seed, mask, mask_scale] = shape;
    to.Add(blades).Add(roundness).Add(rotation_deg).Add(irregularity);
    to.Add(static_cast<std::int64_t>(seed)).Add(static_cast<int>(mask_scale));
    to.Add(mask != nullptr);
    if (mask) to.Add(mask->fingerprint());
}

}  // namespace

std::size_t KeptGhost::bytes() const {
    std::size_t sum = sizeof(KeptGhost) + BytesOf(left.row_at) + BytesOf(left.rgb);
    if (tiles) {
        sum += BytesOf(tiles->smooth) + BytesOf(tiles->edges) + BytesOf(tiles->straight_edges) +
               BytesOf(tiles->arc_edges) + BytesOf(tiles->pictured) + BytesOf(tiles->fringe_edges) +
               BytesOf(tiles->band_rgb) + BytesOf(tiles->band_sharpness) +
               BytesOf(tiles->band_weights) + BytesOf(tiles->left);
    }
    if (fringes) sum += BytesOf(fringes->tables) + BytesOf(fringes->crossings);
    return sum;
}

std::shared_ptr<const KeptGhost> KeptOf(const GhostBuilder::Built& built, LeftPixels left) {
    auto kept = std::make_shared<KeptGhost>();
    kept->tiles = built.ghost.tiles;
    kept->left = std::move(left);
    kept->fringes = built.ghost.light.fringes;
    kept->miss = built.miss;
    kept->dispersion_step_px = built.dispersion_step_px;
    kept->ringing = built.ringing;
    kept->flux_mm2 = built.flux_mm2;
    return kept;
}

GhostBuilder::Built BuiltOf(const KeptGhost& kept) {
    GhostBuilder::Built built;
    built.ghost.tiles = kept.tiles;
    built.ghost.left = &kept.left;
    built.ghost.light.fringes = kept.fringes;
    built.miss = kept.miss;
    built.dispersion_step_px = kept.dispersion_step_px;
    built.ringing = kept.ringing;
    built.flux_mm2 = kept.flux_mm2;
    built.work.mesh_hits = 1;
    built.work.ghost_hits = 1;
    return built;
}

GhostKeys::GhostKeys(const RenderScene& scene, const PlacedLight& light, const GhostCanvas& canvas,
                     bool with_flux)
    : scene_(scene), light_(light) {
    const FlareRequest& request = scene.request;
    Fingerprinter to;
    to.Add("ghost").Add(scene.lens.fingerprint()).Add(scene.lens.sensor_gap_mm());
    to.Add(scene.stop.semi_diameter_mm).Add(request.model.ringing).Add(with_flux);
    Add(request.iris, to);
    Add(scene.settings, to);
    Add(light, to);
    Add(MapOf(request, light.pose), to);
    Add(canvas, to);
    for (const Vec3d& seen : ResponseOf(request)) Add(seen, to);
    to.Add(static_cast<std::int64_t>(request.wavelengths_nm.size()));
    for (const double nm : request.wavelengths_nm) to.Add(nm);
    common_ = to.value();
}

std::size_t SeenGhosts::bytes() const {
    return sizeof(SeenGhosts) + BytesOf(samples) + BytesOf(motions);
}

Fingerprint GhostKeys::OfSeen(const std::vector<BounceSequence>& sequences) const {
    Fingerprinter to;
    to.Add("seen").Add(common_).Add(scene_.units_factor);
    to.Add(static_cast<std::int64_t>(sequences.size()));
    for (const BounceSequence& sequence : sequences) {
        to.Add(static_cast<std::int64_t>(sequence.size()));
        for (const int surface : sequence) to.Add(surface);
    }
    return to.value();
}

Fingerprint GhostKeys::Of(const BounceSequence& sequence, double weight, bool plain) const {
    Fingerprinter to;
    to.Add(common_).Add(MeshKey(scene_.lens, MeshSpecFor(scene_.request, sequence, light_)));
    to.Add(weight).Add(plain);
    if (const ArtistGhost* const artist = ArtistOf(scene_.request, sequence)) {
        to.Add(artist->gain);
        Add(artist->tint, to);
    }
    return to.value();
}

}  // namespace flare
