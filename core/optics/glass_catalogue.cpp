// SPDX-License-Identifier: Apache-2.0
//
// How near two names are is judged without regard to hyphens, case and the family letter before the
// first hyphen ("N-", "S-", "J-"), because these are what people leave out or mix up; after that by
// the edit distance. It only ever words an error message.
#include "core/optics/glass_catalogue.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/check.h"
#include "core/optics/glass_catalogue_reader.h"
#include "core/optics/glass_catalogue_text.h"

namespace flare {

namespace {

// Longer names are no glass and not worth a comparison with every one.
constexpr std::size_t kMaxNameBytes = 40;
constexpr std::size_t kMaxNearNames = 5;
constexpr std::size_t kMaxEdits = 2;

char Upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

std::string UpperCase(std::string_view text) {
    std::string upper(text);
    std::transform(upper.begin(), upper.end(), upper.begin(), Upper);
    return upper;
}

// Upper-case letters and digits only.
std::string Bare(std::string_view name) {
    std::string bare;
    for (const char c : name) {
        const char upper = Upper(c);
        if ((upper >= 'A' && upper <= 'Z') || (upper >= '0' && upper <= '9')) bare += upper;
    }
    return bare;
}

// "BK7" of "N-BK7".
std::string_view WithoutFamily(std::string_view name) {
    const std::size_t hyphen = name.find('-');
    return hyphen <= 2 ? name.substr(hyphen + 1) : name;
}

// Edit distance (insert, delete, replace), or kMaxEdits + 1 where it is larger than that by length
// alone.
std::size_t Edits(const std::string& one, const std::string& other) {
    const auto [shorter, longer] = std::minmax(one.size(), other.size());
    if (longer - shorter > kMaxEdits) return kMaxEdits + 1;
    std::vector<std::size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < one.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < other.size(); ++j) {
            const std::size_t replaced = diagonal + (one[i] == other[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

std::string Join(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

}  // namespace

Result<GlassCatalogue> GlassCatalogue::Parse(std::string_view text) {
    GlassCatalogue catalogue;
    bool titled = false;
    std::size_t number = 0;
    const auto bad = [&number](std::string message) {
        return Error{"bad_catalogue", std::move(message), "line " + std::to_string(number)};
    };
    while (!text.empty()) {
        ++number;
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.empty() || line.front() == '#') continue;
        if (!titled) {
            if (line != kGlassColumns) return bad("the first line must name the columns");
            titled = true;
            continue;
        }
        Result<GlassEntry> entry = ReadGlassLine(line);
        if (!entry) return bad(entry.error().message);
        const std::size_t place = catalogue.entries_.size();
        if (!catalogue.by_full_name_.emplace(UpperCase(entry->full_name()), place).second) {
            return bad("there is a second " + entry->full_name());
        }
        catalogue.by_name_[UpperCase(entry->name)].push_back(place);
        catalogue.entries_.push_back(std::move(*entry));
    }
    if (!titled) return bad("the text ends before it names the columns");
    return catalogue;
}

Result<Glass> GlassCatalogue::Find(std::string_view name) const {
    if (name.size() > kMaxNameBytes) {
        return Error{"unknown_glass",
                     "there is no glass with a name of " + std::to_string(name.size()) + " bytes",
                     ""};
    }
    const std::string key = UpperCase(name);
    if (const auto found = by_full_name_.find(key); found != by_full_name_.end()) {
        return entries_[found->second].glass;
    }
    const std::string quoted = "\"" + std::string(name) + "\"";
    if (const auto found = by_name_.find(key); found != by_name_.end()) {
        if (found->second.size() == 1) return entries_[found->second.front()].glass;
        std::vector<std::string> all;
        for (const std::size_t place : found->second) all.push_back(entries_[place].full_name());
        return Error{"ambiguous_glass",
                     "the glass " + quoted + " is made by several, and not the same: " + Join(all) +
                         "; name the maker too",
                     ""};
    }
    const std::vector<std::string> near = NearNames(name);
    return Error{"unknown_glass",
                 "there is no glass " + quoted +
                     (near.empty() ? "" : "; the nearest names are " + Join(near)),
                 ""};
}

std::vector<std::string> GlassCatalogue::NearNames(std::string_view name) const {
    // A maker may stand in front, however it is set off.
    std::string maker;
    if (const std::size_t gap = name.find_first_of(" :/_"); gap != std::string_view::npos) {
        const std::string first = UpperCase(name.substr(0, gap));
        if (std::any_of(entries_.begin(), entries_.end(),
                        [&](const GlassEntry& entry) { return entry.maker == first; })) {
            maker = first;
            name.remove_prefix(gap + 1);
        }
    }
    const std::string wanted = Bare(name), core = Bare(WithoutFamily(name));
    if (wanted.empty()) return {};

    std::set<std::pair<std::size_t, std::size_t>> near;  // how far, and which
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        const std::string bare = Bare(entries_[i].name);
        std::size_t far = Edits(wanted, bare);
        if (far > kMaxEdits && Bare(WithoutFamily(entries_[i].name)) != core) continue;
        if (far > 0) far = Bare(WithoutFamily(entries_[i].name)) == core ? 1 : far + 1;
        if (!maker.empty() && entries_[i].maker != maker) ++far;
        near.emplace(far, i);
    }
    std::vector<std::string> names;
    for (const auto& [far, place] : near) {
        if (names.size() == kMaxNearNames) break;
        names.push_back(entries_[place].full_name());
    }
    return names;
}

const GlassCatalogue& BuiltInGlasses() {
    static const GlassCatalogue catalogue = [] {
        Result<GlassCatalogue> read = GlassCatalogue::Parse(GlassCatalogueText());
        FLARE_CHECK(read.ok());
        return std::move(*read);
    }();
    return catalogue;
}

Result<Glass> GlassByName(std::string_view name) {
    return BuiltInGlasses().Find(name);
}

}  // namespace flare
