// SPDX-License-Identifier: Apache-2.0
//
// flare glass list | show: the glass catalogue that is built in.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "core/optics/glass_catalogue.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

std::string Upper(std::string text) {
    for (char& c : text) {
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    }
    return text;
}

// The entry that a name means, given the glass that the catalogue found for it.
const GlassEntry* EntryOf(const std::string& name, const Glass& glass) {
    for (const GlassEntry& entry : BuiltInGlasses().entries()) {
        const bool named =
            Upper(entry.full_name()) == Upper(name) || Upper(entry.name) == Upper(name);
        if (named && entry.glass == glass) return &entry;
    }
    return nullptr;
}

int List(const std::string& maker) {
    Table table({"name", "nd", "vd", "code", "from nm", "to nm", "absorption", "status"});
    int count = 0;
    for (const GlassEntry& entry : BuiltInGlasses().entries()) {
        if (!maker.empty() && entry.maker != maker) continue;
        ++count;
        table.AddRow({entry.full_name(), Fixed(entry.glass.nd(), 6), Fixed(entry.glass.vd(), 3),
                      entry.code, Fixed(entry.glass.low_nm(), 0), Fixed(entry.glass.high_nm(), 0),
                      entry.glass.absorbs() ? "known" : "", entry.status});
    }
    if (count == 0) return Complain("", {"unknown_maker", "no glass of \"" + maker + "\"", ""});
    return Print(table.text());
}

int Show(const std::string& name) {
    const Result<Glass> glass = GlassByName(name);
    if (!glass) return Complain("", glass.error());
    const GlassEntry* entry = EntryOf(name, *glass);
    FLARE_CHECK(entry != nullptr);
    Table table({"nm", "n", "absorbed in 10 mm"});
    const double lines[] = {365.0146, 404.6561, 435.8343, kLineF, 546.074,
                            kLineD,   632.8,    kLineC,   852.11, 1013.98};
    for (const double nm : lines) {
        if (nm < glass->low_nm() || nm > glass->high_nm()) continue;
        const double absorbed = -std::expm1(-10.0 * glass->AbsorptionPerMm(nm));
        table.AddRow({Fixed(nm, 4), Fixed(glass->Index(nm), 6),
                      glass->absorbs() ? Fixed(absorbed, 6) : "not known"});
    }
    return Print(entry->full_name() + "\n  n_d " + Fixed(glass->nd(), 6) + ", V_d " +
                 Fixed(glass->vd(), 3) + ", code " + entry->code +
                 (entry->status.empty() ? "" : ", " + entry->status) + "\n  formula from " +
                 Fixed(glass->low_nm(), 0) + " to " + Fixed(glass->high_nm(), 0) + " nm\n\n" +
                 table.text());
}

}  // namespace

void AddGlassCommands(CLI::App& app, int& exit_code) {
    CLI::App* glass = app.add_subcommand("glass", "The glass catalogue");
    glass->require_subcommand(0, 1);
    glass->callback([glass, &exit_code] {
        if (!glass->get_subcommands().empty()) return;
        std::fputs(glass->help().c_str(), stderr);
        exit_code = kBadInput;
    });
    auto word = std::make_shared<std::string>();
    CLI::App* list = glass->add_subcommand("list", "List the glasses");
    list->add_option("--maker", *word, "Of one maker, as SCHOTT")->type_name("MAKER");
    list->callback([word, &exit_code] { exit_code = List(*word); });
    CLI::App* show = glass->add_subcommand("show", "Show a glass's index at the usual lines");
    show->add_option("name", *word, "A glass, as \"SCHOTT N-BK7\" or \"N-BK7\"")
        ->required()
        ->type_name("NAME");
    show->callback([word, &exit_code] { exit_code = Show(*word); });
}

}  // namespace flare::cli
