// SPDX-License-Identifier: Apache-2.0
//
// The handler refuses what it can from the head alone, answers small things on the transport's
// thread, and hands pictures, lenses in a state and ghost lists to the scheduler. Each request ends
// in exactly one call of Answer or Abandon, which count and log it.
#include "server/daemon.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include "server/lens_query.h"
#include "server/negotiation.h"
#include "server/refusals.h"
#include "server/report_store.h"
#include "server/routes.h"
#include "server/warm_jobs.h"

namespace flare {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kClientLeft = 499;  // in logs and counters only: no such reply is ever written
constexpr std::chrono::seconds kLastReplies{2};

// One request on its way to its reply.
struct Exchange {
    std::string method, target;
    std::string_view route;
    Clock::time_point start = Clock::now();
    HttpHandler::Done done;
};
using ExchangePtr = std::shared_ptr<Exchange>;

}  // namespace

class Daemon::Handler final : public HttpHandler {
  public:
    Handler(const DaemonOptions& options, DaemonServices services)
        : services_(std::move(services)),
          counters_(options.version),
          scheduler_(options.schedule) {}

    std::optional<HttpReply> Refuse(const HttpHead& head) override;
    void Handle(HttpRequest request, Done done) override;
    HttpReply TransportError(int status, const Error& error) override;
    void ClientTooSlow() override { counters_.CountRejection("slow_client"); }

    void StartDraining() {
        draining_ = true;
        scheduler_.StopAdmitting();
    }
    Scheduler& scheduler() { return scheduler_; }
    void ShowConnectionsOf(const HttpServer* server) { server_ = server; }

  private:
    HttpReply RefusalReply(Refusal refusal);
    HttpReply AnswerNow(const Route& route);
    HttpReply Metrics() const;
    HttpReply ReportReply(const std::string& id) const;
    void SubmitFlare(HttpRequest request, const ExchangePtr& exchange);
    void SubmitLens(const HttpRequest& request, const std::string& lens,
                    const ExchangePtr& exchange);
    void SubmitGhosts(const HttpRequest& request, const std::string& lens,
                      const ExchangePtr& exchange);
    void SubmitWarm(HttpRequest request, const ExchangePtr& exchange);
    HttpReply WarmReply(const Route& route, std::string_view method);
    template <class Work>
    void SubmitJson(const HttpRequest& request, const ExchangePtr& exchange, const Work& work);
    void Submit(Job job, const ExchangePtr& exchange);
    template <class Work>
    void RunGuarded(const JobTicket& ticket, const ExchangePtr& exchange, const Work& work);
    void AnswerFlare(ServiceReply reply, const std::string& id, const ExchangePtr& exchange);
    void AnswerError(const Error& error, const JobTicket& ticket, const ExchangePtr& exchange);
    void Answer(HttpReply reply, const ExchangePtr& exchange);
    void Abandon(const ExchangePtr& exchange);
    void Count(const Exchange& exchange, int status);

    const DaemonServices services_;
    CountersTable counters_;
    ReportStore reports_;
    WarmJobs warm_jobs_;
    Scheduler scheduler_;
    std::atomic<bool> draining_ = false;
    std::atomic<const HttpServer*> server_ = nullptr;
};

std::optional<HttpReply> Daemon::Handler::Refuse(const HttpHead& head) {
    const std::optional<Route> route = FindRoute(head.path);
    std::optional<HttpReply> reply;
    if (!route) {
        reply = ErrorReply(404, {"not_found", "nothing is served at '" + head.path + "'", ""});
    } else if (!route->allows(head.method)) {
        reply = ErrorReply(405, {"method_not_allowed",
                                 std::string(route->pattern) + " takes " +
                                     std::string(route->allow()) + ", not " + head.method,
                                 ""});
        reply->fields.emplace_back("Allow", route->allow());
    } else if (route->id == RouteId::kNotBuilt) {
        reply = ErrorReply(501, {"unsupported", head.path + " is not built yet", ""});
    } else if (route->id == RouteId::kFlare) {
        reply = RefuseFlareHead(head);
    } else if (route->id == RouteId::kWarm || head.method == "DELETE") {
        reply = RefuseWorkHead(head);
    }
    const bool is_work = route && (route->id == RouteId::kFlare || route->id == RouteId::kLens ||
                                   route->id == RouteId::kGhosts || route->id == RouteId::kWarm);
    if (!reply && is_work && draining_) reply = RefusalReply(Refusal::kDraining);
    if (reply)
        counters_.CountRequest(route ? std::string(route->pattern) : "other", reply->status, 0.0);
    return reply;
}

HttpReply Daemon::Handler::TransportError(int status, const Error& error) {
    if (error.code == "overloaded") counters_.CountRejection("connections");
    counters_.CountRequest("other", status, 0.0);
    spdlog::info("{} {}: {}", status, error.code, error.message);
    HttpReply reply = ErrorReply(status, error);
    if (status == 503) reply.fields.emplace_back("Retry-After", "1");
    return reply;
}

// The reply to a request that the scheduler turned away, counted as such.
HttpReply Daemon::Handler::RefusalReply(Refusal refusal) {
    const RefusalWords words = WordsFor(refusal);
    counters_.CountRejection(words.reason);
    HttpReply reply = ErrorReply(StatusFor(words.error.code), words.error);
    if (reply.status == 503) {
        reply.fields.emplace_back("Retry-After", std::to_string(scheduler_.RetryAfterSeconds()));
    }
    return reply;
}

void Daemon::Handler::Handle(HttpRequest request, Done done) {
    const std::optional<Route> route = FindRoute(request.head.path);
    FLARE_CHECK(route.has_value());  // Refuse has seen it
    const auto exchange = std::make_shared<Exchange>();
    exchange->method = request.head.method;
    exchange->target = request.head.path;
    exchange->route = route->pattern;
    exchange->done = std::move(done);
    if (route->id == RouteId::kFlare) return SubmitFlare(std::move(request), exchange);
    if (route->id == RouteId::kLens) {
        return SubmitLens(request, route->name, exchange);
    }
    if (route->id == RouteId::kGhosts) {
        return SubmitGhosts(request, route->name, exchange);
    }
    if (route->id == RouteId::kWarm) return SubmitWarm(std::move(request), exchange);
    if (!request.head.query.empty()) {
        return Answer(ErrorReply(400, {"bad_query", "this route takes no query", "?"}), exchange);
    }
    if (route->id == RouteId::kWarmJob) {
        return Answer(WarmReply(*route, request.head.method), exchange);
    }
    Answer(AnswerNow(*route), exchange);
}

HttpReply Daemon::Handler::AnswerNow(const Route& route) {
    switch (route.id) {
        case RouteId::kLenses:
            return TextReply(kJson, services_.lens_list);
        case RouteId::kReport:
            return ReportReply(route.name);
        case RouteId::kEncoders:
            return TextReply(kJson, services_.encoders());
        case RouteId::kOpenApi:
            return TextReply("application/yaml", std::string(services_.openapi));
        case RouteId::kMetrics:
            return Metrics();
        case RouteId::kHealthz:
            return TextReply("text/plain", "ok\n");
        case RouteId::kReadyz:
            return draining_ ? RefusalReply(Refusal::kDraining)
                             : TextReply("text/plain", "ready\n");
        case RouteId::kFlare:
        case RouteId::kLens:
        case RouteId::kGhosts:
        case RouteId::kWarm:
        case RouteId::kWarmJob:
        case RouteId::kNotBuilt:
            break;
    }
    return ErrorReply(500, {"internal", "no answer for this route", ""});
}

HttpReply Daemon::Handler::Metrics() const {
    GaugeReadings readings;
    readings.cache = services_.cache();
    readings.encoders = services_.encoder_counts();
    readings.queue_depth = scheduler_.queued();
    if (const HttpServer* server = server_) readings.connections = server->connections();
    readings.warm_jobs = warm_jobs_.under_way();
    readings.draining = draining_;
    return TextReply("text/plain; version=0.0.4; charset=utf-8", counters_.Text(readings));
}

HttpReply Daemon::Handler::ReportReply(const std::string& id) const {
    std::optional<std::string> report = reports_.Get(id);
    if (report) return TextReply(kJson, std::move(*report));
    return ErrorReply(404, {"not_found",
                            "no report '" + id + "': the last " +
                                std::to_string(ReportStore::kKept) + " are kept",
                            ""});
}

void Daemon::Handler::SubmitFlare(HttpRequest request, const ExchangePtr& exchange) {
    const auto format = FormatForAccept(FieldValue(request.head.fields, "Accept"));
    FLARE_CHECK(format.has_value());  // Refuse has seen it
    const auto body = std::make_shared<const std::string>(std::move(request.body));
    Job job;
    job.cancel = request.cancel;
    job.picture_bytes = [this, body]() -> std::uint64_t {
        try {
            return services_.picture_bytes(*body);
        } catch (const std::exception&) {  // not even the request fits
            return std::numeric_limits<std::uint64_t>::max();
        }
    };
    job.run = [this, body, format, exchange](const JobTicket& ticket) {
        RunGuarded(ticket, exchange, [&] {
            const std::string id = reports_.NewId();
            Result<ServiceReply> reply = services_.flare(*body, *format, id, ticket.cancel());
            if (!reply) return AnswerError(reply.error(), ticket, exchange);
            AnswerFlare(std::move(*reply), id, exchange);
        });
    };
    Submit(std::move(job), exchange);
}

void Daemon::Handler::SubmitLens(const HttpRequest& request, const std::string& lens,
                                 const ExchangePtr& exchange) {
    const Result<LensState> state = ParseLensQuery(request.head.query);
    if (!state) {
        return Answer(ErrorReply(StatusFor(state.error().code), state.error()), exchange);
    }
    SubmitJson(request, exchange, [this, lens, state = *state](const CancelToken&) {
        return services_.lens(lens, state);
    });
}

void Daemon::Handler::SubmitGhosts(const HttpRequest& request, const std::string& lens,
                                   const ExchangePtr& exchange) {
    const Result<GhostQuery> query = ParseGhostQuery(request.head.query);
    if (!query) {
        return Answer(ErrorReply(StatusFor(query.error().code), query.error()), exchange);
    }
    SubmitJson(request, exchange, [this, lens, query = *query](const CancelToken& cancel) {
        return services_.ghosts(lens, query, cancel);
    });
}

// Understanding the body is an ordinary job; what it asks for goes on in the background.
void Daemon::Handler::SubmitWarm(HttpRequest request, const ExchangePtr& exchange) {
    const auto body = std::make_shared<const std::string>(std::move(request.body));
    Job job;
    job.cancel = request.cancel;
    job.run = [this, body, exchange](const JobTicket& ticket) {
        RunGuarded(ticket, exchange, [&] {
            const Result<WarmTask> task = services_.warm(*body);
            if (!task) return AnswerError(task.error(), ticket, exchange);
            const WarmJobs::JobPtr started = warm_jobs_.Add(reports_.NewId(), *task);
            const std::optional<Refusal> refusal = scheduler_.SubmitBackground(
                {started->cancel(), [started] { return started->Step(); }});
            if (refusal) {
                warm_jobs_.Remove(started->id());
                return Answer(RefusalReply(*refusal), exchange);
            }
            HttpReply reply = TextReply(kJson, started->Json());
            reply.status = 202;
            reply.fields.emplace_back("Location", "/v1/warm/" + started->id());
            Answer(std::move(reply), exchange);
        });
    };
    Submit(std::move(job), exchange);
}

HttpReply Daemon::Handler::WarmReply(const Route& route, std::string_view method) {
    const WarmJobs::JobPtr job = warm_jobs_.Find(route.name);
    if (!job) return ErrorReply(404, {"not_found", "no warming '" + route.name + "'", ""});
    if (method == "DELETE") job->cancel().Cancel();
    return TextReply(kJson, job->Json());
}

// `work` gives a JSON text or an error.
template <class Work>
void Daemon::Handler::SubmitJson(const HttpRequest& request, const ExchangePtr& exchange,
                                 const Work& work) {
    Job job;
    job.cancel = request.cancel;
    job.run = [this, exchange, work](const JobTicket& ticket) {
        RunGuarded(ticket, exchange, [&] {
            Result<std::string> text = work(ticket.cancel());
            if (!text) return AnswerError(text.error(), ticket, exchange);
            Answer(TextReply(kJson, std::move(*text)), exchange);
        });
    };
    Submit(std::move(job), exchange);
}

void Daemon::Handler::Submit(Job job, const ExchangePtr& exchange) {
    job.refuse = [this, exchange](Refusal reason) {
        if (reason == Refusal::kCancelled) return Abandon(exchange);
        Answer(RefusalReply(reason), exchange);
    };
    if (const std::optional<Refusal> refusal = scheduler_.Submit(std::move(job))) {
        Answer(RefusalReply(*refusal), exchange);
    }
}

// No exception may leave a worker: a picture too big for the machine's memory costs one request.
template <class Work>
void Daemon::Handler::RunGuarded(const JobTicket& ticket, const ExchangePtr& exchange,
                                 const Work& work) {
    try {
        work();
    } catch (const std::bad_alloc&) {
        spdlog::error("out of memory in {}", exchange->target);
        AnswerError({"overloaded", "not enough memory for this request", ""}, ticket, exchange);
    } catch (const std::exception& problem) {
        spdlog::error("{} failed: {}", exchange->target, problem.what());
        AnswerError({"internal", "the request failed inside the daemon", ""}, ticket, exchange);
    }
}

void Daemon::Handler::AnswerFlare(ServiceReply reply, const std::string& id,
                                  const ExchangePtr& exchange) {
    reports_.Put(id, std::move(reply.report));
    HttpReply answer = TextReply(std::move(reply.content_type), std::move(reply.bytes));
    answer.fields.emplace_back("Flare-Report", std::move(reply.report_summary));
    answer.fields.emplace_back("Cache-Control", "no-store");
    answer.spare = services_.spare;
    Answer(std::move(answer), exchange);
}

void Daemon::Handler::AnswerError(const Error& error, const JobTicket& ticket,
                                  const ExchangePtr& exchange) {
    if (error.code == "cancelled") {
        if (ticket.deadline_passed()) return Answer(RefusalReply(Refusal::kDeadline), exchange);
        if (ticket.cut_by_drain()) return Answer(RefusalReply(Refusal::kDraining), exchange);
        return Abandon(exchange);
    }
    HttpReply reply = ErrorReply(StatusFor(error.code), error);
    if (error.code == "encoder_stale") reply.fields.emplace_back("Retry-After", "1");
    if (error.code == "overloaded") {
        counters_.CountRejection("memory");
        reply.fields.emplace_back("Retry-After", std::to_string(scheduler_.RetryAfterSeconds()));
    }
    Answer(std::move(reply), exchange);
}

void Daemon::Handler::Answer(HttpReply reply, const ExchangePtr& exchange) {
    Count(*exchange, reply.status);
    exchange->done(std::move(reply));
}

void Daemon::Handler::Abandon(const ExchangePtr& exchange) {
    Count(*exchange, kClientLeft);
    exchange->done(std::nullopt);
}

void Daemon::Handler::Count(const Exchange& exchange, int status) {
    const double seconds = std::chrono::duration<double>(Clock::now() - exchange.start).count();
    counters_.CountRequest(std::string(exchange.route), status, seconds);
    spdlog::info("{} {} {} {:.1f} ms", exchange.method, exchange.target, status, 1000.0 * seconds);
}

Daemon::Daemon(const DaemonOptions& options, DaemonServices services,
               std::vector<ListeningSocket> sockets)
    : handler_(std::make_unique<Handler>(options, std::move(services))),
      server_(std::make_unique<HttpServer>(options.http, std::move(sockets), *handler_)) {
    handler_->ShowConnectionsOf(server_.get());
}

// Jobs hold on to connections and connections call the handler, so the order is: no job left, then
// no connection, then the handler.
Daemon::~Daemon() {
    CutOff();
    server_.reset();
}

bool Daemon::SubmitBackground(std::function<bool()> step) {
    return !handler_->scheduler().SubmitBackground({CancelToken(), std::move(step)});
}

void Daemon::StartDraining() {
    handler_->StartDraining();
    server_->CloseAfterReplies();
}

bool Daemon::WaitUntilDrained(std::chrono::milliseconds bound) {
    const Clock::time_point end = Clock::now() + bound;
    if (!handler_->scheduler().WaitUntilIdle(bound)) return false;
    return server_->WaitUntilQuiet(
        std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()));
}

void Daemon::CutOff() {
    StartDraining();
    handler_->scheduler().CutOff();
    server_->WaitUntilQuiet(kLastReplies);
}

}  // namespace flare
