// SPDX-License-Identifier: Apache-2.0
//
// The daemon over real sockets, with a stand-in for the renderer whose behaviour the body commands:
// "echo TEXT", "error CODE", "throw", "block" (until the gate opens or the token is set), "bytes
// N".
#include "server/daemon.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <regex>
#include <stdexcept>
#include <thread>

#include "protocol/client/client.h"

namespace flare {
namespace {

using namespace std::chrono_literals;
using client::Fetch;
using client::Reply;

bool Eventually(const std::function<bool()>& condition) {
    for (int i = 0; i < 1000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(10ms);
    }
    return false;
}

class DaemonTest : public testing::Test {
  protected:
    void SetUp() override {
        spdlog::set_level(spdlog::level::off);
        options_.version = "test";
        options_.schedule.workers = 2;
        options_.http.body_bytes = 100'000;
    }

    void Start() {
        auto socket = ListeningSocket::Open("http://127.0.0.1:0", {});
        ASSERT_TRUE(socket.ok()) << socket.error().message;
        url_ = socket->url();
        std::vector<ListeningSocket> sockets;
        sockets.push_back(std::move(*socket));
        daemon_ = std::make_unique<Daemon>(options_, Services(), std::move(sockets));
    }

    Result<ServiceReply> Serve(std::string_view body, ReplyFormat format, const std::string& id,
                               const CancelToken& cancel) {
        const std::string text(body);
        if (text.starts_with("error ")) return Error{text.substr(6), "as asked", "/there"};
        if (text == "throw") throw std::runtime_error("as asked");
        if (text == "no memory") throw std::bad_alloc();
        if (text == "block") {
            ++blocked_;
            while (!open_ && !cancel.cancelled()) std::this_thread::sleep_for(1ms);
            --blocked_;
            if (cancel.cancelled()) {
                ++cancelled_;
                return Error{"cancelled", "", ""};
            }
        }
        ServiceReply reply;
        reply.bytes = text;
        reply.content_type = format == ReplyFormat::kPng ? "image/png" : "image/x-exr";
        reply.report_summary = "{\"id\":\"" + id + "\"}";
        reply.report = "{\"whole\":\"" + id + "\"}";
        return reply;
    }

    DaemonServices Services() {
        DaemonServices services;
        services.flare = [this](auto body, auto format, const auto& id, const auto& cancel) {
            return Serve(body, format, id, cancel);
        };
        services.picture_bytes = [](std::string_view body) -> std::uint64_t {
            if (!body.starts_with("bytes ")) return 0;
            return std::stoull(std::string(body.substr(6)));
        };
        services.lens = [](const std::string& name, const LensState& state) -> Result<std::string> {
            if (name == "known" && state.zoom_mm) return std::to_string(*state.zoom_mm);
            if (name == "known") return std::string("{\"name\":\"known\"}");
            return Error{"unknown_lens", "no lens '" + name + "'", ""};
        };
        services.ghosts = [](const std::string& name, const GhostQuery& query,
                             const CancelToken&) -> Result<std::string> {
            return name + " at " + std::to_string(query.field_deg);
        };
        services.lens_list = "{\"lenses\":[]}";
        services.openapi = "openapi: 3.1.0\n";
        services.cache = [] { return CacheReadings{{.hits = 7, .misses = 3}, 12345, {.hits = 2}}; };
        services.encoders = [] { return std::string("{\"encoders\":[]}"); };
        services.encoder_counts = [] {
            return std::vector<EncoderCounts>{{"A-cam", true, 42, {{"bad_data", 3}}}};
        };
        return services;
    }

    Reply Get(const std::string& target, client::Headers headers = {}) {
        return Fetch(url_, {.target = target, .headers = std::move(headers)});
    }
    Reply Post(const std::string& body, client::Headers headers = {}) {
        return Fetch(
            url_,
            {.method = "POST", .target = "/v1/flare", .headers = std::move(headers), .body = body});
    }

    // The value of a line of /metrics; 0 if it is not there.
    double Metric(const std::string& line) {
        const std::string text = Get("/metrics").body;
        const std::size_t at = text.find("\n" + line + " ");
        return at == std::string::npos ? 0.0 : std::stod(text.substr(at + line.size() + 2));
    }

    int Connect() {
        const int fd = socket(AF_INET, SOCK_STREAM, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const int port = std::stoi(url_.substr(url_.rfind(':') + 1));
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        const timeval patience{10, 0};
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
        const void* name = &address;
        EXPECT_EQ(connect(fd, static_cast<const sockaddr*>(name), sizeof(address)), 0);
        return fd;
    }
    static void Send(int fd, const std::string& text) {
        EXPECT_EQ(send(fd, text.data(), text.size(), MSG_NOSIGNAL),
                  static_cast<ssize_t>(text.size()));
    }
    // All that comes until the server closes.
    static std::string ReadAll(int fd) {
        std::string all;
        char part[4096];
        for (ssize_t n = recv(fd, part, sizeof(part), 0); n > 0;
             n = recv(fd, part, sizeof(part), 0)) {
            all.append(part, static_cast<std::size_t>(n));
        }
        return all;
    }
    // What comes back for raw bytes, after which the sender is silent but stays.
    std::string Raw(const std::string& text) {
        const int fd = Connect();
        Send(fd, text);
        const std::string reply = ReadAll(fd);
        close(fd);
        return reply;
    }

    DaemonOptions options_;
    std::atomic<bool> open_ = false;
    std::atomic<int> blocked_ = 0, cancelled_ = 0;
    std::string url_;
    std::unique_ptr<Daemon> daemon_;
};

constexpr const char* kPostHead = "POST /v1/flare HTTP/1.1\r\nHost: x\r\n";

TEST_F(DaemonTest, ServesTheSmallRoutes) {
    Start();
    EXPECT_EQ(Get("/healthz").status, 200);
    EXPECT_EQ(Get("/readyz").status, 200);
    EXPECT_EQ(Get("/v1/lenses").body, "{\"lenses\":[]}");
    EXPECT_EQ(Get("/v1/encoders").body, "{\"encoders\":[]}");
    EXPECT_EQ(Metric("flared_encoder_connected{name=\"A-cam\"}"), 1.0);
    EXPECT_EQ(Metric("flared_encoder_samples_total{name=\"A-cam\"}"), 42.0);
    EXPECT_EQ(Metric("flared_encoder_faults_total{name=\"A-cam\",kind=\"bad_data\"}"), 3.0);
    EXPECT_EQ(Get("/v1/lenses/known").body, "{\"name\":\"known\"}");
    EXPECT_EQ(Get("/v1/lenses/kn%6Fwn").body, "{\"name\":\"known\"}");
    EXPECT_EQ(Get("/v1/lenses/known?zoom_mm=85").body, "85.000000");
    EXPECT_EQ(Get("/v1/lenses/known/ghosts?field_deg=5").body, "known at 5.000000");
    EXPECT_EQ(Get("/v1/openapi.yaml").body, "openapi: 3.1.0\n");
    EXPECT_EQ(Get("/v1/lenses").header("content-type"), "application/json");
}

TEST_F(DaemonTest, AnswersAFlareWithItsReport) {
    Start();
    const Reply reply = Post("picture", {{"Content-Type", "application/json"}});
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, "picture");
    EXPECT_EQ(reply.header("Content-Type"), "image/x-exr");
    const std::string summary(reply.header("Flare-Report"));
    std::smatch id;
    ASSERT_TRUE(std::regex_search(summary, id, std::regex("\"id\":\"([^\"]+)\""))) << summary;
    EXPECT_EQ(Get("/v1/reports/" + id[1].str()).body, "{\"whole\":\"" + id[1].str() + "\"}");
    EXPECT_EQ(Get("/v1/reports/none").status, 404);
    EXPECT_EQ(Post("picture", {{"Accept", "image/png"}}).header("Content-Type"), "image/png");
}

TEST_F(DaemonTest, RefusesWithStatusAndCode) {
    Start();
    const struct {
        client::Request request;
        int status;
        const char* code;
        const char* where;
    } kRows[] = {
        {{.target = "/nothing"}, 404, "not_found", ""},
        {{.target = "/v1/lenses/"}, 404, "not_found", ""},
        {{.target = "/v1/lenses/x"}, 404, "unknown_lens", ""},
        {{.target = "/v1/flare"}, 405, "method_not_allowed", ""},
        {{.method = "DELETE", .target = "/v1/lenses"}, 405, "method_not_allowed", ""},
        {{.method = "BREW", .target = "/healthz"}, 405, "method_not_allowed", ""},
        {{.target = "/"}, 501, "unsupported", ""},
        {{.target = "/v1/live"}, 501, "unsupported", ""},
        {{.target = "/v1/encoders?x=1"}, 400, "bad_query", "?"},
        {{.method = "PUT", .target = "/v1/warm/x"}, 405, "method_not_allowed", ""},
        {{.target = "/v1/warm/x"}, 404, "not_found", ""},
        {{.target = "/healthz?x=1"}, 400, "bad_query", "?"},
        {{.target = "/v1/lenses/known/ghosts?f=1"}, 400, "unknown_field", "?f"},
        {{.target = "/v1/lenses/known?focus_m=0"}, 400, "bad_value", "?focus_m"},
        {{.target = "/v1/lenses?focus_m=1"}, 400, "bad_query", "?"},
        {{.method = "POST", .target = "/v1/flare", .headers = {{"Accept", "text/html"}}},
         406,
         "not_acceptable",
         ""},
        {{.method = "POST", .target = "/v1/flare", .headers = {{"Content-Type", "text/plain"}}},
         415,
         "unsupported_media_type",
         ""},
        {{.method = "POST", .target = "/v1/flare", .headers = {{"Origin", "http://evil.example"}}},
         403,
         "forbidden",
         ""},
        {{.method = "POST", .target = "/v1/flare", .headers = {{"Content-Encoding", "gzip"}}},
         415,
         "unsupported_media_type",
         ""},
        {{.method = "POST", .target = "/v1/flare", .body = "error bad_value"},
         400,
         "bad_value",
         "/there"},
        {{.method = "POST", .target = "/v1/flare", .body = "error unknown_lens"},
         404,
         "unknown_lens",
         "/there"},
        {{.method = "POST", .target = "/v1/flare", .body = "error unsupported"},
         400,
         "unsupported",
         "/there"},
        {{.method = "POST", .target = "/v1/flare", .body = "throw"}, 500, "internal", ""},
        {{.method = "POST", .target = "/v1/flare", .body = "no memory"}, 503, "overloaded", ""},
        {{.method = "POST", .target = "/v1/flare", .body = std::string(100'001, ' ')},
         413,
         "too_large",
         ""},
    };
    for (const auto& row : kRows) {
        const Reply reply = Fetch(url_, row.request);
        const std::string name =
            row.request.method + " " + row.request.target + " " + row.request.body.substr(0, 40);
        EXPECT_EQ(reply.status, row.status) << name << reply.error;
        EXPECT_EQ(reply.header("Content-Type"), "application/json") << name;
        EXPECT_NE(reply.body.find(std::string("\"code\":\"") + row.code + '"'), std::string::npos)
            << name << reply.body;
        EXPECT_NE(reply.body.find(std::string("\"where\":\"") + row.where + '"'), std::string::npos)
            << name << reply.body;
    }
    EXPECT_EQ(Get("/v1/flare").header("Allow"), "POST");
    EXPECT_EQ(Fetch(url_, {.method = "PUT", .target = "/metrics"}).header("Allow"), "GET, HEAD");
    EXPECT_EQ(Post("still here").body, "still here");
}

TEST_F(DaemonTest, AnswersHeadLikeGetWithoutTheBody) {
    Start();
    const Reply reply = Fetch(url_, {.method = "HEAD", .target = "/v1/lenses"});
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body, "");
    EXPECT_EQ(reply.header("Content-Length"), "13");
}

TEST_F(DaemonTest, AnswersPipelinedRequestsInOrder) {
    Start();
    std::string requests;
    for (int i = 0; i < 5; ++i) {
        requests += std::string(kPostHead) + "Content-Length: 1\r\n\r\n" + std::to_string(i);
    }
    requests += "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
    const std::string replies = Raw(requests);
    std::size_t at = 0;
    for (int i = 0; i < 5; ++i) {
        at = replies.find("\r\n\r\n" + std::to_string(i) + "HTTP/1.1 200", at);
        ASSERT_NE(at, std::string::npos) << i << replies;
    }
    EXPECT_TRUE(replies.ends_with("\r\n\r\nok\n"));
}

TEST_F(DaemonTest, TakesChunkedBodies) {
    Start();
    const std::string reply = Raw(std::string(kPostHead) +
                                  "Connection: close\r\nTransfer-Encoding: chunked\r\n\r\n"
                                  "3\r\nabc\r\n4;x=y\r\ndefg\r\n0\r\n\r\n");
    EXPECT_TRUE(reply.ends_with("\r\n\r\nabcdefg")) << reply;
}

TEST_F(DaemonTest, InvitesABodyOnlyIfItWillBeRead) {
    Start();
    const int fd = Connect();
    Send(fd, std::string(kPostHead) +
                 "Connection: close\r\nExpect: 100-continue\r\nContent-Length: 4\r\n\r\n");
    char invitation[12];
    ASSERT_EQ(recv(fd, invitation, sizeof(invitation), MSG_WAITALL), 12);
    EXPECT_EQ(std::string(invitation, 12), "HTTP/1.1 100");
    Send(fd, "body");
    EXPECT_TRUE(ReadAll(fd).ends_with("body"));
    close(fd);
    for (const char* head : {"Expect: 100-continue\r\nContent-Length: 200000\r\n\r\n",
                             "Expect: 100-continue\r\nAccept: no/no\r\nContent-Length: 4\r\n\r\n",
                             "Expect: a-miracle\r\nContent-Length: 4\r\n\r\n"}) {
        const std::string refused = Raw(std::string(kPostHead) + head);
        EXPECT_TRUE(refused.starts_with("HTTP/1.1 4")) << refused;
        EXPECT_NE(refused.find("Connection: close"), std::string::npos) << refused;
    }
}

TEST_F(DaemonTest, RefusesWhatIsNoProperHttp) {
    options_.http.header = 300ms;
    Start();
    const struct {
        std::string text;
        const char* status;
    } kRows[] = {
        {"nonsense\r\n\r\n", "400"},
        {"GET /healthz HTTP/1.1\r\n\r\n", "400"},  // no Host
        {"GET /healthz HTTP/3.0\r\nHost: x\r\n\r\n", "400"},
        {std::string(kPostHead) + "Content-Length: -1\r\n\r\n", "400"},
        {std::string(kPostHead) + "Content-Length: 1\r\nContent-Length: 2\r\n\r\nab", "400"},
        {std::string(kPostHead) + "Transfer-Encoding: chunked\r\n\r\nxyz\r\n", "400"},
        {std::string(kPostHead) + "Transfer-Encoding: gzip\r\n\r\n", "501"},
        {std::string(kPostHead) + "Transfer-Encoding: chunked\r\n\r\n20000\r\n", "413"},
        {std::string(kPostHead) + "X: " + std::string(20'000, 'x') + "\r\n\r\n", "431"},
        {"GET /" + std::string(3'000, 'x') + " HTTP/1.1\r\nHost: x\r\n\r\n", "414"},
    };
    for (const auto& row : kRows) {
        const std::string reply = Raw(row.text);
        EXPECT_EQ(reply.substr(0, 12), std::string("HTTP/1.1 ") + row.status)
            << row.text.substr(0, 80) << " -> " << reply.substr(0, 200);
    }
    EXPECT_EQ(Get("/healthz").status, 200);
}

TEST_F(DaemonTest, CutsSlowClientsOff) {
    options_.http.idle = 200ms;
    options_.http.header = 200ms;
    options_.http.body = 200ms;
    Start();
    for (const char* start : {"", "GET /heal",
                              "POST /v1/flare HTTP/1.1\r\nHost: x\r\n"
                              "Content-Length: 1000\r\n\r\nabc"}) {
        const int fd = Connect();
        Send(fd, start);
        const auto begin = std::chrono::steady_clock::now();
        // Dripping bytes must not buy time; silence is dealt with by another timeout.
        std::jthread dripper;
        if (*start != '\0') {
            dripper = std::jthread([fd](std::stop_token stop) {
                while (!stop.stop_requested()) {
                    if (send(fd, "x", 1, MSG_NOSIGNAL) != 1) return;
                    std::this_thread::sleep_for(50ms);
                }
            });
        }
        EXPECT_EQ(ReadAll(fd), "");
        EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s) << start;
        dripper = {};
        close(fd);
    }
    EXPECT_EQ(Get("/healthz").status, 200);
    const char* const counter = "flared_requests_rejected_total{reason=\"slow_client\"}";
    EXPECT_TRUE(Eventually([&] { return Metric(counter) == 2.0; }));
}

TEST_F(DaemonTest, AClientThatLeavesHasItsWorkCancelled) {
    Start();
    const int fd = Connect();
    Send(fd, std::string(kPostHead) + "Content-Length: 5\r\n\r\nblock");
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    close(fd);
    EXPECT_TRUE(Eventually([&] { return cancelled_ == 1; }));
    EXPECT_TRUE(Eventually([&] {
        return Metric("flared_requests_total{code=\"499\",route=\"/v1/flare\"}") == 1.0;
    })) << Get("/metrics").body;
}

TEST_F(DaemonTest, AClientThatLeavesBehindPipelinedBytesIsSeenToo) {
    Start();
    const int fd = Connect();
    Send(fd, std::string(kPostHead) + "Content-Length: 5\r\n\r\nblockGET /healthz HTTP/1.1\r\n");
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    close(fd);
    EXPECT_TRUE(Eventually([&] { return cancelled_ == 1; }));
}

TEST_F(DaemonTest, AFullQueueAnswers503AndSaysWhenToComeBack) {
    options_.schedule.workers = 1;
    options_.schedule.queue = 1;
    Start();
    std::jthread first([&] { EXPECT_EQ(Post("block").status, 200); });
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    std::jthread second([&] { EXPECT_EQ(Post("block").status, 200); });
    ASSERT_TRUE(Eventually([&] { return Metric("flared_queue_depth") == 1.0; }));
    const Reply refused = Post("third");
    EXPECT_EQ(refused.status, 503);
    EXPECT_NE(refused.body.find("\"overloaded\""), std::string::npos);
    EXPECT_GE(std::stoi("0" + std::string(refused.header("Retry-After"))), 1);
    EXPECT_EQ(Metric("flared_requests_rejected_total{reason=\"queue_full\"}"), 1.0);
    EXPECT_EQ(Get("/healthz").status, 200) << "small answers do not need a worker";
    open_ = true;
    first.join();
    second.join();
    EXPECT_EQ(Post("fourth").status, 200);
}

TEST_F(DaemonTest, APictureThatDoesNotFitIsRefused) {
    options_.schedule.picture_bytes = 1000;
    Start();
    EXPECT_EQ(Post("bytes 1000").status, 200);
    EXPECT_EQ(Post("bytes 1001").status, 413);
}

TEST_F(DaemonTest, ADeadlineAnswers503) {
    options_.schedule.deadline = 50ms;
    Start();
    const Reply reply = Post("block");
    EXPECT_EQ(reply.status, 503);
    EXPECT_NE(reply.body.find("\"deadline\""), std::string::npos);
    EXPECT_EQ(cancelled_, 1);
}

TEST_F(DaemonTest, TooManyConnectionsAreToldSo) {
    options_.http.connections = 2;
    Start();
    const int a = Connect(), b = Connect();
    const std::string ok = "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n";
    for (const int fd : {a, b}) {
        Send(fd, ok);
        char reply[12];
        ASSERT_EQ(recv(fd, reply, sizeof(reply), MSG_WAITALL), 12);
    }
    const int c = Connect();
    EXPECT_TRUE(ReadAll(c).starts_with("HTTP/1.1 503"));
    close(a);
    close(b);
    close(c);
    EXPECT_TRUE(Eventually([&] { return Get("/healthz").status == 200; }));
}

TEST_F(DaemonTest, ADrainFinishesWorkAndRefusesNewWork) {
    Start();
    std::jthread running([&] {
        const Reply reply = Post("block");
        EXPECT_EQ(reply.status, 200) << reply.error;
        EXPECT_EQ(reply.header("Connection"), "close");
    });
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    daemon_->StartDraining();
    EXPECT_EQ(Get("/readyz").status, 503);
    EXPECT_EQ(Get("/healthz").status, 200);
    const Reply refused = Post("late");
    EXPECT_EQ(refused.status, 503);
    EXPECT_NE(refused.body.find("\"draining\""), std::string::npos);
    EXPECT_FALSE(daemon_->WaitUntilDrained(50ms));
    open_ = true;
    EXPECT_TRUE(daemon_->WaitUntilDrained(10s));
}

TEST_F(DaemonTest, WorkThatIsCutOffIsAnswered) {
    Start();
    std::jthread running([&] { EXPECT_EQ(Post("block").status, 503); });
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    daemon_->CutOff();
    running.join();
    EXPECT_EQ(cancelled_, 1);
}

TEST_F(DaemonTest, CanBeDestroyedWhileClientsAreConnectedAndWaiting) {
    Start();
    const int idle = Connect();
    std::jthread running([&] { Post("block"); });
    ASSERT_TRUE(Eventually([&] { return blocked_ == 1; }));
    daemon_.reset();
    running.join();
    EXPECT_EQ(ReadAll(idle), "");
    close(idle);
}

TEST_F(DaemonTest, CountsByRouteAndNotByWhatClientsInvent) {
    Start();
    Post("a");
    Post("b");
    Post("error bad_value");
    Get("/v1/lenses/one");
    Get("/v1/lenses/two");
    Get("/invention/1");
    Get("/invention/2");
    EXPECT_EQ(Metric("flared_requests_total{code=\"200\",route=\"/v1/flare\"}"), 2.0);
    EXPECT_EQ(Metric("flared_requests_total{code=\"400\",route=\"/v1/flare\"}"), 1.0);
    EXPECT_EQ(Metric("flared_requests_total{code=\"404\",route=\"/v1/lenses/NAME\"}"), 2.0);
    EXPECT_EQ(Metric("flared_requests_total{code=\"404\",route=\"other\"}"), 2.0);
    EXPECT_EQ(Metric("flared_request_seconds_count{route=\"/v1/flare\"}"), 3.0);
    EXPECT_EQ(Metric("flared_mesh_cache_hits_total"), 7.0);
    EXPECT_EQ(Metric("flared_mesh_disk_hits_total"), 2.0);
    EXPECT_EQ(Metric("flared_mesh_cache_misses_total"), 3.0);
    EXPECT_EQ(Metric("flared_rays_traced_total"), 12345.0);
}

TEST_F(DaemonTest, ServesManyClientsAtOnce) {
    options_.schedule.queue = 1000;
    Start();
    std::atomic<int> right = 0;
    std::vector<std::jthread> clients;
    for (int c = 0; c < 16; ++c) {
        clients.emplace_back([&, c] {
            for (int i = 0; i < 20; ++i) {
                const std::string body = std::to_string(c) + "/" + std::to_string(i);
                if (Post(body).body == body) ++right;
            }
        });
    }
    clients.clear();
    EXPECT_EQ(right, 320);
}

TEST(Client, SaysWhyThereIsNoReply) {
    for (const char* url :
         {"", "ftp://x", "http://", "http://x", "http://127.0.0.1:0", "http://127.0.0.1:x",
          "unix:", "http://127.0.0.1:1", "unix:/nowhere/at/all", "http://[::1", "http://u@h:1"}) {
        const Reply reply = Fetch(url, {.connect_timeout = 2s});
        EXPECT_FALSE(reply.ok()) << url;
    }
    EXPECT_FALSE(Fetch("unix:/" + std::string(200, 'x'), {}).ok());
}

}  // namespace
}  // namespace flare
