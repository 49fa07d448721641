// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/udp_encoder.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>

#include "server/encoder/freed.h"
#include "server/encoder/opentrackio.h"

namespace flare {
namespace {

constexpr double kOpenAgain_ms = 1'000.0;
constexpr std::size_t kMostDatagram = 65'536;

class Socket {
  public:
    Socket() = default;
    ~Socket() { Close(); }
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;

    int fd() const { return fd_; }
    void Close() {
        if (fd_ >= 0) close(fd_);
        fd_ = -1;
    }

    // "" or what went wrong.
    std::string Open(const EncoderConfig& config) {
        const auto failed = [&](const std::string& what) {
            const std::string why = std::strerror(errno);
            Close();
            return "cannot " + what + ": " + why;
        };
        fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (fd_ < 0) return failed("open a socket");
        // Several programs of one machine may listen to a multicast group.
        const int yes = 1;
        if (!config.multicast.empty()) {
            setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        }
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(config.port));
        inet_pton(AF_INET, config.address.c_str(), &address.sin_addr);
        const in_addr interface = address.sin_addr;
        if (!config.multicast.empty()) {
            inet_pton(AF_INET, config.multicast.c_str(), &address.sin_addr);
        }
        const void* const name = &address;
        if (bind(fd_, static_cast<const sockaddr*>(name), sizeof address) != 0) {
            return failed("listen on UDP port " + std::to_string(config.port));
        }
        if (config.multicast.empty()) return "";
        ip_mreq group{};
        group.imr_multiaddr = address.sin_addr;
        group.imr_interface = interface;
        if (setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
            return failed("join " + config.multicast);
        }
        return "";
    }

  private:
    int fd_ = -1;
};

class UdpEncoder final : public EncoderSource {
  public:
    explicit UdpEncoder(EncoderTrack& track)
        : track_(track), thread_([this](const StopSignal& stop) {
              while (!stop.set()) {
                  if (const std::string problem = socket_.Open(track_.config()); problem.empty()) {
                      Listen(stop);
                  } else {
                      track_.Disconnected(EncoderFault::kOther, problem);
                      stop.WaitFor_ms(kOpenAgain_ms);
                  }
              }
          }) {}

  private:
    void Listen(const StopSignal& stop) {
        track_.Recovered();
        while (!stop.set()) {
            std::array<pollfd, 2> fds{pollfd{stop.fd(), POLLIN, 0},
                                      pollfd{socket_.fd(), POLLIN, 0}};
            const int wait_ms = static_cast<int>(std::ceil(track_.config().stale_ms));
            const int ready = poll(fds.data(), fds.size(), track_.connected() ? wait_ms : -1);
            if (ready == 0) {
                track_.Disconnected(EncoderFault::kTimeout,
                                    "no datagram for " + std::to_string(wait_ms) + " ms");
            }
            if (ready <= 0 || fds[0].revents != 0) continue;
            if (!Receive()) return;
        }
    }

    // Everything that has arrived; false if the socket is no use any more.
    bool Receive() {
        for (;;) {
            const ssize_t size = recv(socket_.fd(), buffer_.data(), buffer_.size(), 0);
            if (size < 0) {
                if (errno == EAGAIN || errno == EINTR) return true;
                track_.Disconnected(EncoderFault::kOther, std::strerror(errno));
                socket_.Close();
                return false;
            }
            const double now_s = EncoderClock::Now_s();
            const Result<std::optional<EncoderSample>> sample =
                Decode(std::span(buffer_).first(static_cast<std::size_t>(size)));
            if (!sample) {
                track_.Fault(EncoderFault::kBadData, sample.error().message);
            } else if (*sample) {
                if (!track_.connected()) track_.Connected(description_);
                EncoderSample timed = **sample;
                timed.time_s = now_s;
                track_.Add(timed);
            }
        }
    }

    // Nothing if the datagram is for another, or not the end of a sample.
    Result<std::optional<EncoderSample>> Decode(std::span<const std::uint8_t> datagram) {
        if (track_.config().kind == EncoderKind::kFreeD) return DecodeAsFreeD(datagram);
        Result<OpenTrackIoStream::Step> step = open_track_io_.Push(datagram);
        if (!step) return step.error();
        if (step->lost > 0) {
            track_.Fault(EncoderFault::kLostData,
                         std::to_string(step->lost) + " datagrams are missing", step->lost);
        }
        return step->sample;
    }

    Result<std::optional<EncoderSample>> DecodeAsFreeD(std::span<const std::uint8_t> datagram) {
        const Result<FreeDMessage> message = DecodeFreeD(datagram);
        if (!message) return message.error();
        const std::optional<int> camera = track_.config().source;
        if (camera && message->camera != *camera) return std::optional<EncoderSample>();
        EncoderSample sample;
        sample.raw[Index(LensAxis::kFocus)] = message->focus;
        sample.raw[Index(LensAxis::kZoom)] = message->zoom;
        return std::optional(sample);
    }

    EncoderTrack& track_;
    const std::string description_ = std::string(Name(track_.config().kind)) + " on UDP port " +
                                     std::to_string(track_.config().port);
    Socket socket_;
    OpenTrackIoStream open_track_io_;
    std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(kMostDatagram);
    SourceThread thread_;
};

}  // namespace

Result<std::unique_ptr<EncoderSource>> StartUdp(EncoderTrack& track) {
    const EncoderConfig& config = track.config();
    in_addr parsed{};
    if (inet_pton(AF_INET, config.address.c_str(), &parsed) != 1) {
        return Error{"bad_config", "'" + config.address + "' is no IPv4 address", "address"};
    }
    if (!config.multicast.empty() && (inet_pton(AF_INET, config.multicast.c_str(), &parsed) != 1 ||
                                      !IN_MULTICAST(ntohl(parsed.s_addr)))) {
        return Error{"bad_config", "'" + config.multicast + "' is no multicast group", "multicast"};
    }
    return std::unique_ptr<EncoderSource>(new UdpEncoder(track));
}

}  // namespace flare
