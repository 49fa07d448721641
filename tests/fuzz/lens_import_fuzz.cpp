// SPDX-License-Identifier: Apache-2.0
//
// Any bytes as a lens file of another program. The first byte chooses the format, 0 to 9 in the
// order of FormatNames(); any other lets the content say.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "core/prescription/prescription_writer.h"
#include "server/translate/lens_import_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace flare;
    if (size == 0) return 0;
    std::optional<LensFormat> format;
    if (data[0] < FormatNames().size()) format = FormatByName(FormatNames()[data[0]]);
    const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
    const Result<ImportedLens> lens = ImportLensFile(text, format);
    if (!lens) {
        FLARE_CHECK(!lens.error().code.empty() && !lens.error().message.empty());
        return 0;
    }
    for (const Finding& finding : CheckPrescription(lens->prescription)) {
        FLARE_CHECK(!finding.message.empty());
    }
    const Result<Prescription> back =
        ReadPrescriptionToml(TomlFromPrescription(lens->prescription));
    FLARE_CHECK(back.ok() || !back.error().message.empty());
    return 0;
}
