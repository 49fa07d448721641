// SPDX-License-Identifier: Apache-2.0
//
// The paths of the contract and what may be done with each.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace flare {

enum class RouteId {
    kFlare,
    kLenses,
    kLens,
    kGhosts,
    kReport,
    kWarm,
    kWarmJob,
    kEncoders,
    kOpenApi,
    kMetrics,
    kHealthz,
    kReadyz,
    kNotBuilt,  // stands in the contract and is not served yet
};

struct Route {
    RouteId id;
    std::string_view pattern;  // "/v1/lenses/NAME"
    bool post = false;         // else GET, and with it HEAD
    bool can_delete = false;   // and DELETE
    std::string name;          // what stands at NAME or ID, decoded

    std::string_view allow() const {
        return post ? "POST" : can_delete ? "GET, HEAD, DELETE" : "GET, HEAD";
    }
    bool allows(std::string_view method) const;
};

// nullopt if there is nothing at this path.
std::optional<Route> FindRoute(std::string_view path);

}  // namespace flare
