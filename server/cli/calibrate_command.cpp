// SPDX-License-Identifier: Apache-2.0
//
// flare encoder calibrate: a person stands at the lens, turns a ring from mark to mark and types
// what each says; the counts come from the encoder, and a table for the configuration goes out.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <thread>

#include "server/cli/app.h"
#include "server/cli/encoder_view.h"
#include "server/cli/files.h"
#include "server/cli/options.h"
#include "server/encoder/axis_table.h"

namespace flare::cli {
namespace {

// A ring that stands still: so many looks at its count, so far apart.
constexpr int kLooks = 11;
constexpr std::chrono::milliseconds kBetweenLooks{20};

struct CalibrateOptions {
    std::string server, config, name, output = "-";
    std::string axis = "focus";
    double wrap = 0.0;
};

struct Counted {
    double count = 0.0;   // the median
    double spread = 0.0;  // between the smallest and the largest
};

Result<double> LookAt(const EncoderView& view, const CalibrateOptions& options) {
    const Result<wire::JsonDocument> document = view.Document();
    if (!document) return document.error();
    const auto encoder = FindEncoder(*document, options.name);
    if (!encoder) {
        return Error{"unknown_encoder", "there is no encoder '" + options.name + "'", ""};
    }
    const auto raw = encoder->Find("raw");
    const auto count = raw ? raw->Find(options.axis) : std::nullopt;
    if (count && count->kind() == wire::JsonKind::kNumber) return count->number();
    return Error{"encoder_stale",
                 "the encoder '" + options.name + "' gives no count for " + options.axis, ""};
}

Result<Counted> Count(const EncoderView& view, const CalibrateOptions& options) {
    std::vector<double> looks;
    for (int i = 0; i < kLooks; ++i) {
        if (i > 0) std::this_thread::sleep_for(kBetweenLooks);
        const Result<double> look = LookAt(view, options);
        if (!look) return look.error();
        double count = *look;
        if (options.wrap > 0.0 && !looks.empty()) {
            count += options.wrap * std::round((looks.front() - count) / options.wrap);
        }
        looks.push_back(count);
    }
    std::sort(looks.begin(), looks.end());
    return Counted{looks[kLooks / 2], looks.back() - looks.front()};
}

// A mark's value; nothing if it is none.
std::optional<double> MarkFrom(const std::string& text, LensAxis axis) {
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc() || end != text.data() + text.size()) return std::nullopt;
    const bool fits = value > 0.0 && (std::isfinite(value) || axis == LensAxis::kFocus);
    return fits ? std::optional(value) : std::nullopt;
}

std::string Digits(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.12g", value);
    return text;
}

std::string Row(const char* key, const std::vector<double>& values) {
    std::string row = std::string(key) + " = [";
    for (const double value : values) {
        row += (row.back() == '[' ? "" : ", ") + Digits(value);
    }
    return row + "]\n";
}

std::string Toml(const CalibrateOptions& options, const AxisMarks& marks) {
    std::string text =
        "[encoder." + options.axis + "]\n" + Row("raw", marks.raw) + Row("value", marks.value);
    if (options.wrap > 0.0) text += "wrap = " + Digits(options.wrap) + "\n";
    return text;
}

int Fail(const Error& error) {
    Complain("", error);
    return error.code == "no_server" ? kServerFailed : kBadInput;
}

// A mark that cannot stand beside the others is left out at once, and so is one whose count cannot
// be had: nobody has to begin anew for one slip.
void Add(double count, double value, LensAxis axis, AxisMarks& marks) {
    AxisMarks with = marks;
    with.raw.push_back(count);
    with.value.push_back(value);
    if (with.raw.size() > 1) {
        if (const Result<AxisTable> table = AxisTable::Build(axis, with); !table) {
            std::fprintf(stderr, "left out: with it the table's %s %s\n",
                         table.error().where.c_str(), table.error().message.c_str());
            return;
        }
    }
    marks = std::move(with);
}

// Asks until an empty line or the end of the input.
AxisMarks Lead(const EncoderView& view, const CalibrateOptions& options, LensAxis axis) {
    AxisMarks marks;
    marks.wrap = options.wrap;
    const char* const unit = axis == LensAxis::kFocus  ? "metres, or inf"
                             : axis == LensAxis::kIris ? "the stop"
                                                       : "mm";
    std::string line;
    for (;;) {
        std::fprintf(stderr, "Set %s to a mark and type it (%s); an empty line ends: ",
                     options.axis.c_str(), unit);
        if (!std::getline(std::cin, line) || line.empty()) return marks;
        const std::optional<double> value = MarkFrom(line, axis);
        if (!value) {
            std::fprintf(stderr, "'%s' is no mark\n", line.c_str());
            continue;
        }
        const Result<Counted> counted = Count(view, options);
        if (!counted) {
            std::fprintf(stderr, "left out: %s\n", counted.error().message.c_str());
            continue;
        }
        double count = counted->count;
        if (options.wrap > 0.0 && !marks.raw.empty()) {
            count += options.wrap * std::round((marks.raw.back() - count) / options.wrap);
        }
        std::fprintf(stderr, "count %.12g (moved by %.3g)\n", count, counted->spread);
        Add(count, *value, axis, marks);
    }
}

int Calibrate(const CalibrateOptions& options) {
    const auto axis = static_cast<LensAxis>(
        std::find(kLensAxisNames.begin(), kLensAxisNames.end(), options.axis) -
        kLensAxisNames.begin());
    const Result<EncoderView> view = EncoderView::Open(options.server, options.config);
    if (!view) return Fail(view.error());
    const Result<double> first = LookAt(*view, options);
    if (!first) return Fail(first.error());
    const AxisMarks marks = Lead(*view, options, axis);
    const Result<AxisTable> table = AxisTable::Build(axis, marks);
    if (!table) {
        Error error = table.error();
        error.message = "the marks make no table: " + error.where + " " + error.message;
        error.where.clear();
        return Fail(error);
    }
    if (const auto error = WriteOutput(options.output, Toml(options, marks))) {
        Complain("", *error);
        return kFailed;
    }
    return kDone;
}

}  // namespace

void AddCalibrateCommand(CLI::App& encoder, int& exit_code) {
    auto options = std::make_shared<CalibrateOptions>();
    CLI::App* command = encoder.add_subcommand(
        "calibrate", "Make the table of a ring, mark by mark, standing at the lens");
    command->add_option("name", options->name, "The encoder")->required()->type_name("NAME");
    command->add_option("--axis", options->axis, "The ring: focus, iris or zoom")
        ->check(CLI::IsMember({"focus", "iris", "zoom"}))
        ->capture_default_str();
    command->add_option("--wrap", options->wrap, "Counts of one turn of an absolute encoder")
        ->check(AboveZeroUpTo(1e15));
    command->add_option("-o,--output", options->output, "Where the table goes, or -")
        ->type_name("FILE")
        ->capture_default_str();
    AddEncoderSource(*command, options->server, options->config);
    command->callback([options, &exit_code] { exit_code = Calibrate(*options); });
}

}  // namespace flare::cli
