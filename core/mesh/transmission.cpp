// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/transmission.h"

#include <algorithm>
#include <cmath>

namespace flare {
namespace {

constexpr double kTableError = 1e-7;
constexpr int kLargestTable = 2048;

// Cubic through four equally spaced points about x, at the ends through the last four.
double Cubic(const std::vector<double>& values, double x) {
    const int last = static_cast<int>(values.size()) - 1;
    const int i = std::clamp(static_cast<int>(x) - 1, 0, last - 3);
    const double t = x - i;
    const double* v = &values[static_cast<std::size_t>(i)];
    const double a = t, b = t - 1.0, c = t - 2.0, d = t - 3.0;
    return -v[0] * b * c * d / 6.0 + v[1] * a * c * d / 2.0 - v[2] * a * b * d / 2.0 +
           v[3] * a * b * c / 6.0;
}

}  // namespace

double TransmissionTables::Table::At(double c) const {
    return Cubic(values, c * static_cast<double>(values.size() - 1));
}

std::vector<int> AbsorbingSteps(const Lens& lens, const BounceSequence& sequence) {
    std::vector<int> absorbing;
    const InteractionList list = WriteOut(lens, sequence, kLineD);
    for (std::size_t i = 0; i < list.steps.size(); ++i) {
        const Interaction& step = list.steps[i];
        if (step.surface == lens.sensor_index()) continue;
        const Glass& medium =
            step.forward ? lens.MediumBefore(step.surface) : lens.MediumBehind(step.surface);
        if (medium.absorbs()) absorbing.push_back(static_cast<int>(i));
    }
    return absorbing;
}

TransmissionTables::TransmissionTables(const Lens& lens, std::vector<double> wavelengths_nm,
                                       ThreadPool& threads)
    : wavelengths_nm_(std::move(wavelengths_nm)) {
    for (const LensSurface& surface : lens.surfaces()) coatings_.push_back(surface.coating);
    if (lens.sensor()) sensor_reflectance_ = lens.sensor()->reflectance;
    const std::size_t bands = wavelengths_nm_.size();
    tables_.resize(coatings_.size() * bands * kQuantities);
    threads.For(static_cast<int>(coatings_.size() * bands), [&](int item) {
        BuildTables(lens, item / static_cast<int>(bands), item % static_cast<int>(bands));
    });
}

void TransmissionTables::BuildTables(const Lens& lens, int surface, int band) {
    const auto s = static_cast<std::size_t>(surface);
    if (coatings_[s].bare()) return;
    const double wavelength = wavelengths_nm_[static_cast<std::size_t>(band)];
    const double before = lens.MediumBefore(surface).Index(wavelength);
    const double behind = lens.MediumBehind(surface).Index(wavelength);
    const double rare = std::min(before, behind);
    const double dense = std::max(before, behind);
    const auto exact = [&](double c, int quantity) {
        if (quantity != kReflectanceFromDense) {
            const Reflection r = ReflectionOf(coatings_[s], false, rare, dense, c, wavelength);
            return quantity == kTransmittance ? r.transmittance : r.reflectance;
        }
        const double ratio = rare / dense;
        const double cos_dense = std::sqrt(1.0 - ratio * ratio * (1.0 - c * c));
        return ReflectionOf(coatings_[s], true, dense, rare, cos_dense, wavelength).reflectance;
    };
    for (int quantity = 0; quantity < kQuantities; ++quantity) {
        Table table;
        for (int i = 0; i <= 16; ++i) table.values.push_back(exact(i / 16.0, quantity));
        for (bool good = false; !good;) {
            const std::size_t count = table.values.size() - 1;
            if (count > kLargestTable) {
                table.values.clear();
                break;
            }
            std::vector<double> finer(2 * count + 1);
            good = true;
            for (std::size_t i = 0; i <= count; ++i) {
                finer[2 * i] = table.values[i];
                if (i == count) break;
                const double c = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
                finer[2 * i + 1] = exact(c, quantity);
                good = good && std::abs(table.At(c) - finer[2 * i + 1]) < kTableError;
            }
            table.values = std::move(finer);
        }
        tables_[(s * wavelengths_nm_.size() + static_cast<std::size_t>(band)) * kQuantities +
                static_cast<std::size_t>(quantity)] = std::move(table);
    }
}

const TransmissionTables::Table& TransmissionTables::TableOf(int surface, int band,
                                                             Quantity quantity) const {
    return tables_[(static_cast<std::size_t>(surface) * wavelengths_nm_.size() +
                    static_cast<std::size_t>(band)) *
                       kQuantities +
                   quantity];
}

double TransmissionTables::StepFactor(const Interaction& step, int band, double rare_cos2) const {
    if (static_cast<std::size_t>(step.surface) == coatings_.size()) return sensor_reflectance_;
    const bool from_rare = step.n_in <= step.n_out;
    const bool reflects = step.kind == InteractionKind::kReflect;
    const double c = std::sqrt(std::clamp(rare_cos2, 0.0, 1.0));
    if (rare_cos2 >= 0.0) {
        const Quantity quantity = !reflects   ? kTransmittance
                                  : from_rare ? kReflectanceFromRare
                                              : kReflectanceFromDense;
        const Table& table = TableOf(step.surface, band, quantity);
        if (!table.values.empty()) return table.At(c);
    } else if (!reflects) {
        return 0.0;
    }
    double cos_in = c;
    if (!from_rare) {
        const double ratio = step.n_out / step.n_in;
        cos_in = std::sqrt(std::clamp(1.0 - ratio * ratio * (1.0 - rare_cos2), 0.0, 1.0));
    }
    const Coating& coating = coatings_[static_cast<std::size_t>(step.surface)];
    const Reflection r = ReflectionOf(coating, !from_rare, step.n_in, step.n_out, cos_in,
                                      wavelengths_nm_[static_cast<std::size_t>(band)]);
    return reflects ? r.reflectance : r.transmittance;
}

TransmissionTables::Path TransmissionTables::PathOf(const Lens& lens,
                                                    const BounceSequence& sequence) const {
    Path path;
    path.tables_ = this;
    path.absorbing_ = AbsorbingSteps(lens, sequence);
    for (const double wavelength : wavelengths_nm_) {
        path.lists_.push_back(WriteOut(lens, sequence, wavelength));
    }
    return path;
}

double TransmissionTables::Path::Weight(int band, std::span<const double> passage) const {
    const InteractionList& list = lists_[static_cast<std::size_t>(band)];
    double weight = 1.0;
    for (std::size_t s = 0; s < list.steps.size(); ++s) {
        if (list.steps[s].kind == InteractionKind::kStop) continue;
        weight *= tables_->StepFactor(list.steps[s], band, passage[s]);
    }
    double absorbed = 0.0;
    for (std::size_t a = 0; a < absorbing_.size(); ++a) {
        const Interaction& step = list.steps[static_cast<std::size_t>(absorbing_[a])];
        absorbed += step.absorption_per_mm * passage[list.steps.size() + a];
    }
    return absorbed == 0.0 ? weight : weight * std::exp(-absorbed);
}

}  // namespace flare
