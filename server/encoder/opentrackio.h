// SPDX-License-Identifier: Apache-2.0
//
// OpenTrackIO 1.0.1 over UDP (SMPTE RIS-OSVP): datagrams with a 16-byte big-endian header, "OTrk",
// a reserved byte, the encoding (1 JSON, 2 CBOR), a sequence number, the offset of this segment,
// its length with the top bit set in the last one, and a Fletcher-16 over header and payload; then
// a sample in JSON, perhaps in several segments. CBOR is refused. Of a sample its lens is read:
// tStop or fStop, focusDistance (m), pinholeFocalLength (mm) as values, and `encoders`
// (0 to 1: focus 0 is infinity, iris 0 open, zoom 0 wide) as counts for calibration tables, or
// `rawEncoders` where there are no encoders.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "server/encoder/lens_reading.h"

namespace flare {

// Both sums modulo 255 over the bytes, in the order of the wire.
std::array<std::uint8_t, 2> Fletcher16(std::span<const std::uint8_t> first,
                                       std::span<const std::uint8_t> second);

struct OpenTrackIoSegment {
    int encoding = 1;
    std::uint16_t sequence = 0;
    std::uint32_t offset = 0;
    bool last = true;
    std::span<const std::uint8_t> payload;  // into the datagram
};

// Error code "bad_data".
Result<OpenTrackIoSegment> DecodeOpenTrackIoSegment(std::span<const std::uint8_t> datagram);

// The lens of one sample; its time is left 0. A sample without a lens gives no values. Error code
// "bad_data", `where` a JSON pointer.
Result<EncoderSample> DecodeOpenTrackIoSample(std::string_view json);

// Puts segments together and looks for gaps in the sequence. Belongs to one thread.
class OpenTrackIoStream {
  public:
    struct Step {
        std::optional<EncoderSample> sample;  // once it is complete
        std::uint64_t lost = 0;               // datagrams that the sequence skipped
    };
    Result<Step> Push(std::span<const std::uint8_t> datagram);

  private:
    std::string text_;
    bool collecting_ = false;
    std::optional<std::uint16_t> sequence_;  // of the last datagram
};

}  // namespace flare
