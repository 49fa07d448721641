// SPDX-License-Identifier: Apache-2.0
//
// Renders a request: lights in, flare layers out. The bytes of the image depend on the request
// alone, never on threads, caches or the order of requests.
#pragma once

#include <functional>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/image/flare_image.h"
#include "core/mesh/mesh_provider.h"
#include "core/render/flare_request.h"
#include "core/render/report.h"

namespace flare {

class RenderKeeper;

// What the renderer borrows from its caller. Nothing here changes the image.
struct RenderContext {
    ThreadPool& threads;
    MeshProvider& meshes;
    CancelToken cancel;
    std::function<double()> now_ms;  // a monotonic clock for the report
    RenderKeeper* keeper = nullptr;  // of what is kept from picture to picture; null: nothing is
};

struct Rendering {
    FlareImage image;
    Report report;
    Quality quality;  // that was drawn: the request's, or what was found for it
};

// Errors name the request's field by JSON pointer; code "cancelled" if the token was set.
Result<Rendering> Render(const FlareRequest& request, const RenderContext& context);

// Checks the values of a request without rendering it. The empty optional says it is sound.
std::optional<Error> CheckRequest(const FlareRequest& request);

}  // namespace flare
