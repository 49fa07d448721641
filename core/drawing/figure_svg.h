// SPDX-License-Identifier: Apache-2.0
//
// Writes one section of a drawing: shapes in a group scaled to mm, strokes and labels of one size
// on paper whatever the lens's.
#pragma once

#include <string>

#include "core/drawing/section_figure.h"
#include "core/drawing/svg_writer.h"

namespace flare {

// Where lens space lies on paper: pixel = origin + (scale z, -scale height).
struct FigurePlace {
    Vec2d origin{0.0, 0.0};
    double scale = 1.0;              // pixels per mm
    double left = 0.0, right = 0.0;  // the paper that labels may use
    double top = 0.0, bottom = 0.0;  // of what is drawn to scale
    // Base lines of the rows of labels: the section's name, pupils beyond the sheet, names, surface
    // numbers.
    double name_row = 0.0, far_row = 0.0, top_row = 0.0, bottom_row = 0.0;
};

namespace ink {
inline constexpr const char* kLine = "#33475b";
inline constexpr const char* kText = "#22303c";
inline constexpr const char* kFaint = "#9aa7b2";
inline constexpr const char* kAxial = "#3949ab";
inline constexpr const char* kField = "#2e7d32";
inline constexpr const char* kGhosts[] = {"#d0212f", "#e07b00", "#8e24aa", "#ad1457"};
}  // namespace ink

// The colour of glass of an index: pale at 1.4, deeper to 2.0.
inline constexpr double kPaleIndex = 1.4, kDeepIndex = 2.0;
std::string GlassColour(double nd);

// "(9,1)"
std::string SequenceName(const BounceSequence& sequence);

// The room that a ghost's name needs on paper, right of the sensor.
double GhostLabelWidth(const BounceSequence& sequence);

void WriteFigure(const SectionFigure& figure, const FigurePlace& place, SvgWriter& svg);

}  // namespace flare
