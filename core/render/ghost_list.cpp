// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_list.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/image/raster_sink.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/ghost_choice.h"
#include "core/render/ghost_flux.h"
#include "core/render/ghost_light.h"
#include "core/tracing/paraxial_ghost.h"

namespace flare {
namespace {

constexpr double kFarthestPeak_mm = 150.0;  // peaks are looked for this far from the axis

// The ranked list is a measurement, not a preview: a finer mesh and finer masks.
constexpr int kCells = 64;
constexpr int kPatchCells = 8;
constexpr double kPositionTolerance_mm = 0.02;
constexpr double kMaskTolerance = 0.002;
constexpr double kCosineTolerance = 2e-4;
constexpr WalkTolerance kTolerance{0.05, 0.02, 1.0, 12.0, 0.03};
// A peak lies in a small bright place; the wide dim parts need no care.
constexpr WalkTolerance kPeakTolerance{0.3, 0.15, 1.0, 64.0, 0.15};

GhostSection SectionOf(const Lens& lens, const BounceSequence& sequence, Section section) {
    const ParaxialPath path = ParaxialPathOf(WriteOut(lens, sequence, kLineD), section);
    GhostSection out;
    out.abcd = path.front_to_sensor;
    for (std::size_t i = 0; i < path.front_to_stop.size(); ++i) {
        GhostCrossing crossing;
        crossing.a1 = path.front_to_stop[i].a;
        crossing.m = out.abcd.a / crossing.a1;
        crossing.z_eff_mm = path.stop_to_sensor[i].b / crossing.m;
        out.crossings.push_back(crossing);
        const auto largest = static_cast<std::size_t>(out.largest_crossing);
        if (std::abs(crossing.a1) > std::abs(out.crossings[largest].a1)) {
            out.largest_crossing = static_cast<int>(i);
        }
    }
    return out;
}

// The brightest 18.75 um pixel, drawn strip by strip so that a ghost of any size needs little
// memory.
double PeakOf(const std::shared_ptr<const GhostSurface>& surface, const LightBundle& bundle,
              const Lens& lens, const TransmissionTables& tables, const Iris& iris,
              const CancelToken& cancel) {
    PictureMap map;
    map.px_per_x = {1.0 / kPeakPixel_mm, 0.0};
    map.px_per_y = {0.0, 1.0 / kPeakPixel_mm};
    map.offset_px = {0.0, 0.0};
    LightColour colour;
    colour.spectral = true;
    const double reach = kFarthestPeak_mm / kPeakPixel_mm;
    const GhostLight prepared = PrepareGhost(surface, bundle, lens, tables, colour,
                                             CellsInWindow(*surface, tables.wavelengths_nm(), iris,
                                                           map, {-reach, -reach, reach, reach}));
    if (prepared.cells.empty()) return 0.0;
    double y0 = 1e300;
    double y1 = -1e300;
    for (const GhostLight::Cell& cell : prepared.cells) {
        y0 = std::min(y0, cell.y0);
        y1 = std::max(y1, cell.y1);
    }
    constexpr int kRows = 64;
    const int width = 2 * static_cast<int>(reach);
    std::vector<double> plane(static_cast<std::size_t>(width) * kRows);
    RasterTarget target;
    target.layers = {plane.data()};
    target.x0 = -width / 2;
    target.width = width;
    target.rows = kRows;
    GhostWalk walk(prepared, iris, map, kPeakTolerance);
    double peak = 0.0;
    const int first = static_cast<int>(std::floor(std::max(y0, -reach) / kRows)) * kRows;
    for (int row = first; row <= std::min(y1, reach) && !cancel.cancelled(); row += kRows) {
        target.y0 = row;
        std::fill(plane.begin(), plane.end(), 0.0);
        const WalkWindow window{-reach, static_cast<double>(row), reach,
                                static_cast<double>(row + kRows)};
        RasterSink sink(prepared, target);
        for (const GhostLight::Cell& cell : prepared.cells) {
            if (cell.y1 >= window.y0 && cell.y0 <= window.y1) walk.Cell(cell, window, sink);
        }
        peak = std::max(peak, *std::max_element(plane.begin(), plane.end()));
    }
    return peak / (kPeakPixel_mm * kPeakPixel_mm);
}

}  // namespace

Result<GhostList> RankGhosts(const std::shared_ptr<const Lens>& lens,
                             const GhostListOptions& options, const RenderContext& context) {
    if (!(options.field_deg >= 0.0 && options.field_deg <= 180.0)) {
        return Error{"bad_value", "the field angle must be 0 to 180 degrees", "field_deg"};
    }
    if (!(std::abs(options.azimuth_deg) <= 360.0)) {
        return Error{"bad_value", "the azimuth must be within +-360 degrees", "azimuth_deg"};
    }
    if (options.model.sensor_reflection && !lens->sensor()) {
        return Error{"bad_value", "the lens \"" + lens->name() + "\" has no reflecting sensor",
                     "sensor_reflection"};
    }
    if (!(options.wavelength_nm >= 300.0 && options.wavelength_nm <= 1100.0)) {
        return Error{"bad_value", "the wavelength must be 300 to 1100 nm", "wavelength_nm"};
    }
    if (options.f_number && !(*options.f_number > 0.0 && *options.f_number <= 1e4)) {
        return Error{"bad_value", "the f-number must be above 0 and at most 10000", "f_number"};
    }
    const double rim =
        lens->surfaces()[static_cast<std::size_t>(lens->stop_index())].semi_diameter_mm;
    const double opening =
        options.f_number ? StopForFNumber(*lens, *options.f_number).semi_diameter_mm : rim;
    const Iris iris({}, opening, rim);
    PlacedLight light;
    light.field_rad = RadiansFromDegrees(options.field_deg);
    light.pose = PoseOf(*lens, RadiansFromDegrees(options.azimuth_deg));
    const LightBundle bundle = BundleOf(*lens, light);
    const TransmissionTables tables(*lens, {options.wavelength_nm}, context.threads);
    GhostList list;
    std::vector<BounceSequence> sequences =
        TwoReflectionSequences(*lens, options.model.sensor_reflection);
    if (options.model.reflections == 4) {
        const Result<GhostChoice> four =
            ChooseFourReflections(*lens, options.model, iris, light, context);
        if (!four) return four.error();
        list.four_reflections = four->facts;
        sequences.insert(sequences.end(), four->sequences.begin(), four->sequences.end());
    }

    list.ghosts.resize(sequences.size());
    context.threads.For(static_cast<int>(sequences.size()), [&](int i) {
        if (context.cancel.cancelled()) return;
        GhostEntry& entry = list.ghosts[static_cast<std::size_t>(i)];
        entry.sequence = sequences[static_cast<std::size_t>(i)];
        entry.x = SectionOf(*lens, entry.sequence, Section::kX);
        entry.y = SectionOf(*lens, entry.sequence, Section::kY);
        MeshSpec spec = MeshSpecOf(entry.sequence, light);
        spec.wavelengths_nm = {options.wavelength_nm};
        spec.cells = kCells;
        spec.patch_cells = kPatchCells;
        spec.position_tolerance_mm = kPositionTolerance_mm;
        spec.mask_tolerance = kMaskTolerance;
        spec.cosine_tolerance = kCosineTolerance;
        const auto found = context.meshes.Get(
            MeshKey(*lens, spec), [&] { return BuildMesh(*lens, spec); }, context.cancel);
        if (!found) return;
        const auto surface = std::make_shared<const GhostSurface>(
            found->mesh, lens->sensor_gap_mm(), iris.outer_radius());
        const GhostFlux flux = FluxOf(surface, bundle, *lens, tables, iris, kTolerance);
        entry.flux_mm2 = flux.flux_mm2;
        entry.centroid_mm = light.pose.LensSpace(flux.centroid_mm);
        if (options.with_peaks && flux.flux_mm2 > 0.0) {
            entry.peak_irradiance = PeakOf(surface, bundle, *lens, tables, iris, context.cancel);
        }
    });
    if (context.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    for (const GhostEntry& entry : list.ghosts) list.total_flux_mm2 += entry.flux_mm2;
    std::stable_sort(
        list.ghosts.begin(), list.ghosts.end(),
        [](const GhostEntry& a, const GhostEntry& b) { return a.flux_mm2 > b.flux_mm2; });
    return list;
}

}  // namespace flare
