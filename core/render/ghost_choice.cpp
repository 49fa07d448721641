// SPDX-License-Identifier: Apache-2.0
#include "core/render/ghost_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/mesh/transmission.h"
#include "core/render/ghost_peak.h"
#include "core/tracing/paraxial_ghost.h"

namespace flare {

namespace {

// The coarse mesh.
constexpr int kCells = 16;
constexpr int kPatchCells = 4;
constexpr double kPositionTolerance_mm = 0.05;
constexpr double kMaskTolerance = 0.05;
constexpr double kCosineTolerance = 1e-3;

// Axial reflectances and transmittances of every surface at the d line.
class AxialWeights {
  public:
    explicit AxialWeights(const Lens& lens) {
        for (int i = 0; i <= lens.sensor_index(); ++i) {
            Reflection both{0.0, 1.0};
            if (i == lens.sensor_index()) {
                if (lens.sensor()) both.reflectance = lens.sensor()->reflectance;
            } else if (const auto& s = lens.surfaces()[static_cast<std::size_t>(i)]; !s.is_stop()) {
                both = ReflectionOf(s.coating, s.dense_in_front, lens.MediumBefore(i).Index(kLineD),
                                    lens.MediumBehind(i).Index(kLineD), 1.0, kLineD);
            }
            at_.push_back(both);
        }
    }

    double Of(const InteractionList& list) const {
        double weight = 1.0;
        for (const Interaction& step : list.steps) {
            const Reflection& both = at_[static_cast<std::size_t>(step.surface)];
            weight *=
                step.kind == InteractionKind::kReflect ? both.reflectance : both.transmittance;
        }
        return weight;
    }

  private:
    std::vector<Reflection> at_;
};

// The axial beam from infinity along a path in one section, by first-order heights.
struct AxialPath {
    double half_width_mm = 0.0;  // of the part that all rims and the stop let through, at the front
    double magnification = 0.0;  // height on the sensor over that at the front
};

AxialPath AxialPathOf(const InteractionList& list, Section section, double opening_mm) {
    AxialPath path;
    path.half_width_mm = std::numeric_limits<double>::infinity();
    double z = 0.0;
    Abcd so_far;
    for (const Interaction& step : list.steps) {
        so_far = Then(so_far, Drift(step.vertex_z_mm - z));
        z = step.vertex_z_mm;
        const double rim = step.kind == InteractionKind::kStop
                               ? std::min(opening_mm, step.semi_diameter_mm)
                               : step.semi_diameter_mm;
        if (std::abs(so_far.a) * path.half_width_mm > rim) {
            path.half_width_mm = rim / std::abs(so_far.a);
        }
        so_far = Then(so_far, StepMatrix(step, section));
    }
    path.magnification = Then(so_far, Drift(list.sensor_z_mm - z)).a;
    return path;
}

GhostEstimate FirstOrderEstimate(const InteractionList& list, double weight, double opening_mm) {
    const AxialPath x = AxialPathOf(list, Section::kX, opening_mm);
    const AxialPath y = AxialPathOf(list, Section::kY, opening_mm);
    const double area = kPi * x.half_width_mm * y.half_width_mm;
    const double spread = std::abs(x.magnification * y.magnification);
    GhostEstimate estimate;
    estimate.flux_mm2 = weight * area;
    estimate.peak_irradiance =
        estimate.flux_mm2 / std::max(area * spread, kPeakPixel_mm * kPeakPixel_mm);
    return estimate;
}

}  // namespace

Result<GhostChoice> ChooseFourReflections(const Lens& lens, const ModelSpec& model,
                                          const Iris& iris, const PlacedLight& light,
                                          const RenderContext& context) {
    const std::vector<BounceSequence> all = FourReflectionSequences(lens, model.sensor_reflection);
    const AxialWeights weights(lens);
    GhostChoice choice;
    choice.facts.threshold = model.four_reflection_threshold;
    choice.facts.sequences = all.size();
    std::vector<BounceSequence> likely;
    for (const BounceSequence& sequence : all) {
        if (context.cancel.cancelled()) break;
        const InteractionList list = WriteOut(lens, sequence, kLineD);
        const GhostEstimate estimate =
            FirstOrderEstimate(list, weights.Of(list), iris.outer_radius());
        if (estimate.peak_irradiance * kCausticGain >= model.four_reflection_threshold) {
            likely.push_back(sequence);
        } else {
            choice.facts.lost_flux_mm2 += estimate.flux_mm2;
        }
    }

    const LightBundle bundle = BundleOf(lens, light);
    const TransmissionTables tables(lens, {kLineD}, context.threads);
    std::vector<GhostEstimate> estimates(likely.size());
    std::vector<std::uint64_t> rays(likely.size());
    context.threads.For(static_cast<int>(likely.size()), [&](int item) {
        if (context.cancel.cancelled()) return;
        const auto n = static_cast<std::size_t>(item);
        MeshSpec spec = MeshSpecOf(likely[n], light);
        spec.wavelengths_nm = {kLineD};
        spec.cells = kCells;
        spec.patch_cells = kPatchCells;
        spec.position_tolerance_mm = kPositionTolerance_mm;
        spec.mask_tolerance = kMaskTolerance;
        spec.cosine_tolerance = kCosineTolerance;
        const Result<MeshProvider::Found> found = context.meshes.Get(
            MeshKey(lens, spec), [&] { return BuildMesh(lens, spec); }, context.cancel);
        if (!found) return;
        if (!found->hit) rays[n] = found->mesh->rays_traced;
        const auto surface = std::make_shared<const GhostSurface>(found->mesh, lens.sensor_gap_mm(),
                                                                  iris.outer_radius());
        GhostEstimate& estimate = estimates[n];
        estimate = EstimateOf(*surface, bundle, lens, tables, iris, light.pose);
        const double most = std::min(kMeshGain * estimate.peak_irradiance,
                                     estimate.flux_mm2 / (kPeakPixel_mm * kPeakPixel_mm));
        if (most < model.four_reflection_threshold) return;
        estimate.peak_irradiance = PeakOfPieces(surface, bundle, lens, tables, iris, light.pose);
    });
    if (context.cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    for (std::size_t n = 0; n < likely.size(); ++n) {
        choice.rays_traced += rays[n];
        if (estimates[n].peak_irradiance >= model.four_reflection_threshold) {
            choice.sequences.push_back(likely[n]);
            choice.facts.rendered_flux_mm2 += estimates[n].flux_mm2;
        } else {
            choice.facts.lost_flux_mm2 += estimates[n].flux_mm2;
        }
    }
    choice.facts.rendered = choice.sequences.size();
    return choice;
}

}  // namespace flare
