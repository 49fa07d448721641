// SPDX-License-Identifier: Apache-2.0
//
// Rows of numbers. Four columns are PBRT's: radius, gap, index, aperture. A line that names the
// columns overrules that, as printed tables have one. Old tables of PBRT give the gap in front of a
// surface, and then the first is 0, which no lens's first gap behind its front surface is; all
// others give the gap behind. Index 0 marks the stop, and so does a plane between air and air.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

enum class Column { kRadius, kGap, kIndex, kVNumber, kDiameter, kSemiDiameter, kAperture, kNumber };

std::optional<Column> ColumnNamed(std::string_view word) {
    static constexpr std::array<std::pair<std::string_view, Column>, 32> kWords = {{
        {"radius", Column::kRadius},
        {"r", Column::kRadius},
        {"radius_mm", Column::kRadius},
        {"axpos", Column::kGap},
        {"gap", Column::kGap},
        {"thickness", Column::kGap},
        {"distance", Column::kGap},
        {"separation", Column::kGap},
        {"d", Column::kGap},
        {"gap_mm", Column::kGap},
        {"n", Column::kIndex},
        {"nd", Column::kIndex},
        {"n_d", Column::kIndex},
        {"ior", Column::kIndex},
        {"index", Column::kIndex},
        {"eta", Column::kIndex},
        {"v", Column::kVNumber},
        {"vd", Column::kVNumber},
        {"v_d", Column::kVNumber},
        {"v-no", Column::kVNumber},
        {"abbe", Column::kVNumber},
        {"v-number", Column::kVNumber},
        {"aperture", Column::kAperture},
        {"ap", Column::kAperture},
        {"diameter", Column::kDiameter},
        {"dia", Column::kDiameter},
        {"semi", Column::kSemiDiameter},
        {"semi_ap", Column::kSemiDiameter},
        {"semi-diameter", Column::kSemiDiameter},
        {"semi_diameter_mm", Column::kSemiDiameter},
        {"surface", Column::kNumber},
        {"#", Column::kNumber},
    }};
    const std::string lower = LowerCase(word);
    for (const auto& [name, column] : kWords) {
        if (lower == name) return column;
    }
    return std::nullopt;
}

// The columns that a line names, or none if it names no radius.
std::vector<Column> ColumnsNamedBy(const std::vector<std::string_view>& words) {
    std::vector<Column> columns;
    for (const std::string_view word : words) {
        if (const std::optional<Column> column = ColumnNamed(word)) {
            columns.push_back(*column);
        } else {
            return {};
        }
    }
    const bool radius = std::count(columns.begin(), columns.end(), Column::kRadius) == 1;
    return radius && columns.size() >= 4 ? columns : std::vector<Column>();
}

struct Row {
    int line = 0;
    std::vector<std::string_view> words;
};

struct Table {
    std::vector<Column> columns;
    std::vector<Row> rows;
    std::vector<std::string> prose;
};

Result<Table> Sort(std::string_view text) {
    Table table;
    for (const TextLine& line : LinesOf(text)) {
        std::string_view rest = line.text;
        const bool comment = rest.front() == '#' || rest.substr(0, 2) == "//";
        if (comment) rest.remove_prefix(std::min(rest.find_first_not_of("#/ \t"), rest.size()));
        const std::vector<std::string_view> words = WordsOf(rest, ",;|");
        if (words.empty()) continue;
        const std::vector<Column> named = ColumnsNamedBy(words);
        if (!named.empty() && table.rows.empty()) {
            table.columns = named;
        } else if (comment) {
            table.prose.emplace_back(rest);
        } else if (table.rows.empty() && !NumberIn(words.front())) {
            table.prose.emplace_back(rest);
        } else {
            table.rows.push_back({line.number, words});
        }
    }
    if (table.rows.empty()) return Error{"bad_lens", "the file has no row of numbers", ""};
    if (table.columns.empty()) {
        const std::size_t count = table.rows.front().words.size();
        table.columns = {Column::kRadius, Column::kGap, Column::kIndex};
        if (count == 5) table.columns.push_back(Column::kVNumber);
        table.columns.push_back(Column::kAperture);
        if (count != table.columns.size()) {
            return Error{"bad_lens",
                         "a row has " + std::to_string(count) +
                             " columns: four are radius, gap, index and aperture, five have the "
                             "V-number in front of the aperture; others must be named by a line "
                             "above them",
                         LinePlace(table.rows.front().line)};
        }
    }
    return table;
}

// One row as a surface; its aperture, whatever it is, as the semi-diameter.
Result<SurfacePrescription> SurfaceOf(const Row& row, const std::vector<Column>& columns,
                                      const std::vector<SurfacePrescription>& in_front) {
    if (row.words.size() != columns.size()) {
        return Error{"bad_lens",
                     "this row has " + std::to_string(row.words.size()) + " columns, not " +
                         std::to_string(columns.size()),
                     LinePlace(row.line)};
    }
    SurfacePrescription out;
    out.where = LinePlace(row.line);
    out.gap_given = true;
    double nd = 1.0, vd = 0.0;
    bool indexed = false;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const std::string word = LowerCase(row.words[i]);
        double value = 0.0;
        if (columns[i] == Column::kRadius && word == "stop") {
            out.kind = SurfaceKind::kStop;
            continue;
        }
        const bool nothing = word == "-" || word == "--" || word == "air";
        const bool flat = word == "inf" || word == "infinity" || word == "plano" || word == "flat";
        if (!nothing && !(flat && columns[i] == Column::kRadius)) {
            static constexpr std::array<const char*, 8> kNames = {
                "the radius",   "the gap",           "the index",    "the V-number",
                "the diameter", "the semi-diameter", "the aperture", "the number"};
            const Result<double> read =
                RequireNumber(row.words[i], kNames[static_cast<std::size_t>(columns[i])], row.line);
            if (!read) return read.error();
            value = *read;
        }
        switch (columns[i]) {
            case Column::kRadius:
                out.radius_mm = value;
                break;
            case Column::kGap:
                out.gap_mm = value;
                break;
            case Column::kIndex:
                nd = nothing ? 1.0 : value;
                indexed = !nothing;
                break;
            case Column::kVNumber:
                vd = value;
                break;
            case Column::kDiameter:
            case Column::kSemiDiameter:
            case Column::kAperture:
                out.semi_diameter_mm = value;
                break;
            case Column::kNumber:
                break;
        }
    }
    if (nd == 0.0) out.kind = SurfaceKind::kStop;
    const bool stop = out.kind == SurfaceKind::kStop;
    if (stop && (nd == 0.0 || !indexed)) {
        StandInMediumInFront(out, in_front);
    } else {
        SetMedium(out, nd, vd > 0.0 ? std::optional(vd) : std::nullopt);
    }
    return out;
}

// A stop that is only a plane between air and air.
void FindStop(std::vector<SurfacePrescription>& surfaces) {
    for (const SurfacePrescription& surface : surfaces) {
        if (surface.kind == SurfaceKind::kStop) return;
    }
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const bool air = !surfaces[i].nd && (i == 0 || !surfaces[i - 1].nd);
        if (air && surfaces[i].radius_mm == 0.0) {
            surfaces[i].kind = SurfaceKind::kStop;
            return;
        }
    }
}

void SettleGaps(LensDraft& draft) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    SurfacePrescription& last = surfaces.back();
    if (surfaces.front().gap_mm == 0.0 && surfaces.size() > 1) {
        for (std::size_t i = 0; i + 1 < surfaces.size(); ++i) {
            surfaces[i].gap_mm = surfaces[i + 1].gap_mm;
        }
        last.gap_mm = 0.0;
        draft.Remark(
            "The first gap is 0, so gaps are those in front of each surface; where the "
            "sensor stands is not in the file.");
    }
    last.gap_given = last.gap_mm != 0.0;
    if (!last.gap_given) draft.Remark("The sensor was put at the paraxial focus.");
}

}  // namespace

Result<LensDraft> ReadTable(std::string_view text) {
    Result<Table> table = Sort(text);
    if (!table) return table.error();
    LensDraft draft;
    bool dispersion = false;
    for (const Row& row : table->rows) {
        Result<SurfacePrescription> surface = SurfaceOf(row, table->columns, draft.lens.surfaces);
        if (!surface) return surface.error();
        dispersion = dispersion || surface->vd.has_value();
        draft.lens.surfaces.push_back(std::move(*surface));
        if (draft.lens.surfaces.size() > static_cast<std::size_t>(kMaxSurfaces)) {
            return Error{"bad_lens",
                         "the table has more than " + std::to_string(kMaxSurfaces) + " rows",
                         LinePlace(row.line)};
        }
    }
    FindStop(draft.lens.surfaces);
    SettleGaps(draft);
    std::optional<double> f_number;
    for (const std::string& line : table->prose) {
        if (!f_number) f_number = FNumberIn(line);
        draft.lens.notes += (draft.lens.notes.empty() ? "" : " ") + line;
    }
    if (!table->prose.empty()) draft.title = table->prose.front();
    draft.lens.design_f_number = f_number;
    const auto has = [&](Column column) {
        return std::count(table->columns.begin(), table->columns.end(), column) > 0;
    };
    // PBRT's apertures are diameters, but not everybody's who copied the form.
    const ApertureColumn stated =
        has(Column::kSemiDiameter) ? ApertureColumn::kSemiDiameters : ApertureColumn::kDiameters;
    SettleApertures(draft, stated, f_number);
    if (!dispersion) draft.Remark("The file has no V-numbers: the lens has no dispersion.");
    draft.Remark("The file has no coatings: every surface is bare.");
    return draft;
}

}  // namespace flare
