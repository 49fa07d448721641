// SPDX-License-Identifier: Apache-2.0
//
// The two tracers against each other, in speed and in place: all two-reflection ghosts of a lens,
// rays over each ghost's own pass region at 5 degrees, bare glass.
//
//   trace_bench [LENS FILE] ...
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/mesh/pass_region.h"
#include "core/tracing/trace_columns.h"
#include "server/lens_library.h"

namespace flare {
namespace {

double Now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

struct Tally {
    double reference_s = 0.0, columns_s = 0.0, ray_surfaces = 0.0;
    std::vector<double> miss_mm;
    std::size_t fates = 0, differ = 0, far_from_rim = 0, rays = 0;
    double worst_ghost_p999 = 0.0;
    BounceSequence worst;
};

void Ghost(const Lens& lens, const LightBundle& bundle, const BounceSequence& sequence, int side,
           Tally& tally) {
    const InteractionList list = WriteOut(lens, sequence, kLineD);
    const PassRegion region = FindPassRegion({list}, bundle);
    if (!region.rect) return;
    const Rect& r = *region.rect;
    RayColumns rays;
    rays.Resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    std::vector<Ray> exact;
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            const Ray ray = bundle.AtFront(r.u0 + (r.u1 - r.u0) * (i + 0.5) / side,
                                           r.v0 + (r.v1 - r.v0) * (j + 0.5) / side);
            rays.Set(exact.size(), ray.origin, ray.direction);
            exact.push_back(ray);
        }
    }
    TraceColumns out;
    ColumnNeeds needs;
    TraceInColumns(list, rays, needs, out);
    const double t0 = Now();
    for (int k = 0; k < 8; ++k) TraceInColumns(list, rays, needs, out);
    tally.columns_s += (Now() - t0) / 8.0;

    InteractionList to_vertex = list;
    to_vertex.sensor_z_mm = lens.surfaces().back().vertex_z_mm;
    TraceOptions options;
    options.clip = false;
    RayRecord record;
    std::vector<TraceResult> results;
    const double t1 = Now();
    for (const Ray& ray : exact) results.push_back(TraceRay(to_vertex, ray, options, &record));
    tally.reference_s += Now() - t1;
    tally.ray_surfaces += static_cast<double>(exact.size() * list.steps.size());

    std::vector<double> miss;
    for (std::size_t k = 0; k < exact.size(); ++k) {
        const TraceResult& a = results[k];
        const bool lives = out.ended_at[k] == TraceColumns::kArrived &&
                           out.fate[k] == static_cast<std::uint8_t>(RayFate::kArrived);
        ++tally.fates;
        if (lives != (a.fate == RayFate::kArrived)) ++tally.differ;
        if (!lives || a.fate != RayFate::kArrived || a.max_rim_ratio2 > 1.0) continue;
        const double gap = lens.sensor_gap_mm();
        const double x =
            static_cast<double>(out.exit_x[k]) + gap * static_cast<double>(out.slope_x[k]);
        const double y =
            static_cast<double>(out.exit_y[k]) + gap * static_cast<double>(out.slope_y[k]);
        const double ex = a.sensor_mm.x + gap * a.exit_direction.x / a.exit_direction.z;
        const double ey = a.sensor_mm.y + gap * a.exit_direction.y / a.exit_direction.z;
        if (std::abs(ex) > 40.0 || std::abs(ey) > 40.0) continue;
        miss.push_back(std::hypot(x - ex, y - ey));
    }
    if (miss.empty()) return;
    std::sort(miss.begin(), miss.end());
    const double p999 = miss[miss.size() * 999 / 1000];
    if (p999 > tally.worst_ghost_p999) {
        tally.worst_ghost_p999 = p999;
        tally.worst = sequence;
    }
    tally.miss_mm.insert(tally.miss_mm.end(), miss.begin(), miss.end());
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using namespace flare;
    std::printf("arithmetic %s\n", ArithmeticClass().c_str());
    for (int n = 1; n < argc; ++n) {
        const auto lens = LoadLensFile(argv[n]);
        if (!lens) continue;
        const auto bare = (*lens)->WithBareGlass();
        const LightBundle bundle(*bare, 0.0872664625997165, 0.0, bare->rotational() ? 0.0 : 0.5);
        Tally tally;
        for (const BounceSequence& s : TwoReflectionSequences(*bare))
            Ghost(*bare, bundle, s, 64, tally);
        std::sort(tally.miss_mm.begin(), tally.miss_mm.end());
        const auto p = [&](double share) {
            return tally.miss_mm.empty()
                       ? 0.0
                       : tally.miss_mm[static_cast<std::size_t>(
                             share * static_cast<double>(tally.miss_mm.size() - 1))] /
                             0.01875;
        };
        std::printf(
            "%-34s %6.1f M/s reference %7.1f M/s columns %5.1fx; px: median %.5f p99.9 %.5f max "
            "%.4f, worst ghost p99.9 %.4f (%d,%d); fates differ %.2e\n",
            bare->name().c_str(), tally.ray_surfaces / tally.reference_s / 1e6,
            tally.ray_surfaces / tally.columns_s / 1e6, tally.reference_s / tally.columns_s, p(0.5),
            p(0.999), p(1.0), tally.worst_ghost_p999 / 0.01875,
            tally.worst.empty() ? -1 : tally.worst[0], tally.worst.empty() ? -1 : tally.worst[1],
            static_cast<double>(tally.differ) / static_cast<double>(tally.fates));
    }
}
