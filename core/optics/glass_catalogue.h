// SPDX-License-Identifier: Apache-2.0
//
// Glasses by name, as makers publish them: about 1600 of Schott, Ohara, Hoya, Hikari, CDGM and
// Sumita (lenses/glass/). A name is "MAKER NAME" ("SCHOTT N-BK7") or the glass's name alone where
// no other maker uses it; upper and lower case are one. Nothing else is accepted: "BK7", "NBK7" and
// "N-BK 7" are errors that list near names, never another glass.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/optics/glass.h"

namespace flare {

struct GlassEntry {
    std::string maker, name;
    std::optional<double> nd, vd;  // as the maker prints them; glass.nd() follows from the formula
    std::string code;              // "517642.251": what n_d and V_d round to, and the density
    std::string status;            // "preferred", "standard", "special", ...; "" where not known
    Glass glass;                   // glass.absorbs(): the catalogue has internal absorption

    std::string full_name() const { return maker + " " + name; }
};

class GlassCatalogue {
  public:
    // Reads the text of a catalogue file (lenses/glass/README.md). Fails with code "bad_catalogue"
    // and the line. Every glass read has an index between 1 and 4 from 300 to 1100 nm.
    static Result<GlassCatalogue> Parse(std::string_view text);

    // By maker, then by name.
    const std::vector<GlassEntry>& entries() const { return entries_; }

    // Fails with code "unknown_glass" and up to five near names, or "ambiguous_glass" and all
    // glasses of that name. Takes microseconds; a failure a quarter of a millisecond.
    Result<Glass> Find(std::string_view name) const;

  private:
    std::vector<std::string> NearNames(std::string_view name) const;

    std::vector<GlassEntry> entries_;
    // Upper-case names, with the maker and without, to places in entries_.
    std::map<std::string, std::size_t, std::less<>> by_full_name_;
    std::map<std::string, std::vector<std::size_t>, std::less<>> by_name_;
};

// The catalogue that is built into the program. The first call reads it (some 30 ms).
const GlassCatalogue& BuiltInGlasses();

// Find in the catalogue that is built in.
Result<Glass> GlassByName(std::string_view name);

}  // namespace flare
