// SPDX-License-Identifier: Apache-2.0
#include "server/lens_query.h"

#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "protocol/limits.h"
#include "server/http/text.h"

namespace flare {
namespace {

constexpr double kMaxField_deg = 180.0;
constexpr double kMaxAzimuth_deg = 360.0;
constexpr double kAboveZero = std::numeric_limits<double>::min();

struct Range {
    double low, high;
};

std::string Text(Range range) {
    char text[80];
    if (range.low == kAboveZero) {
        std::snprintf(text, sizeof text, "a number above 0 and at most %g", range.high);
    } else {
        std::snprintf(text, sizeof text, "a number from %g to %g", range.low, range.high);
    }
    return text;
}

// One parameter of the query at a time: each Read says whether it was its own.
class Parameter {
  public:
    Parameter(const std::string& name, const std::string& text) : name_(name), text_(text) {}

    const std::optional<Error>& error() const { return error_; }

    template <class Number>
    bool Read(std::string_view name, Range range, Number& out) {
        if (name != name_) return false;
        const std::optional<double> value = ParseNumber(text_);
        if (value && *value >= range.low && *value <= range.high) {
            out = *value;
        } else {
            Refuse(Text(range));
        }
        return true;
    }

    bool ReadReflections(int& out) {
        if (name_ != "reflections") return false;
        if (text_ != "2" && text_ != "4") Refuse("2 or 4");
        out = text_ == "4" ? 4 : 2;
        return true;
    }

    bool Read(std::string_view name, bool& out) {
        if (name != name_) return false;
        if (text_ != "true" && text_ != "false") Refuse("true or false");
        out = text_ == "true";
        return true;
    }

    bool ReadCoatings(wire::Coatings& out) {
        if (name_ != "coatings") return false;
        if (text_.empty() || text_.size() > limits::kNameBytes) Refuse("none or a coating's name");
        out.none = text_ == "none";
        if (!out.none) out.default_name = text_;
        return true;
    }

    bool ReadState(LensState& state) {
        return Read("focus_m", {kAboveZero, limits::kMaxDistance_m}, state.focus_m) ||
               Read("zoom_mm", {kAboveZero, limits::kMaxZoom_mm}, state.zoom_mm);
    }

    void RefuseUnknown() {
        error_ = Error{"unknown_field", "there is no parameter '" + name_ + "'", "?" + name_};
    }

  private:
    void Refuse(const std::string& expected) {
        error_ = Error{"bad_value", name_ + " is '" + text_ + "', not " + expected, "?" + name_};
    }

    const std::string& name_;
    const std::string& text_;
    std::optional<Error> error_;
};

// Hands each parameter to `read`, which says whether it knew it.
template <class Read>
std::optional<Error> ReadAll(std::string_view text, const Read& read) {
    const Result<Query> query = ParseQuery(text);
    if (!query) return query.error();
    for (const auto& [name, value] : *query) {
        Parameter parameter(name, value);
        if (!read(parameter)) parameter.RefuseUnknown();
        if (parameter.error()) return parameter.error();
    }
    return std::nullopt;
}

}  // namespace

Result<LensState> ParseLensQuery(std::string_view query) {
    LensState state;
    const auto error = ReadAll(query, [&](Parameter& p) { return p.ReadState(state); });
    if (error) return *error;
    return state;
}

Result<GhostQuery> ParseGhostQuery(std::string_view query) {
    GhostQuery result;
    const auto error = ReadAll(query, [&](Parameter& p) {
        return p.ReadState(result.state) || p.ReadCoatings(result.coatings) ||
               p.Read("field_deg", {-kMaxField_deg, kMaxField_deg}, result.field_deg) ||
               p.Read("azimuth_deg", {-kMaxAzimuth_deg, kMaxAzimuth_deg}, result.azimuth_deg) ||
               p.Read("f_number", {limits::kMinFNumber, limits::kMaxFNumber}, result.f_number) ||
               p.Read("wavelength_nm", {limits::kMinWavelength_nm, limits::kMaxWavelength_nm},
                      result.wavelength_nm) ||
               p.ReadReflections(result.model.reflections) ||
               p.Read("threshold", {kAboveZero, limits::kMaxFourReflectionThreshold},
                      result.model.four_reflection_threshold) ||
               p.Read("sensor_reflection", result.model.sensor_reflection);
    });
    if (error) return *error;
    return result;
}

}  // namespace flare
