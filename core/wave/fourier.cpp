// SPDX-License-Identifier: Apache-2.0
//
// Rows, then columns. Columns are gathered a few at a time, so that a cache line that was fetched
// is used as a whole.
#include "core/wave/fourier.h"

#include <kissfft/kissfft.hh>

#include "core/base/check.h"

namespace flare {
namespace {

constexpr int kColumnsAtOnce = 8;

void TransformRows(const kissfft<double>& plan, std::vector<Complex>& values, int side,
                   ThreadPool& threads) {
    const auto n = static_cast<std::size_t>(side);
    threads.For(side, [&](int j) {
        std::vector<Complex> row(n);
        Complex* const begin = values.data() + static_cast<std::size_t>(j) * n;
        plan.transform(begin, row.data());
        std::copy(row.begin(), row.end(), begin);
    });
}

void TransformColumns(const kissfft<double>& plan, std::vector<Complex>& values, int side,
                      ThreadPool& threads) {
    const auto n = static_cast<std::size_t>(side);
    const int at_once = std::min(kColumnsAtOnce, side);
    threads.For(side / at_once, [&](int block) {
        const auto width = static_cast<std::size_t>(at_once);
        const std::size_t first = static_cast<std::size_t>(block) * width;
        std::vector<Complex> columns(n * width), out(n);
        for (std::size_t j = 0; j < n; ++j) {
            for (std::size_t i = 0; i < width; ++i) columns[i * n + j] = values[j * n + first + i];
        }
        for (std::size_t i = 0; i < width; ++i) {
            plan.transform(columns.data() + i * n, out.data());
            std::copy(out.begin(), out.end(), columns.begin() + static_cast<std::ptrdiff_t>(i * n));
        }
        for (std::size_t j = 0; j < n; ++j) {
            for (std::size_t i = 0; i < width; ++i) values[j * n + first + i] = columns[i * n + j];
        }
    });
}

}  // namespace

struct SquareFourier::Plans {
    explicit Plans(std::size_t side) : forward(side, false), inverse(side, true) {}
    kissfft<double> forward, inverse;
};

SquareFourier::SquareFourier(int side) : side_(side) {
    FLARE_CHECK(side >= 2 && (side & (side - 1)) == 0);
    plans_ = std::make_unique<const Plans>(static_cast<std::size_t>(side));
}

SquareFourier::~SquareFourier() = default;

void SquareFourier::Forward(std::vector<Complex>& values, ThreadPool& threads) const {
    FLARE_CHECK(values.size() == static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    TransformRows(plans_->forward, values, side_, threads);
    TransformColumns(plans_->forward, values, side_, threads);
}

void SquareFourier::Inverse(std::vector<Complex>& values, ThreadPool& threads) const {
    FLARE_CHECK(values.size() == static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    TransformRows(plans_->inverse, values, side_, threads);
    TransformColumns(plans_->inverse, values, side_, threads);
    const double scale = 1.0 / (static_cast<double>(side_) * side_);
    threads.For(side_, [&](int j) {
        const auto n = static_cast<std::size_t>(side_);
        for (std::size_t i = 0; i < n; ++i) values[static_cast<std::size_t>(j) * n + i] *= scale;
    });
}

}  // namespace flare
