// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/qsb_talk.h"

#include <cstdio>

#include "server/encoder/usb_silence.h"

namespace flare {
namespace {

constexpr int kBaud = 230'400;
constexpr char kStream[] = "S0E\n";
constexpr int kVersionRegister = 0x14;
constexpr double kPatience_s = 1.0;

}  // namespace

std::optional<UsbProblem> QsbTalk::Run(const UsbFound& found) {
    if (auto problem = port_.Open(found.device.get(), kBaud)) return problem;
    if (auto problem = Begin(found)) return problem;
    return Listen();
}

// The device is known to be a QSB when it has told its version.
std::optional<UsbProblem> QsbTalk::Begin(const UsbFound& found) {
    if (auto problem = port_.Write(QsbSetUp(track_.config().index_count))) return problem;
    const double end_s = EncoderClock::Now_s() + kPatience_s;
    while (!stop_.set() && EncoderClock::Now_s() < end_s) {
        UsbRead read = port_.Read();
        if (read.problem) return read.problem;
        lines_.Push(read.text());
        while (const std::optional<std::string> line = lines_.Next()) {
            const Result<QsbReply> reply = DecodeQsb(*line);
            if (!reply || reply->kind != 'r' || reply->register_number != kVersionRegister)
                continue;
            char version[20];
            std::snprintf(version, sizeof version, ", version %X", reply->data);
            if (auto problem = port_.Write(kStream)) return problem;
            track_.Connected(found.description + version);
            return std::nullopt;
        }
    }
    if (stop_.set()) return std::nullopt;
    return UsbProblem{EncoderFault::kTimeout, "the QSB does not answer"};
}

std::optional<UsbProblem> QsbTalk::Listen() {
    UsbSilence silence(track_);
    std::uint64_t dropped = lines_.dropped();
    while (!stop_.set()) {
        UsbRead read = port_.Read();
        const double now_s = EncoderClock::Now_s();
        if (read.problem) {
            // The rest of a record will never come.
            if (lines_.in_a_line()) track_.Fault(EncoderFault::kShortRead, "half an answer");
            return read.problem;
        }
        const std::uint64_t before = track_.samples();
        lines_.Push(read.text());
        while (const std::optional<std::string> line = lines_.Next()) Take(*line, now_s);
        if (lines_.dropped() != dropped) {
            dropped = lines_.dropped();
            track_.Fault(EncoderFault::kBadData, "bytes without a line end");
        }
        if (track_.samples() != before) {
            silence.Heard();
        } else if (silence.TooLong()) {
            // Perhaps it lost its power for a moment and streams no more.
            if (auto problem = port_.Write(kStream)) return problem;
        }
    }
    return std::nullopt;
}

void QsbTalk::Take(const std::string& line, double now_s) {
    const Result<QsbReply> reply = DecodeQsb(line);
    if (!reply) return track_.Fault(EncoderFault::kBadData, reply.error().message);
    if (reply->kind == 'e') return track_.Fault(EncoderFault::kOther, "the QSB reports an error");
    if (reply->register_number != kQsbCountRegister || reply->kind == 'w') return;
    EncoderSample sample;
    sample.time_s = now_s;
    sample.raw[Index(track_.config().axis)] = static_cast<double>(counter_.Follow(reply->data));
    track_.Add(sample);
}

}  // namespace flare
