// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/axis_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/optics/lens_state.h"

namespace flare {
namespace {

Error Bad(std::string message, std::string where) {
    return {"bad_value", std::move(message), std::move(where)};
}

bool IsValue(LensAxis axis, double value) {
    return value > 0.0 && (std::isfinite(value) || axis == LensAxis::kFocus);
}

}  // namespace

double EvenFromValue(LensAxis axis, double value) {
    return axis == LensAxis::kFocus ? 1.0 / value : std::log2(value);
}

double ValueFromEven(LensAxis axis, double even) {
    if (axis != LensAxis::kFocus) return std::exp2(even);
    return even > 0.0 ? 1.0 / even : std::numeric_limits<double>::infinity();
}

Result<AxisTable> AxisTable::Build(LensAxis axis, const AxisMarks& marks) {
    const std::size_t count = marks.raw.size();
    if (count < 2) return Bad("needs two marks at least", "raw");
    if (marks.value.size() != count) {
        return Bad("needs one value for each raw, " + std::to_string(count), "value");
    }
    if (!(marks.wrap >= 0.0) || !std::isfinite(marks.wrap)) {
        return Bad("is a number of counts, or 0 for none", "wrap");
    }
    AxisTable table;
    table.axis_ = axis;
    table.zero_ = marks.zero;
    table.wrap_ = marks.wrap;

    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return marks.raw[a] < marks.raw[b]; });
    for (const std::size_t i : order) {
        if (!std::isfinite(marks.raw[i])) return Bad("has a count that is no number", "raw");
        if (!table.raw_.empty() && marks.raw[i] == table.raw_.back()) {
            return Bad("has the same count twice", "raw");
        }
        if (!IsValue(axis, marks.value[i])) return Bad("has a value that is not above 0", "value");
        table.raw_.push_back(marks.raw[i]);
        table.value_.push_back(marks.value[i]);
        table.even_.push_back(EvenFromValue(axis, marks.value[i]));
    }
    const bool rising = table.even_.back() > table.even_.front();
    for (std::size_t i = 1; i < count; ++i) {
        const double step = table.even_[i] - table.even_[i - 1];
        if (rising ? step <= 0.0 : step >= 0.0) {
            return Bad("does not rise or fall steadily with the counts", "value");
        }
    }
    if (table.wrap_ > 0.0 && table.raw_.back() - table.raw_.front() > table.wrap_) {
        return Bad("is less than the marks span", "wrap");
    }
    table.sign_ = marks.reverse ? -1.0 : 1.0;
    table.middle_ = 0.5 * (table.raw_.front() + table.raw_.back());
    return table;
}

double AxisTable::Value(double count) const {
    double r = sign_ * (count - zero_);
    if (wrap_ > 0.0) r -= wrap_ * std::round((r - middle_) / wrap_);
    const auto mark = std::lower_bound(raw_.begin(), raw_.end(), r);
    if (mark != raw_.end() && *mark == r) {
        return value_[static_cast<std::size_t>(mark - raw_.begin())];
    }
    if (r < raw_.front()) return value_.front();
    if (r > raw_.back()) return value_.back();
    return ValueFromEven(axis_, MonotoneAt(raw_, even_, r));
}

}  // namespace flare
