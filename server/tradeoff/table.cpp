// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/table.h"

#include <charconv>
#include <tuple>
#include <type_traits>

#include "server/tradeoff/number_text.h"

namespace flare {
namespace {

// One column: its name and where it stands in a row.
template <class Row, class Visit>
void ForEachColumn(Row& row, Visit visit) {
    visit("lens", row.lens);
    visit("coatings", row.coatings);
    visit("lens_hash", row.lens_hash);
    visit("f_number", row.f_number);
    visit("field_deg", row.field_deg);
    visit("width", row.width);
    visit("height", row.height);
    visit("truth", row.truth);
    visit("knob", row.knob);
    visit("value", row.value);
    visit("rel_l1", row.rel_l1);
    visit("energy", row.energy);
    visit("rel_l2_blur2", row.rel_l2_blur2);
    visit("log_error_stops_mean", row.stops_mean);
    visit("log_error_stops_p99", row.stops_p99);
    visit("p999_ratio", row.p999_ratio);
    visit("estimated_rel_l1", row.estimated);
    visit("cold_ms", row.cold_ms);
    visit("warm_ms", row.warm_ms);
    visit("cold_cpu_ms", row.cold_cpu_ms);
    visit("warm_cpu_ms", row.warm_cpu_ms);
    visit("runs", row.runs);
    visit("threads", row.threads);
    visit("rays", row.rays);
    visit("pieces", row.pieces);
}

std::string FieldText(const std::string& value) {
    if (value.find_first_of(",\"\r\n") == std::string::npos) return value;
    std::string quoted = "\"";
    for (const char c : value) {
        quoted += c;
        if (c == '"') quoted += c;
    }
    return quoted + "\"";
}
std::string FieldText(double value) {
    return NumberText(value);
}
std::string FieldText(int value) {
    return std::to_string(value);
}

bool Read(const std::string& text, std::string& value) {
    value = text;
    return true;
}
template <class Number>
bool Read(const std::string& text, Number& value) {
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    return parsed.ec == std::errc{} && parsed.ptr == end;
}

// Quotes may surround a field, and stand double inside one.
std::vector<std::string> Fields(std::string_view line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (c == '"') {
            const bool pair = quoted && i + 1 < line.size() && line[i + 1] == '"';
            if (pair) {
                fields.back() += '"';
                ++i;
            } else {
                quoted = !quoted;
            }
        } else if (c == ',' && !quoted) {
            fields.emplace_back();
        } else {
            fields.back() += c;
        }
    }
    return fields;
}

bool RowFromLine(std::string_view line, TradeoffRow& row) {
    const std::vector<std::string> fields = Fields(line);
    std::size_t next = 0;
    bool sound = true;
    ForEachColumn(row, [&](const char*, auto& value) {
        sound = sound && next < fields.size() && Read(fields[next], value);
        ++next;
    });
    return sound && next == fields.size();
}

}  // namespace

std::string TradeoffRow::Key() const {
    std::string key;
    for (const std::string& part :
         {lens, coatings, lens_hash, NumberText(f_number), NumberText(field_deg),
          std::to_string(width), std::to_string(height), truth, knob, value}) {
        key += part + '\n';
    }
    return key;
}

TradeoffRow RowFor(const TradeoffScene& scene, const Trial& trial) {
    TradeoffRow row;
    row.lens = scene.lens_name;
    row.coatings = scene.coatings;
    row.lens_hash = scene.lens->fingerprint().hex();
    row.f_number = scene.f_number;
    row.field_deg = scene.field_deg;
    row.width = scene.width;
    row.height = scene.height;
    row.truth = TruthName(trial.truth);
    row.knob = trial.knob;
    row.value = trial.value;
    return row;
}

std::string CsvHead() {
    std::string head;
    TradeoffRow row;
    ForEachColumn(row, [&](const char* name, auto&) {
        head += (head.empty() ? "" : ",") + std::string(name);
    });
    return head + "\n";
}

std::string CsvLine(const TradeoffRow& row) {
    std::string line;
    bool first = true;
    ForEachColumn(row, [&](const char*, const auto& value) {
        line += (first ? "" : ",") + FieldText(value);
        first = false;
    });
    return line + "\n";
}

Result<std::vector<TradeoffRow>> RowsFromCsv(std::string_view text) {
    const std::string head = CsvHead();
    if (!text.starts_with(head)) {
        return Error{"bad_value", "these are not the columns of a tradeoff table", "line 1"};
    }
    text.remove_prefix(head.size());
    std::vector<TradeoffRow> rows;
    for (int number = 2; !text.empty(); ++number) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) break;
        TradeoffRow row;
        if (!RowFromLine(text.substr(0, end), row)) {
            return Error{"bad_value", "this is no row of a tradeoff table",
                         "line " + std::to_string(number)};
        }
        rows.push_back(std::move(row));
        text.remove_prefix(end + 1);
    }
    return rows;
}

}  // namespace flare
