// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/script_encoder.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "protocol/limits.h"

namespace flare {
namespace {

enum class Column { kTime, kFocus, kFStop, kTStop, kZoom, kRawFocus, kRawIris, kRawZoom };
constexpr std::array<std::string_view, 8> kColumnNames{"time_s",  "focus_m", "f_number", "t_stop",
                                                       "zoom_mm", "focus",   "iris",     "zoom"};

std::string_view Trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return "";
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> Cells(std::string_view line) {
    std::vector<std::string_view> cells;
    for (;;) {
        const std::size_t comma = line.find(',');
        cells.push_back(Trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return cells;
        line.remove_prefix(comma + 1);
    }
}

std::optional<double> Number(std::string_view text) {
    double value = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc() || end != text.data() + text.size() || std::isnan(value)) {
        return std::nullopt;
    }
    return value;
}

class ScriptReader {
  public:
    Result<std::vector<EncoderSample>> Run(std::string_view text) {
        while (!text.empty() && !error_) {
            const std::size_t end = text.find('\n');
            ++line_;
            ReadLine(Trimmed(text.substr(0, end)));
            text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        }
        if (!error_ && samples_.empty()) Fail("there is no sample");
        if (error_) return *error_;
        return std::move(samples_);
    }

  private:
    void Fail(std::string message) {
        error_ = Error{"bad_script", std::move(message), "line " + std::to_string(line_)};
    }

    void ReadLine(std::string_view line) {
        if (line.empty() || line.front() == '#') return;
        const std::vector<std::string_view> cells = Cells(line);
        if (columns_.empty()) return ReadNames(cells);
        if (cells.size() != columns_.size()) {
            return Fail("has " + std::to_string(cells.size()) + " columns, not " +
                        std::to_string(columns_.size()));
        }
        EncoderSample sample;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            if (cells[i].empty() && columns_[i] != Column::kTime) continue;
            const std::optional<double> value = Number(cells[i]);
            if (!value) return Fail("'" + std::string(cells[i]) + "' is no number");
            Put(columns_[i], *value, sample);
            if (error_) return;
        }
        if (!samples_.empty() && sample.time_s <= samples_.back().time_s) {
            return Fail("time_s does not rise");
        }
        if (samples_.size() == limits::kScriptSamples) {
            return Fail("more than " + std::to_string(limits::kScriptSamples) + " samples");
        }
        samples_.push_back(sample);
    }

    void ReadNames(const std::vector<std::string_view>& cells) {
        for (const std::string_view cell : cells) {
            const auto name = std::find(kColumnNames.begin(), kColumnNames.end(), cell);
            if (name == kColumnNames.end()) {
                return Fail("there is no column '" + std::string(cell) + "'");
            }
            const auto column = static_cast<Column>(name - kColumnNames.begin());
            if (Has(column)) return Fail("the column " + std::string(cell) + " stands twice");
            columns_.push_back(column);
        }
        if (!Has(Column::kTime)) return Fail("there is no column time_s");
        if (Has(Column::kFStop) && Has(Column::kTStop)) {
            return Fail("f_number and t_stop exclude each other");
        }
    }
    bool Has(Column column) const {
        return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
    }

    void Put(Column column, double value, EncoderSample& sample) {
        const bool may_be_infinite = column == Column::kFocus && value > 0.0;
        if (!std::isfinite(value) && !may_be_infinite) return Fail("a value is infinite");
        const auto state = [&](LensAxis axis) {
            if (!(value > 0.0)) return Fail("a value is not above 0");
            sample.stated[axis] = value;
        };
        switch (column) {
            case Column::kTime:
                if (value < 0.0) return Fail("time_s is less than 0");
                sample.time_s = value;
                return;
            case Column::kFocus:
                return state(LensAxis::kFocus);
            case Column::kTStop:
                sample.stated.iris_is_t_stop = true;
                return state(LensAxis::kIris);
            case Column::kFStop:
                return state(LensAxis::kIris);
            case Column::kZoom:
                return state(LensAxis::kZoom);
            case Column::kRawFocus:
                sample.raw[Index(LensAxis::kFocus)] = value;
                return;
            case Column::kRawIris:
                sample.raw[Index(LensAxis::kIris)] = value;
                return;
            case Column::kRawZoom:
                sample.raw[Index(LensAxis::kZoom)] = value;
                return;
        }
    }

    int line_ = 0;
    std::vector<Column> columns_;
    std::vector<EncoderSample> samples_;
    std::optional<Error> error_;
};

class ScriptEncoder final : public EncoderSource {
  public:
    ScriptEncoder(EncoderTrack& track, std::vector<EncoderSample> samples)
        : track_(track), samples_(std::move(samples)), thread_([this](const StopSignal& stop) {
              do Play(stop);
              while (track_.config().loop && !stop.set());
          }) {}

  private:
    // A loop begins anew one step (that before the last sample) after the last.
    void Play(const StopSignal& stop) {
        const double start_s = EncoderClock::Now_s();
        if (!track_.connected()) track_.Connected("script " + track_.config().file);
        for (EncoderSample sample : samples_) {
            sample.time_s += start_s;
            if (stop.WaitFor_ms(1e3 * (sample.time_s - EncoderClock::Now_s()))) return;
            track_.Add(sample);
        }
        const std::size_t count = samples_.size();
        const double step_s =
            count < 2 ? 1.0 : samples_[count - 1].time_s - samples_[count - 2].time_s;
        stop.WaitFor_ms(1e3 * step_s);
    }

    EncoderTrack& track_;
    const std::vector<EncoderSample> samples_;
    SourceThread thread_;
};

}  // namespace

Result<std::vector<EncoderSample>> ReadScript(std::string_view text) {
    return ScriptReader().Run(text);
}

Result<std::unique_ptr<EncoderSource>> StartScript(EncoderTrack& track) {
    const std::string& path = track.config().file;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!file || !(text << file.rdbuf())) {
        return Error{"bad_config", "cannot read " + path, "file"};
    }
    Result<std::vector<EncoderSample>> samples = ReadScript(text.str());
    if (!samples) {
        return Error{"bad_config",
                     path + ", " + samples.error().where + ": " + samples.error().message, "file"};
    }
    return std::unique_ptr<EncoderSource>(new ScriptEncoder(track, std::move(*samples)));
}

}  // namespace flare
