// SPDX-License-Identifier: Apache-2.0
#include "server/cli/field_table.h"

#include "core/base/units.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

std::string OrDash(const std::optional<double>& value, int digits, double factor = 1.0) {
    return value ? Fixed(*value * factor, digits) : "-";
}

// What the last row means.
std::string EdgeText(FieldEdge edge) {
    switch (edge) {
        case FieldEdge::kImageCircle:
            return "the edge of the image circle";
        case FieldEdge::kNoChiefRay:
            return "the last angle with a chief ray";
        case FieldEdge::kNoLight:
            return "the last angle with light";
    }
    return "";
}

std::string OneTable(const FieldTable& field, const FieldData& data, bool fisheye) {
    std::vector<std::string> heads{"field deg", "image mm", "distortion %"};
    if (fisheye) heads.emplace_back("f-theta %");
    for (const char* head : {"illumination %", "beam mm2", "beam %", "T d"}) {
        heads.emplace_back(head);
    }
    for (const double wavelength_nm : data.wavelengths_nm) {
        heads.push_back("T " + Fixed(wavelength_nm, 0));
    }
    Table table(heads);
    for (const FieldRow& row : field.rows) {
        std::vector<std::string> cells{Fixed(DegreesFromRadians(row.field_rad), 3),
                                       OrDash(row.image_height_mm, 3),
                                       OrDash(row.distortion, 2, 100.0)};
        if (fisheye) cells.push_back(OrDash(row.f_theta_distortion, 2, 100.0));
        cells.push_back(OrDash(row.relative_illumination, 1, 100.0));
        cells.push_back(Fixed(row.beam_area_mm2, 2));
        cells.push_back(Fixed(row.beam_share * 100.0, 1));
        cells.push_back(OrDash(row.transmittance, 4));
        for (std::size_t i = 0; i < data.wavelengths_nm.size(); ++i) {
            cells.push_back(row.transmittances.empty() ? "-" : Fixed(row.transmittances[i], 4));
        }
        table.AddRow(std::move(cells));
    }
    return table.text();
}

}  // namespace

std::string FieldTables(const Lens& lens, const FieldOptions& options) {
    const FieldData data = FieldDataOf(lens, options);
    std::string text;
    for (const FieldTable& field : data.tables) {
        text += text.empty() ? "" : "\n";
        text += "Field at f/" + Fixed(data.f_number, 2);
        if (!lens.rotational()) {
            text += field.section == Section::kX ? ", light in the x-z plane"
                                                 : ", light in the y-z plane";
        }
        text += ", to " + EdgeText(field.edge) + "\n";
        text += OneTable(field, data, lens.prescription().fisheye);
    }
    return text;
}

}  // namespace flare::cli
