// SPDX-License-Identifier: Apache-2.0
//
// Writes the first state of a rotational lens as files of other programs, for tests of the
// importers. Where a format has no place for a number (an asphere in a table) it is left out.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "core/optics/prescription.h"
#include "tests/support/paraxial_table.h"

namespace flare::testing {

inline std::string Digits(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

inline double IndexBehind(const SurfacePrescription& surface) {
    return MediumOf(surface).value().nd();
}
inline double VNumberBehind(const SurfacePrescription& surface) {
    const Glass glass = MediumOf(surface).value();
    return glass.is_air() || std::isinf(glass.vd()) ? 0.0 : surface.vd.value_or(glass.vd());
}
inline double LastGap(const Prescription& lens) {
    const SurfacePrescription& last = lens.surfaces[lens.optical_count() - 1];
    return last.gap_given ? last.gap_mm : FiguresOf(lens).bfl_mm;
}
inline double GapBehind(const Prescription& lens, std::size_t i) {
    return i + 1 == lens.optical_count() ? LastGap(lens) : lens.surfaces[i].gap_mm;
}

// The maker's name of a glass, and the maker.
inline std::pair<std::string, std::string> MakerAndName(const std::string& glass) {
    const std::size_t gap = glass.find(' ');
    return {glass.substr(0, gap), glass.substr(gap + 1)};
}

inline std::string FlareSimText(const Prescription& lens, double apertures = 1.0) {
    std::string out = "# f/" + Digits(FiguresOf(lens).f_number) + "\nname: " + lens.name +
                      "\nfocal_length: " + Digits(FiguresOf(lens).efl_mm) + "\n\nsurfaces:\n";
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const bool stop = surface.kind == SurfaceKind::kStop;
        out += "  " + (stop ? "stop" : Digits(surface.radius_mm)) + " " +
               Digits(GapBehind(lens, i)) + " " + Digits(IndexBehind(surface)) + " " +
               Digits(VNumberBehind(surface)) + " " + Digits(apertures * surface.semi_diameter_mm) +
               " 0\n";
    }
    return out;
}

inline std::string PbrtText(const Prescription& lens) {
    std::string out = "# f/" + Digits(FiguresOf(lens).f_number) + "\n";
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const bool stop = surface.kind == SurfaceKind::kStop;
        out += Digits(surface.radius_mm) + " " + Digits(GapBehind(lens, i)) + " " +
               Digits(stop ? 0.0 : IndexBehind(surface)) + " " +
               Digits(2.0 * surface.semi_diameter_mm) + "\n";
    }
    return out;
}

inline std::string TableText(const Prescription& lens) {
    std::string out = "# f/" + Digits(FiguresOf(lens).f_number) +
                      "\nsurface,radius,thickness,nd,vd,semi-diameter\n";
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const bool stop = surface.kind == SurfaceKind::kStop;
        out +=
            std::to_string(i) + "," + (stop ? "stop" : Digits(surface.radius_mm)) + "," +
            Digits(GapBehind(lens, i)) + "," +
            (stop ? "-,-" : Digits(IndexBehind(surface)) + "," + Digits(VNumberBehind(surface))) +
            "," + Digits(surface.semi_diameter_mm) + "\n";
    }
    return out;
}

inline std::string OpenLensFlareText(const Prescription& lens) {
    std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<opticalSystem>\n<name>" +
                      lens.name + "</name>\n<effectiveFocalLength>" +
                      Digits(FiguresOf(lens).efl_mm) + "</effectiveFocalLength>\n<elements>\n";
    const auto element = [&](const char* type, const SurfacePrescription& surface, double gap,
                             double nd, double vd) {
        out += "<element>\n<type>" + std::string(type) + "</type>\n<height>" +
               Digits(surface.semi_diameter_mm) + "</height>\n<thickness>" + Digits(gap) +
               "</thickness>\n<radius>" + Digits(surface.radius_mm) +
               "</radius>\n<refractiveIndex>" + Digits(nd) + "</refractiveIndex>\n<abbeNumber>" +
               Digits(vd) +
               "</abbeNumber>\n<coatingLambda>550.000000</coatingLambda>\n"
               "<coatingIor>1.380000</coatingIor>\n</element>\n";
    };
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const bool stop = surface.kind == SurfaceKind::kStop;
        element(stop ? "apertureStop" : "lensSpherical", surface, GapBehind(lens, i),
                IndexBehind(surface), VNumberBehind(surface));
    }
    SurfacePrescription sensor;
    sensor.semi_diameter_mm = 18.0;
    element("sensor", sensor, 0.001, 1.0, 89.3);
    return out + "</elements>\n</opticalSystem>\n";
}

inline std::string RealflareText(const Prescription& lens) {
    std::string rows;
    std::size_t stop = 0;
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        if (surface.kind == SurfaceKind::kStop) stop = i;
        rows += std::string(i > 0 ? ",\n" : "") + "{\"radius\": " + Digits(surface.radius_mm) +
                ", \"distance\": " + Digits(GapBehind(lens, i)) +
                ", \"refractive_index\": " + Digits(IndexBehind(surface)) +
                ", \"abbe_nr\": " + Digits(VNumberBehind(surface)) +
                ", \"height\": " + Digits(surface.semi_diameter_mm) + "}";
    }
    return "{\"name\": \"" + lens.name + "\", \"year\": 1990, \"patent_number\": \"1\",\n" +
           "\"focal_length\": " + Digits(FiguresOf(lens).efl_mm) +
           ", \"fstop\": " + Digits(FiguresOf(lens).f_number) +
           ", \"aperture_index\": " + std::to_string(stop) + ",\n\"lens_elements\": [\n" + rows +
           "]}\n";
}

inline std::string LentilText(const Prescription& lens) {
    std::string rows;
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const double nd = IndexBehind(surface);
        const bool stop = surface.kind == SurfaceKind::kStop;
        const char* geometry = surface.kind == SurfaceKind::kCylinderX   ? "cyl-x"
                               : surface.kind == SurfaceKind::kCylinderY ? "cyl-y"
                                                                         : "spherical";
        rows += std::string(i > 0 ? ",\n" : "") + "{\"radius\": " +
                (surface.radius_mm == 0.0 ? "99999.0" : Digits(surface.radius_mm)) +
                ", \"thickness\": " + Digits(GapBehind(lens, i)) +
                ", \"ior\": " + (nd == 1.0 ? "null" : Digits(nd)) +
                ", \"abbe\": " + (nd == 1.0 ? "null" : Digits(VNumberBehind(surface))) +
                ", \"material\": \"" +
                (stop        ? "iris"
                 : nd == 1.0 ? "air"
                             : "abbe") +
                "\", \"housing-radius\": " + Digits(surface.semi_diameter_mm) +
                ", \"lens-geometry\": \"" + geometry + "\", \"aspherical-equation\": null}";
    }
    return "{\"company\": \"a\", \"product-name\": \"b\", \"patent-number\": null,\n"
           "\"optical-elements-patent\": [\n" +
           rows + "]}\n";
}

inline std::string ZemaxText(const Prescription& lens) {
    std::string out = "VERS 160608 48 100027\nMODE SEQ\nNAME " + lens.name +
                      "\nUNIT MM X W X CM MR CPMM\nFNUM " + Digits(FiguresOf(lens).f_number) +
                      " 0\nGCAT SCHOTT OHARA HOYA HIKARI CDGM SUMITA MISC\nFTYP 0 0 3 3\n"
                      "YFLN 0 10 14\nSURF 0\n  TYPE STANDARD\n  CURV 0.0 0 0 0 0 \"\"\n"
                      "  DISZ INFINITY\n";
    std::size_t i = 0;
    for (; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        out += "SURF " + std::to_string(i + 1) + "\n";
        if (surface.kind == SurfaceKind::kStop) out += "  STOP\n";
        out += surface.asphere.empty() ? "  TYPE STANDARD\n" : "  TYPE EVENASPH\n";
        out += "  CURV " + Digits(surface.radius_mm == 0.0 ? 0.0 : 1.0 / surface.radius_mm) +
               " 0 0 0 0 \"\"\n  CONI " + Digits(surface.conic) + "\n  PARM 1 0\n";
        for (std::size_t k = 0; k < surface.asphere.size(); ++k) {
            out += "  PARM " + std::to_string(k + 2) + " " + Digits(surface.asphere[k]) + "\n";
        }
        out += "  DISZ " + Digits(GapBehind(lens, i)) + "\n";
        if (surface.glass) {
            out += "  GLAS " + MakerAndName(*surface.glass).second + " 0 0 1.5 40 0 0 0 0 0 0\n";
        } else if (surface.nd && *surface.nd != 1.0) {
            out += "  GLAS ___BLANK 1 0 " + Digits(*surface.nd) + " " +
                   Digits(VNumberBehind(surface)) + " 0 0 0 0 0 0\n";
        }
        out += "  DIAM " + Digits(surface.semi_diameter_mm) + " 1 0 0 1 \"\"\n";
    }
    return out + "SURF " + std::to_string(i + 1) + "\n  TYPE STANDARD\n  CURV 0.0 0 0 0 0 \"\"\n" +
           "  DISZ 0\n  DIAM 20 0 0 0 1 \"\"\n";
}

// CODE V's made-up glass: the digits of n - 1 and of V.
inline std::string MadeUpGlass(double nd, double vd) {
    char text[40];
    std::snprintf(text, sizeof text, "%07.0f.%04.0f", std::round((nd - 1.0) * 1e7),
                  std::round((vd == 0.0 ? 50.0 : vd) * 100.0));
    return text;
}

inline std::string CodeVText(const Prescription& lens) {
    std::string out = "RDM;LEN \"VERSION: 11.2\"\nTITLE '" + lens.name + "'\nFNO " +
                      Digits(FiguresOf(lens).f_number) +
                      "\nDIM   M\nWL    656.3 587.6 486.1\nYAN 0.0 14.0\nSO 0.0 0.1e14\n";
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        out += "S " + Digits(surface.radius_mm) + " " + Digits(GapBehind(lens, i));
        if (surface.glass) {
            const auto [maker, name] = MakerAndName(*surface.glass);
            out += " " + name + "_" + maker;
        } else if (surface.nd && *surface.nd != 1.0) {
            out += " " + MadeUpGlass(*surface.nd, VNumberBehind(surface));
        }
        out += "  ! surface " + std::to_string(i) + "\n  CIR " + Digits(surface.semi_diameter_mm) +
               "; CCY 0\n";
        if (surface.kind == SurfaceKind::kStop) out += "  STO\n";
        if (surface.kind == SurfaceKind::kAsphere) {
            out += "  ASP\n  K " + Digits(surface.conic) + "\n";
            for (std::size_t k = 0; k < surface.asphere.size(); ++k) {
                out += "  " + std::string(1, static_cast<char>('A' + k)) + " " +
                       Digits(surface.asphere[k]) + "\n";
            }
        }
    }
    return out + "SI 0.0 0.0\nGO\n";
}

inline std::string OptilandText(const Prescription& lens) {
    const auto cs = [](const std::string& z) {
        return "\"cs\": {\"x\": 0.0, \"y\": 0.0, \"z\": " + z +
               ", \"rx\": 0.0, \"ry\": 0.0, \"rz\": 0.0}";
    };
    std::string out =
        "{\"version\": 1.0, \"aperture\": {\"type\": \"imageFNO\", \"value\": " +
        Digits(FiguresOf(lens).f_number) +
        "}, \"fields\": {\"fields\": [{\"field_type\": \"angle\", \"x\": 0.0, \"y\": 14}]},\n"
        "\"surface_group\": {\"surfaces\": [\n{\"type\": \"ObjectSurface\", \"geometry\": "
        "{\"type\": \"Plane\", " +
        cs("-Infinity") + ", \"radius\": Infinity}}";
    double z = 0.0;
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        std::string terms = "0.0";
        for (const double term : surface.asphere) terms += ", " + Digits(term);
        const std::string type = surface.radius_mm == 0.0  ? "Plane"
                                 : surface.asphere.empty() ? "StandardGeometry"
                                                           : "EvenAsphere";
        std::string material = "{\"type\": \"IdealMaterial\", \"index\": 1.0}";
        if (surface.glass) {
            const auto [maker, name] = MakerAndName(*surface.glass);
            material = "{\"type\": \"Material\", \"name\": \"" + name +
                       "\", \"filename\": "
                       "\"C:\\\\data\\\\glass\\\\" +
                       maker + "\\\\" + name + ".yml\"}";
        } else if (IndexBehind(surface) != 1.0) {
            material = "{\"type\": \"AbbeMaterial\", \"index\": " + Digits(IndexBehind(surface)) +
                       ", \"abbe\": " + Digits(VNumberBehind(surface)) + "}";
        }
        out += ",\n{\"type\": \"Surface\", \"geometry\": {\"type\": \"" + type + "\", " +
               cs(Digits(z)) + ", \"radius\": " +
               (surface.radius_mm == 0.0 ? "Infinity" : Digits(surface.radius_mm)) +
               ", \"conic\": " + Digits(surface.conic) + ", \"coefficients\": [" + terms +
               "]}, \"material_post\": " + material +
               ", \"is_stop\": " + (surface.kind == SurfaceKind::kStop ? "true" : "false") +
               ", \"aperture\": {\"type\": \"RadialAperture\", \"r_max\": " +
               Digits(surface.semi_diameter_mm) +
               "}, \"coating\": null, \"bsdf\": null, \"is_reflective\": false}";
        z += GapBehind(lens, i);
    }
    return out + ",\n{\"type\": \"Surface\", \"geometry\": {\"type\": \"Plane\", " + cs(Digits(z)) +
           ", \"radius\": Infinity}}]}}\n";
}

inline std::string RayOpticsText(const Prescription& lens) {
    const auto object = [](const std::string& module, const std::string& type,
                           const std::string& attributes) {
        return "{\"__instance_type__\": [\"" + module + "\", \"" + type + "\"], \"attributes\": {" +
               attributes + "}}";
    };
    const auto face = [&](double semi, const std::string& id) {
        return object("rayoptics.elem.surface", "Surface",
                      "\"interact_mode\": \"transmit\", \"decenter\": null, \"max_aperture\": " +
                          Digits(semi) + ", \"clear_apertures\": [], \"profile_id\": \"" + id +
                          "\"");
    };
    const std::string air = object("opticalglass.opticalmedium", "Air", "");
    std::string faces = face(1e9, "o"),
                profiles = "\"o\": " + object("p", "Spherical", "\"cv\": 0.0");
    std::string gaps = object("g", "Gap", "\"thi\": 10000000000.0, \"medium\": " + air);
    std::size_t stop = 0;
    for (std::size_t i = 0; i < lens.optical_count(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        if (surface.kind == SurfaceKind::kStop) stop = i + 1;
        const std::string id = std::to_string(i);
        const std::string curvature =
            "\"cv\": " + Digits(surface.radius_mm == 0.0 ? 0.0 : 1.0 / surface.radius_mm);
        std::string terms = "0.0";
        for (const double term : surface.asphere) terms += ", " + Digits(term);
        profiles += ", \"" + id + "\": " +
                    (surface.kind == SurfaceKind::kAsphere
                         ? object("p", "EvenPolynomial",
                                  curvature + ", \"cc\": " + Digits(surface.conic) +
                                      ", \"coefs\": [" + terms + "]")
                         : object("p", "Spherical", curvature));
        faces += ",\n" + face(surface.semi_diameter_mm, id);
        std::string medium = air;
        if (surface.glass) {
            const auto [maker, name] = MakerAndName(*surface.glass);
            std::string module = maker;
            for (char& c : module) c = static_cast<char>(std::tolower(c));
            medium = object("opticalglass." + module, "Glass", "\"gname\": \"" + name + "\"");
        } else if (IndexBehind(surface) != 1.0) {
            medium = object("opticalglass.modelglass", "ModelGlass",
                            "\"label\": \"x\", \"n\": " + Digits(IndexBehind(surface)) +
                                ", \"v\": " + Digits(VNumberBehind(surface)));
        }
        gaps +=
            ",\n" + object("g", "Gap",
                           "\"thi\": " + Digits(GapBehind(lens, i)) + ", \"medium\": " + medium);
    }
    faces += ",\n" + face(20.0, "o");
    const std::string sequence =
        object("s", "SequentialModel",
               "\"ifcs\": [" + faces + "],\n\"gaps\": [" + gaps +
                   "],\n\"stop_surface\": " + std::to_string(stop) + ", \"z_dir\": [1]");
    return "{\"optical_model\": " +
           object("rayoptics.optical.opticalmodel", "OpticalModel",
                  "\"specsheet\": {\"imager\": [-0.0, -Infinity, NaN]},\n\"seq_model\": " +
                      sequence + ",\n\"profile_dict\": {" + profiles + "}") +
           "}\n";
}

struct ForeignFormat {
    const char* name;
    std::function<std::string(const Prescription&)> write;
    bool aspheres;  // does it have a place for them?
    bool v_numbers;
};

inline const std::array<ForeignFormat, 10>& ForeignFormats() {
    static const std::array<ForeignFormat, 10> formats = {{
        {"zemax", ZemaxText, true, true},
        {"codev", CodeVText, true, true},
        {"pbrt", PbrtText, false, false},
        {"table", TableText, false, true},
        {"flaresim", [](const Prescription& lens) { return FlareSimText(lens); }, false, true},
        {"openlensflare", OpenLensFlareText, false, true},
        {"realflare", RealflareText, false, true},
        {"lentil", LentilText, false, true},
        {"optiland", OptilandText, true, true},
        {"rayoptics", RayOpticsText, true, true},
    }};
    return formats;
}

}  // namespace flare::testing
