// SPDX-License-Identifier: Apache-2.0
#include "server/routes.h"

#include <array>
#include <vector>

#include "server/http/text.h"

namespace flare {
namespace {

struct Pattern {
    RouteId id;
    std::string_view path;  // a part in capitals stands for any one part
    bool post = false;
    bool can_delete = false;
};

constexpr std::array kPatterns{
    Pattern{RouteId::kFlare, "/v1/flare", true},
    Pattern{RouteId::kLenses, "/v1/lenses"},
    Pattern{RouteId::kLens, "/v1/lenses/NAME"},
    Pattern{RouteId::kGhosts, "/v1/lenses/NAME/ghosts"},
    Pattern{RouteId::kReport, "/v1/reports/ID"},
    Pattern{RouteId::kOpenApi, "/v1/openapi.yaml"},
    Pattern{RouteId::kMetrics, "/metrics"},
    Pattern{RouteId::kHealthz, "/healthz"},
    Pattern{RouteId::kReadyz, "/readyz"},
    Pattern{RouteId::kWarm, "/v1/warm", true},
    Pattern{RouteId::kWarmJob, "/v1/warm/ID", false, true},
    Pattern{RouteId::kEncoders, "/v1/encoders"},
    Pattern{RouteId::kNotBuilt, "/v1/live"},
    Pattern{RouteId::kNotBuilt, "/"},
};

// The name that fills the pattern ("" if it has no place for one), or nullopt.
std::optional<std::string> Match(std::string_view pattern, std::string_view path) {
    const auto wanted = Split(pattern, '/'), given = Split(path, '/');
    if (wanted.size() != given.size()) return std::nullopt;
    std::string name;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i] == "NAME" || wanted[i] == "ID") {
            const std::optional<std::string> decoded = DecodePercent(given[i]);
            if (!decoded || decoded->empty()) return std::nullopt;
            name = *decoded;
        } else if (wanted[i] != given[i]) {
            return std::nullopt;
        }
    }
    return name;
}

}  // namespace

bool Route::allows(std::string_view method) const {
    if (post) return method == "POST";
    return method == "GET" || method == "HEAD" || (can_delete && method == "DELETE");
}

std::optional<Route> FindRoute(std::string_view path) {
    for (const Pattern& pattern : kPatterns) {
        if (std::optional<std::string> name = Match(pattern.path, path)) {
            return Route{pattern.id, pattern.path, pattern.post, pattern.can_delete,
                         std::move(*name)};
        }
    }
    return std::nullopt;
}

}  // namespace flare
