// SPDX-License-Identifier: Apache-2.0
//
// The built-in table is read once, at its first use, into records that live as long as the program.
// It is ours, so a line that cannot be read is a broken invariant.
#include "core/optics/coating_material.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/base/check.h"
#include "core/optics/coating_tables.h"
#include "core/optics/table_text.h"

namespace flare {

struct MaterialDispersion {
    enum class Kind { kSellmeier, kSellmeierSquared, kPowers, kTable };
    struct Point {
        double wavelength_nm;
        std::complex<double> index;
    };

    std::string material, page;
    Kind kind = Kind::kTable;
    double low_nm = 0.0, high_nm = 0.0;
    std::vector<double> coefficients;
    std::vector<Point> points;

    std::string name() const { return material + "-" + page; }
};

namespace {

// A formula serves at least this range, whatever the range of the measurements it was fitted to.
constexpr double kVisibleLow_nm = 360.0, kVisibleHigh_nm = 800.0;

MaterialDispersion::Kind KindFrom(std::string_view word) {
    if (word == "formula 1") return MaterialDispersion::Kind::kSellmeier;
    if (word == "formula 2") return MaterialDispersion::Kind::kSellmeierSquared;
    if (word == "formula 5") return MaterialDispersion::Kind::kPowers;
    FLARE_CHECK(word == "table");
    return MaterialDispersion::Kind::kTable;
}

MaterialDispersion ReadMaterial(std::string_view line) {
    const std::vector<std::string_view> columns = SplitText(line, '\t');
    FLARE_CHECK(columns.size() == 5);
    MaterialDispersion out;
    out.material = columns[0];
    out.page = columns[1];
    out.kind = KindFrom(columns[2]);
    const std::vector<double> range = NumbersIn(columns[3], ' ');
    FLARE_CHECK(range.size() == 2);
    out.low_nm = 1000.0 * range[0];
    out.high_nm = 1000.0 * range[1];
    if (out.kind != MaterialDispersion::Kind::kTable) {
        out.low_nm = std::min(out.low_nm, kVisibleLow_nm);
        out.high_nm = std::max(out.high_nm, kVisibleHigh_nm);
        out.coefficients = NumbersIn(columns[4], ' ');
        FLARE_CHECK(out.coefficients.size() % 2 == 1);
        return out;
    }
    for (const std::string_view point : SplitText(columns[4], ' ')) {
        const std::vector<double> numbers = NumbersIn(point, ':');
        FLARE_CHECK(numbers.size() == 3);
        out.points.push_back({numbers[0], {numbers[1], numbers[2]}});
    }
    FLARE_CHECK(out.points.size() >= 2);
    return out;
}

const std::vector<MaterialDispersion>& Materials() {
    static const std::vector<MaterialDispersion> materials = [] {
        std::vector<MaterialDispersion> out;
        for (const std::string_view line : TableLines(CoatingMaterialsText())) {
            out.push_back(ReadMaterial(line));
        }
        return out;
    }();
    return materials;
}

// Formulas 1, 2 and 5 of the refractiveindex.info database, wavelength in um:
//   1: n^2 - 1 = C1 + sum C_i L^2 / (L^2 - C_{i+1}^2)    2: the same with C_{i+1} unsquared
//   5: n = C1 + sum C_i L^C_{i+1}
double FormulaIndex(const MaterialDispersion& material, double um) {
    const std::vector<double>& c = material.coefficients;
    double sum = c[0];
    for (std::size_t i = 1; i < c.size(); i += 2) {
        if (material.kind == MaterialDispersion::Kind::kPowers) {
            sum += c[i] * std::pow(um, c[i + 1]);
        } else {
            const bool squared = material.kind == MaterialDispersion::Kind::kSellmeierSquared;
            sum += c[i] * um * um / (um * um - (squared ? c[i + 1] : c[i + 1] * c[i + 1]));
        }
    }
    return material.kind == MaterialDispersion::Kind::kPowers ? sum : std::sqrt(1.0 + sum);
}

std::complex<double> TableIndex(const std::vector<MaterialDispersion::Point>& points,
                                double wavelength_nm) {
    const auto above =
        std::upper_bound(points.begin() + 1, points.end() - 1, wavelength_nm,
                         [](double w, const auto& point) { return w < point.wavelength_nm; });
    const auto below = above - 1;
    const double t =
        (wavelength_nm - below->wavelength_nm) / (above->wavelength_nm - below->wavelength_nm);
    return below->index + std::clamp(t, 0.0, 1.0) * (above->index - below->index);
}

}  // namespace

std::complex<double> CoatingMaterial::DispersedIndex(double wavelength_nm) const {
    const double nm = std::clamp(wavelength_nm, dispersion_->low_nm, dispersion_->high_nm);
    if (dispersion_->kind == MaterialDispersion::Kind::kTable) {
        return TableIndex(dispersion_->points, nm);
    }
    return FormulaIndex(*dispersion_, nm / 1000.0);
}

std::string CoatingMaterial::name() const {
    if (dispersion_ != nullptr) return dispersion_->name();
    char text[80];
    if (constant_.imag() == 0.0) {
        std::snprintf(text, sizeof text, "n %.6g", constant_.real());
    } else {
        std::snprintf(text, sizeof text, "n %.6g + %.6gi", constant_.real(), constant_.imag());
    }
    return text;
}

void CoatingMaterial::AddTo(Fingerprinter& fingerprinter) const {
    if (dispersion_ != nullptr) {
        fingerprinter.Add("material").Add(dispersion_->name());
    } else {
        fingerprinter.Add("index").Add(constant_.real()).Add(constant_.imag());
    }
}

Result<CoatingMaterial> MaterialByName(std::string_view name) {
    for (const MaterialDispersion& material : Materials()) {
        if (name == material.material || name == material.name()) return CoatingMaterial(&material);
    }
    return Error{"bad_lens",
                 "unknown coating material \"" + std::string(name) + "\"; known are " +
                     KnownMaterials() + ", as \"MgF2\" or \"TiO2-Sarkar\"",
                 ""};
}

std::string KnownMaterials() {
    std::string out, last;
    for (const MaterialDispersion& material : Materials()) {
        if (material.material == last) {
            out.back() = ',';
            out += " " + material.page + ")";
        } else {
            out += (out.empty() ? "" : ", ") + material.material + " (" + material.page + ")";
        }
        last = material.material;
    }
    return out;
}

}  // namespace flare
