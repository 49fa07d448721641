// SPDX-License-Identifier: Apache-2.0
//
// Memory of byte strings that are used no more, for the next ones: the page faults of a fresh
// string of 25 MB cost more than filling it. Holds a few strings and a bounded number of bytes;
// what does not fit is freed. Safe from any thread.
#pragma once

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace flare {

class SpareBytes {
  public:
    explicit SpareBytes(std::size_t most_strings = 4, std::size_t most_bytes = std::size_t{1} << 28)
        : most_strings_(most_strings), most_bytes_(most_bytes) {}

    // The roomiest string there is, with whatever it held last; an empty one if there is none.
    std::string Take();
    // A string that is used no more. Those too small to matter are freed.
    void Keep(std::string bytes);

  private:
    const std::size_t most_strings_, most_bytes_;
    std::mutex mutex_;
    std::vector<std::string> spare_;
};

}  // namespace flare
