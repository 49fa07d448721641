// SPDX-License-Identifier: Apache-2.0
//
// Zemax's sequential .zmx: lines of a keyword and its values, those of a surface behind its SURF.
// Surface 0 is the object and the last one the image; both go. A solve leaves its latest value in
// the file, and that is what is read. Keywords that only steer analyses, tolerances or drawings are
// passed over; all others that are not read are listed.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/glass_names.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// A thickness above this is an object at infinity.
constexpr double kFarAway = 1e9;

struct ZemaxSurface {
    int line = 0;
    std::string type = "STANDARD", glass;
    bool stop = false, model_glass = false, rim_fixed = false;
    double curvature = 0.0, conic = 0.0, thickness = 0.0, semi = 0.0;
    double model_nd = 0.0, model_vd = 0.0;
    std::map<int, double> parameters;
};

// What does not touch the lens: program version, wavelengths, rays, drawing, glass map, solves.
bool OnlySettings(const std::string& keyword) {
    static const std::set<std::string, std::less<>> kSettings = {
        "VERS", "MODE", "PFIL", "LANG",        "ENVD", "GFAC", "RAIM", "PUSH", "SDMA", "OMMA",
        "ROPD", "PICB", "FWGN", "VDXN",        "VDYN", "VCXN", "VCYN", "VANN", "WAVM", "WAVL",
        "WWGT", "PWAV", "POLS", "GLRS",        "GSTD", "NSCD", "COFN", "FIMP", "HIDE", "SLAB",
        "POPS", "MEMA", "TOL",  "MOFF",        "COMM", "NOTE", "MIRR", "PZUP", "FCOM", "BLNK",
        "EFFL", "WAVN", "WFNO", "SCOL",        "DMFS", "OPDX", "RSCE", "RSCH", "RSRE", "RSRH",
        "CONF", "EFL",  "LTGT", "TRAC",        "SPID", "CRAY", "CRSR", "PRAM", "RIMS", "HYPR",
        "XFLD", "PIPA", "RWRE", "DEFA",        "DLTX", "DLTY", "FLAP", "NSOO", "GLCZ", "DMVA",
        "CFSB", "MNCA", "MNCG", "MNEA",        "MNEG", "MXCA", "MXCG", "MXEA", "MXEG", "TCMM",
        "SCAT", "OPTH", "RECL", "XDAT_PICKUP", "UNIT"};
    return kSettings.count(keyword) > 0;
}

class ZemaxReader {
  public:
    Result<LensDraft> Read(std::string_view text) {
        for (const TextLine& line : LinesOf(text)) {
            const std::vector<std::string_view> words = WordsOf(line.text);
            const std::string keyword = UpperCase(words.front());
            const std::optional<Error> error =
                keyword == "SURF" ? Begin(line, words) : ReadHeader(line, keyword, words);
            if (error) return *error;
        }
        if (surfaces_.size() < 3) {
            return Error{"bad_lens", "the file has no surfaces between object and image", ""};
        }
        return Draft();
    }

  private:
    std::optional<Error> Begin(const TextLine& line, const std::vector<std::string_view>& words) {
        const std::optional<double> number = words.size() > 1 ? NumberIn(words[1]) : std::nullopt;
        if (number != static_cast<double>(surfaces_.size())) {
            return Error{"bad_lens",
                         "SURF " + std::to_string(surfaces_.size()) + " should stand here, not " +
                             Quoted(line.text),
                         LinePlace(line.number)};
        }
        // Object and image are not the lens's, and dummies may still go.
        if (surfaces_.size() > static_cast<std::size_t>(2 * kMaxSurfaces)) {
            return Error{"bad_lens",
                         "a lens has at most " + std::to_string(kMaxSurfaces) +
                             " surfaces; this file has more than twice that",
                         LinePlace(line.number)};
        }
        surfaces_.emplace_back().line = line.number;
        return std::nullopt;
    }

    static Error Unsupported(const std::string& what, int line) {
        return {"unsupported", what, LinePlace(line)};
    }

    std::optional<Error> ReadHeader(const TextLine& line, const std::string& keyword,
                                    const std::vector<std::string_view>& words) {
        if (!surfaces_.empty() && ReadsInSurface(keyword)) {
            return ReadSurface(line, keyword, words);
        }
        const auto value = [&](std::size_t i) {
            return i < words.size() ? NumberIn(words[i]) : std::nullopt;
        };
        if (keyword == "MODE" && words.size() > 1 && UpperCase(words[1]) != "SEQ") {
            return Unsupported("the file is not sequential (MODE " + Quoted(words[1]) + ")",
                               line.number);
        } else if (keyword == "NAME") {
            draft_.title =
                std::string(line.text.substr(std::min<std::size_t>(5, line.text.size())));
        } else if (keyword == "UNIT") {
            return ReadUnit(line, words);
        } else if (keyword == "GCAT") {
            for (std::size_t i = 1; i < words.size(); ++i) {
                makers_.push_back(UpperCase(words[i].substr(0, words[i].find('_'))));
            }
        } else if (keyword == "FNUM") {
            draft_.f_number = value(1);
        } else if (keyword == "ENPD") {
            draft_.pupil_mm = value(1);
        } else if (keyword == "FLOA" || keyword == "FTYP") {
            if (keyword == "FTYP") field_type_ = value(1).value_or(0.0);
        } else if (keyword == "XFLN" || keyword == "YFLN") {
            for (std::size_t i = 1; i < words.size(); ++i) {
                largest_field_ = std::max(largest_field_, std::abs(value(i).value_or(0.0)));
            }
        } else if (keyword == "MNUM" && value(1).value_or(1.0) > 1.0) {
            draft_.Remark("The file has " + NumberText(*value(1)) +
                          " configurations; the first is read.");
        } else if (!OnlySettings(keyword) && keyword != "MNUM") {
            unread_.insert(Quoted(keyword));
        }
        return std::nullopt;
    }

    std::optional<Error> ReadUnit(const TextLine& line,
                                  const std::vector<std::string_view>& words) {
        static constexpr std::array<std::pair<std::string_view, double>, 5> kUnits = {
            {{"MM", 1.0}, {"CM", 10.0}, {"IN", 25.4}, {"METER", 1000.0}, {"M", 1000.0}}};
        const std::string unit = words.size() > 1 ? UpperCase(words[1]) : "";
        for (const auto& [name, mm] : kUnits) {
            if (unit == name) {
                unit_mm_ = mm;
                return std::nullopt;
            }
        }
        return Error{"bad_lens", "the unit " + Quoted(unit) + " is not known",
                     LinePlace(line.number)};
    }

    static bool ReadsInSurface(const std::string& keyword) {
        static const std::set<std::string, std::less<>> kRead = {
            "TYPE", "CURV", "CONI", "PARM", "DISZ", "GLAS", "DIAM", "STOP", "CLAP", "XDAT",
            "COAT", "OBSC", "SQAP", "SQOB", "ELAP", "ELOB", "UDAP", "UDAD", "UDOB"};
        return kRead.count(keyword) > 0;
    }

    std::optional<Error> ReadSurface(const TextLine& line, const std::string& keyword,
                                     const std::vector<std::string_view>& words) {
        ZemaxSurface& surface = surfaces_.back();
        if (keyword == "STOP") {
            surface.stop = true;
        } else if (keyword == "TYPE") {
            surface.type = words.size() > 1 ? UpperCase(words[1]) : "";
        } else if (keyword == "GLAS") {
            return ReadGlass(line, words);
        } else if (keyword == "DISZ" && words.size() > 1 && UpperCase(words[1]) == "INFINITY") {
            surface.thickness = kFarAway * 10.0;
        } else if (keyword == "CURV" || keyword == "CONI" || keyword == "DISZ" ||
                   keyword == "DIAM" || keyword == "CLAP" || keyword == "PARM") {
            const bool second = keyword == "CLAP" || keyword == "PARM";
            const std::size_t at = second ? 2 : 1;
            const Result<double> value =
                RequireNumber(at < words.size() ? words[at] : "", keyword, line.number);
            if (!value) return value.error();
            return Take(surface, keyword, *value, words, line);
        } else {
            // Obscurations, odd apertures, coatings by name, extra data.
            unread_.insert(Quoted(keyword) + " of surface " + std::to_string(surfaces_.size() - 1));
        }
        return std::nullopt;
    }

    static std::optional<Error> Take(ZemaxSurface& surface, const std::string& keyword,
                                     double value, const std::vector<std::string_view>& words,
                                     const TextLine& line) {
        if (keyword == "CURV") surface.curvature = value;
        if (keyword == "CONI") surface.conic = value;
        if (keyword == "DISZ") surface.thickness = value;
        if (keyword == "DIAM" && !surface.rim_fixed) {
            surface.semi = value;
            surface.rim_fixed = words.size() > 2 && words[2] == "1";
        }
        if (keyword == "CLAP") {
            surface.semi = value;
            surface.rim_fixed = true;
        }
        if (keyword == "PARM") {
            const Result<double> number = RequireNumber(words[1], "PARM's number", line.number);
            if (!number) return number.error();
            if (*number >= 0.0 && *number <= 100.0) {
                surface.parameters[static_cast<int>(*number)] = value;
            }
        }
        return std::nullopt;
    }

    std::optional<Error> ReadGlass(const TextLine& line,
                                   const std::vector<std::string_view>& words) {
        ZemaxSurface& surface = surfaces_.back();
        surface.glass = words.size() > 1 ? UpperCase(words[1]) : "";
        if (surface.glass == "MIRROR") {
            return Unsupported("surface " + std::to_string(surfaces_.size() - 1) +
                                   " is a mirror: lenses with mirrors cannot be traced",
                               line.number);
        }
        surface.model_glass = words.size() > 2 && words[2] == "1";
        const auto value = [&](std::size_t i) {
            return i < words.size() ? NumberIn(words[i]).value_or(0.0) : 0.0;
        };
        surface.model_nd = value(4);
        surface.model_vd = value(5);
        return std::nullopt;
    }

    // Stands in the line of many a glass that has nothing to do with it.
    static bool DefaultModel(const ZemaxSurface& from) {
        return from.model_nd <= 1.0 || (from.model_nd == 1.5 && from.model_vd == 40.0);
    }

    std::optional<Error> SetGlass(const ZemaxSurface& from, SurfacePrescription& to) {
        if (from.glass.empty()) return std::nullopt;
        if (from.model_glass) {
            SetMedium(to, from.model_nd, from.model_vd);
            return std::nullopt;
        }
        const Result<std::string> name = CatalogueName(from.glass, makers_);
        if (name.ok()) {
            to.glass = *name;
        } else if (DefaultModel(from)) {
            return Error{"bad_lens", name.error().message, LinePlace(from.line)};
        } else {
            SetMedium(to, from.model_nd, from.model_vd);
            draft_.Remark(name.error().message + "; its n_d and V_d from the file were taken.");
        }
        return std::nullopt;
    }

    // The even asphere's terms: PARM 1 is of r^2, 2 of r^4, ...
    std::optional<Error> SetShape(const ZemaxSurface& from, SurfacePrescription& to) {
        to.radius_mm = from.curvature == 0.0 ? 0.0 : 1.0 / from.curvature;
        if (!std::isfinite(to.radius_mm)) to.radius_mm = 0.0;
        const bool even = from.type == "EVENASPH";
        if (!even && from.type != "STANDARD") {
            return Unsupported("surfaces of TYPE " + Quoted(from.type) + " cannot be read",
                               from.line);
        }
        bool departs = false;
        if (even) {
            for (const auto& [number, value] : from.parameters) {
                if (value == 0.0 || number < 1) continue;
                if (number == 1) {
                    return Unsupported("the term of r^2 (PARM 1) cannot be read", from.line);
                }
                if (number > 8) {
                    return Unsupported("an even asphere has terms up to PARM 8", from.line);
                }
                to.asphere.resize(
                    std::max(to.asphere.size(), static_cast<std::size_t>(number) - 1));
                to.asphere[static_cast<std::size_t>(number) - 2] = value;
                departs = true;
            }
        }
        if (departs || (from.conic != 0.0 && to.radius_mm != 0.0)) {
            to.kind = SurfaceKind::kAsphere;
            to.conic = from.conic;
        }
        return std::nullopt;
    }

    Result<LensDraft> Draft() {
        if (surfaces_.front().thickness < kFarAway) {
            draft_.Remark("The object's distance, " + NumberText(surfaces_.front().thickness) +
                          ", is not carried over: light comes from infinity.");
        }
        for (std::size_t i = 1; i + 1 < surfaces_.size(); ++i) {
            const ZemaxSurface& from = surfaces_[i];
            SurfacePrescription to;
            to.where = LinePlace(from.line);
            if (const std::optional<Error> error = SetShape(from, to)) return *error;
            if (const std::optional<Error> error = SetGlass(from, to)) return *error;
            to.gap_mm = from.thickness;
            to.gap_given = true;
            // A rim that the program worked out is as good as any, unless nothing is there.
            const bool dummy = from.glass.empty() && surfaces_[i - 1].glass.empty();
            to.semi_diameter_mm = dummy && !from.rim_fixed && !from.stop ? 0.0 : from.semi;
            if (from.stop) draft_.stop_on = i - 1;
            draft_.lens.surfaces.push_back(std::move(to));
        }
        DropDummies(draft_);
        if (field_type_ == 0.0 && largest_field_ > 0.0) draft_.field_deg = largest_field_;
        if (field_type_ >= 2.0 && largest_field_ > 0.0) draft_.image_height_mm = largest_field_;
        ScaleLengths(draft_, unit_mm_);
        draft_.lens.design_f_number = draft_.f_number;
        RemarkUnread(draft_, unread_);
        RemarkBare(draft_);
        return std::move(draft_);
    }

    LensDraft draft_;
    std::vector<ZemaxSurface> surfaces_;
    std::vector<std::string> makers_;
    std::set<std::string> unread_;
    double unit_mm_ = 1.0, field_type_ = 0.0, largest_field_ = 0.0;
};

}  // namespace

Result<LensDraft> ReadZemax(std::string_view text) {
    return ZemaxReader().Read(text);
}

}  // namespace flare
