// SPDX-License-Identifier: Apache-2.0
//
// What a coating's layer is made of: a complex index n + i k (k >= 0 absorbs) against wavelength in
// nm. Either a constant or one of the tabled thin-film materials of lenses/coatings/materials.tsv,
// which is built in. A small value, cheap to copy, safe from any thread.
#pragma once

#include <complex>
#include <string>
#include <string_view>

#include "core/base/fingerprint.h"
#include "core/base/result.h"

namespace flare {

struct MaterialDispersion;

class CoatingMaterial {
  public:
    // The same index at every wavelength. Not explicit: {1.38, 99.64} is a layer.
    CoatingMaterial(double n) : constant_(n) {}                        // NOLINT
    CoatingMaterial(std::complex<double> index) : constant_(index) {}  // NOLINT

    // A tabled material has no data outside 360-800 nm (a formula perhaps more): beyond them it
    // keeps the index at their end.
    std::complex<double> Index(double wavelength_nm) const {
        return dispersion_ == nullptr ? constant_ : DispersedIndex(wavelength_nm);
    }
    bool is_constant() const { return dispersion_ == nullptr; }
    // "MgF2-Li-o"; "n 1.38" or "n 1.38 + 0.01i" of a constant.
    std::string name() const;

    void AddTo(Fingerprinter& fingerprinter) const;

    friend bool operator==(const CoatingMaterial&, const CoatingMaterial&) = default;

  private:
    friend Result<CoatingMaterial> MaterialByName(std::string_view name);
    explicit CoatingMaterial(const MaterialDispersion* dispersion) : dispersion_(dispersion) {}
    std::complex<double> DispersedIndex(double wavelength_nm) const;

    std::complex<double> constant_ = 1.0;
    const MaterialDispersion* dispersion_ = nullptr;  // of the built-in table, which never moves
};

// "MgF2", or one publication's figures, "TiO2-Sarkar"; the plain name means the first one in the
// table. Fails with a message that lists the names.
Result<CoatingMaterial> MaterialByName(std::string_view name);

// "MgF2 (Li-o), SiO2 (Malitson), TiO2 (Siefke, Sarkar), ..." for messages.
std::string KnownMaterials();

}  // namespace flare
