// SPDX-License-Identifier: Apache-2.0
//
// What a US Digital QSB (quadrature encoder to USB) says: lines of one letter, a register of two
// hex digits, eight of data, with time stamps eight more, and then '!' or nothing. `r`, `w` and `s`
// answer a read, a write and a stream; `e` is an error. The count is register 0E.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace flare {

inline constexpr int kQsbCountRegister = 0x0e;

struct QsbReply {
    char kind = 'r';  // lower case
    int register_number = 0;
    std::uint32_t data = 0;
    std::optional<std::uint32_t> stamp;
};

// The commands that set one up: line feeds and time stamps behind each answer, quadrature with four
// counts a cycle, the shortest interval (1.9 ms), and its version asked for. With `index_count` the
// counter takes that count each time the encoder's index mark passes: it is the preset (register
// 08) of the counter chip LS7366R, whose mode register MDR0 (03) says what the index does.
std::string QsbSetUp(std::optional<int> index_count);

// One line without its end. Error code "bad_data".
Result<QsbReply> DecodeQsb(std::string_view line);

// The 32-bit counter followed over its ends.
class QsbCounter {
  public:
    std::int64_t Follow(std::uint32_t data);

  private:
    std::optional<std::uint32_t> last_;
    std::int64_t count_ = 0;
};

}  // namespace flare
