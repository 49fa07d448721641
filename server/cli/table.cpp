// SPDX-License-Identifier: Apache-2.0
#include "server/cli/table.h"

#include <algorithm>
#include <cstdio>

namespace flare::cli {
namespace {

std::string Formatted(const char* format, int digits, double value) {
    char text[400];
    std::snprintf(text, sizeof text, format, digits, value);
    return text;
}

bool IsNumber(const std::string& cell) {
    return cell.find_first_not_of("0123456789.+-e") == std::string::npos;
}

// Characters, not bytes: makers' names are not all ASCII.
std::size_t Width(const std::string& cell) {
    return static_cast<std::size_t>(std::count_if(cell.begin(), cell.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u;
    }));
}

}  // namespace

std::string Table::text() const {
    const std::size_t columns = rows_.front().size();
    std::vector<std::size_t> widths(columns, 0);
    std::vector<bool> numeric(columns, true);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        for (std::size_t c = 0; c < columns; ++c) {
            widths[c] = std::max(widths[c], Width(rows_[r][c]));
            if (r > 0) numeric[c] = numeric[c] && IsNumber(rows_[r][c]);
        }
    }
    std::string text;
    for (const std::vector<std::string>& row : rows_) {
        std::string line;
        for (std::size_t c = 0; c < columns; ++c) {
            const std::string padding(widths[c] - Width(row[c]), ' ');
            line += (c == 0 ? "" : "  ") + (numeric[c] ? padding + row[c] : row[c] + padding);
        }
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
    }
    return text;
}

std::string Fixed(double value, int digits) {
    std::string text = Formatted("%.*f", digits, value);
    // What rounds to zero has no sign.
    if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
    return text;
}

std::string Significant(double value, int digits) {
    return Formatted("%.*g", digits, value);
}

}  // namespace flare::cli
