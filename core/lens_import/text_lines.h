// SPDX-License-Identifier: Apache-2.0
//
// Lines, words and numbers of a text, with the places of errors. Private to this layer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace flare {

struct TextLine {
    int number = 0;  // from 1
    std::string_view text;
};

// Without line ends (LF, CR LF or CR) and blanks at both ends; empty lines are left out.
std::vector<TextLine> LinesOf(std::string_view text);

std::string LinePlace(int number);

// Separated by blanks, tabs and any of `also`.
std::vector<std::string_view> WordsOf(std::string_view text, std::string_view also = "");

std::string UpperCase(std::string_view text);
std::string LowerCase(std::string_view text);

// A finite number with nothing behind it: 12, -.5, +1.0E-3, 2D-3 as Fortran writes it.
std::optional<double> NumberIn(std::string_view word);

// What NumberIn reads, or an error at `line` that names `what`.
Result<double> RequireNumber(std::string_view word, const std::string& what, int line);

// The first f-number in a text: "f/1.4", "F/2", "f / 3.5".
std::optional<double> FNumberIn(std::string_view text);

// A short piece of an outside text, fit for a message: control characters become '?'.
std::string Quoted(std::string_view text);

}  // namespace flare
