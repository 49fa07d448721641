// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/states_reader.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/optics/prescription_faults.h"
#include "core/prescription/document_fields.h"

namespace flare {

namespace {

constexpr std::size_t kMostRows = 2 * kMaxSurfaces;

// Distances in metres; infinity is written inf, or "inf" where numbers have no infinity (JSON).
void ReadFocusAxis(Fields& fields, std::vector<double>& out) {
    const DocumentNode* node = fields.Find("focus_m");
    if (node == nullptr) return;
    if (node->array() == nullptr) {
        fields.Fail("\"focus_m\" of states must be an array of distances", node->where);
        return;
    }
    for (const DocumentNode& item : *node->array()) {
        if (item.string() != nullptr && *item.string() == "inf") {
            out.push_back(std::numeric_limits<double>::infinity());
        } else if (item.number() != nullptr && !std::isnan(*item.number())) {
            out.push_back(*item.number());
        } else {
            fields.Fail("\"focus_m\" of states holds something that is no distance", item.where);
            return;
        }
    }
}

// A number list, or one list a zoom position laid end to end.
void ReadValues(Fields& fields, const char* key, std::vector<double>& out) {
    const DocumentNode* node = fields.Require(key);
    if (node == nullptr) return;
    const DocumentNode::Array* rows = node->array();
    if (rows == nullptr || rows->empty() || rows->front().array() == nullptr) {
        fields.Read(key, out);
        return;
    }
    const std::size_t columns = rows->front().array()->size();
    for (const DocumentNode& row : *rows) {
        if (row.array() == nullptr || row.array()->size() != columns) {
            fields.Fail(std::string("\"") + key + "\" must have rows of equal length", row.where);
            return;
        }
        for (const DocumentNode& item : *row.array()) {
            if (item.number() == nullptr || !std::isfinite(*item.number())) {
                fields.Fail(std::string("\"") + key + "\" holds something that is no number",
                            item.where);
                return;
            }
            out.push_back(*item.number());
        }
    }
}

Result<StateTable::Row> ReadRow(const DocumentNode& node, const char* key) {
    Fields fields(node, std::string("an entry of states.") + key);
    const bool gap = std::string_view(key) == "gap";
    const char* const values = gap ? "gap_mm" : "semi_diameter_mm";
    fields.Allow({"surface", values}, {});
    StateTable::Row row;
    row.where = node.where;
    double surface = 0.0;
    fields.Require("surface");
    if (fields.Read("surface", surface) &&
        !(surface >= 0.0 && surface < kMaxSurfaces && surface == std::floor(surface))) {
        fields.Fail("\"surface\" must be a surface's number, not " + NumberText(surface),
                    fields.Find("surface")->where);
    }
    ReadValues(fields, values, row.values);
    if (fields.error().has_value()) return *fields.error();
    row.surface = static_cast<int>(surface);
    return row;
}

void ReadRows(Fields& fields, const char* key, std::vector<StateTable::Row>& out) {
    const DocumentNode* node = fields.Find(key);
    if (node == nullptr) return;
    if (node->array() == nullptr || node->array()->size() > kMostRows) {
        fields.Fail(std::string("states.") + key + " must be an array of at most " +
                        std::to_string(kMostRows) + " tables",
                    node->where);
        return;
    }
    for (const DocumentNode& item : *node->array()) {
        Result<StateTable::Row> row = ReadRow(item, key);
        if (!row) {
            fields.Fail(row.error().message, row.error().where);
            return;
        }
        out.push_back(std::move(*row));
    }
}

}  // namespace

Result<StateTable> ReadStates(const DocumentNode& node) {
    Fields fields(node, "states");
    fields.Allow({"focal_mm", "focus_m", "f_number", "gap", "semi_diameter"}, {});
    StateTable table;
    table.where = node.where;
    fields.Read("focal_mm", table.focal_mm);
    ReadFocusAxis(fields, table.focus_m);
    fields.Read("f_number", table.f_number);
    ReadRows(fields, "gap", table.gaps);
    ReadRows(fields, "semi_diameter", table.semi_diameters);
    if (fields.error().has_value()) return *fields.error();
    return table;
}

}  // namespace flare
