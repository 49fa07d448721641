// SPDX-License-Identifier: Apache-2.0
//
// Bytes of a serial line in, lines out; any mix of CR and LF ends one, and empty ones are none. A
// line that grows past `limit` is dropped up to its end, and counted. Belongs to one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace flare {

class LineSplitter {
  public:
    explicit LineSplitter(std::size_t limit) : limit_(limit) {}

    void Push(std::string_view bytes) { bytes_ += bytes; }
    std::optional<std::string> Next() {
        while (at_ < bytes_.size()) {
            const char c = bytes_[at_++];
            if (c != '\r' && c != '\n') {
                if (line_.size() == limit_) {
                    if (!too_long_) ++dropped_;
                    too_long_ = true;
                } else {
                    line_ += c;
                }
                continue;
            }
            const bool whole = !line_.empty() && !too_long_;
            std::string line;
            line.swap(line_);
            too_long_ = false;
            if (whole) return line;
        }
        bytes_.clear();
        at_ = 0;
        return std::nullopt;
    }
    bool in_a_line() const { return !line_.empty(); }
    std::uint64_t dropped() const { return dropped_; }

  private:
    const std::size_t limit_;
    std::string bytes_, line_;
    std::size_t at_ = 0;
    std::uint64_t dropped_ = 0;
    bool too_long_ = false;
};

}  // namespace flare
