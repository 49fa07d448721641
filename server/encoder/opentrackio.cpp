// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/opentrackio.h"

#include <algorithm>

#include "protocol/codec/json_document.h"
#include "protocol/limits.h"

namespace flare {
namespace {

constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kChecksumAt = 14;
constexpr int kJsonEncoding = 1;
// A step back, or so far ahead, is a sender that began anew.
constexpr std::uint16_t kMostLost = 1'000;

Error BadData(std::string message, std::string where = "") {
    return {"bad_data", std::move(message), std::move(where)};
}

// A number of an object; none if it is absent, an error if it is something else.
Result<std::optional<double>> NumberAt(const wire::JsonView& object, std::string_view name) {
    const std::optional<wire::JsonView> member = object.Find(name);
    if (!member) return std::optional<double>();
    if (member->kind() != wire::JsonKind::kNumber) {
        return BadData("a lens value is no number", member->Pointer());
    }
    return std::optional(member->number());
}

}  // namespace

std::array<std::uint8_t, 2> Fletcher16(std::span<const std::uint8_t> first,
                                       std::span<const std::uint8_t> second) {
    unsigned a = 0, b = 0;
    for (const auto part : {first, second}) {
        for (const std::uint8_t byte : part) {
            a = (a + byte) % 255;
            b = (b + a) % 255;
        }
    }
    return {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
}

Result<OpenTrackIoSegment> DecodeOpenTrackIoSegment(std::span<const std::uint8_t> datagram) {
    if (datagram.size() < kHeaderBytes) return BadData("shorter than an OpenTrackIO header");
    constexpr std::array<std::uint8_t, 4> kMagic{'O', 'T', 'r', 'k'};
    if (!std::equal(kMagic.begin(), kMagic.end(), datagram.begin())) {
        return BadData("not an OpenTrackIO datagram", "byte 1");
    }
    const auto two = [&](std::size_t at) {
        return static_cast<std::uint16_t>(datagram[at] << 8 | datagram[at + 1]);
    };
    OpenTrackIoSegment segment;
    segment.encoding = datagram[5];
    segment.sequence = two(6);
    segment.offset = static_cast<std::uint32_t>(two(8)) << 16 | two(10);
    segment.last = (two(12) & 0x8000U) != 0;
    segment.payload = datagram.subspan(kHeaderBytes);
    if ((two(12) & 0x7fffU) != segment.payload.size()) {
        return BadData("the payload is not as long as its header says", "byte 13");
    }
    const auto sum = Fletcher16(datagram.first(kChecksumAt), segment.payload);
    if (sum[0] != datagram[kChecksumAt] || sum[1] != datagram[kChecksumAt + 1]) {
        return BadData("the OpenTrackIO checksum is wrong", "byte 15");
    }
    return segment;
}

Result<EncoderSample> DecodeOpenTrackIoSample(std::string_view json) {
    const auto parsed = wire::JsonDocument::Parse(json);
    if (const wire::Refusal* refusal = wire::RefusalOf(parsed)) {
        return BadData(refusal->message, refusal->where);
    }
    const wire::JsonView root = std::get<wire::JsonDocument>(parsed).root();
    if (root.kind() != wire::JsonKind::kObject) return BadData("a sample is an object");
    EncoderSample sample;
    const std::optional<wire::JsonView> lens = root.Find("lens");
    if (!lens) return sample;
    if (lens->kind() != wire::JsonKind::kObject) return BadData("no object", lens->Pointer());

    const bool t_stop = lens->Find("tStop").has_value();
    constexpr std::array<std::string_view, 3> kValues{"focusDistance", "fStop",
                                                      "pinholeFocalLength"};
    for (const LensAxis axis : kLensAxes) {
        const std::string_view name =
            axis == LensAxis::kIris && t_stop ? "tStop" : kValues[Index(axis)];
        const Result<std::optional<double>> value = NumberAt(*lens, name);
        if (!value) return value.error();
        sample.stated[axis] = *value;
    }
    sample.stated.iris_is_t_stop = t_stop;

    std::optional<wire::JsonView> counts = lens->Find("encoders");
    if (!counts) counts = lens->Find("rawEncoders");
    if (!counts) return sample;
    if (counts->kind() != wire::JsonKind::kObject) return BadData("no object", counts->Pointer());
    for (const LensAxis axis : kLensAxes) {
        const Result<std::optional<double>> count = NumberAt(*counts, Name(axis));
        if (!count) return count.error();
        sample.raw[Index(axis)] = *count;
    }
    return sample;
}

Result<OpenTrackIoStream::Step> OpenTrackIoStream::Push(std::span<const std::uint8_t> datagram) {
    const Result<OpenTrackIoSegment> segment = DecodeOpenTrackIoSegment(datagram);
    if (!segment) return segment.error();
    Step step;
    if (sequence_) {
        const auto ahead = static_cast<std::uint16_t>(segment->sequence - *sequence_ - 1);
        if (ahead < kMostLost) step.lost = ahead;
        if (ahead != 0) collecting_ = false;
    }
    sequence_ = segment->sequence;
    if (segment->encoding != kJsonEncoding) {
        return BadData("the encoding " + std::to_string(segment->encoding) + " is not JSON",
                       "byte 6");
    }
    if (segment->offset == 0) {
        text_.clear();
        collecting_ = true;
    }
    if (!collecting_) return step;  // the beginning was lost
    if (segment->offset != text_.size()) {
        collecting_ = false;
        return BadData("a segment does not begin where the last one ended", "byte 9");
    }
    if (text_.size() + segment->payload.size() > limits::kOpenTrackIoBytes) {
        collecting_ = false;
        return BadData("the sample is too long");
    }
    text_.append(segment->payload.begin(), segment->payload.end());
    if (!segment->last) return step;
    collecting_ = false;
    Result<EncoderSample> sample = DecodeOpenTrackIoSample(text_);
    if (!sample) return sample.error();
    step.sample = std::move(*sample);
    return step;
}

}  // namespace flare
