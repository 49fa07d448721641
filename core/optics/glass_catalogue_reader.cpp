// SPDX-License-Identifier: Apache-2.0
//
// A line is read field by field into the data of a glass; then the glass is asked for its index
// over all wavelengths that the program uses, so that no pole and no misprint gets past here.
#include "core/optics/glass_catalogue_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace flare {

namespace {

constexpr std::size_t kColumns = 10;
constexpr std::size_t kMaxCoefficients = 31;
constexpr double kMaxPower = 20.0;
constexpr double kNmPerUm = 1000.0;
constexpr double kMaxUm = 100.0;

Error Bad(std::string message) {
    return {"bad_catalogue", std::move(message), ""};
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(separator, at), text.size());
        parts.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return parts;
}

std::optional<double> Number(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
        return std::nullopt;
    }
    return value;
}

// Numbers with one space between them; nothing if one of them is none.
std::vector<double> Numbers(std::string_view text) {
    std::vector<double> numbers;
    for (const std::string_view part : Split(text, ' ')) {
        const std::optional<double> number = Number(part);
        if (!number.has_value()) return {};
        numbers.push_back(*number);
    }
    return numbers;
}

// Formula numbers and the order of coefficients are those of refractiveindex.info.
std::optional<Error> ReadFormula(std::string_view number, std::string_view coefficients,
                                 GlassData& out) {
    using Formula = GlassData::Formula;
    if (number == "1" || number == "2") {
        out.formula = Formula::kSellmeier;
    } else if (number == "3") {
        out.formula = Formula::kSquaredPowers;
    } else if (number == "5") {
        out.formula = Formula::kPowers;
    } else {
        return Bad("the formula must be 1, 2, 3 or 5, not \"" + std::string(number) + "\"");
    }
    const bool sellmeier = out.formula == Formula::kSellmeier;
    const std::vector<double> c = Numbers(coefficients);
    if (c.size() % 2 == 0 || c.size() < 3 || c.size() > kMaxCoefficients) {
        return Bad("the coefficients must be an odd number of numbers, 3 to " +
                   std::to_string(kMaxCoefficients));
    }
    out.constant = sellmeier ? 1.0 + c[0] : c[0];
    for (std::size_t i = 1; i < c.size(); i += 2) {
        const double place = number == "1" ? c[i + 1] * c[i + 1] : c[i + 1];
        if (!sellmeier && (place != std::round(place) || std::abs(place) > kMaxPower)) {
            return Bad("the powers must be whole numbers of at most 20");
        }
        out.terms.push_back({c[i], place});
    }
    return std::nullopt;
}

std::optional<Error> ReadRange(std::string_view text, GlassData& out) {
    const std::vector<double> range = Numbers(text);
    if (range.size() != 2 || !(range[0] > 0.0 && range[0] < range[1] && range[1] <= kMaxUm)) {
        return Bad("the range must be two rising wavelengths above 0, in um");
    }
    out.low_nm = range[0] * kNmPerUm;
    out.high_nm = range[1] * kNmPerUm;
    return std::nullopt;
}

std::optional<Error> ReadAbsorption(std::string_view text, GlassData& out) {
    if (text.empty()) return std::nullopt;
    double last_nm = 0.0;
    for (const std::string_view item : Split(text, ';')) {
        const std::vector<std::string_view> pair = Split(item, ':');
        const std::optional<double> um = Number(pair[0]);
        const std::optional<double> k = pair.size() == 2 ? Number(pair[1]) : std::nullopt;
        if (!um.has_value() || !k.has_value()) {
            return Bad("the absorption \"" + std::string(item) + "\" is not um:k");
        }
        if (!(*um * kNmPerUm > last_nm && *um <= kMaxUm && *k >= 0.0 && *k < 1.0)) {
            return Bad("the absorption points must rise and k be 0 or more and below 1");
        }
        last_nm = *um * kNmPerUm;
        out.absorption.push_back({last_nm, *k});
    }
    return std::nullopt;
}

std::optional<Error> CheckIndex(const Glass& glass) {
    for (int nm = 300; nm <= 1100; ++nm) {
        const double n = glass.Index(nm);
        if (!(n >= 1.0 && n <= 4.0)) {
            return Bad("the index at " + std::to_string(nm) + " nm is not within 1 .. 4");
        }
    }
    return std::nullopt;
}

}  // namespace

Result<GlassEntry> ReadGlassLine(std::string_view line) {
    const std::vector<std::string_view> fields = Split(line, '\t');
    if (fields.size() != kColumns) {
        return Bad("a line has " + std::to_string(kColumns) + " fields, not " +
                   std::to_string(fields.size()));
    }
    const auto is_word = [](std::string_view text) {
        return !text.empty() &&
               std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
    };
    if (!is_word(fields[0]) || !is_word(fields[1])) {
        return Bad("maker and glass must be words without spaces");
    }

    GlassData data;
    if (auto error = ReadFormula(fields[2], fields[4], data)) return *std::move(error);
    if (auto error = ReadRange(fields[3], data)) return *std::move(error);
    if (auto error = ReadAbsorption(fields[9], data)) return *std::move(error);
    const std::optional<double> nd = Number(fields[5]), vd = Number(fields[6]);
    if (nd.has_value() == fields[5].empty() || vd.has_value() == fields[6].empty()) {
        return Bad("nd and Vd must be numbers or empty");
    }
    Glass glass(std::move(data));
    if (auto error = CheckIndex(glass)) return *std::move(error);
    return GlassEntry{
        std::string(fields[0]), std::string(fields[1]), nd, vd, std::string(fields[7]),
        std::string(fields[8]), std::move(glass)};
}

}  // namespace flare
