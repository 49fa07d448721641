// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/trial.h"

#include <algorithm>
#include <charconv>
#include <functional>

namespace flare {
namespace {

// Every ghost of four reflections that is a hundred times fainter than those drawn by default.
constexpr double kFaintestFour = 1e-4;
// Drawn wavelengths are then as many as are allowed.
constexpr double kFinestStep_px = 1e-3;

std::string Text(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed).ptr;
    return {text, end};
}

class Knob {
  public:
    Knob(std::string name, std::string words, Truth truth = Truth::kGhosts)
        : name_(std::move(name)), words_(std::move(words)), truth_(truth) {}

    using Change = std::function<void(Trial&)>;
    Knob& Add(std::string value, const Change& change) {
        Trial trial;
        trial.knob = name_;
        trial.value = std::move(value);
        trial.truth = truth_;
        trial.ringing = truth_ == Truth::kRinging;
        trial.settings = SettingsOf(Quality(QualityPreset::kFinal));
        change(trial);
        trials_.push_back(std::move(trial));
        return *this;
    }
    template <class Set>
    Knob& Each(std::initializer_list<double> values, Set set) {
        for (const double value : values) {
            Add(Text(value), [&](Trial& trial) { set(trial, value); });
        }
        return *this;
    }

    const std::string& name() const { return name_; }
    const std::string& words() const { return words_; }
    const std::vector<Trial>& trials() const { return trials_; }

  private:
    std::string name_, words_;
    Truth truth_;
    std::vector<Trial> trials_;
};

int Whole(double value) {
    return static_cast<int>(value);
}

void MakeUniform(Trial& trial, int cells) {
    trial.whole = true;
    trial.settings.mesh_cells = cells;
    trial.settings.patch_cells = 0;
    trial.settings.cubic = false;
    trial.settings.tiles.reset();
    trial.culling = CullingRule::kNone;
}

void DrawWavelengths(Trial& trial, int count) {
    trial.settings.dispersion_step_px = kFinestStep_px;
    trial.settings.most_drawn = count;
}

std::vector<Knob> Methods() {
    std::vector<Knob> knobs;
    knobs.emplace_back("tolerance", "this program: all settings together")
        .Each({0.25, 0.1, 0.05, 0.035, 0.02, 0.01, 0.005, 0.0025, 0.001},
              [](Trial& trial, double value) {
                  trial.whole = true;
                  trial.settings = SettingsFor(value);
              });
    knobs.emplace_back("uniform-mesh", "one grid for every ghost, straight between vertices")
        .Each({8, 16, 32, 64, 128},
              [](Trial& trial, double value) { MakeUniform(trial, Whole(value)); });
    knobs.emplace_back("founding-report", "16² grid, three wavelengths, both culling rules")
        .Add("all", [](Trial& trial) {
            MakeUniform(trial, 16);
            DrawWavelengths(trial, 3);
            trial.culling = CullingRule::kReport;
        });
    knobs.emplace_back("photon", "random rays, samples a ghost")
        .Each({256, 1024, 4096, 16384}, [](Trial& trial, double value) {
            trial.whole = true;
            trial.photon = PhotonSpec{};
            trial.photon->samples = Whole(value);
        });
    return knobs;
}

void AddMeshKnobs(std::vector<Knob>& knobs) {
    knobs.emplace_back("grid", "cells along a side of a ghost's mesh")
        .Each({8, 16, 32, 64, 128},
              [](Trial& trial, double value) { trial.settings.mesh_cells = Whole(value); });
    knobs.emplace_back("order", "interpolation between vertices")
        .Add("linear", [](Trial& trial) { trial.settings.cubic = false; })
        .Add("cubic", [](Trial&) {});
    knobs.emplace_back("patches", "finer grid in cells that need one, cells a side")
        .Each({0, 4, 8},
              [](Trial& trial, double value) { trial.settings.patch_cells = Whole(value); });
    knobs.emplace_back("position", "tolerance of interpolation that calls for a patch, mm")
        .Each({0.1, 0.03, 0.01, 0.003},
              [](Trial& trial, double value) { trial.settings.position_tolerance_mm = value; });
    knobs.emplace_back("precision", "arithmetic of rays")
        .Add("float", [](Trial&) {})
        .Add("double", [](Trial& trial) { trial.settings.arithmetic = MeshArithmetic::kDouble; });
}

void AddColourKnobs(std::vector<Knob>& knobs) {
    knobs.emplace_back("wavelengths", "drawn")
        .Each({3, 5, 9, 17, 33, 65},
              [](Trial& trial, double value) { DrawWavelengths(trial, Whole(value)); });
    knobs.emplace_back("traced", "wavelengths that rays are traced at")
        .Each({2, 3, 4},
              [](Trial& trial, double value) { trial.settings.traced_wavelengths = Whole(value); });
    knobs.emplace_back("coating-tables", "bands of colour that coatings are evaluated at")
        .Each({7, 14, 21, 41, 81},
              [](Trial& trial, double value) { trial.settings.colour_bands = Whole(value); });
    knobs.emplace_back("transmittance", "tolerance of light interpolated in a cell")
        .Each({2e-2, 2e-3, 4e-4, 1e-4},
              [](Trial& trial, double value) { trial.settings.light_tolerance = value; });
}

void AddRasterKnobs(std::vector<Knob>& knobs) {
    knobs.emplace_back("pieces", "change of irradiance that a piece of a cell may have")
        .Each({0.4, 0.15, 0.08, 0.02, 0.01},
              [](Trial& trial, double value) { trial.settings.walk.density_step = value; });
    knobs.emplace_back("tiles", "tolerance of light in tiles; off: polygons alone")
        .Add("off", [](Trial& trial) { trial.settings.tiles.reset(); })
        .Each({0.3, 0.1, 0.04, 0.01, 0.002},
              [](Trial& trial, double value) { trial.settings.tiles->light = value; });
    knobs.emplace_back("tile-edges", "how far a mask's edge may be off in a tile, px")
        .Each({0.3, 0.15, 0.05, 0.02, 0.005},
              [](Trial& trial, double value) { trial.settings.tiles->edge_px = value; });
}

void AddModelKnobs(std::vector<Knob>& knobs) {
    knobs.emplace_back("culling", "share of the light that may be left out; or an old rule")
        .Add("none", [](Trial& trial) { trial.culling = CullingRule::kNone; })
        .Each({0.00125, 0.005, 0.0125, 0.05},
              [](Trial& trial, double value) {
                  trial.settings.culled_share = value / trial.settings.tolerance;
              })
        .Add("area-rule", [](Trial& trial) { trial.culling = CullingRule::kReportSize; })
        .Add("stop-rule", [](Trial& trial) { trial.culling = CullingRule::kReportCrossings; })
        .Add("both-rules", [](Trial& trial) { trial.culling = CullingRule::kReport; });
    knobs.emplace_back("ringing", "diffraction at the edges of ghosts", Truth::kRinging)
        .Add("off", [](Trial& trial) { trial.ringing = false; })
        .Add("on", [](Trial&) {});
    knobs
        .emplace_back("four-reflections", "ghosts of four reflections, from this peak irradiance",
                      Truth::kFourReflections)
        .Add("off", [](Trial&) {})
        .Each({0.1, 0.01, 1e-3},
              [](Trial& trial, double value) { trial.four_reflection_threshold = value; });
}

const std::vector<Knob>& Knobs() {
    static const std::vector<Knob> knobs = [] {
        std::vector<Knob> all = Methods();
        AddMeshKnobs(all);
        AddColourKnobs(all);
        AddRasterKnobs(all);
        AddModelKnobs(all);
        return all;
    }();
    return knobs;
}

void SetFour(double threshold, FlareRequest& request) {
    if (threshold <= 0.0) return;
    request.model.reflections = 4;
    request.model.four_reflection_threshold = threshold;
}

}  // namespace

const std::vector<std::string>& KnobNames() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Knob& knob : Knobs()) list.push_back(knob.name());
        return list;
    }();
    return names;
}

std::string KnobWords(const std::string& knob) {
    for (const Knob& known : Knobs()) {
        if (known.name() == knob) return known.words();
    }
    return "";
}

Result<std::vector<Trial>> TrialsOf(const std::vector<std::string>& knobs) {
    const auto named = [](const Trial& trial, const std::string& text) {
        return text == trial.knob || text == trial.knob + "=" + trial.value;
    };
    std::vector<Trial> all;
    for (const Knob& knob : Knobs()) {
        all.insert(all.end(), knob.trials().begin(), knob.trials().end());
    }
    for (const std::string& text : knobs) {
        const bool known =
            std::any_of(all.begin(), all.end(), [&](const Trial& t) { return named(t, text); });
        if (known) continue;
        std::string names;
        for (const std::string& name : KnobNames()) names += (names.empty() ? "" : ", ") + name;
        return Error{"bad_value", text + " is no knob and no value of one; there are " + names, ""};
    }
    if (knobs.empty()) return all;
    std::erase_if(all, [&](const Trial& trial) {
        return std::none_of(knobs.begin(), knobs.end(),
                            [&](const std::string& text) { return named(trial, text); });
    });
    return all;
}

void Apply(const Trial& trial, FlareRequest& request) {
    request.model.culling = trial.culling;
    request.model.ringing = trial.ringing;
    SetFour(trial.four_reflection_threshold, request);
    if (trial.photon) {
        request.quality = QualityPreset::kReference;
        request.photon = trial.photon;
    } else {
        request.quality = QualityPreset::kFinal;
        request.settings = std::make_shared<const QualitySettings>(trial.settings);
    }
}

// The four-reflection ghosts of the reference are drawn as a final does: thousands of them at the
// finest settings would take hours, and what is asked here is which of them are missing.
void ApplyTruth(Truth truth, FlareRequest& request) {
    request.quality =
        truth == Truth::kFourReflections ? QualityPreset::kFinal : QualityPreset::kReference;
    request.model.ringing = truth == Truth::kRinging;
    if (truth == Truth::kFourReflections) SetFour(kFaintestFour, request);
}

std::string TruthName(Truth truth) {
    switch (truth) {
        case Truth::kGhosts:
            return "ghosts";
        case Truth::kRinging:
            return "ringing";
        case Truth::kFourReflections:
            return "four";
    }
    return "";
}

}  // namespace flare
