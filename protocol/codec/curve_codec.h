// SPDX-License-Identifier: Apache-2.0
//
// Curves over wavelength: a light's "spectrum" and the sensitivities of a "camera".
#pragma once

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

// {"wavelengths_nm": [...], "values": [...]}: strictly ascending, none negative, light somewhere in
// the visible (380 to 780 nm).
bool ReadSpectrum(Reader& reader, const JsonView& at, SampledSpectrum& spectrum);

// {"wavelengths_nm": [...], "red": [...], "green": [...], "blue": [...]}, each as above.
bool ReadCamera(Reader& reader, const JsonView& at, Camera& camera);

}  // namespace flare::wire
