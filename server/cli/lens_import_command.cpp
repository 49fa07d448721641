// SPDX-License-Identifier: Apache-2.0
//
// flare lens import: a lens that another program wrote, as a lens file.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_writer.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/lens_commands.h"
#include "server/translate/lens_import_json.h"

namespace flare::cli {
namespace {

struct ImportOptions {
    std::string file, output, from;
};

// Is it a name as a library has them?
bool IsSlug(const std::string& name) {
    return !name.empty() && name.size() <= 100 && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    });
}

int Import(const ImportOptions& options) {
    const Result<std::string> text = ReadInput(options.file);
    if (!text) return Complain("", text.error());
    Result<ImportedLens> imported =
        ImportLensFile(*text, options.from.empty() ? std::nullopt : FormatByName(options.from));
    if (!imported) return Complain(options.file, imported.error());
    // A library finds a lens by its file's name.
    const std::string stem = std::filesystem::path(options.output).stem().string();
    if (options.output != "-" && IsSlug(stem)) imported->prescription.name = stem;

    std::string told = options.file + ": read as " + std::string(FormatName(imported->format)) +
                       ", " + std::to_string(imported->prescription.surfaces.size()) +
                       " surfaces\n";
    for (const std::string& remark : imported->remarks) told += options.file + ": " + remark + "\n";
    int errors = 0;
    for (const Finding& finding : CheckPrescription(imported->prescription)) {
        const bool error = finding.severity == Severity::kError;
        errors += error ? 1 : 0;
        told += options.file + ": " + (finding.where.empty() ? "" : finding.where + ": ") +
                (error ? "error: " : "warning: ") + finding.message + " [" + finding.code + "]\n";
    }
    std::fputs(told.c_str(), stderr);
    if (const std::optional<Error> error =
            WriteOutput(options.output, TomlFromPrescription(imported->prescription))) {
        return Complain("", *error);
    }
    return errors > 0 ? kBadInput : kDone;
}

}  // namespace

void AddLensImport(CLI::App& lens, int& exit_code) {
    auto options = std::make_shared<ImportOptions>();
    CLI::App* command = lens.add_subcommand(
        "import",
        "Read a lens of another program and write a lens file; what was not carried over and what "
        "the lint finds is said. With errors of the lint the file is written all the same, to be "
        "mended, and the exit code is 2");
    command->add_option("file", options->file, "The foreign file, or - for standard input")
        ->required()
        ->type_name("FILE");
    command->add_option("-o,--output", options->output, "The lens file, or - for standard output")
        ->required()
        ->type_name("OUT.toml");
    command->add_option("--from", options->from, "The format, where its content does not tell it")
        ->check(CLI::IsMember(FormatNames()));
    command->callback([options, &exit_code] { exit_code = Import(*options); });
}

}  // namespace flare::cli
