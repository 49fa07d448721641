// SPDX-License-Identifier: Apache-2.0
#include "core/render/starburst_layer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/units.h"
#include "core/render/mask_outline.h"
#include "core/render/quality.h"
#include "core/render/source_disc.h"
#include "core/spectrum/spectrum.h"
#include "core/spectrum/wavelength_plan.h"
#include "core/tracing/chief_ray.h"

namespace flare {
namespace {

constexpr double kMmPerNm = 1e-6;
constexpr double kTurn_rad = 1e-4;  // of a light, to see how its image moves
constexpr int kRows = 16;           // of a strip
// The near pattern's transform: fringes are resolved up to D k = 0.0375 side.
constexpr int kSide = 1024, kFineSide = 2048;
constexpr double kBluest_nm = 430.0;   // of what counts in a colour
constexpr int kTransmittanceStep = 2;  // samples of the spectrum

// The canonical chief ray's place on the sensor for a light turned by small angles along u and v.
std::optional<Vec2d> TurnedChief(const Lens& lens, const PlacedLight& light, double along_u,
                                 double along_v) {
    const double field = light.field_rad;
    const double azimuth = light.pose.azimuth_rad;
    const Vec2d out(std::cos(azimuth), std::sin(azimuth));
    const double across = std::sin(field) + along_u * std::cos(field);
    const Vec2d travel(across * out.x - along_v * out.y, across * out.y + along_v * out.x);
    const double forward = std::cos(field) - along_u * std::sin(field);
    const bool turned = along_v != 0.0;
    const LightBundle bundle(lens, turned ? std::atan2(travel.length(), forward) : field + along_u,
                             light.inverse_distance,
                             turned ? std::atan2(travel.y, travel.x) : azimuth);
    const std::optional<ChiefRay> chief = FindChiefRay(lens, bundle, kLineD);
    if (!chief) return std::nullopt;
    return chief->sensor_mm;
}

// Millimetres a radian along u and along v, by differences; on one side at the edge of the field.
std::optional<std::array<Vec2d, 2>> SensorScale(const Lens& lens, const PlacedLight& light,
                                                Vec2d chief) {
    const auto slope = [&](double u, double v) -> std::optional<Vec2d> {
        const auto ahead = TurnedChief(lens, light, u * kTurn_rad, v * kTurn_rad);
        const auto behind = TurnedChief(lens, light, -u * kTurn_rad, -v * kTurn_rad);
        if (ahead && behind) return (*ahead - *behind) / (2.0 * kTurn_rad);
        if (behind) return (chief - *behind) / kTurn_rad;
        return std::nullopt;
    };
    const std::optional<Vec2d> along_u = slope(1.0, 0.0);
    if (!along_u) return std::nullopt;
    if (lens.rotational()) {
        // Turning about the axis moves the image on its circle.
        const double s = std::sin(light.field_rad);
        const double v = std::abs(s) < 1e-6 ? along_u->x : chief.x / s;
        return std::array<Vec2d, 2>{Vec2d(along_u->x, 0.0), Vec2d(0.0, v)};
    }
    const std::optional<Vec2d> along_v = slope(0.0, 1.0);
    if (!along_v) return std::nullopt;
    return std::array<Vec2d, 2>{*along_u, *along_v};
}

// A beam's edge with the picture's scale taken out: place over wavelength is then its frequency.
EdgeLoop Scaled(const EdgeLoop& edge, Vec2d along_u, Vec2d along_v) {
    const double determinant = along_u.x * along_v.y - along_u.y * along_v.x;
    EdgeLoop loop;
    loop.smooth = edge.smooth;
    for (const EdgePiece& piece : edge.pieces) {
        EdgePiece& scaled = loop.pieces.emplace_back();
        for (const Vec2d& p : piece) {
            scaled.push_back(
                Vec2d(along_v.y * p.x - along_u.y * p.y, along_u.x * p.y - along_v.x * p.x) /
                determinant);
        }
    }
    if (determinant < 0.0) {
        std::reverse(loop.pieces.begin(), loop.pieces.end());
        for (EdgePiece& piece : loop.pieces) std::reverse(piece.begin(), piece.end());
    }
    return loop;
}

// A disc's image, or that of a shape's cell about its own middle.
SpotSource SpotSourceOf(const SourceCell& shape, double radius_rad, Vec2d along_u, Vec2d along_v) {
    SpotSource source;
    if (shape.patches.empty()) {
        source.ellipse = {along_u * radius_rad, along_v * radius_rad};
        return source;
    }
    // A disc's second moment along an axis is a quarter of its radius squared: the ellipse with
    // these moments is the image of a disc under twice their Cholesky factor.
    const double a = 2.0 * std::sqrt(shape.xx);
    const double b = 4.0 * shape.xy / a;
    const double c = std::sqrt(std::max(0.0, 4.0 * shape.yy - b * b));
    source.ellipse = {along_u * a + along_v * b, along_v * c};
    source.patches = shape.patches;
    for (SourcePatch& patch : source.patches) {
        for (Vec2d& p : patch.outline) p = along_u * p.x + along_v * p.y;
    }
    return source;
}

// A number in -1..1 for the turn `index` of an unsteady iris (SplitMix64).
double TurnShare(std::uint64_t seed, std::uint64_t index) {
    std::uint64_t z = seed + (index + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    z ^= z >> 31;
    return static_cast<double>(z >> 11) * 0x1.0p-52 - 1.0;
}

double EdgeLengthOf(const ApertureOutline& outline) {
    double length = 0.0;
    for (const EdgeLoop& loop : outline) {
        for (const EdgePiece& piece : loop.pieces) {
            for (std::size_t i = 1; i < piece.size(); ++i) {
                length += (piece[i] - piece[i - 1]).length();
            }
        }
    }
    return length;
}

}  // namespace

Vec2d StarburstLayer::Spot::PlaceAt(double wavelength_nm) const {
    const std::vector<double> weights = NodeWeights(nodes_nm, wavelength_nm);
    Vec2d place(0.0, 0.0);
    for (std::size_t i = 0; i < weights.size(); ++i) place += places[i] * weights[i];
    return place;
}

StarburstLayer::StarburstLayer(const FlareRequest& request, double opening_semi_diameter_mm,
                               const PixelWindow& window, double least_light)
    : request_(request),
      opening_semi_diameter_mm_(opening_semi_diameter_mm),
      window_(window),
      least_light_(least_light),
      spectral_(request.color == ColorMode::kSpectral) {
    planes_.assign(spectral_ ? request.wavelengths_nm.size() : 3,
                   std::vector<double>(window.pixels(), 0.0));
    facts_.core = request.starburst.core && !request.layers.bokeh;
}

bool StarburstLayer::PlaceSpot(const PlacedLight& light, const LightBundle& bundle,
                               Spot& spot) const {
    const Lens& lens = *request_.lens;
    const PictureMap map = MapOf(request_, light.pose);
    const auto pixel = [&](Vec2d sensor) {
        return map.offset_px + map.px_per_x * sensor.x + map.px_per_y * sensor.y;
    };
    const std::optional<ChiefRay> chief = FindChiefRay(lens, bundle, kLineD);
    if (!chief) return false;
    spot.middle = pixel(chief->sensor_mm);
    spot.nodes_nm = ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, 3);
    if (spectral_) spot.nodes_nm = request_.wavelengths_nm;
    for (const double wavelength_nm : spot.nodes_nm) {
        const std::optional<ChiefRay> coloured = FindChiefRay(lens, bundle, wavelength_nm);
        spot.places.push_back(pixel(coloured ? coloured->sensor_mm : chief->sensor_mm));
    }
    const auto scale = SensorScale(lens, light, chief->sensor_mm);
    if (!scale) return false;
    const auto turned = [&](Vec2d v) { return map.px_per_x * v.x + map.px_per_y * v.y; };
    spot.along_u = turned((*scale)[0]);
    spot.along_v = turned((*scale)[1]);
    return std::abs(spot.along_u.x * spot.along_v.y - spot.along_u.y * spot.along_v.x) > 0.0;
}

// The outlines of all turns of the iris; the beam of the unturned one, if any light passes.
std::optional<BeamOutline> StarburstLayer::AddOutlines(const PlacedLight& light,
                                                       const LightBundle& bundle, Spot& spot,
                                                       ThreadPool& threads) const {
    const Lens& lens = *request_.lens;
    const double rim =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    const StarburstSpec& spec = request_.starburst;
    const bool unsteady = spec.jitter_deg > 0.0 && (request_.iris.blades > 0 || request_.iris.mask);
    const int turns = unsteady ? spec.jitter_count : 1;
    std::optional<BeamOutline> first;
    for (int turn = 0; turn < turns; ++turn) {
        IrisShape shape = request_.iris;
        if (unsteady) {
            shape.rotation_deg +=
                spec.jitter_deg * TurnShare(spec.seed, static_cast<std::uint64_t>(turn));
        }
        const Iris iris(shape, opening_semi_diameter_mm_, rim);
        std::optional<BeamOutline> beam =
            FindBeamOutline(lens, bundle, light.pose, iris, kLineD, threads);
        if (!beam) continue;
        ApertureOutline outline = {beam->edge};
        double area_mm2 = beam->area_mm2;
        if (iris.picture() != nullptr) {
            outline =
                FindMaskOutline(lens, bundle, light.pose, *iris.picture(), *beam, kLineD, threads);
            area_mm2 = AreaOf(outline);
            if (!(area_mm2 > 0.0)) continue;
        }
        spot.area_mm2 += area_mm2 / turns;
        for (EdgeLoop& loop : outline) loop = Scaled(loop, spot.along_u, spot.along_v);
        spot.outlines.push_back(std::move(outline));
        if (!first) first = std::move(beam);
    }
    return first;
}

std::vector<SpotBand> StarburstLayer::BandsOf(const PlacedLight& light, const LightBundle& bundle,
                                              const BeamOutline& beam, const Spot& spot,
                                              ThreadPool& threads) const {
    const Lens& lens = *request_.lens;
    const std::vector<double> nodes =
        spectral_ ? request_.wavelengths_nm
                  : EvenInWavelength(kSpectrumFirst_nm, SampleWavelength(kSpectrumSamples - 1),
                                     (kSpectrumSamples - 1) / kTransmittanceStep + 1);
    std::vector<double> passed(nodes.size());
    threads.For(static_cast<int>(nodes.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        passed[n] = BeamTransmittance(lens, bundle, beam, nodes[n]) * spot.area_mm2;
    });
    std::vector<SpotBand> bands;
    if (spectral_) {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            bands.push_back({{nodes[i] * kMmPerNm, Vec3d(light.irradiance.x * passed[i], 0.0, 0.0)},
                             spot.places[i]});
        }
        return bands;
    }
    const Spectrum power = PowerOf(light);
    const ColorResponse& response = ResponseOf(request_);
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const auto n = static_cast<std::size_t>(i);
        const std::size_t node = std::min(n / kTransmittanceStep, nodes.size() - 2);
        const double t = (static_cast<double>(n) - static_cast<double>(node * kTransmittanceStep)) /
                         kTransmittanceStep;
        const double through = passed[node] * (1.0 - t) + passed[node + 1] * t;
        bands.push_back({{SampleWavelength(i) * kMmPerNm, response[n] * (power[n] * through)},
                         spot.PlaceAt(SampleWavelength(i))});
    }
    return bands;
}

void StarburstLayer::Add(const PlacedLight& light, ThreadPool& threads, const CancelToken& cancel) {
    const Vec3d& e = light.irradiance;
    if (e.x == 0.0 && e.y == 0.0 && e.z == 0.0) return;
    if (!light.shape) {
        AddSpot(light, {}, threads, cancel);
        return;
    }
    const SourceDisc whole(*request_.lens, light);
    const PlacedLight middle = whole.LightOf(SourceSquare());
    AddSpot(middle, whole.CellOf(SourceSquare(), middle), threads, cancel);
}

void StarburstLayer::AddSpot(const PlacedLight& light, const SourceCell& shape, ThreadPool& threads,
                             const CancelToken& cancel) {
    const Vec3d& e = light.irradiance;
    const LightBundle bundle = BundleOf(*request_.lens, light);
    Spot spot;
    if (!PlaceSpot(light, bundle, spot)) return;
    const std::optional<BeamOutline> beam = AddOutlines(light, bundle, spot, threads);
    if (!beam || cancel.cancelled()) return;
    const std::vector<SpotBand> bands = BandsOf(light, bundle, *beam, spot, threads);
    const bool fine =
        request_.quality == QualityPreset::kFinal || request_.quality == QualityPreset::kReference;
    const NearPattern near(spot.outlines, fine ? kFineSide : kSide, !facts_.core, threads);
    const double radius = 0.5 * light.angular_diameter_rad;
    const SpotSource source = SpotSourceOf(shape, radius, spot.along_u, spot.along_v);

    const double flux =
        spectral_ ? bands.front().band.weight.x / e.x
                  : BeamTransmittance(*request_.lens, bundle, *beam, kLineD) * spot.area_mm2;
    facts_.core_share =
        (facts_.core_share * facts_.flux_mm2 + near.core_share() * flux) / (facts_.flux_mm2 + flux);
    facts_.flux_mm2 += flux;
    ++facts_.lights;

    const PixelWindow seen = SeenOf(spot, bands, source, flux);
    if (seen.pixels() == 0) return;
    const auto draw = [&](const std::vector<SpotBand>& of, Vec2d middle, double shortest_mm,
                          std::size_t plane) {
        const SpotPattern pattern(spot.outlines, near, of, source, middle,
                                  near.limit() * shortest_mm, threads);
        Draw(pattern, seen, plane, threads, cancel);
    };
    if (!spectral_) {
        draw(bands, spot.middle, kBluest_nm * kMmPerNm, 0);
        return;
    }
    for (std::size_t i = 0; i < bands.size() && !cancel.cancelled(); ++i) {
        draw({bands[i]}, bands[i].middle, bands[i].band.wavelength, i);
    }
}

void StarburstLayer::Draw(const SpotPattern& pattern, const PixelWindow& window,
                          std::size_t first_plane, ThreadPool& threads, const CancelToken& cancel) {
    threads.For((window.height + kRows - 1) / kRows, [&](int strip) {
        if (cancel.cancelled()) return;
        const int row = strip * kRows;
        const PixelWindow part{window.x, window.y + row, window.width,
                               std::min(kRows, window.height - row)};
        const std::vector<Vec3d> light = pattern.Light(part);
        const auto width = static_cast<std::size_t>(window.width);
        const std::size_t corner =
            static_cast<std::size_t>(part.y - window_.y) * static_cast<std::size_t>(window_.width) +
            static_cast<std::size_t>(part.x - window_.x);
        for (std::size_t k = 0; k < light.size(); ++k) {
            const std::size_t at =
                corner + k / width * static_cast<std::size_t>(window_.width) + k % width;
            planes_[first_plane][at] += light[k].x;
            if (spectral_) continue;
            planes_[first_plane + 1][at] += light[k].y;
            planes_[first_plane + 2][at] += light[k].z;
        }
    });
}

// By the theorem of Gauss the transform of an aperture is an integral over its edge, and so no
// larger than the edge's length over 2 pi and the frequency. At r pixels from its middle a pattern
// of light w hence has at most w L^2 / (4 pi^2 A r^2) a pixel, whatever the wavelength; L and A are
// the edge and area of the outline that pixels over wavelengths are the frequencies of.
PixelWindow StarburstLayer::SeenOf(const Spot& spot, const std::vector<SpotBand>& bands,
                                   const SpotSource& source, double flux_mm2) {
    if (!(least_light_ > 0.0)) return window_;
    double most_edge = 0.0, least_area = std::numeric_limits<double>::infinity();
    for (const ApertureOutline& outline : spot.outlines) {
        most_edge = std::max(most_edge, EdgeLengthOf(outline));
        least_area = std::min(least_area, AreaOf(outline));
    }
    const double tail = most_edge * most_edge / (4.0 * kPi * kPi * least_area);
    Vec3d light(0.0, 0.0, 0.0);
    Vec2d lo = bands.front().middle, hi = lo;
    for (const SpotBand& band : bands) {
        const Vec3d& w = band.band.weight;
        light += Vec3d(std::abs(w.x), std::abs(w.y), std::abs(w.z));
        lo = Vec2d(std::min(lo.x, band.middle.x), std::min(lo.y, band.middle.y));
        hi = Vec2d(std::max(hi.x, band.middle.x), std::max(hi.y, band.middle.y));
    }
    const double most = spectral_ ? light.x : std::max({light.x, light.y, light.z});
    const double radius = std::sqrt(tail * most / least_light_);
    // A pixel ends half a diagonal from its middle, the source at its edge.
    const double reach = radius + 1.0 + source.reach();
    const auto from = [&](double at, int first, int size) {
        return static_cast<int>(
            std::clamp(std::floor(at - reach), 0.0 + first, 0.0 + first + size));
    };
    const auto to = [&](double at, int first, int size) {
        return static_cast<int>(std::clamp(std::ceil(at + reach), 0.0 + first, 0.0 + first + size));
    };
    const int x = from(lo.x, window_.x, window_.width), y = from(lo.y, window_.y, window_.height);
    PixelWindow seen{x, y, to(hi.x, window_.x, window_.width) - x,
                     to(hi.y, window_.y, window_.height) - y};
    if (seen.width <= 0 || seen.height <= 0) seen.width = seen.height = 0;
    if (seen.pixels() == window_.pixels()) return window_;
    ++unseen_.count;
    unseen_.peak += least_light_;
    unseen_.flux_mm2 +=
        flux_mm2 * std::min(1.0, tail / (radius * radius) *
                                     static_cast<double>(window_.pixels() - seen.pixels()));
    return seen;
}

LayerPlanes StarburstLayer::Resolve(double scale) const {
    LayerPlanes planes;
    for (const std::vector<double>& light : planes_) {
        std::vector<float>& plane = planes.emplace_back(light.size());
        for (std::size_t k = 0; k < light.size(); ++k) plane[k] = PlaneValue(light[k] * scale);
    }
    return planes;
}

void StarburstLayer::Clear() {
    for (std::vector<double>& light : planes_) std::fill(light.begin(), light.end(), 0.0);
}

}  // namespace flare
