// SPDX-License-Identifier: Apache-2.0
//
// The pilot has random numbers of its own, so that where samples go does not depend on what they
// find: the estimate stays unbiased.
#include "core/render/photon_layer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/units.h"
#include "core/render/layer_planes.h"

namespace flare {
namespace {

constexpr int kPilot = kPhotonReplicates;  // its place among the random streams
constexpr int kPilotShare = 64;            // samples for one of the pilot's
constexpr double kLeastPilot = 512.0;
constexpr double kEvenShare = 0.25;
constexpr int kSamplesPerItem = 1 << 14;
constexpr std::size_t kItemsAtOnce = 64;
constexpr std::size_t kMostPhotons = std::size_t{1} << 22;  // kept for "nearest"

}  // namespace

PhotonLayer::PhotonLayer(const RenderScene& scene, const RenderContext& context, Report& report)
    : scene_(scene),
      context_(context),
      report_(report),
      spec_(*scene.request.photon),
      sensor_(SensorMapOf(scene.request)),
      sequences_(TwoReflectionSequences(scene.lens, scene.request.model.sensor_reflection)),
      map_(scene.window, scene.spectral() ? 1 : 3, spec_),
      sum_(scene.window.pixels() * scene.channel_count(), 0.0),
      squares_(sum_.size(), 0.0) {
    for (const BounceSequence& sequence : sequences_) {
        report_.facts.ghosts.push_back({sequence, "photon", 0.0, {}});
    }
}

void PhotonLayer::Add(const PlacedLight& light, bool reported) {
    const Vec3d& e = light.irradiance;
    if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return;
    Lamp lamp{PhotonSource(scene_.lens, light), {}, e.x, reported, {}, {}};
    if (!scene_.spectral()) lamp.colors = ColorsOf(PowerOf(light), ResponseOf(scene_.request));
    lamps_.push_back(std::move(lamp));
}

std::vector<PhotonLayer::Item> PhotonLayer::Items() const {
    std::vector<Item> items;
    for (std::size_t l = 0; l < lamps_.size(); ++l) {
        for (std::size_t s = 0; s < sequences_.size(); ++s) {
            const std::int64_t count = lamps_[l].strata[s].count(lamps_[l].regions[s]);
            for (std::int64_t first = 0; first < count; first += kSamplesPerItem) {
                const std::int64_t left = std::min<std::int64_t>(kSamplesPerItem, count - first);
                items.push_back({l, s, first, static_cast<int>(left)});
            }
        }
    }
    return items;
}

void PhotonLayer::Trace(int replicate, std::size_t channel, const ColorsOfLamp& colors,
                        const Take& take) {
    const std::vector<Item> items = Items();
    std::vector<LandedPhotons> landed(std::min(kItemsAtOnce, items.size()));
    for (std::size_t begin = 0; begin < items.size(); begin += kItemsAtOnce) {
        const std::size_t count = std::min(kItemsAtOnce, items.size() - begin);
        context_.threads.For(static_cast<int>(count), [&](int i) {
            const auto n = static_cast<std::size_t>(i);
            if (context_.cancel.cancelled()) return;
            const Item& item = items[begin + n];
            const Lamp& lamp = lamps_[item.lamp];
            // At most 2^17 lights, 2^5 replicates and 2^10 wavelengths.
            const std::size_t stream =
                item.lamp << 15 | static_cast<std::size_t>(replicate) << 10 | channel;
            const PhotonBatch batch{
                lamp.source,
                colors(lamp),
                sequences_[item.sequence],
                lamp.regions[item.sequence],
                spec_.seed,
                {static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(item.sequence)},
                lamp.strata[item.sequence],
                item.first,
                item.count};
            landed[n] = TracePhotons(scene_.lens, scene_.iris, batch, sensor_, scene_.window,
                                     map_.margin());
        });
        if (context_.cancel.cancelled()) return;
        for (std::size_t n = 0; n < count; ++n) {
            report_.work.rays_traced += static_cast<std::uint64_t>(items[begin + n].count);
            take(items[begin + n], landed[n]);
        }
    }
}

void PhotonLayer::FindRegions() {
    const std::size_t ghosts = sequences_.size();
    std::vector<std::optional<PhotonRegion>> found(ghosts);
    for (Lamp& lamp : lamps_) {
        context_.threads.For(static_cast<int>(ghosts), [&](int i) {
            const auto s = static_cast<std::size_t>(i);
            if (context_.cancel.cancelled()) return;
            found[s].emplace(scene_.lens, scene_.iris, sequences_[s], lamp.source);
        });
        if (context_.cancel.cancelled()) return;
        for (std::optional<PhotonRegion>& region : found) {
            report_.work.sampled_rays += region->rays();
            lamp.regions.push_back(std::move(*region));
        }
    }
}

void PhotonLayer::Pilot() {
    const double samples = static_cast<double>(spec_.samples);
    const auto ghosts = sequences_.size();
    for (Lamp& lamp : lamps_) {
        for (const PhotonRegion& region : lamp.regions) {
            lamp.strata.push_back(
                PhotonStrata::For(std::max(kLeastPilot, samples / kPilotShare), region));
        }
    }
    const PhotonColors one =
        OneWavelength(scene_.spectral() ? scene_.request.wavelengths_nm.front() : kLineD, 1.0);
    std::vector<double> flux(lamps_.size() * ghosts, 0.0);
    Trace(
        kPilot, 0, [&](const Lamp&) -> const PhotonColors& { return one; },
        [&](const Item& item, const LandedPhotons& landed) {
            flux[item.lamp * ghosts + item.sequence] += landed.flux_mm2;
        });
    for (std::size_t l = 0; l < lamps_.size(); ++l) {
        double all = 0.0;
        for (std::size_t s = 0; s < ghosts; ++s) all += flux[l * ghosts + s];
        for (std::size_t s = 0; s < ghosts; ++s) {
            const double found = flux[l * ghosts + s];
            const double share = all > 0.0 ? kEvenShare / static_cast<double>(ghosts) +
                                                 (1.0 - kEvenShare) * found / all
                                           : 1.0 / static_cast<double>(ghosts);
            lamps_[l].strata[s] =
                PhotonStrata::For(samples * static_cast<double>(ghosts) * share / kPhotonReplicates,
                                  lamps_[l].regions[s]);
            if (lamps_[l].reported) report_.facts.ghosts[s].flux_mm2 += found;
        }
    }
}

void PhotonLayer::AddReplicate(int replicate, std::size_t channel) {
    map_.Clear();
    std::vector<PhotonColors> spectral;  // of each lamp
    if (scene_.spectral()) {
        for (const Lamp& lamp : lamps_) {
            spectral.push_back(
                OneWavelength(scene_.request.wavelengths_nm[channel], lamp.irradiance));
        }
    }
    std::size_t kept = 0;
    Trace(
        replicate, channel,
        [&](const Lamp& lamp) -> const PhotonColors& {
            return spectral.empty() ? lamp.colors
                                    : spectral[static_cast<std::size_t>(&lamp - lamps_.data())];
        },
        [&](const Item&, const LandedPhotons& landed) {
            landed_ += landed.photons.size();
            kept += landed.photons.size();
            too_many_ =
                too_many_ || (spec_.estimate == PhotonEstimate::kNearest && kept > kMostPhotons);
            if (!too_many_) map_.Add(landed.photons);
        });
    if (too_many_ || context_.cancel.cancelled()) return;
    const std::vector<double>& light = map_.Light(context_.threads, context_.cancel);
    const std::size_t first = channel * scene_.window.pixels();
    for (std::size_t i = 0; i < light.size(); ++i) {
        sum_[first + i] += light[i];
        squares_[first + i] += light[i] * light[i];
    }
}

std::optional<Error> PhotonLayer::Run() {
    const double before = context_.now_ms();
    if (!lamps_.empty() && !sequences_.empty()) {
        FindRegions();
        if (!context_.cancel.cancelled()) Pilot();
        const std::size_t passes = scene_.spectral() ? scene_.channel_count() : 1;
        for (int replicate = 0; replicate < kPhotonReplicates; ++replicate) {
            for (std::size_t channel = 0; channel < passes; ++channel) {
                if (context_.cancel.cancelled()) break;
                AddReplicate(replicate, channel);
                if (too_many_) {
                    return Error{"limit",
                                 "more photons reach the picture than the estimate \"nearest\" has "
                                 "room for: " +
                                     std::to_string(kMostPhotons) +
                                     " in a sixteenth of the samples",
                                 "/quality/samples"};
                }
            }
        }
    }
    if (context_.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    SetFacts();
    report_.work.mesh_ms += context_.now_ms() - before;
    return std::nullopt;
}

double PhotonLayer::Mean(std::size_t at) const {
    return sum_[at] / kPhotonReplicates;
}

double PhotonLayer::StandardError(std::size_t at) const {
    const double spread = squares_[at] - sum_[at] * sum_[at] / kPhotonReplicates;
    return std::sqrt(std::max(0.0, spread) / (kPhotonReplicates * (kPhotonReplicates - 1.0)));
}

void PhotonLayer::SetFacts() {
    double light = 0.0, error = 0.0;
    for (std::size_t i = 0; i < sum_.size(); ++i) {
        light += std::abs(Mean(i));
        error += StandardError(i);
    }
    PhotonFacts& facts = report_.facts.photon.emplace();
    facts.rays = report_.work.rays_traced;
    facts.landed = landed_;
    // The mean of |x| of a normal x is sqrt(2 / pi) of its standard deviation.
    facts.rel_l1 = light > 0.0 ? std::sqrt(2.0 / kPi) * error / light : 0.0;
    report_.facts.estimated_error.rel_l1 = facts.rel_l1;
}

std::vector<std::vector<float>> PhotonLayer::Resolve(double scale) const {
    const std::size_t pixels = scene_.window.pixels();
    std::vector<std::vector<float>> planes(scene_.channel_count());
    for (std::size_t c = 0; c < planes.size(); ++c) {
        for (std::size_t i = 0; i < pixels; ++i) {
            planes[c].push_back(PlaneValue(Mean(c * pixels + i) * scale));
        }
    }
    return planes;
}

void PhotonLayer::AppendErrorTo(FlareImage& image, double scale) const {
    const std::size_t pixels = scene_.window.pixels();
    LayerPlanes planes(scene_.channel_count());
    for (std::size_t c = 0; c < planes.size(); ++c) {
        for (std::size_t i = 0; i < pixels; ++i) {
            planes[c].push_back(PlaneValue(StandardError(c * pixels + i) * scale));
        }
    }
    AppendBeside(scene_, "photon_error", std::move(planes), image);
}

}  // namespace flare
