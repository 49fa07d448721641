// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/cooke_talk.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "server/encoder/usb_silence.h"

namespace flare {
namespace {

constexpr std::array kFirstBauds{115'200, 9'600};
constexpr int kFastBaud = 230'400;
constexpr double kPatience_s = 0.4;
constexpr char kAccepted[] = "!";

// "5/100-009" to "cooke-5-100-009": the name by which a library may have just this lens.
std::string LibraryName(const CookeLens& lens) {
    std::string name = "cooke-";
    for (const char c : lens.serial) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == ' ') continue;
        name += std::isalnum(byte) ? static_cast<char>(std::tolower(byte)) : '-';
    }
    return name;
}

std::string Description(const CookeLens& lens, const UsbFound& found) {
    std::string text = "Cooke /i lens " + lens.serial + ", " + std::to_string(lens.focal_mm);
    if (lens.zoom) text += "-" + std::to_string(lens.longest_focal_mm);
    return text + " mm, on " + found.description;
}

}  // namespace

std::optional<UsbProblem> CookeTalk::Run(const UsbFound& found) {
    CookeLens lens;
    if (auto problem = port_.Open(found.device.get(), kFirstBauds.front())) return problem;
    if (auto problem = Meet(lens)) return problem;
    if (auto problem = SpeedUp()) return problem;
    imperial_ = lens.imperial;
    const Answer checksums = Ask("G\r", "!MN");
    if (checksums.problem) return checksums.problem;
    if (checksums.line.empty()) {
        return UsbProblem{EncoderFault::kTimeout, "the lens sends no checksums"};
    }
    if (auto problem = port_.Write("Kc\r")) return problem;
    track_.Connected(Description(lens, found), LibraryName(lens));
    auto problem = Listen();
    if (!problem) port_.Write("H\r");  // a lens that is left alone shall be quiet
    return problem;
}

CookeTalk::Answer CookeTalk::Ask(std::string_view command, std::string_view begins) {
    Answer answer;
    answer.problem = port_.Write(command);
    const double end_s = EncoderClock::Now_s() + kPatience_s;
    while (!answer.problem && !stop_.set() && EncoderClock::Now_s() < end_s) {
        const UsbRead read = port_.Read();
        answer.problem = read.problem;
        lines_.Push(read.text());
        while (std::optional<std::string> line = lines_.Next()) {
            if (!line->starts_with(begins)) continue;
            answer.line = std::move(*line);
            return answer;
        }
    }
    return answer;
}

// A lens that still sends from before is quieted first.
std::optional<UsbProblem> CookeTalk::Meet(CookeLens& lens) {
    for (const int baud : kFirstBauds) {
        if (auto problem = port_.SetBaud(baud)) return problem;
        if (auto problem = port_.Write("H\r")) return problem;
        const Answer answer = Ask("N\r", "N");
        if (answer.problem) return answer.problem;
        const Result<CookeLens> met = DecodeCookeLens(answer.line);
        if (!met) continue;
        lens = *met;
        baud_ = baud;
        return std::nullopt;
    }
    return UsbProblem{EncoderFault::kTimeout, "no /i lens answers"};
}

// 285 records of 41 bytes a second do not fit through 115200 baud. A lens that cannot follow is met
// again as it was.
std::optional<UsbProblem> CookeTalk::SpeedUp() {
    const Answer accepted = Ask("Kb7\r", kAccepted);
    if (accepted.problem || accepted.line.empty()) return accepted.problem;
    if (auto problem = port_.SetBaud(kFastBaud)) return problem;
    const Answer answer = Ask("N\r", "N");
    if (answer.problem || !answer.line.empty()) return answer.problem;
    return port_.SetBaud(baud_);
}

std::optional<UsbProblem> CookeTalk::Listen() {
    UsbSilence silence(track_);
    while (!stop_.set()) {
        UsbRead read = port_.Read();
        const double now_s = EncoderClock::Now_s();
        if (read.problem) {
            if (lines_.in_a_line()) track_.Fault(EncoderFault::kShortRead, "half a record");
            return read.problem;
        }
        const std::uint64_t before = track_.samples();
        lines_.Push(read.text());
        while (const std::optional<std::string> line = lines_.Next()) Take(*line, now_s);
        if (track_.samples() != before) {
            silence.Heard();
        } else if (silence.TooLong()) {
            // Perhaps the lens was changed on a cable that stayed.
            return UsbProblem{EncoderFault::kTimeout, "the lens says nothing"};
        }
    }
    return std::nullopt;
}

void CookeTalk::Take(std::string_view line, double now_s) {
    const Result<std::string_view> text = CheckCookeChecksum(line);
    const Result<CookeRecord> record =
        text ? DecodeCookePacked(*text) : Result<CookeRecord>(text.error());
    if (!record) return track_.Fault(EncoderFault::kBadData, record.error().message);
    EncoderSample sample;
    sample.time_s = now_s;
    sample.stated[LensAxis::kFocus] = CookeFocus_m(*record, imperial_);
    sample.stated[LensAxis::kIris] = record->t_stop;
    sample.stated.iris_is_t_stop = true;
    if (record->zoom_mm > 0) sample.stated[LensAxis::kZoom] = record->zoom_mm;
    track_.Add(sample);
}

}  // namespace flare
