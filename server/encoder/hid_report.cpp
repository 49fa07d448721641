// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/hid_report.h"

namespace flare {
namespace {

double Count(std::span<const std::uint8_t> bytes, const HidField& field) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        value = value << 8 | bytes[field.big_endian ? i : bytes.size() - 1 - i];
    }
    const std::int64_t limit = std::int64_t{1} << field.bits;
    auto number = static_cast<std::int64_t>(value);
    if (field.is_signed && number >= limit / 2) number -= limit;
    return static_cast<double>(number);
}

}  // namespace

Result<std::optional<EncoderSample>> DecodeHidReport(std::span<const std::uint8_t> report,
                                                     const HidMap& map) {
    if (report.empty()) return Error{"bad_data", "the report is empty", ""};
    if (map.report && report[0] != *map.report) return std::optional<EncoderSample>();
    EncoderSample sample;
    for (const LensAxis axis : kLensAxes) {
        const std::optional<HidField>& field = map.fields[Index(axis)];
        if (!field) continue;
        const auto first = static_cast<std::size_t>(field->byte);
        const auto size = static_cast<std::size_t>(field->bits / 8);
        if (first + size > report.size()) {
            return Error{"bad_data",
                         "the report of " + std::to_string(report.size()) + " bytes ends before " +
                             std::string(Name(axis)),
                         ""};
        }
        sample.raw[Index(axis)] = Count(report.subspan(first, size), *field);
    }
    return std::optional(sample);
}

}  // namespace flare
