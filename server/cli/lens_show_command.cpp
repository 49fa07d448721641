// SPDX-License-Identifier: Apache-2.0
//
// flare lens show: a lens and its first-order data, in one state.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/optics/paraxial.h"
#include "server/cli/app.h"
#include "server/cli/field_table.h"
#include "server/cli/files.h"
#include "server/cli/lens_commands.h"
#include "server/cli/options.h"
#include "server/cli/table.h"
#include "server/translate/lens_json.h"

namespace flare::cli {
namespace {

struct ShowOptions {
    std::string name;
    std::string lenses;
    LensState state;
    bool json = false;
    bool field = false;
};

// One radius, or two where the sections differ.
std::string RadiusText(const SurfaceShape& shape) {
    const auto text = [](double curvature) {
        return curvature == 0.0 ? std::string("flat") : Fixed(1.0 / curvature, 4);
    };
    if (shape.flat()) return "";
    if (shape.rotational()) return text(shape.curvature_x());
    return text(shape.curvature_x()) + " / " + text(shape.curvature_y());
}

std::string SurfaceTable(const Lens& lens) {
    Table table({"#", "kind", "radius mm", "gap mm", "glass", "nd", "vd", "semi-diameter mm",
                 "coating", "vertex z mm"});
    const auto optional = [](const std::optional<double>& value, int digits) {
        return value ? Fixed(*value, digits) : std::string();
    };
    for (std::size_t i = 0; i < lens.surfaces().size(); ++i) {
        const SurfacePrescription& file = lens.prescription().surfaces[i];
        const LensSurface& surface = lens.surfaces()[i];
        const std::optional<double> nd = file.glass ? surface.behind.nd() : file.nd;
        const std::optional<double> vd = file.glass ? surface.behind.vd() : file.vd;
        const double next_z_mm = i + 1 < lens.surfaces().size() ? lens.surfaces()[i + 1].vertex_z_mm
                                                                : lens.sensor_z_mm();
        table.AddRow(
            {std::to_string(i), std::string(KindName(surface.kind)), RadiusText(surface.shape),
             Fixed(next_z_mm - surface.vertex_z_mm, 4), file.glass.value_or(""), optional(nd, 5),
             optional(vd, 2), Fixed(surface.semi_diameter_mm, 3),
             surface.is_stop() ? "" : surface.coating.name, Fixed(surface.vertex_z_mm, 4)});
    }
    const std::optional<LensSensor>& sensor = lens.sensor();
    if (sensor) {
        table.AddRow({std::to_string(lens.sensor_index()), "sensor", "", "", "", "", "",
                      Fixed(sensor->semi_diameter_mm, 3),
                      "reflects " + Significant(sensor->reflectance, 4),
                      Fixed(lens.sensor_z_mm(), 4)});
    }
    return table.text();
}

// Lines of a label and a text; empty texts are left out.
class Lines {
  public:
    void Add(const std::string& label, const std::string& value) {
        char padded[40];
        std::snprintf(padded, sizeof padded, "  %-24s", label.c_str());
        if (!value.empty()) text_ += padded + value + "\n";
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

// `suffix` tells the sections of an anamorphic lens apart.
void AddSection(Lines& lines, const Lens& lens, Section section, const std::string& suffix) {
    const FirstOrder& first = lens.first_order(section);
    const double last_z_mm = lens.surfaces().back().vertex_z_mm;
    lines.Add("EFL" + suffix, Fixed(first.efl_mm, 4) + " mm");
    lines.Add("BFL" + suffix, Fixed(first.bfl_mm, 4) + " mm");
    lines.Add("entrance pupil" + suffix, "z " + Fixed(first.entrance.z_mm, 4) + " mm, diameter " +
                                             Fixed(first.entrance.diameter_mm, 4) + " mm");
    lines.Add("exit pupil" + suffix,
              "z " + Fixed(first.exit.z_mm, 4) + " mm (" + Fixed(first.exit.z_mm - last_z_mm, 4) +
                  " from the last vertex), diameter " + Fixed(first.exit.diameter_mm, 4) + " mm");
}

std::string Summary(const LensInState& shown) {
    const Lens& lens = *shown.lens;
    const Prescription& file = lens.prescription();
    const double stop_mm =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    Lines lines;
    lines.Add("maker", file.maker);
    lines.Add("patent", file.patent);
    lines.Add("state", StateText(shown));
    if (lens.rotational()) {
        AddSection(lines, lens, Section::kY, "");
    } else {
        AddSection(lines, lens, Section::kX, " in x");
        AddSection(lines, lens, Section::kY, " in y");
        lines.Add("squeeze", Fixed(lens.squeeze(), 4));
    }
    lines.Add("f-number", Fixed(lens.f_number(), 4) + " (working, rims included: " +
                              Fixed(WorkingBeam(lens, stop_mm).working_f_number, 4) + ")");
    lines.Add("axial transmittance", Fixed(AxialTransmittance(lens, kLineD), 6));
    lines.Add("sensor", "z " + Fixed(lens.sensor_z_mm(), 4) + " mm");
    return lens.name() + "\n" + lines.text();
}

int Show(const ShowOptions& options) {
    const auto file = FindLens(options.name, options.lenses);
    if (!file) return Complain("", file.error());
    const Result<LensInState> shown = SetState(*file, options.state);
    if (!shown) return Complain(options.name, shown.error());
    if (options.json) return Print(LensJson(**file, *shown, true));
    if (options.field) return Print(FieldTables(*shown->lens));
    return Print(Summary(*shown) + "\n" + SurfaceTable(*shown->lens));
}

}  // namespace

void AddLensShow(CLI::App& lens, int& exit_code) {
    auto options = std::make_shared<ShowOptions>();
    CLI::App* command = lens.add_subcommand("show", "Show a lens and its first-order data");
    AddLensName(*command, options->name);
    AddStateOptions(*command, options->state);
    command->add_flag("--json", options->json, "JSON instead of a table");
    command->add_flag("--field", options->field,
                      "Distortion, illumination and transmittance against field angle instead");
    AddLensFolder(*command, options->lenses);
    command->callback([options, &exit_code] { exit_code = Show(*options); });
}

}  // namespace flare::cli
