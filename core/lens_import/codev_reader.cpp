// SPDX-License-Identifier: Apache-2.0
//
// CODE V's .seq: commands, several on a line between semicolons, '!' before a comment, '&' at the
// end of a line that goes on. "S r t glass" adds a surface; r is a radius after RDM, a curvature
// after RDM N. What follows up to the next S belongs to it. A command that would change a surface
// and is not read here is an error; others are listed.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/glass_names.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

constexpr double kFarAway = 1e9;

// Cuts a line at semicolons and its comment off, both outside quotes.
std::vector<std::string> CommandsOf(std::string_view line) {
    std::vector<std::string> commands(1);
    char quote = 0;
    for (const char c : line) {
        if (quote == 0 && c == '!') break;
        if (quote == 0 && c == ';') {
            commands.emplace_back();
            continue;
        }
        if (c == '\'' || c == '"') quote = quote == 0 ? c : (quote == c ? '\0' : quote);
        commands.back() += c;
    }
    return commands;
}

bool In(const std::set<std::string, std::less<>>& words, const std::string& word) {
    return words.count(word) > 0;
}

// "517.642", "517642" or "516800.641673": the digits of n - 1 and of V.
std::optional<std::pair<double, double>> FictitiousGlass(std::string_view word) {
    const auto digits = [](std::string_view text) {
        return !text.empty() && text.size() <= 12 &&
               std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
    };
    const std::size_t dot = word.find('.');
    std::string_view index = word.substr(0, dot);
    std::string_view v = dot == std::string_view::npos ? "" : word.substr(dot + 1);
    if (dot == std::string_view::npos && word.size() == 6) {
        index = word.substr(0, 3);
        v = word.substr(3);
    }
    if (!digits(index) || !digits(v) || index.size() < 3 || v.size() < 3) return std::nullopt;
    return std::pair(1.0 + *NumberIn(index) * std::pow(10.0, -static_cast<double>(index.size())),
                     *NumberIn(v) * std::pow(10.0, 2.0 - static_cast<double>(v.size())));
}

class CodeVReader {
  public:
    Result<LensDraft> Read(std::string_view text) {
        std::string joined;
        int first_line = 0;
        for (const TextLine& line : LinesOf(text)) {
            if (joined.empty()) first_line = line.number;
            joined += line.text;
            if (joined.back() == '&') {
                joined.back() = ' ';
                continue;
            }
            for (const std::string& command : CommandsOf(joined)) {
                if (const std::optional<Error> error = Run(command, first_line)) return *error;
            }
            joined.clear();
        }
        if (!image_seen_) return Error{"bad_lens", "the file has no image surface (SI)", ""};
        if (draft_.lens.surfaces.empty()) {
            return Error{"bad_lens", "the file has no surfaces between object and image", ""};
        }
        return Draft();
    }

  private:
    using Words = std::vector<std::string_view>;

    std::optional<Error> Run(const std::string& command, int line) {
        const Words words = WordsOf(command);
        if (words.empty()) return std::nullopt;
        const std::string full = UpperCase(words.front());
        const std::string word = full.substr(0, 3);
        if (in_private_catalogue_) {
            in_private_catalogue_ = full != "END";
            return std::nullopt;
        }
        if (full == "S" || full == "SO" || full == "SI") return AddSurface(full, words, line);
        if (word == "S0" ||
            (full.size() > 1 && full[0] == 'S' && full[1] >= '0' && full[1] <= '9')) {
            return Error{"unsupported", "surfaces must be given in their order, by S",
                         LinePlace(line)};
        }
        if (full.size() == 1 || In({"ASP", "CON", "SPH", "STO", "CIR"}, word)) {
            return OfSurface(full.size() == 1 ? full : word, words, line);
        }
        return OfLens(word, words, command, line);
    }

    std::optional<Error> AddSurface(const std::string& which, const Words& words, int line) {
        double numbers[2] = {0.0, 0.0};
        for (std::size_t i = 1; i <= 2 && i < words.size(); ++i) {
            const Result<double> number =
                RequireNumber(words[i], i == 1 ? "the radius" : "the thickness", line);
            if (!number) return number.error();
            numbers[i - 1] = *number;
        }
        in_image_ = image_seen_ = which == "SI";
        in_object_ = which == "SO";
        if (which == "SO") {
            if (numbers[1] < kFarAway) {
                draft_.Remark("The object's distance, " + NumberText(numbers[1]) +
                              ", is not carried over: light comes from infinity.");
            }
            return std::nullopt;
        }
        if (which == "SI") {
            if (numbers[1] != 0.0 && !draft_.lens.surfaces.empty()) {
                draft_.lens.surfaces.back().gap_mm += numbers[1];
                draft_.Remark("The image's defocus of " + NumberText(numbers[1]) +
                              " was added to the last gap.");
            }
            return std::nullopt;
        }
        if (draft_.lens.surfaces.size() > static_cast<std::size_t>(2 * kMaxSurfaces)) {
            return Error{"bad_lens",
                         "a lens has at most " + std::to_string(kMaxSurfaces) +
                             " surfaces; this file has more than twice that",
                         LinePlace(line)};
        }
        SurfacePrescription surface;
        surface.where = LinePlace(line);
        // Radii or curvatures: known when all is read, since RDM may stand anywhere above.
        surface.radius_mm = numbers[0];
        surface.gap_mm = numbers[1];
        surface.gap_given = true;
        if (words.size() > 3) {
            if (const std::optional<Error> error = SetGlass(words[3], surface, line)) return error;
        }
        draft_.lens.surfaces.push_back(std::move(surface));
        as_radii_.push_back(radii_.value_or(false));
        return std::nullopt;
    }

    std::optional<Error> SetGlass(std::string_view word, SurfacePrescription& surface, int line) {
        const std::string glass = UpperCase(word);
        if (glass == "AIR") return std::nullopt;
        if (glass == "REFL" || glass == "MIR" || glass == "TIRO") {
            return Error{"unsupported",
                         "surface " + std::to_string(draft_.lens.surfaces.size() + 1) +
                             " is a mirror: lenses with mirrors cannot be traced",
                         LinePlace(line)};
        }
        if (const auto made_up = FictitiousGlass(glass)) {
            SetMedium(surface, made_up->first, made_up->second);
            return std::nullopt;
        }
        const std::size_t gap = glass.rfind('_');
        std::vector<std::string> makers;
        if (gap != std::string::npos) makers.push_back(glass.substr(gap + 1));
        const Result<std::string> name = CatalogueName(glass.substr(0, gap), makers);
        if (!name) return Error{"bad_lens", name.error().message, LinePlace(line)};
        surface.glass = *name;
        return std::nullopt;
    }

    std::optional<Error> OfSurface(const std::string& word, const Words& words, int line) {
        if (word == "STO" && words.size() > 1) return StopAt(words[1], line);
        if (in_image_) return std::nullopt;
        if (draft_.lens.surfaces.empty() || in_object_) {
            return Error{"bad_lens", Quoted(word) + " stands before the first surface",
                         LinePlace(line)};
        }
        SurfacePrescription& surface = draft_.lens.surfaces.back();
        if (word == "STO") {
            draft_.stop_on = draft_.lens.surfaces.size() - 1;
        } else if (word == "ASP" || word == "CON") {
            surface.kind = SurfaceKind::kAsphere;
        } else if (word == "CIR") {
            return ReadRim(words, line);
        } else if (word != "SPH") {
            return ReadAsphere(word[0], words, line);
        }
        return std::nullopt;
    }

    std::optional<Error> StopAt(std::string_view word, int line) {
        const std::optional<double> number = word.size() > 1 && (word[0] == 'S' || word[0] == 's')
                                                 ? NumberIn(word.substr(1))
                                                 : std::nullopt;
        if (!number || *number < 1.0 ||
            *number > static_cast<double>(draft_.lens.surfaces.size())) {
            return Error{"bad_lens", "STO names " + Quoted(word) + ", which is no surface above",
                         LinePlace(line)};
        }
        draft_.stop_on = static_cast<std::size_t>(*number) - 1;
        return std::nullopt;
    }

    std::optional<Error> ReadRim(const Words& words, int line) {
        std::size_t at = 1;
        bool edge = false;
        while (at < words.size() && !NumberIn(words[at])) {
            const std::string kind = UpperCase(words[at++]);
            if (kind == "OBS" || kind == "HOL") {
                unread_.insert("CIR " + kind);
                return std::nullopt;
            }
            edge = edge || kind == "EDG";
        }
        const Result<double> semi =
            RequireNumber(at < words.size() ? words[at] : "", "the aperture", line);
        if (!semi) return semi.error();
        SurfacePrescription& surface = draft_.lens.surfaces.back();
        // The edge of an element serves where no clear aperture is given.
        if (!edge || surface.semi_diameter_mm == 0.0) surface.semi_diameter_mm = *semi;
        return std::nullopt;
    }

    // K is the conic constant; A, B, C, ... the terms of r^4, r^6, r^8, ...
    std::optional<Error> ReadAsphere(char letter, const Words& words, int line) {
        const Result<double> value = RequireNumber(words.size() > 1 ? words[1] : "",
                                                   "the term " + Quoted({&letter, 1}), line);
        if (!value) return value.error();
        SurfacePrescription& surface = draft_.lens.surfaces.back();
        if (letter == 'K') {
            surface.conic = *value;
        } else if (letter >= 'A' && letter <= 'H') {
            const auto place = static_cast<std::size_t>(letter - 'A');
            surface.asphere.resize(std::max(surface.asphere.size(), place + 1));
            surface.asphere[place] = *value;
        } else if (*value != 0.0) {
            return Error{"unsupported", "the term " + Quoted({&letter, 1}) + " cannot be read",
                         LinePlace(line)};
        }
        return std::nullopt;
    }

    std::optional<Error> OfLens(const std::string& word, const Words& words,
                                const std::string& command, int line) {
        // These move or bend a surface in ways that would be lost.
        static const std::set<std::string, std::less<>> kChanging = {
            "THI", "RDY", "RDX", "CUY", "CUX", "GLA", "XDE", "YDE", "ZDE", "ADE", "BDE", "CDE",
            "DAR", "BEN", "REV", "RET", "CYL", "XTO", "YTO", "AAS", "XAS", "SPS", "DIF", "GRT",
            "HOE", "FRE", "MIR", "INS", "DEL", "FLY", "SCA", "NSS", "GRN", "LCS", "PAR"};
        if (In(kChanging, word)) {
            return Error{"unsupported",
                         "the command " + Quoted(words.front()) +
                             " is not read, and without it this would be another lens",
                         LinePlace(line)};
        }
        const std::optional<double> value = words.size() > 1 ? NumberIn(words[1]) : std::nullopt;
        if (word == "RDM") {
            radii_ = words.size() < 2 || UpperCase(words[1]) != "N";
        } else if (word == "TIT") {
            const std::size_t begin = command.find_first_of("'\"");
            if (begin != std::string::npos) {
                const std::size_t end = command.find_last_of("'\"");
                draft_.title =
                    command.substr(begin + 1, end - begin - std::min<std::size_t>(1, end - begin));
            }
        } else if (word == "EPD") {
            draft_.pupil_mm = value;
        } else if (word == "FNO") {
            draft_.f_number = value;
        } else if (word == "DIM") {
            const std::string unit = words.size() > 1 ? UpperCase(words[1]) : "M";
            unit_mm_ = unit == "I" ? 25.4 : unit == "C" ? 10.0 : 1.0;
        } else if (In({"XAN", "YAN", "XIM", "YIM", "XRI", "YRI"}, word)) {
            std::optional<double>& field =
                word[1] == 'A' ? draft_.field_deg : draft_.image_height_mm;
            for (std::size_t i = 1; i < words.size(); ++i) {
                const double at = std::abs(NumberIn(words[i]).value_or(0.0));
                if (at > field.value_or(0.0)) field = at;
            }
        } else if (word == "ZOO") {
            draft_.Remark("The file zooms; its first position is read.");
        } else if (word == "PRV") {
            in_private_catalogue_ = true;
            draft_.Remark("The private catalogue (PRV) is not read.");
        } else if (!In({"LEN", "WL",  "REF", "WTW", "INI", "WTF", "VUX", "VUY", "VLX", "VLY",
                        "GO",  "CCY", "CCX", "THC", "PIM", "DER", "SLB", "TEM", "GLC", "PRE",
                        "CUM", "PIK", "END", "CA",  "OUT", "RES", "WRI", "DSP"},
                       word)) {
            unread_.insert(Quoted(words.front()));
        }
        return std::nullopt;
    }

    Result<LensDraft> Draft() {
        std::vector<SurfacePrescription>& surfaces = draft_.lens.surfaces;
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            SurfacePrescription& surface = surfaces[i];
            if (!as_radii_[i] && surface.radius_mm != 0.0) {
                surface.radius_mm = 1.0 / surface.radius_mm;
            }
            const bool bent = !surface.asphere.empty() || surface.conic != 0.0;
            if (!bent && surface.kind == SurfaceKind::kAsphere) surface.kind = SurfaceKind::kSphere;
            if (bent) surface.kind = SurfaceKind::kAsphere;
        }
        if (!radii_) draft_.Remark("RDM is not in the file: its numbers were read as curvatures.");
        DropDummies(draft_);
        ScaleLengths(draft_, unit_mm_);
        draft_.lens.design_f_number = draft_.f_number;
        RemarkUnread(draft_, unread_);
        RemarkBare(draft_);
        return std::move(draft_);
    }

    LensDraft draft_;
    std::vector<bool> as_radii_;
    std::optional<bool> radii_;
    bool image_seen_ = false, in_image_ = false, in_object_ = false, in_private_catalogue_ = false;
    std::set<std::string> unread_;
    double unit_mm_ = 1.0;
};

}  // namespace

Result<LensDraft> ReadCodeV(std::string_view text) {
    return CodeVReader().Read(text);
}

}  // namespace flare
