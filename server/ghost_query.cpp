// SPDX-License-Identifier: Apache-2.0
#include "server/ghost_query.h"

#include <string>

#include "protocol/limits.h"
#include "server/http/text.h"

namespace flare {
namespace {

constexpr double kMaxField_deg = 180.0;
constexpr double kMinFNumber = 1e-3;  // less than the lens has is clamped anyway

Result<double> NumberBetween(const std::string& name, const std::string& text, double low,
                             double high) {
    const std::optional<double> value = ParseNumber(text);
    if (value && *value >= low && *value <= high) return *value;
    return Error{"bad_value",
                 name + " is '" + text + "', not a number from " + std::to_string(low) + " to " +
                     std::to_string(high),
                 "?" + name};
}

}  // namespace

Result<GhostQuery> ParseGhostQuery(std::string_view text) {
    const Result<Query> query = ParseQuery(text);
    if (!query) return query.error();
    GhostQuery result;
    for (const auto& [name, value] : *query) {
        if (name == "coatings") {
            if (value != "none") {
                return Error{"bad_value", "coatings can only be none, not '" + value + "'",
                             "?coatings"};
            }
            result.bare_glass = true;
            continue;
        }
        Result<double> number =
            Error{"unknown_field", "there is no parameter '" + name + "'", "?" + name};
        if (name == "field_deg") {
            number = NumberBetween(name, value, -kMaxField_deg, kMaxField_deg);
            if (number) result.field_deg = *number;
        } else if (name == "f_number") {
            number = NumberBetween(name, value, kMinFNumber, limits::kMaxFNumber);
            if (number) result.f_number = *number;
        } else if (name == "wavelength_nm") {
            number =
                NumberBetween(name, value, limits::kMinWavelength_nm, limits::kMaxWavelength_nm);
            if (number) result.wavelength_nm = *number;
        }
        if (!number) return number.error();
    }
    return result;
}

}  // namespace flare
