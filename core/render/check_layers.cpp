// SPDX-License-Identifier: Apache-2.0
#include "core/render/check_layers.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/tracing/bounce_sequence.h"

namespace flare {
namespace {

Error Bad(std::string where, std::string message, std::string code = "bad_value") {
    return {std::move(code), std::move(message), std::move(where)};
}

std::optional<Error> CheckVisible(const FlareRequest& request) {
    if (!request.visible) return std::nullopt;
    if (!(std::abs(request.visible->exposure_stops) <= kMaxExposure_stops)) {
        return Bad("/visible/exposure_stops", "must be within +-60");
    }
    const double floor = request.visible->noise_floor;
    if (!(floor > 0.0 && floor <= kMaxNoiseFloor)) {
        return Bad("/visible/noise_floor", "must be above 0 and at most 1e30");
    }
    if (request.photon) {
        return Bad("/visible", "photons draw every ghost", "unsupported");
    }
    if (!request.layers.ghosts && !request.layers.starburst) {
        return Bad("/visible", "nothing of a bokeh layer is left out", "unsupported");
    }
    // What ghosts are sampled for is the frame.
    if (request.image.overscan != std::array<int, 4>{}) {
        return Bad("/visible", "cannot be told beyond the frame, with overscan", "unsupported");
    }
    return std::nullopt;
}

std::optional<Error> CheckSplit(const FlareRequest& request) {
    if (request.photon && request.split != SplitBy::kNone) {
        return Bad("/split", "a picture by photons cannot be split", "unsupported");
    }
    if (request.photon && !request.artist.empty()) {
        return Bad("/artist", "a picture by photons is as it is", "unsupported");
    }
    if (request.split == SplitBy::kGhost && !request.layers.ghosts) {
        return Bad("/split", "there is no layer of ghosts to split");
    }
    const auto disc = std::find_if(request.lights.begin(), request.lights.end(),
                                   [](const auto& l) { return l.angular_diameter_deg > 0.0; });
    if (request.split == SplitBy::kGhost && disc != request.lights.end()) {
        return Bad("/split", "ghosts of lights that are no points cannot be told apart",
                   "unsupported");
    }
    if (request.split == SplitBy::kLight && request.lights.size() > kMaxSplitLayers) {
        return Bad("/split", "at most " + std::to_string(kMaxSplitLayers) + " lights can be split",
                   "limit");
    }
    return std::nullopt;
}

// Is it a ghost that this request may render?
bool IsGhost(const FlareRequest& request, const BounceSequence& sequence) {
    const std::size_t most = request.model.reflections == 4 ? 4 : 2;
    if (sequence.size() != 2 && sequence.size() != most) return false;
    if (CheckSequence(*request.lens, sequence)) return false;
    const std::vector<int> reflecting =
        ReflectingSurfaces(*request.lens, request.model.sensor_reflection);
    return std::all_of(sequence.begin(), sequence.end(), [&](int surface) {
        return std::find(reflecting.begin(), reflecting.end(), surface) != reflecting.end();
    });
}

std::optional<Error> CheckArtistGhost(const FlareRequest& request, const ArtistGhost& ghost,
                                      const std::string& place) {
    if (!IsGhost(request, ghost.sequence)) {
        return Bad(place + "/sequence",
                   "the lens \"" + request.lens->name() + "\" has no such ghost in this request");
    }
    if (!(ghost.gain >= 0.0 && ghost.gain <= kMaxArtistGain)) {
        return Bad(place + "/gain", "must be 0 to 1000000");
    }
    const Vec3d& tint = ghost.tint;
    for (const double channel : {tint.x, tint.y, tint.z}) {
        if (!(channel >= 0.0 && channel <= kMaxArtistGain)) {
            return Bad(place + "/tint", "must be 0 to 1000000 in each channel");
        }
    }
    if (request.color == ColorMode::kSpectral && tint != Vec3d(1.0, 1.0, 1.0)) {
        return Bad(place + "/tint", "a spectral picture has no red, green and blue to tint");
    }
    return std::nullopt;
}

std::optional<Error> CheckArtist(const FlareRequest& request) {
    if (request.artist.empty()) return std::nullopt;
    if (!request.layers.ghosts) return Bad("/artist", "there is no layer of ghosts");
    if (request.artist.size() > kMaxArtistGhosts) {
        return Bad("/artist/ghosts", "at most " + std::to_string(kMaxArtistGhosts) + " ghosts",
                   "limit");
    }
    std::set<BounceSequence> seen;
    for (std::size_t i = 0; i < request.artist.size(); ++i) {
        const std::string place = "/artist/ghosts/" + std::to_string(i);
        const ArtistGhost& ghost = request.artist[i];
        if (std::optional<Error> error = CheckArtistGhost(request, ghost, place)) return error;
        if (!seen.insert(ghost.sequence).second) {
            return Bad(place + "/sequence", "the ghost is named twice");
        }
    }
    return std::nullopt;
}

}  // namespace

std::optional<Error> CheckLayers(const FlareRequest& request) {
    if (std::optional<Error> error = CheckSplit(request)) return error;
    if (std::optional<Error> error = CheckVisible(request)) return error;
    return CheckArtist(request);
}

}  // namespace flare
