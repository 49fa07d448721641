// SPDX-License-Identifier: Apache-2.0
//
// Lenses for tests: those of the library by name, and any prescription built or the test stopped.
#pragma once

#include <array>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "core/base/check.h"
#include "core/optics/lens.h"
#include "core/prescription/prescription_reader.h"

namespace flare::testing {

inline constexpr const char* kSeedName = "tronnier-double-gauss-50mm-f2";
inline constexpr const char* kHeliarName = "tronnier-color-heliar-100mm-f3_5";
inline constexpr const char* kRetrofocusName = "angenieux-retrofocus-35mm-f2_5";
inline constexpr const char* kTelephotoName = "kreitzer-telephoto-400mm-f5_6";
inline constexpr const char* kPrimeName = "zeiss-master-prime-50mm-t1_3";
inline constexpr const char* kFisheyeName = "shimizu-fisheye-6mm-f2_8-220deg";

inline constexpr std::array<const char*, 6> kLibraryNames{
    kSeedName, kHeliarName, kRetrofocusName, kTelephotoName, kPrimeName, kFisheyeName};

inline std::shared_ptr<const Lens> BuildLens(const Prescription& prescription) {
    const Result<std::shared_ptr<const Lens>> lens = Lens::Build(prescription);
    FLARE_CHECK(lens.ok());
    return *lens;
}

inline Prescription LibraryPrescription(const std::string& name) {
    std::ifstream file(std::string(FLARE_SOURCE_DIR "/lenses/") + name + ".toml");
    std::stringstream text;
    text << file.rdbuf();
    const Result<Prescription> prescription = ReadPrescriptionToml(text.str());
    FLARE_CHECK(prescription.ok());
    return *prescription;
}

inline std::shared_ptr<const Lens> LibraryLens(const std::string& name) {
    return BuildLens(LibraryPrescription(name));
}

}  // namespace flare::testing
