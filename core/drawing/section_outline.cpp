// SPDX-License-Identifier: Apache-2.0
//
// Every shape's sag is even in x and in y, so only the upper half of an element is thought out.
#include "core/drawing/section_outline.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

constexpr int kFaceSteps = 64;
constexpr double kCrossing_mm = 1e-9;

// z of a surface at a height in the section.
double FaceZ(const Lens& lens, int index, Section section, double height) {
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(index)];
    const double sag =
        section == Section::kX ? surface.shape.Sag(height, 0.0) : surface.shape.Sag(0.0, height);
    return surface.vertex_z_mm + sag;
}

class ElementJoiner {
  public:
    ElementJoiner(const Lens& lens, Section section, int front)
        : lens_(lens), section_(section), front_(front), height_{Rim(front), Rim(front + 1)} {
        EndWhereFacesCross();
    }

    Outline Run() const {
        Outline outline = FaceOutline(lens_, front_, section_, height_[0]);
        const Outline edge = UpperEdge();
        outline.insert(outline.end(), edge.begin(), edge.end());
        const Outline back = FaceOutline(lens_, front_ + 1, section_, height_[1]);
        outline.insert(outline.end(), back.rbegin(), back.rend());
        for (auto p = edge.rbegin(); p != edge.rend(); ++p) outline.emplace_back(p->x, -p->y);
        return outline;
    }

  private:
    // A stop within glass is as wide as its neighbours: the glass goes on past it.
    double Rim(int index) const {
        const auto rim = [&](int i) {
            return lens_.surfaces()[static_cast<std::size_t>(i)].semi_diameter_mm;
        };
        const bool within = lens_.surfaces()[static_cast<std::size_t>(index)].is_stop() &&
                            index > 0 && index + 1 < static_cast<int>(lens_.surfaces().size());
        return within ? std::max(rim(index - 1), rim(index + 1)) : rim(index);
    }

    double FrontZ(double height) const { return FaceZ(lens_, front_, section_, height); }
    double BackZ(double height) const { return FaceZ(lens_, front_ + 1, section_, height); }
    bool Cross(double height) const { return FrontZ(height) > BackZ(height) + kCrossing_mm; }

    void EndWhereFacesCross() {
        const double both = std::min(height_[0], height_[1]);
        if (Cross(0.0)) return;
        double inside = 0.0;
        for (int i = 1; i <= kFaceSteps; ++i) {
            double outside = both * i / kFaceSteps;
            if (!Cross(outside)) {
                inside = outside;
                continue;
            }
            for (int halving = 0; halving < 50; ++halving) {
                const double middle = 0.5 * (inside + outside);
                (Cross(middle) ? outside : inside) = middle;
            }
            height_[0] = height_[1] = inside;
            return;
        }
    }

    // Is the wider face, from the smaller one's height to its own, clear of the plane at `z`?
    bool StepIsFree(bool front_is_wider, double z) const {
        const double low = std::min(height_[0], height_[1]);
        const double high = std::max(height_[0], height_[1]);
        for (int i = 0; i <= kFaceSteps; ++i) {
            const double height = low + (high - low) * i / kFaceSteps;
            if (front_is_wider ? FrontZ(height) > z : BackZ(height) < z) return false;
        }
        return true;
    }

    // The corners between the rims of both faces.
    Outline UpperEdge() const {
        const double front_z = FrontZ(height_[0]);
        const double back_z = BackZ(height_[1]);
        if (height_[0] > height_[1] && StepIsFree(true, back_z)) return {{back_z, height_[0]}};
        if (height_[0] < height_[1] && StepIsFree(false, front_z)) return {{front_z, height_[1]}};
        return {};
    }

    const Lens& lens_;
    Section section_;
    int front_;
    double height_[2];  // of both faces, as drawn
};

}  // namespace

Outline FaceOutline(const Lens& lens, int index, Section section, double height_mm) {
    const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(index)];
    const bool straight =
        surface.shape.rotational() ? surface.shape.flat() : surface.shape.curvature(section) == 0.0;
    const int steps = straight ? 1 : kFaceSteps;
    Outline outline;
    for (int i = 0; i <= steps; ++i) {
        // Denser towards the rims, where deep faces are steep.
        const double height = height_mm * -std::cos(kPi * i / steps);
        outline.emplace_back(FaceZ(lens, index, section, height), height);
    }
    return outline;
}

Outline FaceOutline(const Lens& lens, int index, Section section) {
    return FaceOutline(lens, index, section,
                       lens.surfaces()[static_cast<std::size_t>(index)].semi_diameter_mm);
}

std::vector<ElementOutline> ElementOutlines(const Lens& lens, Section section) {
    std::vector<ElementOutline> elements;
    for (int i = 0; i + 1 < static_cast<int>(lens.surfaces().size()); ++i) {
        const Glass& glass = lens.MediumBehind(i);
        if (glass.is_air()) continue;
        elements.push_back({i, glass.nd(), ElementJoiner(lens, section, i).Run()});
    }
    return elements;
}

}  // namespace flare
