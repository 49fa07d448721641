// SPDX-License-Identifier: Apache-2.0
#include "server/translate/lens_json.h"

#include <complex>

#include "core/optics/paraxial.h"
#include "server/translate/field_json.h"
#include "server/translate/json_parts.h"

namespace flare {
namespace {

using wire::JsonWriter;

void OptionalMember(JsonWriter& json, std::string_view name, const std::optional<double>& value) {
    if (value) json.Member(name, *value);
}
void OptionalMember(JsonWriter& json, std::string_view name, const std::string& text) {
    if (!text.empty()) json.Member(name, text);
}

std::string_view SectionName(Section section) {
    return section == Section::kX ? "x" : "y";
}

// A surface with the keys and values that a lens file has for it.
void WriteSurface(JsonWriter& json, const SurfacePrescription& surface) {
    json.BeginInlineObject().Member("kind", KindName(surface.kind));
    const auto radius = [&](std::string_view name, double value) {
        if (value != 0.0) json.Member(name, value);
    };
    radius("radius_mm", surface.radius_mm);
    radius("radius_x_mm", surface.radius_x_mm);
    radius("radius_y_mm", surface.radius_y_mm);
    if (surface.conic != 0.0) json.Member("conic", surface.conic);
    if (!surface.asphere.empty()) {
        json.Key("asphere").BeginRow();
        for (const double a : surface.asphere) json.Value(a);
        json.End();
    }
    if (surface.gap_given) json.Member("gap_mm", surface.gap_mm);
    if (surface.glass) json.Member("glass", *surface.glass);
    OptionalMember(json, "nd", surface.nd);
    OptionalMember(json, "vd", surface.vd);
    json.Member("semi_diameter_mm", surface.semi_diameter_mm);
    if (surface.coating) json.Member("coating", *surface.coating);
    if (surface.kind == SurfaceKind::kSensor) json.Member("reflectance", surface.reflectance);
    json.End();
}

void WriteDesign(JsonWriter& json, const Lens& lens) {
    const Prescription& prescription = lens.prescription();
    json.Key("design").BeginInlineObject();
    if (!lens.rotational()) json.Member("section", SectionName(prescription.design_section));
    OptionalMember(json, "focal_mm", prescription.design_focal_mm);
    OptionalMember(json, "f_number", prescription.design_f_number);
    OptionalMember(json, "image_circle_mm", prescription.design_image_circle_mm);
    OptionalMember(json, "focal_tolerance", prescription.focal_tolerance);
    OptionalMember(json, "f_number_tolerance", prescription.f_number_tolerance);
    json.End();
}

// As a lens file writes them.
void WriteCoatings(JsonWriter& json, const CoatingDefinitions& coatings) {
    if (coatings.empty()) return;
    json.Key("coatings").BeginObject();
    for (const auto& [name, design] : coatings) {
        json.Key(name).BeginObject();
        OptionalMember(json, "source", design.source);
        OptionalMember(json, "notes", design.notes);
        json.Key("layers").BeginArray();
        for (const CoatingLayer& layer : design.layers()) {
            json.BeginInlineObject();
            if (layer.material.is_constant()) {
                const std::complex<double> index = layer.material.Index(kLineD);
                json.Member("n", index.real()).Member("k", index.imag());
            } else {
                json.Member("material", layer.material.name());
            }
            json.Member("thickness_nm", layer.thickness_nm).End();
        }
        json.End().End();
    }
    json.End();
}

void WriteOrigin(JsonWriter& json, const Lens& lens) {
    const Prescription& prescription = lens.prescription();
    OptionalMember(json, "maker", prescription.maker);
    OptionalMember(json, "patent", prescription.patent);
    if (prescription.year) json.Member("year", *prescription.year);
    OptionalMember(json, "source", prescription.source);
    OptionalMember(json, "notes", prescription.notes);
    WriteDesign(json, lens);
    json.Member("fisheye", prescription.fisheye);
    json.Member("default_coating", prescription.default_coating);
    WriteCoatings(json, prescription.coatings);
}

void WriteNumbers(JsonWriter& json, std::string_view name, const std::vector<double>& numbers) {
    if (numbers.empty()) return;
    json.Key(name).BeginRow();
    for (const double number : numbers) json.Value(number);  // infinity becomes null
    json.End();
}

void WriteStates(JsonWriter& json, const StateTable& states) {
    if (states.empty()) return;
    json.Key("states").BeginObject();
    WriteNumbers(json, "focal_mm", states.focal_mm);
    WriteNumbers(json, "focus_m", states.focus_m);
    WriteNumbers(json, "f_number", states.f_number);
    json.End();
}

double StopSemiDiameter(const Lens& lens) {
    return lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
}

// All but the f-number.
void WriteSection(JsonWriter& json, const FirstOrder& first, double last_vertex_z_mm) {
    json.Member("efl_mm", first.efl_mm).Member("bfl_mm", first.bfl_mm);
    json.Key("entrance_pupil").BeginInlineObject();
    json.Member("z_mm", first.entrance.z_mm).Member("diameter_mm", first.entrance.diameter_mm);
    json.End();
    json.Key("exit_pupil").BeginInlineObject();
    json.Member("z_mm", first.exit.z_mm).Member("diameter_mm", first.exit.diameter_mm);
    json.Member("z_from_last_vertex_mm", first.exit.z_mm - last_vertex_z_mm);
    json.End();
    json.Member("pupil_magnification", first.pupil_magnification);
}

void WriteFirstOrder(JsonWriter& json, const Lens& lens) {
    const double last_vertex_z_mm = lens.surfaces().back().vertex_z_mm;
    WriteSection(json, lens.first_order(lens.prescription().design_section), last_vertex_z_mm);
    // What a request's f_number is measured by: of both sections.
    json.Member("f_number", lens.f_number());
    json.Member("working_f_number", WorkingBeam(lens, StopSemiDiameter(lens)).working_f_number);
    json.Member("t_axis", AxialTransmittance(lens, kLineD));
    json.Member("squeeze", lens.squeeze());
    if (!lens.rotational()) {
        for (const Section section : {Section::kX, Section::kY}) {
            const FirstOrder& first = lens.first_order(section);
            json.Key(SectionName(section)).BeginObject().Member("f_number", first.f_number);
            WriteSection(json, first, last_vertex_z_mm);
            json.End();
        }
    }
    json.Member("stop_index", lens.stop_index());
    json.Member("last_vertex_z_mm", last_vertex_z_mm);
    json.Member("sensor_z_mm", lens.sensor_z_mm());
    if (lens.sensor()) {
        json.Key("sensor").BeginInlineObject().Member("reflectance", lens.sensor()->reflectance);
        json.Member("semi_diameter_mm", lens.sensor()->semi_diameter_mm).End();
    }
}

}  // namespace

std::string LensJson(const Lens& file, const LensInState& shown, bool with_field) {
    const Lens& lens = *shown.lens;
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Member("name", lens.name());
    WriteOrigin(json, lens);
    WriteStates(json, file.prescription().states);
    json.Key("state");
    WriteState(json, shown);
    WriteFirstOrder(json, lens);
    if (with_field) WriteField(json, lens);
    json.Key("surfaces").BeginArray();
    for (const SurfacePrescription& surface : lens.prescription().surfaces) {
        WriteSurface(json, surface);
    }
    json.End();
    json.Key("vertex_z_mm").BeginRow();
    for (const LensSurface& surface : lens.surfaces()) json.Value(surface.vertex_z_mm);
    json.End();
    json.Member("fingerprint", lens.fingerprint().hex());
    json.End();
    return json.Take();
}

std::string LensListJson(const LensLibrary& library) {
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Key("lenses").BeginArray();
    for (const std::string& name : library.Names()) {
        const auto lens = library.Find(name);
        if (!lens) continue;
        json.BeginInlineObject().Member("name", name);
        const Prescription& prescription = (*lens)->prescription();
        json.Member("efl_mm", (*lens)->first_order(prescription.design_section).efl_mm);
        json.Member("f_number", (*lens)->f_number());
        if (!(*lens)->rotational()) json.Member("squeeze", (*lens)->squeeze());
        if (!prescription.states.focal_mm.empty()) {
            json.Key("zoom_mm").BeginRow().Value(prescription.states.focal_mm.front());
            json.Value(prescription.states.focal_mm.back()).End();
        }
        json.Member("surface_count", static_cast<int>((*lens)->surfaces().size()));
        OptionalMember(json, "maker", prescription.maker);
        json.End();
    }
    json.End().Key("broken").BeginArray();
    for (const auto& [name, error] : library.broken()) {
        json.BeginInlineObject().Member("name", name).Key("error").BeginObject();
        json.Member("code", error.code).Member("message", error.message);
        json.Member("where", error.where);
        json.End().End();
    }
    json.End().End();
    return json.Take();
}

std::string ErrorJson(const Error& error) {
    return wire::EncodeRefusal({error.code, error.message, error.where});
}

}  // namespace flare
