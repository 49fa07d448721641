// SPDX-License-Identifier: Apache-2.0
//
// One door for every caller: the body of POST /v1/flare in, the bytes of the reply out. `flare
// render` calls it in process and the daemon calls it behind HTTP, so both give the same bytes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/base/spare_bytes.h"
#include "core/mesh/mesh_provider.h"
#include "server/encoder/encoder_set.h"
#include "server/lens_library.h"
#include "server/warm_ahead.h"

namespace flare {

enum class ReplyFormat { kExr, kPng, kHalfPlanes };

class RenderKeeper;

struct ServiceContext {
    const LensLibrary& lenses;
    ThreadPool& threads;
    MeshProvider& meshes;
    CancelToken cancel;
    std::function<double()> now_ms;        // monotonic
    SpareBytes* spare = nullptr;           // where replies have their memory from, or none
    const EncoderSet* encoders = nullptr;  // that requests may name; null: none
    WarmAhead* ahead = nullptr;            // is told what was asked of encoders; null: nobody
    RenderKeeper* keeper = nullptr;        // of what is kept from picture to picture; null: nothing
};

// Counted once a request for /metrics.
struct ServiceWork {
    std::uint64_t rays_traced = 0;
    std::uint64_t mesh_hits = 0, mesh_misses = 0;
};

struct ServiceReply {
    std::string bytes;
    std::string content_type;
    std::string report_summary;  // JSON, at most 4 KiB: for the Flare-Report header
    std::string report;          // JSON, whole: for GET /v1/reports/ID and --report
    std::string request_hash;    // 32 hex digits, of the decoded request and the lens's content
    ServiceWork work;
};

// `report_id` is put into the report ("" leaves it out). Errors carry code, message and `where`.
Result<ServiceReply> ServeFlare(std::string_view body, ReplyFormat format,
                                const std::string& report_id, const ServiceContext& context);

}  // namespace flare
