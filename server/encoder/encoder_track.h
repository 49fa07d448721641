// SPDX-License-Identifier: Apache-2.0
//
// What is known of one encoder: its newest reading, the readings before it, its health and what
// went wrong. One device thread writes, any thread reads. A reader of readings takes no lock and
// waits for nobody (each is a slot of atomics under a version number, and is read again if it
// changed meanwhile); the words (descriptions, errors) are behind a mutex that is held for a copy.
//
// History: the last kEncoderHistory readings, 14 s at 285 a second. Between two of them a reading
// at a time is interpolated in the even variables of axis_table.h; after the newest it is held.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "server/encoder/calibration.h"
#include "server/encoder/encoder_config.h"

namespace flare {

enum class EncoderHealth {
    kWaiting,  // no device yet
    kLive,
    kStale,  // connected, and no sample for stale_ms
    kLost,   // was connected; the last state is held
    kFailed  // there is a device and it cannot be used; `problem` says why
};
std::string_view Name(EncoderHealth health);

// What can go wrong; each is counted for itself.
enum class EncoderFault {
    kBadData,    // bytes that are no record
    kLostData,   // a gap in a sequence
    kTimeout,    // nothing for stale_ms
    kShortRead,  // part of a record
    kStall,      // a USB endpoint that halted
    kUnplugged,
    kDenied,     // no permission
    kAmbiguous,  // several devices fit
    kOther
};
inline constexpr std::array<std::string_view, 9> kEncoderFaultNames{
    "bad_data",  "lost_data", "timeout",   "short_read", "stall",
    "unplugged", "denied",    "ambiguous", "other"};
constexpr std::string_view Name(EncoderFault fault) {
    return kEncoderFaultNames[static_cast<std::size_t>(fault)];
}
using EncoderFaultCounts = std::array<std::uint64_t, kEncoderFaultNames.size()>;

struct TimedReading {
    double time_s = 0.0;
    LensReading reading;
    std::array<std::optional<double>, 3> raw;
};

struct EncoderStatus {
    EncoderHealth health = EncoderHealth::kWaiting;
    bool connected = false;
    std::uint64_t samples = 0;
    EncoderFaultCounts faults{};
    double rate_hz = 0.0;     // samples of the last second
    std::string description;  // of the device, "" before it was met
    std::string lens;         // that the device says it is, "" if it does not
    std::string problem;      // the last fault, "" if none since it was last well
    std::optional<TimedReading> newest;
};

// A line for the log; `warning`: somebody may have to do something.
using EncoderLog = std::function<void(bool warning, const std::string& text)>;

class EncoderTrack {
  public:
    EncoderTrack(EncoderConfig config, EncoderLog log);
    ~EncoderTrack();
    EncoderTrack(const EncoderTrack&) = delete;
    EncoderTrack& operator=(const EncoderTrack&) = delete;

    const EncoderConfig& config() const { return config_; }

    // For the device thread.
    void Connected(const std::string& description, const std::string& lens = "");
    void Disconnected(EncoderFault why, const std::string& text);  // counts the fault as well
    void Add(const EncoderSample& sample);
    // Counted each time; logged when it is another than the last, or a minute later.
    void Fault(EncoderFault fault, const std::string& text, std::uint64_t times = 1);
    void Recovered();  // the problem that Disconnected or Fault named is over

    // For everybody.
    std::optional<TimedReading> Newest() const;
    // Error code "encoder_time" before the history, "encoder_stale" if there is no reading at all.
    Result<TimedReading> At(double time_s) const;
    EncoderStatus Status(double now_s) const;
    std::string lens() const;  // the config's, else the device's
    bool connected() const { return connected_.load(std::memory_order_relaxed); }
    std::uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }

  private:
    struct Slot;
    std::optional<TimedReading> Read(std::uint64_t index) const;
    double RateAt(double now_s, std::uint64_t count) const;

    const EncoderConfig config_;
    const EncoderLog log_;
    Calibration calibration_;
    double last_time_s_ = 0.0;

    std::unique_ptr<Slot[]> slots_;
    std::atomic<std::uint64_t> samples_ = 0;  // index of the next
    std::atomic<bool> connected_ = false, ever_connected_ = false;
    std::array<std::atomic<std::uint64_t>, kEncoderFaultNames.size()> faults_{};

    mutable std::mutex mutex_;  // guards what follows
    std::string description_, device_lens_, problem_;
    std::optional<EncoderFault> logged_;
    double logged_s_ = 0.0;
};

// Between two readings, at the share w of the way.
LensReading Between(const LensReading& a, const LensReading& b, double w);

}  // namespace flare
