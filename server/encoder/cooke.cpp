// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/cooke.h"

#include <charconv>
#include <limits>

namespace flare {
namespace {

constexpr std::uint32_t kPackedInfinity = 0xffffff;
constexpr int kTextInfinity = 9'999'999;  // as far as seven digits go
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Error Bad(std::string message) {
    return {"bad_data", std::move(message), ""};
}

// Reads a line from the left, field by field.
class Fields {
  public:
    explicit Fields(std::string_view line) : line_(line) {}

    bool ok() const { return ok_; }
    std::string_view rest() const { return line_; }

    Fields& Tag(std::string_view tags) {
        const std::string_view tag = Take(1);
        if (ok_ && tags.find(tag.front()) == std::string_view::npos) ok_ = false;
        return *this;
    }
    Fields& Number(std::size_t digits, int& value) {
        const std::string_view text = Take(digits);
        const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
        ok_ = ok_ && failed == std::errc() && end == text.data() + text.size() && value >= 0;
        return *this;
    }
    Fields& Text(std::size_t size, std::string& value) {
        value = Take(size);
        return *this;
    }
    Fields& Skip(std::size_t size) {
        Take(size);
        return *this;
    }
    // Characters 40 to 7F of six bits each, the most significant first.
    Fields& Packed(std::size_t size, std::uint32_t& value) {
        value = 0;
        for (const char c : Take(size)) {
            const auto byte = static_cast<unsigned char>(c);
            ok_ = ok_ && (byte & 0xc0U) == 0x40U;
            value = value << 6 | (byte & 0x3fU);
        }
        return *this;
    }

  private:
    std::string_view Take(std::size_t size) {
        if (line_.size() < size) {
            ok_ = false;
            line_ = {};
        }
        if (!ok_) return {};
        const std::string_view taken = line_.substr(0, size);
        line_.remove_prefix(size);
        return taken;
    }

    std::string_view line_;
    bool ok_ = true;
};

// "S5/100-009": nine characters, or, of older lenses, nothing.
bool ReadSerial(std::string_view rest, std::string& serial) {
    if (rest.empty()) return true;
    if (rest.front() != 'S' || rest.size() > 10) return false;
    serial = rest.substr(1);
    return true;
}

}  // namespace

std::array<char, 2> CookeChecksum(std::string_view text) {
    unsigned sum = 0xff;
    for (const char c : text) sum ^= static_cast<unsigned char>(c);
    return {static_cast<char>(0x40U | sum >> 4), static_cast<char>(0x40U | (sum & 0xfU))};
}

Result<std::string_view> CheckCookeChecksum(std::string_view line) {
    if (line.size() < 2) return Bad("shorter than a checksum");
    const std::string_view text = line.substr(0, line.size() - 2);
    const std::array<char, 2> sum = CookeChecksum(text);
    if (line.substr(text.size()) != std::string_view(sum.data(), sum.size())) {
        return Bad("the checksum of the lens's answer is wrong");
    }
    return text;
}

Result<CookeLens> DecodeCookeLens(std::string_view line) {
    CookeLens lens;
    std::string type, units;
    Fields fields(line);
    fields.Tag("N").Tag("S").Text(9, lens.serial).Tag("O").Text(31, lens.owner);
    fields.Tag("L").Text(1, type).Tag("NF").Number(3, lens.focal_mm).Tag("MN");
    std::string longest;
    fields.Text(3, longest).Tag("U").Text(1, units);
    if (!fields.ok() || (type != "P" && type != "Z") ||
        std::string_view("IMbB").find(units) == std::string_view::npos) {
        return Bad("not the fixed data of a lens");
    }
    lens.zoom = type == "Z";
    lens.longest_focal_mm = lens.focal_mm;
    if (lens.zoom && !Fields(longest).Number(3, lens.longest_focal_mm).ok()) {
        return Bad("not the fixed data of a lens");
    }
    lens.imperial = units == "I" || units == "B";
    return lens;
}

Result<CookeRecord> DecodeCookeText(std::string_view line) {
    CookeRecord record;
    int focus = 0, t_hundredths = 0;
    Fields fields(line);
    fields.Tag("D").Number(7, focus).Tag("T").Number(4, t_hundredths).Tag("t").Skip(5);
    fields.Tag("Z").Number(4, record.zoom_mm).Tag("H").Skip(7).Tag("N").Skip(7).Tag("F").Skip(7);
    fields.Tag("V").Skip(5).Tag("E").Skip(4);
    // Older lenses have no normalised zoom.
    if (fields.ok() && fields.rest().starts_with('z')) fields.Skip(5);
    if (!fields.ok() || !ReadSerial(fields.rest(), record.serial) || t_hundredths == 0) {
        return Bad("not a record of a lens's state");
    }
    record.focus = focus >= kTextInfinity ? kInfinity : focus;
    record.t_stop = t_hundredths / 100.0;
    return record;
}

Result<CookeRecord> DecodeCookePacked(std::string_view line) {
    CookeRecord record;
    std::uint32_t focus = 0, t_hundredths = 0, zoom_mm = 0;
    Fields fields(line);
    fields.Tag("d").Packed(4, focus).Packed(2, t_hundredths).Skip(2).Packed(2, zoom_mm);
    fields.Skip(4 + 4 + 4 + 2 + 2);
    if (fields.ok() && !fields.rest().starts_with('S')) fields.Skip(2);
    if (!fields.ok() || !ReadSerial(fields.rest(), record.serial) || t_hundredths == 0) {
        return Bad("not a packed record of a lens's state");
    }
    record.focus = focus == kPackedInfinity ? kInfinity : focus;
    record.t_stop = t_hundredths / 100.0;
    record.zoom_mm = static_cast<int>(zoom_mm);
    return record;
}

double CookeFocus_m(const CookeRecord& record, bool imperial) {
    return imperial ? record.focus * 0.00254 : record.focus / 1000.0;
}

}  // namespace flare
