// SPDX-License-Identifier: Apache-2.0
#include "server/http/message.h"

#include "server/http/text.h"

namespace flare {

std::optional<std::string_view> FieldValue(const HttpFields& fields, std::string_view name) {
    for (const auto& [key, value] : fields) {
        if (EqualIgnoringCase(key, name)) return value;
    }
    return std::nullopt;
}

}  // namespace flare
