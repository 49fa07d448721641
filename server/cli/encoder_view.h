// SPDX-License-Identifier: Apache-2.0
//
// How the commands see encoders: those of a daemon, by GET /v1/encoders, or those of a
// configuration file, which then run inside the command. Both come as the same document.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "protocol/codec/json_document.h"
#include "server/encoder/encoder_set.h"

namespace CLI {
class App;
}

namespace flare::cli {

// The encoders of a configuration file; none for "". Complaints of encoders go to standard error.
Result<std::unique_ptr<EncoderSet>> StartEncoders(const std::string& config_path);

// Until each has given a state; at most two seconds.
void WaitForStates(const EncoderSet& encoders);

// --server URL and --config FILE, of which one may be given.
void AddEncoderSource(CLI::App& command, std::string& server, std::string& config);

// flare encoder calibrate.
void AddCalibrateCommand(CLI::App& encoder, int& exit_code);

class EncoderView {
  public:
    // One of the two is ""; if both are, the daemon at its default address.
    static Result<EncoderView> Open(const std::string& server, const std::string& config);

    // The document as it is now. Error code "no_server" if there is no answer.
    Result<std::string> Text() const;
    Result<wire::JsonDocument> Document() const;

  private:
    std::string server_;
    std::unique_ptr<EncoderSet> encoders_;
};

// The encoder of that name in a document.
std::optional<wire::JsonView> FindEncoder(const wire::JsonDocument& document,
                                          const std::string& name);

}  // namespace flare::cli
