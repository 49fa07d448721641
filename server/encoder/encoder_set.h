// SPDX-License-Identifier: Apache-2.0
//
// All encoders of a program, running from construction until destruction. Safe from any thread.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/encoder/encoder_source.h"

namespace flare {

class EncoderSet {
  public:
    // Error code "bad_config"; `where` names encoder and key. Says once to `log` if the threads of
    // USB devices may not go before others.
    static Result<std::unique_ptr<EncoderSet>> Start(const std::vector<EncoderConfig>& configs,
                                                     const EncoderLog& log);

    const EncoderTrack* Find(std::string_view name) const;  // null if there is none
    const std::vector<std::unique_ptr<EncoderTrack>>& tracks() const { return tracks_; }

  private:
    std::vector<std::unique_ptr<EncoderTrack>> tracks_;
    std::vector<std::unique_ptr<EncoderSource>> sources_;  // go before the tracks they feed
};

// The body of GET /v1/encoders.
std::string EncodersJson(const EncoderSet& encoders);

}  // namespace flare
