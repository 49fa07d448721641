// SPDX-License-Identifier: Apache-2.0
//
// flare lens list | show | check: what is in the library and whether a lens file tells the truth.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "core/optics/paraxial.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "server/cli/app.h"
#include "server/cli/field_table.h"
#include "server/cli/files.h"
#include "server/cli/table.h"
#include "server/translate/lens_json.h"

namespace flare::cli {
namespace {

struct LensOptions {
    std::string name;
    std::string lenses;
    bool json = false;
    bool field = false;
};

int List(const LensOptions& options) {
    const Result<LensLibrary> library = OpenLibrary(options.lenses);
    if (!library) return Complain("", library.error());
    if (options.json) return Print(LensListJson(*library));
    Table table({"name", "EFL mm", "f/", "surfaces", "maker"});
    for (const std::string& name : library->Names()) {
        const auto lens = library->Find(name);
        if (!lens) continue;
        const FirstOrder& first = (*lens)->first_order();
        table.AddRow({name, Fixed(first.efl_mm, 3), Fixed(first.f_number, 2),
                      std::to_string((*lens)->surfaces().size()), (*lens)->prescription().maker});
    }
    for (const auto& [name, error] : library->broken()) Complain(name + ".toml", error);
    return Print(table.text());
}

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
    return table.text();
}

std::string Summary(const Lens& lens) {
    const FirstOrder& first = lens.first_order();
    const Prescription& file = lens.prescription();
    const double stop_mm =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    const double last_z_mm = lens.surfaces().back().vertex_z_mm;
    std::string text = lens.name() + "\n";
    const auto line = [&](const char* label, const std::string& value) {
        char padded[32];
        std::snprintf(padded, sizeof padded, "  %-24s", label);
        if (!value.empty()) text += padded + value + "\n";
    };
    line("maker", file.maker);
    line("patent", file.patent);
    line("EFL", Fixed(first.efl_mm, 4) + " mm");
    line("BFL", Fixed(first.bfl_mm, 4) + " mm");
    line("f-number", Fixed(first.f_number, 4) + " (working, rims included: " +
                         Fixed(WorkingBeam(lens, stop_mm).working_f_number, 4) + ")");
    line("axial transmittance", Fixed(AxialTransmittance(lens, kLineD), 6));
    line("entrance pupil", "z " + Fixed(first.entrance.z_mm, 4) + " mm, diameter " +
                               Fixed(first.entrance.diameter_mm, 4) + " mm");
    line("exit pupil",
         "z " + Fixed(first.exit.z_mm, 4) + " mm (" + Fixed(first.exit.z_mm - last_z_mm, 4) +
             " from the last vertex), diameter " + Fixed(first.exit.diameter_mm, 4) + " mm");
    line("sensor", "z " + Fixed(lens.sensor_z_mm(), 4) + " mm");
    return text;
}

int Show(const LensOptions& options) {
    const auto lens = FindLens(options.name, options.lenses);
    if (!lens) return Complain("", lens.error());
    if (options.json) return Print(LensJson(**lens, true));
    if (options.field) return Print(FieldTables(**lens));
    return Print(Summary(**lens) + "\n" + SurfaceTable(**lens));
}

int Check(const LensOptions& options) {
    const std::string& path = options.name;
    const Result<std::string> text = ReadInput(path);
    if (!text) return Complain("", text.error());
    const Result<Prescription> prescription = ReadPrescriptionToml(*text);
    if (!prescription) return Complain(path, prescription.error());

    std::vector<Finding> findings = CheckPrescription(*prescription);
    const std::string stem = std::filesystem::path(path).stem().string();
    if (path != "-" && stem != prescription->name) {
        findings.push_back({Severity::kWarning, "name",
                            "the lens is named \"" + prescription->name +
                                "\": a library finds it only as " + prescription->name + ".toml",
                            ""});
    }
    int errors = 0;
    std::string lines;
    for (const Finding& finding : findings) {
        const bool error = finding.severity == Severity::kError;
        errors += error ? 1 : 0;
        lines += path + ": " + (finding.where.empty() ? "" : finding.where + ": ") +
                 (error ? "error: " : "warning: ") + finding.message + " [" + finding.code + "]\n";
    }
    if (errors == 0) {
        // The lint and the builder share their rules; this is the proof for this file.
        const auto lens = Lens::Build(*prescription);
        if (!lens) return Complain(path, lens.error());
    }
    lines += path + ": " + std::to_string(errors) + " errors, " +
             std::to_string(static_cast<int>(findings.size()) - errors) + " warnings\n";
    const int printed = Print(lines);
    return errors > 0 ? kBadInput : printed;
}

}  // namespace

void AddLensCommands(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<LensOptions>();
    CLI::App* lens = app.add_subcommand("lens", "The lens library");
    lens->require_subcommand(0, 1);
    lens->callback([lens, &exit_code] {
        if (!lens->get_subcommands().empty()) return;
        std::fputs(lens->help().c_str(), stderr);
        exit_code = kBadInput;
    });

    CLI::App* list = lens->add_subcommand("list", "List the lenses of the library");
    list->add_flag("--json", options->json, "JSON instead of a table");
    list->add_option("--lenses", options->lenses, "The folder of lens files")->type_name("DIR");
    list->callback([options, &exit_code] { exit_code = List(*options); });

    CLI::App* show = lens->add_subcommand("show", "Show a lens and its first-order data");
    show->add_option("name", options->name, "A lens of the library or a lens file")
        ->required()
        ->type_name("NAME");
    show->add_flag("--json", options->json, "JSON instead of a table");
    show->add_flag("--field", options->field,
                   "Distortion, illumination and transmittance against field angle instead");
    show->add_option("--lenses", options->lenses, "The folder of lens files")->type_name("DIR");
    show->callback([options, &exit_code] { exit_code = Show(*options); });

    CLI::App* check =
        lens->add_subcommand("check", "Does a lens file tell the truth about itself?");
    check->add_option("file", options->name, "A lens file, or - for standard input")
        ->required()
        ->type_name("FILE");
    check->callback([options, &exit_code] { exit_code = Check(*options); });
    AddLensDraw(*lens, exit_code);
}

}  // namespace flare::cli
