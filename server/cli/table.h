// SPDX-License-Identifier: Apache-2.0
//
// Tables for people: columns as wide as their widest cell; a column of numbers is set flush right.
#pragma once

#include <string>
#include <vector>

namespace flare::cli {

class Table {
  public:
    explicit Table(std::vector<std::string> heads) { rows_.push_back(std::move(heads)); }

    // As many cells as there are heads.
    void AddRow(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    std::string text() const;

  private:
    std::vector<std::vector<std::string>> rows_;
};

// A number with `digits` digits behind the point.
std::string Fixed(double value, int digits);
// A number with `digits` significant digits, in the form that suits its size.
std::string Significant(double value, int digits);

}  // namespace flare::cli
