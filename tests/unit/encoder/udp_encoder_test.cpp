// SPDX-License-Identifier: Apache-2.0
//
// Datagrams over localhost to a track.
#include "server/encoder/udp_encoder.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "server/encoder/encoder_set.h"
#include "server/encoder/freed.h"

namespace flare {
namespace {

class Sender {
  public:
    Sender() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {}
    ~Sender() { close(fd_); }

    // A port that was free a moment ago.
    static int FreePort() {
        const Sender probe;
        sockaddr_in address = Address(0);
        void* const name = &address;
        EXPECT_EQ(bind(probe.fd_, static_cast<sockaddr*>(name), sizeof address), 0);
        socklen_t size = sizeof address;
        EXPECT_EQ(getsockname(probe.fd_, static_cast<sockaddr*>(name), &size), 0);
        return ntohs(address.sin_port);
    }
    void Send(const std::vector<std::uint8_t>& bytes, int port) const {
        sockaddr_in address = Address(port);
        const void* const name = &address;
        sendto(fd_, bytes.data(), bytes.size(), 0, static_cast<const sockaddr*>(name),
               sizeof address);
    }

  private:
    static sockaddr_in Address(int port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        return address;
    }
    int fd_;
};

std::vector<std::uint8_t> FreeDBytes(int camera, std::uint8_t focus) {
    std::vector<std::uint8_t> bytes(kFreeDBytes, 0);
    bytes[0] = 0xd1;
    bytes[1] = static_cast<std::uint8_t>(camera);
    bytes[25] = focus;
    bytes[28] = FreeDChecksum(std::span(bytes).first(28));
    return bytes;
}

class Udp : public testing::Test {
  protected:
    Udp() {
        config_.name = "tracker";
        config_.kind = EncoderKind::kFreeD;
        config_.address = "127.0.0.1";
        config_.port = Sender::FreePort();
        config_.source = 2;
        config_.stale_ms = 50.0;
    }
    // Sends until `done`: the port may not be open yet.
    template <class Done>
    bool SendUntil(const std::vector<std::uint8_t>& bytes, const Done& done) {
        for (int i = 0; i < 5'000; ++i) {
            sender_.Send(bytes, config_.port);
            if (done()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        return false;
    }

    EncoderConfig config_;
    Sender sender_;
};

TEST_F(Udp, TakesTheDatagramsOfItsCameraAndCountsTheBroken) {
    const auto set = EncoderSet::Start({config_}, [](bool, const std::string&) {});
    ASSERT_TRUE(set) << set.error().message;
    const EncoderTrack& track = *(*set)->Find("tracker");
    ASSERT_TRUE(SendUntil({1, 2, 3}, [&] { return track.Status(0.0).faults[0] > 0; }));
    EXPECT_EQ(track.samples(), 0u);
    EXPECT_FALSE(track.connected());
    ASSERT_TRUE(SendUntil(FreeDBytes(2, 5), [&] { return track.samples() > 0; }));
    EXPECT_TRUE(track.connected());
    sender_.Send(FreeDBytes(1, 9), config_.port);
    ASSERT_TRUE(SendUntil(FreeDBytes(2, 6), [&] { return track.Newest()->raw[0] == 6.0; }));
    // Silence.
    for (int i = 0; i < 5'000 && track.connected(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    const EncoderStatus status = track.Status(EncoderClock::Now_s());
    EXPECT_EQ(status.health, EncoderHealth::kLost);
    EXPECT_EQ(status.newest->raw[0], 6.0);
    EXPECT_EQ(status.faults[static_cast<std::size_t>(EncoderFault::kTimeout)], 1u);
    ASSERT_TRUE(SendUntil(FreeDBytes(2, 7), [&] { return track.connected(); }));
}

TEST_F(Udp, SaysThatThePortIsTakenAndStopsAtOnce) {
    std::vector<EncoderConfig> both{config_, config_};
    both[1].name = "second";
    std::atomic<int> warnings = 0;
    const auto set =
        EncoderSet::Start(both, [&](bool warning, const std::string&) { warnings += warning; });
    ASSERT_TRUE(set);
    while (warnings == 0) std::this_thread::yield();
    int failed = 0;
    for (const auto& track : (*set)->tracks()) {
        const EncoderStatus status = track->Status(EncoderClock::Now_s());
        if (status.health != EncoderHealth::kFailed) continue;
        ++failed;
        EXPECT_NE(status.problem.find("cannot listen on UDP port"), std::string::npos);
    }
    EXPECT_EQ(failed, 1);
}

TEST_F(Udp, RefusesAddressesThatAreNone) {
    config_.address = "localhost";
    const auto set = EncoderSet::Start({config_}, [](bool, const std::string&) {});
    ASSERT_FALSE(set.ok());
    EXPECT_EQ(set.error().where, "encoder tracker, address");
    config_.address = "0.0.0.0";
    config_.multicast = "127.0.0.1";
    const auto group = EncoderSet::Start({config_}, [](bool, const std::string&) {});
    ASSERT_FALSE(group.ok());
    EXPECT_EQ(group.error().where, "encoder tracker, multicast");
}

}  // namespace
}  // namespace flare
