// SPDX-License-Identifier: Apache-2.0
//
// One table says which kinds know which key; a key that its kind does not know is an error, as is
// one that is missing.
#include "server/config_encoders.h"

#include <algorithm>
#include <cmath>

#include "protocol/limits.h"

namespace flare {
namespace {

constexpr int kOpenTrackIoPort = 55'555;
constexpr double kMaxWait_ms = 3.6e6;
constexpr int kMostIndex = 1'000'000'000;

Error BadConfig(std::string message, const toml::source_region& source) {
    return {"bad_config", std::move(message), WhereOf(source)};
}

constexpr unsigned Of(EncoderKind kind) {
    return 1U << static_cast<unsigned>(kind);
}
constexpr unsigned kAnyKind = ~0U;
constexpr unsigned kUsb = Of(EncoderKind::kQsb) | Of(EncoderKind::kCooke) | Of(EncoderKind::kHid);
constexpr unsigned kUdp = Of(EncoderKind::kFreeD) | Of(EncoderKind::kOpenTrackIo);

struct KindsOfKey {
    std::string_view key;
    unsigned kinds;
    unsigned required = 0;
};
constexpr std::array kKeys{
    KindsOfKey{"name", kAnyKind, kAnyKind},
    KindsOfKey{"kind", kAnyKind, kAnyKind},
    KindsOfKey{"lens", kAnyKind},
    KindsOfKey{"stale_ms", kAnyKind},
    KindsOfKey{"focus", kAnyKind},
    KindsOfKey{"iris", kAnyKind},
    KindsOfKey{"zoom", kAnyKind},
    KindsOfKey{"file", Of(EncoderKind::kScript), Of(EncoderKind::kScript)},
    KindsOfKey{"loop", Of(EncoderKind::kScript)},
    KindsOfKey{"port", kUdp, Of(EncoderKind::kFreeD)},
    KindsOfKey{"address", kUdp},
    KindsOfKey{"multicast", kUdp},
    KindsOfKey{"camera_id", Of(EncoderKind::kFreeD)},
    KindsOfKey{"serial", kUsb, Of(EncoderKind::kCooke)},
    KindsOfKey{"vendor", kUsb, Of(EncoderKind::kHid)},
    KindsOfKey{"product", kUsb, Of(EncoderKind::kHid)},
    KindsOfKey{"axis", Of(EncoderKind::kQsb)},
    KindsOfKey{"index", Of(EncoderKind::kQsb)},
    KindsOfKey{"report", Of(EncoderKind::kHid)},
    KindsOfKey{"focus_field", Of(EncoderKind::kHid)},
    KindsOfKey{"iris_field", Of(EncoderKind::kHid)},
    KindsOfKey{"zoom_field", Of(EncoderKind::kHid)},
};

// Each Read returns what is wrong with the node, or "".
std::string Read(const toml::node& node, std::string& target) {
    const auto* text = node.as_string();
    if (!text || text->get().empty() || text->get().size() > limits::kNameBytes) {
        return "needs a string of at most " + std::to_string(limits::kNameBytes) + " bytes";
    }
    target = text->get();
    return "";
}

std::string Read(const toml::node& node, bool& target) {
    const auto* truth = node.as_boolean();
    if (!truth) return "needs true or false";
    target = truth->get();
    return "";
}

std::string Read(const toml::node& node, double low, double high, double& target) {
    const std::optional<double> number = node.value<double>();
    if (!node.is_number() || !number || !(*number >= low && *number <= high)) {
        char text[80];
        std::snprintf(text, sizeof text, "needs a number from %g to %g", low, high);
        return text;
    }
    target = *number;
    return "";
}

std::string ReadWhole(const toml::node& node, int low, int high, int& target) {
    const auto* number = node.as_integer();
    if (!number || number->get() < low || number->get() > high) {
        return "needs a whole number from " + std::to_string(low) + " to " + std::to_string(high);
    }
    target = static_cast<int>(number->get());
    return "";
}

std::string ReadNumbers(const toml::node& node, std::vector<double>& target) {
    const std::string needs =
        "needs an array of at most " + std::to_string(limits::kEncoderMarks) + " numbers";
    const toml::array* list = node.as_array();
    if (!list || list->size() > limits::kEncoderMarks) return needs;
    for (const toml::node& item : *list) {
        const std::optional<double> number = item.value<double>();
        if (!item.is_number() || !number) return needs;
        target.push_back(*number);
    }
    return "";
}

std::string ReadKind(const toml::node& node, EncoderKind& kind) {
    std::string name, names;
    for (const std::string_view known : kEncoderKindNames) {
        names += (names.empty() ? "" : ", ") + std::string(known);
    }
    if (!Read(node, name).empty()) return "needs one of " + names;
    const auto found = std::find(kEncoderKindNames.begin(), kEncoderKindNames.end(), name);
    if (found == kEncoderKindNames.end()) return "'" + name + "' is not one of " + names;
    kind = static_cast<EncoderKind>(found - kEncoderKindNames.begin());
    return "";
}

std::string ReadIrisScale(const toml::node& node, bool& is_t_stop) {
    std::string scale;
    if (!Read(node, scale).empty() || (scale != "t_stop" && scale != "f_number")) {
        return "needs \"t_stop\" or \"f_number\"";
    }
    is_t_stop = scale == "t_stop";
    return "";
}

std::string ReadAxisName(const toml::node& node, LensAxis& target) {
    std::string name;
    if (Read(node, name).empty()) {
        for (const LensAxis axis : kLensAxes) {
            if (Name(axis) != name) continue;
            target = axis;
            return "";
        }
    }
    return "needs \"focus\", \"iris\" or \"zoom\"";
}

// {byte = 1, bits = 16, signed = false, big_endian = false}
std::string ReadField(const toml::node& node, HidField& field) {
    const toml::table* table = node.as_table();
    if (!table || !table->contains("byte")) return "needs a table with byte";
    for (const auto& [key, value] : *table) {
        std::string problem = "is no key of a field";
        if (key == "byte") problem = ReadWhole(value, 0, 1'023, field.byte);
        if (key == "bits") problem = ReadWhole(value, 8, 32, field.bits);
        if (key == "signed") problem = Read(value, field.is_signed);
        if (key == "big_endian") problem = Read(value, field.big_endian);
        if (!problem.empty()) return std::string(key.str()) + " " + problem;
    }
    return field.bits % 8 == 0 ? "" : "bits needs 8, 16, 24 or 32";
}

class EncoderReader {
  public:
    explicit EncoderReader(const toml::table& table) : table_(table) {}

    Result<EncoderConfig> Run() {
        const toml::node* kind = table_.get("kind");
        if (!kind) return BadConfig("an encoder needs a kind", table_.source());
        if (std::string problem = ReadKind(*kind, config_.kind); !problem.empty()) {
            return BadConfig("kind " + problem, kind->source());
        }
        if (config_.kind == EncoderKind::kOpenTrackIo) config_.port = kOpenTrackIoPort;
        for (const auto& [key, node] : table_) {
            const std::string_view name = key.str();
            const auto known = std::find_if(kKeys.begin(), kKeys.end(),
                                            [&](const KindsOfKey& k) { return k.key == name; });
            if (known == kKeys.end() || (known->kinds & Of(config_.kind)) == 0) {
                return BadConfig(std::string(key.str()) + " is no key of an encoder of kind " +
                                     std::string(Name(config_.kind)),
                                 key.source());
            }
            if (const std::optional<Error> error = ReadKey(key.str(), node, key.source())) {
                return *error;
            }
        }
        for (const KindsOfKey& known : kKeys) {
            if ((known.required & Of(config_.kind)) != 0 && !table_.contains(known.key)) {
                return BadConfig("an encoder of kind " + std::string(Name(config_.kind)) +
                                     " needs " + std::string(known.key),
                                 table_.source());
            }
        }
        return std::move(config_);
    }

  private:
    std::optional<Error> ReadKey(std::string_view key, const toml::node& node,
                                 const toml::source_region& source) {
        for (const LensAxis axis : kLensAxes) {
            if (key == Name(axis)) return ReadAxis(axis, node, source);
        }
        const std::string problem = ReadPlain(key, node);
        if (problem.empty()) return std::nullopt;
        return BadConfig(std::string(key) + " " + problem, source);
    }

    std::string ReadPlain(std::string_view key, const toml::node& node) {
        if (key == "name") return Read(node, config_.name);
        if (key == "lens") return Read(node, config_.lens);
        if (key == "stale_ms") return Read(node, 1.0, kMaxWait_ms, config_.stale_ms);
        if (key == "file") return Read(node, config_.file);
        if (key == "loop") return Read(node, config_.loop);
        if (key == "port") return ReadWhole(node, 1, 65'535, config_.port);
        if (key == "address") return Read(node, config_.address);
        if (key == "multicast") return Read(node, config_.multicast);
        if (key == "camera_id") return ReadWhole(node, 0, 255, config_.source.emplace());
        if (key == "serial") return Read(node, config_.serial);
        if (key == "vendor") return ReadWhole(node, 0, 0xffff, config_.vendor.emplace());
        if (key == "product") return ReadWhole(node, 0, 0xffff, config_.product.emplace());
        if (key == "axis") return ReadAxisName(node, config_.axis);
        if (key == "index") {
            return ReadWhole(node, -kMostIndex, kMostIndex, config_.index_count.emplace());
        }
        if (key == "report") return ReadWhole(node, 0, 255, config_.hid.report.emplace());
        for (const LensAxis axis : kLensAxes) {
            if (key != std::string(Name(axis)) + "_field") continue;
            return ReadField(node, config_.hid.fields[Index(axis)].emplace());
        }
        return "";  // kind
    }

    std::optional<Error> ReadAxis(LensAxis axis, const toml::node& node,
                                  const toml::source_region& source) {
        const toml::table* table = node.as_table();
        if (!table) return BadConfig(std::string(Name(axis)) + " needs a table", source);
        AxisCalibration& calibration = config_.calibration.axes[Index(axis)];
        AxisMarks marks;
        constexpr double kMost = 1e15;
        for (const auto& [key, value] : *table) {
            std::string problem = "is no key of a calibration";
            if (key == "raw") problem = ReadNumbers(value, marks.raw);
            if (key == "value") problem = ReadNumbers(value, marks.value);
            if (key == "zero") problem = Read(value, -kMost, kMost, marks.zero);
            if (key == "wrap") problem = Read(value, 0.0, kMost, marks.wrap);
            if (key == "reverse") problem = Read(value, marks.reverse);
            if (key == "smooth_ms") problem = Read(value, 0.0, kMaxWait_ms, calibration.smooth_ms);
            if (key == "scale" && axis == LensAxis::kIris) {
                problem = ReadIrisScale(value, config_.calibration.iris_is_t_stop);
            }
            if (!problem.empty()) {
                return BadConfig(std::string(key.str()) + " " + problem, key.source());
            }
        }
        if (marks.raw.empty() && marks.value.empty()) return WithoutTable(axis, *table);
        Result<AxisTable> built = AxisTable::Build(axis, marks);
        if (!built) {
            const toml::node* culprit = table->get(built.error().where);
            return BadConfig(built.error().where + " " + built.error().message,
                             culprit ? culprit->source() : table->source());
        }
        calibration.table = std::move(*built);
        return std::nullopt;
    }

    // A device that states values may be smoothed; the other keys are about a table's counts.
    static std::optional<Error> WithoutTable(LensAxis axis, const toml::table& table) {
        for (const auto& [key, value] : table) {
            if (key == "smooth_ms") continue;
            return BadConfig(std::string(key.str()) + " means nothing without raw and value in " +
                                 std::string(Name(axis)),
                             key.source());
        }
        return std::nullopt;
    }

    const toml::table& table_;
    EncoderConfig config_;
};

}  // namespace

std::string WhereOf(const toml::source_region& source) {
    return "line " + std::to_string(source.begin.line) + ", column " +
           std::to_string(source.begin.column);
}

Result<std::vector<EncoderConfig>> ReadEncoders(const toml::node& node) {
    const toml::array* list = node.as_array();
    if (!list) return BadConfig("encoders are written as [[encoder]]", node.source());
    if (list->size() > limits::kEncoders) {
        return BadConfig("more than " + std::to_string(limits::kEncoders) + " encoders",
                         node.source());
    }
    std::vector<EncoderConfig> configs;
    for (const toml::node& item : *list) {
        const toml::table* table = item.as_table();
        if (!table) return BadConfig("encoders are written as [[encoder]]", item.source());
        Result<EncoderConfig> config = EncoderReader(*table).Run();
        if (!config) return config.error();
        for (const EncoderConfig& other : configs) {
            if (other.name != config->name) continue;
            return BadConfig("two encoders are called " + other.name, table->source());
        }
        configs.push_back(std::move(*config));
    }
    return configs;
}

}  // namespace flare
