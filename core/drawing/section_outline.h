// SPDX-License-Identifier: Apache-2.0
//
// The outlines of a lens's glass in one of its two sections, as a draughtsman joins them. Points
// are (z, height) in mm of lens space, height being x or y. Pure functions.
#pragma once

#include <vector>

#include "core/optics/lens.h"

namespace flare {

using Outline = std::vector<Vec2d>;

// Surface `index` from -height to +height, the sag exact at every point.
Outline FaceOutline(const Lens& lens, int index, Section section, double height_mm);
// The same over its whole semi-diameter.
Outline FaceOutline(const Lens& lens, int index, Section section);

// The glass between surface `front` and the next.
struct ElementOutline {
    int front = 0;
    double nd = 1.0;
    Outline outline;  // closed: the last point joins the first
};

// Faces of unequal semi-diameter are joined by a step at the smaller one or, where the other face
// is in the way of that, by a straight edge; faces that cross within their rims end where they
// meet. Elements cemented together share the face between them.
std::vector<ElementOutline> ElementOutlines(const Lens& lens, Section section);

}  // namespace flare
