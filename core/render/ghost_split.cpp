// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_split.h"

#include <algorithm>
#include <utility>

namespace flare {

std::string SequenceLabel(const BounceSequence& sequence) {
    std::string name;
    for (const int surface : sequence) name += (name.empty() ? "" : "_") + std::to_string(surface);
    return name;
}

std::optional<Error> CheckSplitLayers(const RenderScene& scene, std::size_t layers) {
    const std::size_t triples = (scene.channel_count() + 2) / 3;
    const std::size_t most =
        std::min(kMaxSplitLayers, kMaxSplitPixels / (scene.window.pixels() * triples));
    if (layers <= most) return std::nullopt;
    return Error{"limit",
                 "the picture would be split into more than " + std::to_string(most) +
                     " layers, the most at its size and number of channels",
                 "/split"};
}

GhostSplit::GhostSplit(const RenderScene& scene, const RenderContext& context)
    : scene_(scene), scratch_(scene, context) {}

std::optional<Error> GhostSplit::Add(const BounceSequence& sequence, TiledGhost& ghost,
                                     const PictureMap& map, Work& work) {
    if (!ghost.tiles && ghost.light.cells.empty()) return std::nullopt;
    const auto known = layers_.find(sequence);
    if (known == layers_.end()) {
        if (std::optional<Error> error = CheckSplitLayers(scene_, layers_.size() + 1)) return error;
    }
    std::vector<TiledGhost> alone;
    alone.push_back(std::move(ghost));
    scratch_.Clear();
    scratch_.Draw(alone, map, work);
    ghost = std::move(alone.front());
    LayerPlanes planes = scratch_.Resolve(1.0);
    if (known == layers_.end()) {
        layers_.emplace(sequence, std::move(planes));
        return std::nullopt;
    }
    for (std::size_t c = 0; c < planes.size(); ++c) {
        float* const sum = known->second[c].data();
        for (std::size_t k = 0; k < planes[c].size(); ++k) sum[k] += planes[c][k];
    }
    return std::nullopt;
}

void GhostSplit::AppendTo(FlareImage& image, double scale) {
    for (auto& [sequence, planes] : layers_) {
        for (std::vector<float>& plane : planes) {
            for (float& value : plane) value = PlaneValue(static_cast<double>(value) * scale);
        }
        AppendBeside(scene_, "ghosts." + SequenceLabel(sequence), std::move(planes), image);
    }
    layers_.clear();
}

}  // namespace flare
