// SPDX-License-Identifier: Apache-2.0
//
// Any bytes as a lens file: refused with a message, or a prescription that the lint can judge, that
// can be built or is refused in words, and that comes back from its own file.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "core/optics/lens.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "core/prescription/prescription_writer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace flare;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const Result<Prescription> prescription = ReadPrescriptionToml(text);
    if (!prescription) {
        FLARE_CHECK(!prescription.error().code.empty() && !prescription.error().message.empty());
        return 0;
    }
    bool faulty = false;
    for (const Finding& finding : CheckPrescription(*prescription)) {
        FLARE_CHECK(!finding.message.empty());
        faulty = faulty || finding.severity == Severity::kError;
    }
    // What the lint has no fault to find with can be built.
    FLARE_CHECK(faulty || Lens::Build(*prescription).ok());
    const std::string written = TomlFromPrescription(*prescription);
    const Result<Prescription> again = ReadPrescriptionToml(written);
    FLARE_CHECK(again.ok());
    FLARE_CHECK(TomlFromPrescription(*again) == written);
    return 0;
}
