// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/curve_codec.h"

#include <string>

#include "protocol/limits.h"

namespace flare::wire {
namespace {

constexpr double kVisibleLow_nm = 380.0, kVisibleHigh_nm = 780.0;

bool ReadWavelengths(Reader& reader, const JsonView& at, std::vector<double>& wavelengths_nm) {
    if (!reader.Array(at, limits::kCurvePoints)) return false;
    if (at.child_count() == 0) return reader.Refuse(at, "bad_value", "no wavelength is given");
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        double wavelength_nm = 0.0;
        if (!reader.Number(*child, AboveZeroUpTo(limits::kMaxCurve_nm), wavelength_nm)) {
            return false;
        }
        if (!wavelengths_nm.empty() && wavelength_nm <= wavelengths_nm.back()) {
            return reader.Refuse(*child, "bad_value", "the wavelengths do not ascend");
        }
        wavelengths_nm.push_back(wavelength_nm);
    }
    return true;
}

bool ReadValues(Reader& reader, const JsonView& at, const std::vector<double>& wavelengths_nm,
                std::vector<double>& values) {
    if (!reader.Array(at, limits::kCurvePoints)) return false;
    if (at.child_count() != wavelengths_nm.size()) {
        return reader.Refuse(at, "bad_value",
                             "there are " + std::to_string(at.child_count()) + " values for " +
                                 std::to_string(wavelengths_nm.size()) + " wavelengths");
    }
    bool seen = false;
    for (auto child = at.FirstChild(); child; child = child->NextSibling()) {
        double value = 0.0;
        if (!reader.Number(*child, FromUpTo(0.0, limits::kMaxCurveValue), value)) return false;
        const double wavelength_nm = wavelengths_nm[values.size()];
        seen = seen ||
               (value > 0.0 && wavelength_nm > kVisibleLow_nm && wavelength_nm < kVisibleHigh_nm);
        values.push_back(value);
    }
    return seen || reader.Refuse(at, "bad_value", "no value between 380 and 780 nm is above 0");
}

}  // namespace

bool ReadSpectrum(Reader& reader, const JsonView& at, SampledSpectrum& spectrum) {
    std::optional<JsonView> wavelengths, values;
    return reader.Object(at, {"wavelengths_nm", "values"}) &&
           reader.Require(at, "wavelengths_nm", wavelengths) &&
           ReadWavelengths(reader, *wavelengths, spectrum.wavelengths_nm) &&
           reader.Require(at, "values", values) &&
           ReadValues(reader, *values, spectrum.wavelengths_nm, spectrum.values);
}

bool ReadCamera(Reader& reader, const JsonView& at, Camera& camera) {
    std::optional<JsonView> wavelengths, red, green, blue;
    return reader.Object(at, {"wavelengths_nm", "red", "green", "blue"}) &&
           reader.Require(at, "wavelengths_nm", wavelengths) &&
           ReadWavelengths(reader, *wavelengths, camera.wavelengths_nm) &&
           reader.Require(at, "red", red) &&
           ReadValues(reader, *red, camera.wavelengths_nm, camera.red) &&
           reader.Require(at, "green", green) &&
           ReadValues(reader, *green, camera.wavelengths_nm, camera.green) &&
           reader.Require(at, "blue", blue) &&
           ReadValues(reader, *blue, camera.wavelengths_nm, camera.blue);
}

}  // namespace flare::wire
