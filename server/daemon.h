// SPDX-License-Identifier: Apache-2.0
//
// The daemon behind its sockets: routes a request, decides whether it may run, has it run, and
// answers. What a picture is it does not know: that comes in as functions, so that a test can put a
// clock or a failure there.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/result.h"
#include "server/counters_table.h"
#include "server/http/listening_socket.h"
#include "server/http/server.h"
#include "server/schedule/scheduler.h"
#include "server/service.h"
#include "server/translate/ghost_query.h"
#include "server/warm_work.h"

namespace flare {

// Called from several threads at once. Errors become replies (docs/daemon.md has the table); one
// with the code "cancelled" is expected only after the token was set.
struct DaemonServices {
    std::function<Result<ServiceReply>(std::string_view body, ReplyFormat format,
                                       const std::string& report_id, const CancelToken& cancel)>
        flare;
    // An estimate of the memory that a flare request takes while it runs; 0 if the body is no
    // request at all.
    std::function<std::uint64_t(std::string_view body)> picture_bytes;
    std::function<Result<std::string>(const std::string& lens, const GhostQuery& query,
                                      const CancelToken& cancel)>
        ghosts;  // JSON
    std::function<Result<std::string>(const std::string& lens, const LensState& state)>
        lens;                  // JSON
    std::string lens_list;     // JSON
    std::string_view openapi;  // YAML; outlives the daemon
    std::function<CacheReadings()> cache;
    std::shared_ptr<SpareBytes> spare;  // takes the memory of pictures that were sent, or nobody
    std::function<std::string()> encoders;  // JSON
    std::function<std::vector<EncoderCounts>()> encoder_counts;
    // What POST /v1/warm asks for, understood and checked; its steps come from one thread at a
    // time.
    std::function<Result<WarmTask>(std::string_view body)> warm;
};

struct DaemonOptions {
    HttpLimits http;
    ScheduleLimits schedule;
    std::string version;
};

class Daemon {
  public:
    // Serves from construction on.
    Daemon(const DaemonOptions& options, DaemonServices services,
           std::vector<ListeningSocket> sockets);
    ~Daemon();
    Daemon(const Daemon&) = delete;
    Daemon& operator=(const Daemon&) = delete;

    // Work in steps of some milliseconds, done only while no request waits or runs. False: there is
    // no room for more of it, or the daemon is going down.
    bool SubmitBackground(std::function<bool()> step);

    // From now on /readyz says 503, new work is refused and every reply closes its connection.
    void StartDraining();
    // Waits until the admitted work is done and its replies are written; false if `bound` passed
    // before.
    bool WaitUntilDrained(std::chrono::milliseconds bound);
    // Cancels what is left of the work; it is answered 503.
    void CutOff();

  private:
    class Handler;
    std::unique_ptr<Handler> handler_;
    std::unique_ptr<HttpServer> server_;
};

}  // namespace flare
