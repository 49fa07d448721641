// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/transmission.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace flare {
namespace {

// Of the table before its last halving, which leaves a sixteenth of it.
constexpr double kTableError = 1e-6;
constexpr std::size_t kLargestTable = 8192;
// Of all tables together: a hundred surfaces of a hundred layers may not ask for gigabytes.
constexpr std::size_t kMostBytes = std::size_t{256} << 20;

// Which four equally spaced points a cubic about x goes through (at the ends the last four), and
// their weights.
struct CubicWeights {
    std::size_t first;
    std::array<double, 4> weights;
};

CubicWeights CubicAt(std::size_t count, double x) {
    const int last = static_cast<int>(count) - 1;
    const int i = std::clamp(static_cast<int>(x) - 1, 0, last - 3);
    const double a = x - i, b = a - 1.0, c = a - 2.0, d = a - 3.0;
    return {static_cast<std::size_t>(i),
            {-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0}};
}

// T and R from both sides, as in Quantity.
using Sample = std::array<double, 3>;

// The same cubic over interval i as a polynomial in 0 ... 1.
std::array<double, 4> CubicOver(const std::vector<Sample>& samples, std::size_t i,
                                std::size_t quantity) {
    const std::size_t first = CubicAt(samples.size(), static_cast<double>(i) + 0.5).first;
    std::array<double, 4> y{};
    for (std::size_t k = 0; k < 4; ++k) y[k] = samples[first + k][quantity];
    // Newton's differences, then the polynomial in x = 0 ... 3, then shifted to the interval.
    const double d1 = y[1] - y[0];
    const double d2 = y[2] - 2.0 * y[1] + y[0];
    const double d3 = y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0];
    const double a1 = d1 - d2 / 2.0 + d3 / 3.0;
    const double a2 = d2 / 2.0 - d3 / 2.0;
    const double a3 = d3 / 6.0;
    const double k = static_cast<double>(i - first);
    return {y[0] + k * (a1 + k * (a2 + k * a3)), a1 + k * (2.0 * a2 + 3.0 * a3 * k),
            a2 + 3.0 * a3 * k, a3};
}

bool CubicHolds(const std::vector<Sample>& samples, double x, const Sample& exact) {
    const CubicWeights cubic = CubicAt(samples.size(), x);
    for (std::size_t quantity = 0; quantity < exact.size(); ++quantity) {
        double sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            sum += cubic.weights[k] * samples[cubic.first + k][quantity];
        }
        if (!(std::abs(sum - exact[quantity]) < kTableError)) return false;
    }
    return true;
}

// `exact` over c = 0 ... 1, halved until a cubic holds at every midpoint; none if that takes more
// than `most` intervals.
template <class Function>
std::vector<Sample> Refined(const Function& exact, std::size_t most) {
    std::vector<Sample> samples;
    for (int i = 0; i <= 16; ++i) samples.push_back(exact(i / 16.0));
    for (bool good = false; !good;) {
        const std::size_t count = samples.size() - 1;
        if (2 * count > most) return {};
        std::vector<Sample> finer(2 * count + 1);
        good = true;
        for (std::size_t i = 0; i < count; ++i) {
            const double x = static_cast<double>(i) + 0.5;
            finer[2 * i] = samples[i];
            finer[2 * i + 1] = exact(x / static_cast<double>(count));
            good = good && CubicHolds(samples, x, finer[2 * i + 1]);
        }
        finer.back() = samples.back();
        samples = std::move(finer);
    }
    return samples;
}

}  // namespace

double TransmissionTables::Table::At(double c) const {
    const double x = c * static_cast<double>(cubics.size());
    const std::size_t i = std::min(static_cast<std::size_t>(x), cubics.size() - 1);
    const double t = x - static_cast<double>(i);
    const std::array<double, 4>& k = cubics[i];
    return k[0] + t * (k[1] + t * (k[2] + t * k[3]));
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
    for (const LensSurface& surface : lens.surfaces()) {
        faces_.push_back({surface.coating, surface.dense_in_front});
    }
    if (lens.sensor()) sensor_reflectance_ = lens.sensor()->reflectance;
    const std::size_t bands = wavelengths_nm_.size();
    const auto coated = static_cast<std::size_t>(std::count_if(
        faces_.begin(), faces_.end(), [](const Face& face) { return !face.coating.bare(); }));
    const std::size_t interval_bytes = kQuantities * sizeof(std::array<double, 4>);
    const std::size_t tables = std::max<std::size_t>(1, coated * bands);
    most_intervals_ = std::min(kLargestTable, kMostBytes / (tables * interval_bytes));
    tables_.resize(faces_.size() * bands * kQuantities);
    threads.For(static_cast<int>(faces_.size() * bands), [&](int item) {
        BuildTables(lens, item / static_cast<int>(bands), item % static_cast<int>(bands));
    });
}

void TransmissionTables::BuildTables(const Lens& lens, int surface, int band) {
    const auto s = static_cast<std::size_t>(surface);
    const Coating& coating = faces_[s].coating;
    if (coating.bare()) return;
    const double wavelength = wavelengths_nm_[static_cast<std::size_t>(band)];
    const double before = lens.MediumBefore(surface).Index(wavelength);
    const double behind = lens.MediumBehind(surface).Index(wavelength);
    const double rare = std::min(before, behind);
    const double dense = std::max(before, behind);
    // Two glasses may change places away from the d line; the layers stay as they were laid.
    const bool from_rare_reversed = (before <= behind) == faces_[s].dense_in_front;
    const CoatingAtWavelength at_wavelength(coating, wavelength);
    const auto exact = [&](double c) {
        const Reflection r = at_wavelength.Of(from_rare_reversed, rare, dense, c);
        Sample sample{r.transmittance, r.reflectance, r.reflectance};
        if (at_wavelength.absorbs()) {
            const double ratio = rare / dense;
            const double cos_dense = std::sqrt(1.0 - ratio * ratio * (1.0 - c * c));
            sample[kReflectanceFromDense] =
                at_wavelength.Of(!from_rare_reversed, dense, rare, cos_dense).reflectance;
        }
        return sample;
    };
    const std::vector<Sample> samples = Refined(exact, most_intervals_);
    for (std::size_t quantity = 0; quantity < kQuantities; ++quantity) {
        Table& table =
            tables_[(s * wavelengths_nm_.size() + static_cast<std::size_t>(band)) * kQuantities +
                    quantity];
        table.cubics.reserve(samples.empty() ? 0 : samples.size() - 1);
        for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
            table.cubics.push_back(CubicOver(samples, i, quantity));
        }
    }
}

const TransmissionTables::Table& TransmissionTables::TableOf(int surface, int band,
                                                             Quantity quantity) const {
    return tables_[(static_cast<std::size_t>(surface) * wavelengths_nm_.size() +
                    static_cast<std::size_t>(band)) *
                       kQuantities +
                   quantity];
}

namespace {

bool FromRare(const Interaction& step) {
    return step.n_in < step.n_out || (step.n_in == step.n_out && step.forward);
}

// From the squared cosine in the rarer medium, above 0.
double BareReflectanceAt(double n_in, double n_out, double rare_cos2) {
    const double rare = std::min(n_in, n_out);
    const double dense = std::max(n_in, n_out);
    const double q_rare = rare * std::sqrt(std::min(rare_cos2, 1.0));
    const double q_dense = std::sqrt((dense - rare) * (dense + rare) + q_rare * q_rare);
    return BareReflectance(rare, dense, q_rare, q_dense);
}

}  // namespace

double TransmissionTables::StepFactor(const Interaction& step, int band, double rare_cos2) const {
    if (static_cast<std::size_t>(step.surface) == faces_.size()) return sensor_reflectance_;
    if (rare_cos2 > 0.0 && faces_[static_cast<std::size_t>(step.surface)].coating.bare()) {
        if (step.n_in == step.n_out) return step.kind == InteractionKind::kReflect ? 0.0 : 1.0;
        const double reflectance = BareReflectanceAt(step.n_in, step.n_out, rare_cos2);
        return step.kind == InteractionKind::kReflect ? reflectance : 1.0 - reflectance;
    }
    const bool from_rare = FromRare(step);
    const bool reflects = step.kind == InteractionKind::kReflect;
    if (rare_cos2 < 0.0 && !reflects) return 0.0;
    const double c = std::sqrt(std::clamp(rare_cos2, 0.0, 1.0));
    double cos_in = c;
    if (!from_rare) {
        const double ratio = step.n_out / step.n_in;
        cos_in = std::sqrt(std::clamp(1.0 - ratio * ratio * (1.0 - rare_cos2), 0.0, 1.0));
    }
    const Face& face = faces_[static_cast<std::size_t>(step.surface)];
    const bool reversed = step.forward == face.dense_in_front;
    const Reflection r = ReflectionOf(face.coating, reversed, step.n_in, step.n_out, cos_in,
                                      wavelengths_nm_[static_cast<std::size_t>(band)]);
    return reflects ? r.reflectance : r.transmittance;
}

const TransmissionTables::Table* TransmissionTables::TableFor(const Interaction& step,
                                                              int band) const {
    if (step.kind == InteractionKind::kStop) return nullptr;
    if (static_cast<std::size_t>(step.surface) == faces_.size()) return nullptr;
    const Quantity quantity = step.kind != InteractionKind::kReflect ? kTransmittance
                              : FromRare(step)                       ? kReflectanceFromRare
                                                                     : kReflectanceFromDense;
    const Table& table = TableOf(step.surface, band, quantity);
    return table.cubics.empty() ? nullptr : &table;
}

TransmissionTables::Path TransmissionTables::PathOf(const Lens& lens,
                                                    const BounceSequence& sequence) const {
    Path path;
    path.tables_ = this;
    path.absorbing_ = AbsorbingSteps(lens, sequence);
    for (const double wavelength : wavelengths_nm_) {
        path.lists_.push_back(WriteOut(lens, sequence, wavelength));
        const int band = static_cast<int>(path.lists_.size()) - 1;
        for (const Interaction& step : path.lists_.back().steps) {
            path.looked_up_.push_back(TableFor(step, band));
        }
    }
    return path;
}

double TransmissionTables::Path::Factor(int band, std::size_t step, double rare_cos2) const {
    const InteractionList& list = lists_[static_cast<std::size_t>(band)];
    const Table* const table =
        looked_up_[static_cast<std::size_t>(band) * list.steps.size() + step];
    if (table != nullptr && rare_cos2 >= 0.0) {
        return table->At(std::sqrt(std::min(rare_cos2, 1.0)));
    }
    return Acts(step) ? tables_->StepFactor(list.steps[step], band, rare_cos2) : 1.0;
}

std::vector<double> TransmissionTables::Path::AbsorptionsPerMm(int band) const {
    std::vector<double> absorptions;
    for (const int step : absorbing_) {
        absorptions.push_back(lists_[static_cast<std::size_t>(band)]
                                  .steps[static_cast<std::size_t>(step)]
                                  .absorption_per_mm);
    }
    return absorptions;
}

double TransmissionTables::Path::Weight(int band, std::span<const double> passage) const {
    const InteractionList& list = lists_[static_cast<std::size_t>(band)];
    double weight = 1.0;
    for (std::size_t s = 0; s < list.steps.size(); ++s) weight *= Factor(band, s, passage[s]);
    double absorbed = 0.0;
    for (std::size_t a = 0; a < absorbing_.size(); ++a) {
        const Interaction& step = list.steps[static_cast<std::size_t>(absorbing_[a])];
        absorbed += step.absorption_per_mm * passage[list.steps.size() + a];
    }
    return absorbed == 0.0 ? weight : weight * std::exp(-absorbed);
}

std::size_t TransmissionTables::bytes() const {
    std::size_t sum = sizeof(TransmissionTables) + wavelengths_nm_.capacity() * sizeof(double) +
                      faces_.capacity() * sizeof(Face) + tables_.capacity() * sizeof(Table);
    for (const Table& table : tables_) sum += table.cubics.capacity() * sizeof(table.cubics[0]);
    return sum;
}

}  // namespace flare
