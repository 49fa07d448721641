// SPDX-License-Identifier: Apache-2.0
//
// Where one picture leaves what the next may need: ghosts as they were drawn, what they were chosen
// by, a lens's tables. A key holds all that its value depends on, and begins with the kind of
// value: a picture has the same bytes whether anything was kept or not. Called from several threads
// at once.
#pragma once

#include <cstddef>
#include <memory>

#include "core/base/fingerprint.h"

namespace flare {

enum class KeptKind { kGhost, kSeen, kTables };

class RenderKeeper {
  public:
    virtual ~RenderKeeper() = default;

    // A `Value` says its kKind and its bytes(). Null if none is kept under that key.
    template <class Value>
    std::shared_ptr<const Value> Find(const Fingerprint& key) {
        return std::static_pointer_cast<const Value>(FindValue(Value::kKind, key));
    }
    template <class Value>
    void Keep(const Fingerprint& key, std::shared_ptr<const Value> value) {
        const std::size_t bytes = value->bytes();
        KeepValue(key, std::move(value), bytes);
    }

  private:
    virtual std::shared_ptr<const void> FindValue(KeptKind kind, const Fingerprint& key) = 0;
    virtual void KeepValue(const Fingerprint& key, std::shared_ptr<const void> value,
                           std::size_t bytes) = 0;
};

}  // namespace flare
