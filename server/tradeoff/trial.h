// SPDX-License-Identifier: Apache-2.0
//
// What a sweep tries: each trial is one value of one knob. A knob is either a setting that is moved
// alone, everything else staying as in the preset final, or a method with its own scale of
// fineness: "tolerance" (what this program does; the presets are among its values), "uniform-mesh"
// (one grid for every ghost, straight between its vertices), "founding-report" (that grid at 16 x
// 16 with three wavelengths and the old culling rules) and "photon". docs/accuracy.md says what
// each value means.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/render/quality.h"

namespace flare {

// What the reference picture that a trial is held against has beyond plain ghosts.
enum class Truth { kGhosts, kRinging, kFourReflections };

struct Trial {
    std::string knob, value;
    Truth truth = Truth::kGhosts;
    bool whole = false;    // a way to draw of its own, not one setting of final
    bool ringing = false;  // diffraction fringes are drawn
    // Of four-reflection ghosts; 0: none are drawn.
    double four_reflection_threshold = 0.0;
    CullingRule culling = CullingRule::kAuto;
    QualitySettings settings;
    std::optional<PhotonSpec> photon;

    std::string name() const { return knob + " " + value; }
};

// All knobs, in the order of a report.
const std::vector<std::string>& KnobNames();
// What each of them is, in a few words.
std::string KnobWords(const std::string& knob);

// Of the knobs that are named, none: all; "knob=value" is that value alone. In the order of
// KnobNames. Error "bad_value" for what is no knob or none of its values.
Result<std::vector<Trial>> TrialsOf(const std::vector<std::string>& knobs);

// The one that the knobs' other settings are those of.
inline constexpr const char* kBaseKnob = "tolerance";
inline constexpr const char* kBaseValue = "0.005";

// Puts the trial's settings into the request, or those of its reference picture.
void Apply(const Trial& trial, FlareRequest& request);
void ApplyTruth(Truth truth, FlareRequest& request);
std::string TruthName(Truth truth);

}  // namespace flare
