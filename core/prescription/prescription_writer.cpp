// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/prescription_writer.h"

#include <charconv>
#include <cmath>
#include <string_view>

#include "core/base/check.h"

namespace flare {

namespace {

// The shortest digits that read back as the same double, with a point or an exponent: TOML tells
// whole numbers from real ones, and "inf" has a name there.
std::string Number(double value) {
    if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
    char text[32];
    const auto [end, fault] = std::to_chars(text, text + sizeof text, value);
    FLARE_CHECK(fault == std::errc());
    std::string out(text, end);
    if (out.find_first_of(".e") == std::string::npos) out += ".0";
    return out;
}

std::string Escaped(std::string_view text, bool lines) {
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (c == '\n' && lines) {
            out += c;
        } else if (byte < 0x20 || byte == 0x7f) {
            static constexpr std::string_view kDigits = "0123456789ABCDEF";
            out += "\\u00";
            out += kDigits[byte >> 4];
            out += kDigits[byte & 15];
        } else {
            out += c;
        }
    }
    return out;
}

std::string Text(std::string_view text) {
    if (text.find('\n') == std::string_view::npos) return '"' + Escaped(text, false) + '"';
    // The line end behind the opening quotes does not count.
    return "\"\"\"\n" + Escaped(text, true) + "\"\"\"";
}

class Writer {
  public:
    explicit Writer(const Prescription& lens) : lens_(lens) {}

    std::string Run() {
        Line("name", Text(lens_.name));
        for (const auto& [key, text] :
             {std::pair("maker", &lens_.maker), std::pair("patent", &lens_.patent)}) {
            if (!text->empty()) Line(key, Text(*text));
        }
        if (lens_.year) Line("year", std::to_string(*lens_.year));
        for (const auto& [key, text] :
             {std::pair("source", &lens_.source), std::pair("notes", &lens_.notes)}) {
            if (!text->empty()) Line(key, Text(*text));
        }
        if (lens_.default_coating != "bare") Line("default_coating", Text(lens_.default_coating));
        if (lens_.fisheye) Line("fisheye", "true");
        WriteDesign();
        WriteStates();
        for (const auto& [name, design] : lens_.coatings) WriteCoating(name, design);
        for (std::size_t i = 0; i < lens_.surfaces.size(); ++i) WriteSurface(i);
        return std::move(out_);
    }

  private:
    void Line(std::string_view key, const std::string& value) {
        out_ += std::string(key) + " = " + value + "\n";
    }
    void Optional(std::string_view key, const std::optional<double>& value) {
        if (value) Line(key, Number(*value));
    }
    void Unless(double fallback, std::string_view key, double value) {
        if (value != fallback) Line(key, Number(value));
    }
    static std::string List(const std::vector<double>& values, std::size_t begin,
                            std::size_t count) {
        std::string out = "[";
        for (std::size_t i = begin; i < begin + count; ++i) {
            out += (i > begin ? ", " : "") + Number(values[i]);
        }
        return out + "]";
    }
    static std::string List(const std::vector<double>& values) {
        return List(values, 0, values.size());
    }

    void WriteDesign() {
        const std::size_t before = out_.size();
        out_ += "\n[design]\n";
        const std::size_t empty = out_.size();
        if (lens_.design_section == Section::kX) Line("section", "\"x\"");
        Optional("focal_mm", lens_.design_focal_mm);
        Optional("f_number", lens_.design_f_number);
        Optional("image_circle_mm", lens_.design_image_circle_mm);
        Optional("focal_tolerance", lens_.focal_tolerance);
        Optional("f_number_tolerance", lens_.f_number_tolerance);
        if (out_.size() == empty) out_.resize(before);
    }

    void WriteStates() {
        const StateTable& table = lens_.states;
        if (table.empty()) return;
        out_ += "\n[states]\n";
        if (!table.focal_mm.empty()) Line("focal_mm", List(table.focal_mm));
        if (!table.focus_m.empty()) Line("focus_m", List(table.focus_m));
        if (!table.f_number.empty()) Line("f_number", List(table.f_number));
        for (const StateTable::Row& row : table.gaps) WriteRow("gap", "gap_mm", row);
        for (const StateTable::Row& row : table.semi_diameters) {
            WriteRow("semi_diameter", "semi_diameter_mm", row);
        }
    }

    void WriteRow(const std::string& table, const std::string& key, const StateTable::Row& row) {
        out_ += "\n[[states." + table + "]]\n";
        Line("surface", std::to_string(row.surface));
        if (lens_.states.focal_mm.empty() || lens_.states.focus_m.empty()) {
            Line(key, List(row.values));
            return;
        }
        const std::size_t focus = lens_.states.focus_positions();
        std::string rows = "[";
        for (std::size_t i = 0; i + focus <= row.values.size(); i += focus) {
            rows += (i > 0 ? ", " : "") + List(row.values, i, focus);
        }
        Line(key, rows + "]");
    }

    void WriteCoating(const std::string& name, const CoatingDesign& design) {
        out_ += "\n[coatings.\"" + Escaped(name, false) + "\"]\n";
        if (!design.source.empty()) Line("source", Text(design.source));
        if (!design.notes.empty()) Line("notes", Text(design.notes));
        std::string layers = "[";
        for (const CoatingLayer& layer : design.layers()) {
            layers += layers.size() > 1 ? ", { " : " { ";
            if (layer.material.is_constant()) {
                const std::complex<double> index = layer.material.Index(kLineD);
                layers += "n = " + Number(index.real()) + ", k = " + Number(index.imag());
            } else {
                layers += "material = " + Text(layer.material.name());
            }
            layers += ", thickness_nm = " + Number(layer.thickness_nm) + " }";
        }
        Line("layers", layers + " ]");
    }

    void WriteSurface(std::size_t index) {
        const SurfacePrescription& surface = lens_.surfaces[index];
        out_ += "\n[[surface]]  # " + std::to_string(index) + "\n";
        Line("kind", Text(KindName(surface.kind)));
        Unless(0.0, "radius_mm", surface.radius_mm);
        Unless(0.0, "radius_x_mm", surface.radius_x_mm);
        Unless(0.0, "radius_y_mm", surface.radius_y_mm);
        Unless(0.0, "conic", surface.conic);
        if (!surface.asphere.empty()) Line("asphere", List(surface.asphere));
        if (surface.gap_given) Line("gap_mm", Number(surface.gap_mm));
        if (surface.glass) Line("glass", Text(*surface.glass));
        Optional("nd", surface.nd);
        Optional("vd", surface.vd);
        Line("semi_diameter_mm", Number(surface.semi_diameter_mm));
        if (surface.coating) Line("coating", Text(*surface.coating));
        if (surface.kind == SurfaceKind::kSensor) {
            Line("reflectance", Number(surface.reflectance));
        }
    }

    const Prescription& lens_;
    std::string out_;
};

}  // namespace

std::string TomlFromPrescription(const Prescription& prescription) {
    return Writer(prescription).Run();
}

}  // namespace flare
