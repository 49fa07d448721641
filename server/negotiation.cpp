// SPDX-License-Identifier: Apache-2.0
//
// RFC 9110, 12.5.1: of the media ranges that cover a type the most specific one gives its quality;
// the type with the highest quality wins; quality 0 rules a type out.
#include "server/negotiation.h"

#include <array>
#include <utility>

#include "server/http/text.h"

namespace flare {
namespace {

constexpr std::array<std::pair<std::string_view, ReplyFormat>, 3> kForms{{
    {"image/x-exr", ReplyFormat::kExr},
    {"image/png", ReplyFormat::kPng},
    {"application/x-flare-half", ReplyFormat::kHalfPlanes},
}};

// 3: the type itself, 2: "image/*", 1: "*/*", 0: does not cover it.
int Specificity(std::string_view range, std::string_view type) {
    if (range == "*/*") return 1;
    if (EqualIgnoringCase(range, type)) return 3;
    if (!range.ends_with("/*")) return 0;
    const std::string_view family = range.substr(0, range.size() - 1);
    return EqualIgnoringCase(family, type.substr(0, family.size())) ? 2 : 0;
}

double QualityOf(const std::vector<std::string_view>& parameters) {
    for (std::size_t i = 1; i < parameters.size(); ++i) {
        const std::string_view parameter = TrimSpace(parameters[i]);
        if (parameter.size() < 2 || !EqualIgnoringCase(parameter.substr(0, 2), "q=")) continue;
        const auto quality = ParseNumber(parameter.substr(2));
        return quality && *quality >= 0.0 && *quality <= 1.0 ? *quality : 0.0;
    }
    return 1.0;
}

double QualityFor(std::string_view accept, std::string_view type) {
    int best_specificity = 0;
    double quality = 0.0;
    for (const std::string_view item : Split(accept, ',')) {
        const auto parameters = Split(item, ';');
        const int specificity = Specificity(TrimSpace(parameters[0]), type);
        if (specificity <= best_specificity) continue;
        best_specificity = specificity;
        quality = QualityOf(parameters);
    }
    return quality;
}

}  // namespace

std::optional<ReplyFormat> FormatForAccept(std::optional<std::string_view> accept) {
    if (!accept || TrimSpace(*accept).empty()) return ReplyFormat::kExr;
    std::optional<ReplyFormat> best;
    double best_quality = 0.0;
    for (const auto& [type, form] : kForms) {
        const double quality = QualityFor(*accept, type);
        if (quality <= best_quality) continue;
        best_quality = quality;
        best = form;
    }
    return best;
}

bool IsJson(std::optional<std::string_view> content_type) {
    if (!content_type) return true;
    const auto parts = Split(*content_type, ';');
    if (!EqualIgnoringCase(TrimSpace(parts[0]), "application/json")) return false;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        const std::string_view part = TrimSpace(parts[i]);
        if (part.empty() || EqualIgnoringCase(part, "charset=utf-8") ||
            EqualIgnoringCase(part, "charset=\"utf-8\"")) {
            continue;
        }
        return false;
    }
    return true;
}

}  // namespace flare
