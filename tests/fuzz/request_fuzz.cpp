// SPDX-License-Identifier: Apache-2.0
//
// Any bytes as the body of POST /v1/flare: refused with a code and a place, or a request in the
// core's words that the renderer's own check can judge.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "core/base/check.h"
#include "core/render/renderer.h"
#include "protocol/codec/flare_request_codec.h"
#include "server/lens_library.h"
#include "server/translate/request_from_wire.h"

namespace {

const flare::LensLibrary& Library() {
    static const flare::Result<flare::LensLibrary> library =
        flare::LensLibrary::Load(FLARE_SOURCE_DIR "/lenses");
    FLARE_CHECK(library.ok());
    return *library;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    Library();
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace flare;
    const std::string_view body(reinterpret_cast<const char*>(data), size);
    const wire::Decoded<wire::FlareRequest> decoded = wire::DecodeFlareRequest(body);
    if (const wire::Refusal* refusal = wire::RefusalOf(decoded)) {
        FLARE_CHECK(!refusal->code.empty() && !refusal->message.empty());
        return 0;
    }
    const auto& wire_request = std::get<wire::FlareRequest>(decoded);
    const Result<FlareRequest> request = RequestFromWire(wire_request, Library());
    if (!request) {
        FLARE_CHECK(!request.error().code.empty() && !request.error().message.empty());
        return 0;
    }
    const std::optional<Error> error = CheckRequest(*request);
    FLARE_CHECK(!error || !error->message.empty());
    FLARE_CHECK(RequestHash(wire_request, *request).hex().size() == 32);
    return 0;
}
