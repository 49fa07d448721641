// SPDX-License-Identifier: Apache-2.0
//
// The version of slot i % size is 2 i + 1 while reading i is written and 2 i + 2 afterwards. All
// fields are atomics, stored with release and loaded with acquire: a reader that sees a field of a
// newer reading sees its odd version too, and tries no further.
#include "server/encoder/encoder_track.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "protocol/limits.h"

namespace flare {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kSayAgain_s = 60.0;

double Stored(const std::optional<double>& value) {
    return value.value_or(kNone);
}
std::optional<double> Loaded(double value) {
    return std::isnan(value) ? std::nullopt : std::optional(value);
}

}  // namespace

double EncoderClock::Now_s() {
    using Seconds = std::chrono::duration<double>;
    static const double offset_s =
        Seconds(std::chrono::system_clock::now().time_since_epoch()).count() -
        Seconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    return offset_s + Seconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string_view Name(EncoderHealth health) {
    switch (health) {
        case EncoderHealth::kWaiting:
            return "waiting";
        case EncoderHealth::kLive:
            return "live";
        case EncoderHealth::kStale:
            return "stale";
        case EncoderHealth::kLost:
            return "lost";
        case EncoderHealth::kFailed:
            return "failed";
    }
    return "failed";
}

LensReading Between(const LensReading& a, const LensReading& b, double w) {
    LensReading between = a;
    for (const LensAxis axis : kLensAxes) {
        if (!a[axis] || !b[axis] || *a[axis] == *b[axis]) continue;
        if (axis == LensAxis::kIris && a.iris_is_t_stop != b.iris_is_t_stop) continue;
        between[axis] = ValueFromEven(
            axis, (1.0 - w) * EvenFromValue(axis, *a[axis]) + w * EvenFromValue(axis, *b[axis]));
    }
    return between;
}

struct EncoderTrack::Slot {
    std::atomic<std::uint64_t> version = 0;
    std::atomic<double> time_s = 0.0;
    std::array<std::atomic<double>, 3> values{}, raw{};
    std::atomic<bool> iris_is_t_stop = false;
};

EncoderTrack::EncoderTrack(EncoderConfig config, EncoderLog log)
    : config_(std::move(config)),
      log_(std::move(log)),
      calibration_(config_.calibration),
      slots_(std::make_unique<Slot[]>(limits::kEncoderHistory)) {}

EncoderTrack::~EncoderTrack() = default;

void EncoderTrack::Connected(const std::string& description, const std::string& lens) {
    calibration_.Forget();
    {
        const std::lock_guard lock(mutex_);
        description_ = description;
        device_lens_ = lens;
        problem_.clear();
        logged_.reset();
    }
    ever_connected_.store(true, std::memory_order_relaxed);
    connected_.store(true, std::memory_order_relaxed);
    log_(false, "encoder " + config_.name + ": connected to " + description);
}

void EncoderTrack::Disconnected(EncoderFault why, const std::string& text) {
    connected_.store(false, std::memory_order_relaxed);
    Fault(why, text);
}

void EncoderTrack::Fault(EncoderFault fault, const std::string& text, std::uint64_t times) {
    faults_[static_cast<std::size_t>(fault)].fetch_add(times, std::memory_order_relaxed);
    const double now_s = EncoderClock::Now_s();
    {
        const std::lock_guard lock(mutex_);
        problem_ = text;
        if (logged_ == fault && now_s - logged_s_ < kSayAgain_s) return;
        logged_ = fault;
        logged_s_ = now_s;
    }
    log_(true, "encoder " + config_.name + ": " + text);
}

void EncoderTrack::Recovered() {
    const std::lock_guard lock(mutex_);
    problem_.clear();
}

void EncoderTrack::Add(const EncoderSample& sample) {
    EncoderSample ordered = sample;
    ordered.time_s = last_time_s_ = std::max(last_time_s_, sample.time_s);
    const LensReading reading = calibration_.Read(ordered);
    const std::uint64_t index = samples_.load(std::memory_order_relaxed);
    Slot& slot = slots_[index % limits::kEncoderHistory];
    slot.version.store(2 * index + 1, std::memory_order_release);
    slot.time_s.store(ordered.time_s, std::memory_order_release);
    for (std::size_t i = 0; i < kLensAxes.size(); ++i) {
        slot.values[i].store(Stored(reading.values[i]), std::memory_order_release);
        slot.raw[i].store(Stored(ordered.raw[i]), std::memory_order_release);
    }
    slot.iris_is_t_stop.store(reading.iris_is_t_stop, std::memory_order_release);
    slot.version.store(2 * index + 2, std::memory_order_release);
    samples_.store(index + 1, std::memory_order_release);
}

std::optional<TimedReading> EncoderTrack::Read(std::uint64_t index) const {
    const Slot& slot = slots_[index % limits::kEncoderHistory];
    const std::uint64_t version = 2 * index + 2;
    if (slot.version.load(std::memory_order_acquire) != version) return std::nullopt;
    TimedReading timed;
    timed.time_s = slot.time_s.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < kLensAxes.size(); ++i) {
        timed.reading.values[i] = Loaded(slot.values[i].load(std::memory_order_acquire));
        timed.raw[i] = Loaded(slot.raw[i].load(std::memory_order_acquire));
    }
    timed.reading.iris_is_t_stop = slot.iris_is_t_stop.load(std::memory_order_acquire);
    if (slot.version.load(std::memory_order_relaxed) != version) return std::nullopt;
    return timed;
}

std::optional<TimedReading> EncoderTrack::Newest() const {
    for (;;) {
        const std::uint64_t count = samples_.load(std::memory_order_acquire);
        if (count == 0) return std::nullopt;
        // Fails only if the whole ring was written meanwhile.
        if (std::optional<TimedReading> newest = Read(count - 1)) return newest;
    }
}

Result<TimedReading> EncoderTrack::At(double time_s) const {
    const Error before{"encoder_time",
                       "the encoder '" + config_.name + "' does not remember that time", ""};
    const std::uint64_t count = samples_.load(std::memory_order_acquire);
    if (count == 0) {
        return Error{"encoder_stale", "the encoder '" + config_.name + "' has given no state yet",
                     ""};
    }
    // A reading that was overwritten is older than all that are left.
    std::uint64_t low = count > limits::kEncoderHistory ? count - limits::kEncoderHistory : 0;
    std::uint64_t high = count;
    while (low < high) {  // the first that is later than time_s
        const std::uint64_t middle = low + (high - low) / 2;
        const std::optional<TimedReading> timed = Read(middle);
        if (timed && timed->time_s > time_s) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if (low == 0) return before;
    const std::optional<TimedReading> a = Read(low - 1);
    if (!a) return before;
    const std::optional<TimedReading> b = low < count ? Read(low) : std::nullopt;
    if (!b) return *a;
    const double w = (time_s - a->time_s) / (b->time_s - a->time_s);
    TimedReading between = *a;
    between.reading = Between(a->reading, b->reading, w);
    for (std::size_t i = 0; i < kLensAxes.size(); ++i) {
        if (a->raw[i] && b->raw[i]) between.raw[i] = (1.0 - w) * *a->raw[i] + w * *b->raw[i];
    }
    return between;
}

double EncoderTrack::RateAt(double now_s, std::uint64_t count) const {
    std::uint64_t low = count > limits::kEncoderHistory ? count - limits::kEncoderHistory : 0;
    std::uint64_t high = count;
    while (low < high) {
        const std::uint64_t middle = low + (high - low) / 2;
        const std::optional<TimedReading> timed = Read(middle);
        if (timed && timed->time_s > now_s - 1.0) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return static_cast<double>(count - low);
}

EncoderStatus EncoderTrack::Status(double now_s) const {
    EncoderStatus status;
    status.samples = samples_.load(std::memory_order_acquire);
    status.newest = Newest();
    status.rate_hz = RateAt(now_s, status.samples);
    status.connected = connected();
    for (std::size_t i = 0; i < faults_.size(); ++i) {
        status.faults[i] = faults_[i].load(std::memory_order_relaxed);
    }
    std::optional<EncoderFault> last;
    {
        const std::lock_guard lock(mutex_);
        status.description = description_;
        status.lens = device_lens_;
        status.problem = problem_;
        last = logged_;
    }
    const bool fresh = status.newest && now_s - status.newest->time_s <= config_.stale_ms * 1e-3;
    if (status.connected) {
        status.health = fresh ? EncoderHealth::kLive : EncoderHealth::kStale;
    } else if (!status.problem.empty() && last != EncoderFault::kUnplugged &&
               last != EncoderFault::kTimeout) {
        status.health = EncoderHealth::kFailed;
    } else {
        status.health = ever_connected_.load(std::memory_order_relaxed) ? EncoderHealth::kLost
                                                                        : EncoderHealth::kWaiting;
    }
    return status;
}

std::string EncoderTrack::lens() const {
    if (!config_.lens.empty()) return config_.lens;
    const std::lock_guard lock(mutex_);
    return device_lens_;
}

}  // namespace flare
