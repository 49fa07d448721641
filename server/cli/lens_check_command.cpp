// SPDX-License-Identifier: Apache-2.0
//
// flare lens check: does a lens file tell the truth about itself?
#include <CLI/CLI.hpp>
#include <filesystem>

#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/lens_commands.h"

namespace flare::cli {
namespace {

int Check(const std::string& path) {
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

void AddLensCheck(CLI::App& lens, int& exit_code) {
    auto path = std::make_shared<std::string>();
    CLI::App* command =
        lens.add_subcommand("check", "Does a lens file tell the truth about itself?");
    command->add_option("file", *path, "A lens file, or - for standard input")
        ->required()
        ->type_name("FILE");
    command->callback([path, &exit_code] { exit_code = Check(*path); });
}

}  // namespace flare::cli
