// SPDX-License-Identifier: Apache-2.0
#include "core/optics/glass.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/check.h"
#include "core/base/fingerprint.h"
#include "core/base/units.h"

namespace flare {

namespace {

// x^power for a whole power. Products only, so that every C library gives the same bits.
double WholePower(double x, double power) {
    double product = 1.0;
    for (int i = static_cast<int>(std::abs(power)); i > 0; --i) product *= x;
    return power < 0.0 ? 1.0 / product : product;
}

}  // namespace

Glass Glass::FromNdVd(double nd, std::optional<double> vd) {
    FLARE_CHECK(nd >= 1.0);
    if (!vd.has_value() || nd == 1.0) return {nd, 0.0};
    FLARE_CHECK(*vd > 0.0);
    const double inverse_square_f_minus_c = 1.0 / (kLineF * kLineF) - 1.0 / (kLineC * kLineC);
    const double b = (nd - 1.0) / (*vd * inverse_square_f_minus_c);
    return {nd - b / (kLineD * kLineD), b};
}

Glass::Glass(GlassData data) : data_(std::make_shared<const GlassData>(std::move(data))) {
    FLARE_CHECK(data_->low_nm > 0.0 && data_->low_nm < data_->high_nm);
}

double Glass::IndexOfData(double wavelength_nm) const {
    const double l = wavelength_nm / 1000.0;
    double sum = data_->constant;
    if (data_->formula == GlassData::Formula::kSellmeier) {
        for (const auto& [strength, place] : data_->terms) {
            sum += strength * l * l / (l * l - place);
        }
        return std::sqrt(sum);
    }
    for (const auto& [strength, place] : data_->terms) sum += strength * WholePower(l, place);
    return data_->formula == GlassData::Formula::kPowers ? sum : std::sqrt(sum);
}

double Glass::AbsorptionPerMm(double wavelength_nm) const {
    if (!absorbs()) return 0.0;
    constexpr double kNmPerMm = 1e6;
    const double per_k = 4.0 * kPi / wavelength_nm * kNmPerMm;
    const auto& points = data_->absorption;
    const auto next = std::find_if(points.begin(), points.end(), [&](const auto& point) {
        return point.wavelength_nm > wavelength_nm;
    });
    if (next == points.begin()) return per_k * points.front().k;
    if (next == points.end()) return per_k * points.back().k;
    const auto& [low_nm, low_k] = *(next - 1);
    const auto& [high_nm, high_k] = *next;
    const double share = (1.0 / wavelength_nm - 1.0 / low_nm) / (1.0 / high_nm - 1.0 / low_nm);
    if (low_k == 0.0 || high_k == 0.0) return per_k * (low_k + share * (high_k - low_k));
    return per_k * low_k * std::pow(high_k / low_k, share);
}

void Glass::AddDispersionTo(Fingerprinter& fingerprinter) const {
    if (data_ == nullptr) {
        fingerprinter.Add("cauchy").Add(a_).Add(b_nm2_);
        return;
    }
    fingerprinter.Add("formula").Add(static_cast<int>(data_->formula)).Add(data_->constant);
    fingerprinter.Add(data_->low_nm).Add(data_->high_nm);
    fingerprinter.Add(static_cast<std::int64_t>(data_->terms.size()));
    for (const auto& [strength, place] : data_->terms) fingerprinter.Add(strength).Add(place);
}

void Glass::AddAbsorptionTo(Fingerprinter& fingerprinter) const {
    const std::size_t count = absorbs() ? data_->absorption.size() : 0;
    fingerprinter.Add(static_cast<std::int64_t>(count));
    for (std::size_t i = 0; i < count; ++i) {
        fingerprinter.Add(data_->absorption[i].wavelength_nm).Add(data_->absorption[i].k);
    }
}

bool operator==(const Glass& one, const Glass& other) {
    if (one.data_ == nullptr || other.data_ == nullptr) {
        return one.data_ == other.data_ && one.a_ == other.a_ && one.b_nm2_ == other.b_nm2_;
    }
    return one.data_ == other.data_ || *one.data_ == *other.data_;
}

}  // namespace flare
