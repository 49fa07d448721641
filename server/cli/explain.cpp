// SPDX-License-Identifier: Apache-2.0
#include "server/cli/explain.h"

#include <cstdio>
#include <map>
#include <optional>

#include "protocol/codec/json_document.h"

namespace flare::cli {
namespace {

using wire::JsonKind;
using wire::JsonView;

std::optional<JsonView> Member(const std::optional<JsonView>& object, const char* name) {
    if (!object || object->kind() != JsonKind::kObject) return std::nullopt;
    return object->Find(name);
}

double Number(const std::optional<JsonView>& object, const char* name) {
    const auto member = Member(object, name);
    return member && member->kind() == JsonKind::kNumber ? member->number() : 0.0;
}

std::string Text(const std::optional<JsonView>& object, const char* name) {
    const auto member = Member(object, name);
    return member && member->kind() == JsonKind::kString ? std::string(member->string()) : "";
}

std::string Digits(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

std::string Percent(double share) {
    return Digits(100.0 * share) + " %";
}

std::string QualityWords(const std::optional<JsonView>& quality) {
    if (const std::string preset = Text(quality, "preset"); !preset.empty()) {
        return "the preset " + preset;
    }
    if (Member(quality, "max_error")) {
        return "an error of at most " + Percent(Number(quality, "max_error"));
    }
    if (Member(quality, "time_budget_ms")) {
        return "the best within " + Digits(Number(quality, "time_budget_ms")) + " ms";
    }
    return "tolerance " + Digits(Number(quality, "tolerance"));
}

class Explanation {
  public:
    explicit Explanation(const JsonView& root) : root_(root), work_(root.Find("work")) {}

    std::string Write() {
        Plan();
        Error();
        Ghosts();
        Artist();
        Layers();
        Visible();
        LeftOut();
        return std::move(out_);
    }

  private:
    void Line(const std::string& text) { out_ += text + "\n"; }

    void Plan() {
        Line("Asked for " + QualityWords(root_.Find("quality")) +
             "; drawn: " + QualityWords(root_.Find("plan")) + ".");
        const auto search = Member(work_, "search");
        if (!search) return;
        const double overruns = Number(search, "overruns");
        Line("Found in " + Digits(Number(search, "total_ms")) + " ms with " +
             Digits(Number(search, "pictures")) + " picture(s) drawn" +
             (overruns > 0.0 ? ", " + Digits(overruns) + " called off as too slow." : "."));
    }

    void Error() {
        const auto error = root_.Find("estimated_error");
        Line("Estimated error " + Percent(Number(error, "rel_l1")) + ": ghosts left out " +
             Percent(Number(error, "culling")) + ", cut into pieces " +
             Percent(Number(error, "pieces")) + ", rays interpolated " +
             Percent(Number(error, "mesh")) + ", few wavelengths " +
             Percent(Number(error, "dispersion")) + ", few colour bands " +
             Percent(Number(error, "colour")) + ".");
    }

    // By the model that ran for each.
    void Ghosts() {
        const auto ghosts = root_.Find("ghosts");
        if (!ghosts || ghosts->kind() != JsonKind::kArray || ghosts->child_count() == 0) return;
        std::map<std::string, int> models;
        for (auto ghost = ghosts->FirstChild(); ghost; ghost = ghost->NextSibling()) {
            ++models[Text(ghost, "model")];
        }
        std::string text = Digits(Number(root_, "ghost_count")) + " ghosts:";
        for (const auto& [model, count] : models) {
            text += (text.back() == ':' ? " " : ", ") + std::to_string(count) + " " + model;
        }
        const auto culling = root_.Find("culling");
        const double all = Number(culling, "frame_flux_mm2");
        if (all > 0.0) {
            text += "; " + Percent(Number(culling, "lost_flux_mm2") / all) +
                    " of their light on the frame is left out";
        }
        Line(text + ".");
    }

    // What is no longer what the lens does.
    void Artist() {
        const auto artist = root_.Find("artist");
        if (!artist || artist->kind() != JsonKind::kArray || artist->child_count() == 0) return;
        int muted = 0, changed = 0;
        for (auto ghost = artist->FirstChild(); ghost; ghost = ghost->NextSibling()) {
            const auto mute = Member(ghost, "mute");
            const bool mutes = mute && mute->kind() == JsonKind::kBoolean && mute->boolean();
            ++(mutes ? muted : changed);
        }
        Line(
            "An artist has changed the gain or tint of " + std::to_string(changed) +
            " ghost(s) and muted " + std::to_string(muted) +
            ": the picture is not what the lens does; error and light stated here are the lens's.");
    }

    void Layers() {
        if (const auto burst = root_.Find("starburst")) {
            Line("Starburst of " + Digits(Number(burst, "lights")) + " light(s), " +
                 Percent(Number(burst, "core_share")) +
                 " of its light within the first dark ring.");
        }
        if (const auto four = root_.Find("four_reflections")) {
            Line(Digits(Number(four, "rendered")) + " of " + Digits(Number(four, "sequences")) +
                 " ghosts of four reflections, those brighter than " +
                 Digits(Number(four, "threshold")) + "; " + Digits(Number(four, "lost_flux_mm2")) +
                 " mm2 of flux in the others.");
        }
    }

    // What cannot be seen, and the most that it does to a pixel.
    void Visible() {
        const auto visible = root_.Find("visible");
        if (!visible) return;
        Line("Nothing fainter than " + Digits(Number(visible, "floor")) +
             " can be seen (a noise floor of " + Digits(Number(visible, "noise_floor")) +
             ", shown " + Digits(Number(visible, "exposure_stops")) + " stops brighter).");
        double most = 0.0;
        const auto part = [&](const char* name, const std::string& words) {
            const auto facts = Member(visible, name);
            const double count = Number(facts, "count"), peak = Number(facts, "peak");
            if (count == 0.0) return;
            most += peak;
            Line("  Left out: " + words + " (" + Digits(count) + "), at most " + Digits(peak) +
                 " in any pixel, " + Digits(Number(facts, "flux_mm2")) + " mm2 of flux.");
        };
        part("ghosts", "ghosts");
        part("four_reflections", "ghosts of four reflections");
        part("details", "colour fringes, diffraction and blur of faint ghosts");
        part("starburst", "tails of starbursts");
        Line(most > 0.0 ? "  Together at most " + Digits(most) + " in any pixel."
                        : "  All that is drawn can be seen, as far as can be told beforehand.");
    }

    void LeftOut() {
        const auto model = root_.Find("model");
        std::string text;
        const auto add = [&](const char* what) {
            text += (text.empty() ? "" : ", ") + std::string(what);
        };
        if (Number(model, "reflections") < 4.0) add("ghosts of four reflections");
        const auto sensor = Member(model, "sensor_reflection");
        if (!sensor || sensor->kind() != JsonKind::kBoolean || !sensor->boolean()) {
            add("light that the sensor reflects");
        }
        if (Text(model, "ringing") == "off") add("diffraction at the edges of ghosts");
        if (!root_.Find("starburst")) add("the starburst");
        Line("Not modelled: " + text + "; scatter by dust and barrel.");
        const auto clamped = root_.Find("clamped");
        for (auto c = clamped ? clamped->FirstChild() : std::nullopt; c; c = c->NextSibling()) {
            if (c->kind() == JsonKind::kString) Line("Clamped " + std::string(c->string()) + ".");
        }
    }

    JsonView root_;
    std::optional<JsonView> work_;
    std::string out_;
};

}  // namespace

std::string ExplainReport(const std::string& report) {
    const auto parsed = wire::JsonDocument::Parse(report);
    const auto* document = std::get_if<wire::JsonDocument>(&parsed);
    if (!document || document->root().kind() != JsonKind::kObject) return "";
    return Explanation(document->root()).Write();
}

}  // namespace flare::cli
