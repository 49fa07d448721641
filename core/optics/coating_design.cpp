// SPDX-License-Identifier: Apache-2.0
#include "core/optics/coating_design.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/optics/coating_tables.h"
#include "core/optics/table_text.h"

namespace flare {
namespace {

constexpr int kShortestDesign_nm = 300, kLongestDesign_nm = 1100;
constexpr double kMgf2Index = 1.38;
constexpr double kMultilayerCentre_nm = 550.0;

CoatingMaterial Material(std::string_view name) {
    return MaterialByName(name).value();
}

// Of materials that are transparent where they are used.
double RealIndex(const CoatingMaterial& material, double wavelength_nm) {
    return material.Index(wavelength_nm).real();
}

// Layers of whole quarter waves at the design wavelength.
CoatingLayer Quarters(const CoatingMaterial& material, int quarters, double design_nm) {
    return {material, quarters * design_nm / 4.0 / RealIndex(material, design_nm)};
}

// Thicknesses of n1 (next to n0) and n2 (next to ns) that make R zero at one wavelength; none if no
// real ones do. Macleod, Thin-Film Optical Filters, two-layer antireflection coatings: n0 B = C
// gives
//   tan d1 tan d2 = n1 n2 (ns - n0) / (n1^2 ns - n0 n2^2)
//   tan d1 / tan d2 = n1 (n2^2 - n0 ns) / (n2 (n0 ns - n1^2))
// Of the two solutions the thinner one is broader.
std::optional<std::pair<double, double>> TwoLayerZero(double n0, double n1, double n2, double ns,
                                                      double wavelength_nm) {
    const double product = n1 * n2 * (ns - n0) / (n1 * n1 * ns - n0 * n2 * n2);
    const double ratio = n1 * (n2 * n2 - n0 * ns) / (n2 * (n0 * ns - n1 * n1));
    const double tan1 = std::sqrt(product * ratio);
    const double tan2 = product / tan1;
    if (!(std::isfinite(tan1) && std::isfinite(tan2))) return std::nullopt;
    std::optional<std::pair<double, double>> thinner;
    for (const double sign : {1.0, -1.0}) {
        const auto thickness = [&](double tangent, double n) {
            const double phase = std::atan(sign * tangent);
            return (phase < 0.0 ? phase + kPi : phase) * wavelength_nm / (2.0 * kPi * n);
        };
        const std::pair found(thickness(tan1, n1), thickness(tan2, n2));
        if (!thinner ||
            n1 * found.first + n2 * found.second < n1 * thinner->first + n2 * thinner->second) {
            thinner = found;
        }
    }
    return thinner;
}

// The high-index layer is ZrO2; on glass above 1.9 that has no zero, but Al2O3 has.
void LayV(const Glass& rare, const Glass& dense, double design_nm, Coating& out) {
    const CoatingMaterial outer = Material("MgF2");
    const double n0 = rare.Index(design_nm), ns = dense.Index(design_nm);
    for (const char* inner_name : {"ZrO2", "Al2O3"}) {
        const CoatingMaterial inner = Material(inner_name);
        const auto found = TwoLayerZero(n0, RealIndex(outer, design_nm),
                                        RealIndex(inner, design_nm), ns, design_nm);
        if (found.has_value()) {
            out.layers = {{outer, found->first}, {inner, found->second}};
            return;
        }
    }
    out.layers = {Quarters(outer, 1, design_nm), Quarters(Material("ZrO2"), 1, design_nm)};
    out.note = "no two thicknesses make R zero between these media: two quarter waves instead";
}

// Mean reflectance at normal incidence over the band that is to the design wavelength what 400-700
// nm is to 550.
double MeanReflectance(const Coating& coating, const Glass& rare, const Glass& dense,
                       double design_nm) {
    constexpr int kSteps = 10;
    double sum = 0.0;
    for (int i = 0; i <= kSteps; ++i) {
        const double wavelength = design_nm * (400.0 + 300.0 * i / kSteps) / 550.0;
        sum += ReflectionOf(coating, false, rare.Index(wavelength), dense.Index(wavelength), 1.0,
                            wavelength)
                   .reflectance;
    }
    return sum / (kSteps + 1);
}

// Quarter, half, quarter: at the design wavelength the half wave is absent and R is that of two
// quarter waves; away from it the half wave flattens the curve. Of the materials for the two inner
// layers the pair is taken that reflects least on this glass.
void LayBroadband(const Glass& rare, const Glass& dense, double design_nm, Coating& out) {
    double least = std::numeric_limits<double>::infinity();
    for (const char* half : {"ZrO2", "HfO2", "Y2O3"}) {
        for (const char* inner : {"Al2O3", "HfO2", "Y2O3"}) {
            if (std::string_view(half) == inner) continue;
            const Coating tried{
                out.name,
                {Quarters(Material("MgF2"), 1, design_nm), Quarters(Material(half), 2, design_nm),
                 Quarters(Material(inner), 1, design_nm)},
                ""};
            const double mean = MeanReflectance(tried, rare, dense, design_nm);
            if (mean < least) {
                least = mean;
                out = tried;
            }
        }
    }
}

struct Multilayer {
    double substrate = 0.0;
    std::vector<double> thicknesses_nm;
};

const std::vector<Multilayer>& Multilayers() {
    static const std::vector<Multilayer> designs = [] {
        std::vector<Multilayer> out;
        for (const std::string_view line : TableLines(MultilayerDesignsText())) {
            const std::vector<std::string_view> columns = SplitText(line, '\t');
            FLARE_CHECK(columns.size() == 3);
            out.push_back({NumberIn(columns[0]), NumbersIn(columns[1], ' ')});
        }
        return out;
    }();
    return designs;
}

void LayMultilayer(const Glass& dense, double design_nm, Coating& out) {
    static constexpr std::array<const char*, 7> kMaterials{"MgF2", "Ta2O5", "SiO2", "Ta2O5",
                                                           "SiO2", "Ta2O5", "SiO2"};
    const double ns = dense.Index(design_nm);
    const Multilayer* nearest = nullptr;
    for (const Multilayer& design : Multilayers()) {
        if (nearest == nullptr ||
            std::abs(design.substrate - ns) < std::abs(nearest->substrate - ns)) {
            nearest = &design;
        }
    }
    FLARE_CHECK(nearest != nullptr && nearest->thicknesses_nm.size() == kMaterials.size());
    for (std::size_t i = 0; i < kMaterials.size(); ++i) {
        out.layers.push_back({Material(kMaterials[i]),
                              nearest->thicknesses_nm[i] * design_nm / kMultilayerCentre_nm});
    }
}

// NNN of "family-NNN".
std::optional<int> DesignWavelength(std::string_view name, std::string_view family) {
    if (name.size() <= family.size() || name.substr(0, family.size()) != family ||
        name[family.size()] != '-') {
        return std::nullopt;
    }
    const std::string_view digits = name.substr(family.size() + 1);
    int design_nm = 0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), design_nm);
    if (error != std::errc() || end != digits.data() + digits.size() ||
        design_nm < kShortestDesign_nm || design_nm > kLongestDesign_nm) {
        return std::nullopt;
    }
    return design_nm;
}

std::string OutOfRange(const char* what, double value, const char* range) {
    char text[96];
    std::snprintf(text, sizeof text, "%s is %.6g but must be %s", what, value, range);
    return text;
}

Error BadCoating(std::string message) {
    return {"bad_lens", std::move(message), ""};
}

}  // namespace

std::string LayerFault(const CoatingLayer& layer) {
    const std::complex<double> index = layer.material.Index(kLineD);
    if (!(index.real() > 0.0 && index.real() <= kMaxLayerIndex)) {
        return OutOfRange("n", index.real(), "above 0, up to 10");
    }
    if (!(index.imag() >= 0.0 && index.imag() <= kMaxLayerIndex)) {
        return OutOfRange("k", index.imag(), "0 to 10");
    }
    if (!(layer.thickness_nm >= 0.0 && layer.thickness_nm <= kMaxLayerThicknessNm)) {
        return OutOfRange("thickness_nm", layer.thickness_nm, "0 to 1e5");
    }
    return "";
}

Result<CoatingDesign> CoatingDesign::Stack(std::string name, std::vector<CoatingLayer> layers) {
    if (name == "bare" || name == "none") {
        return BadCoating("the name \"" + name + "\" means no coating and cannot be defined anew");
    }
    if (layers.size() > static_cast<std::size_t>(kMaxCoatingLayers)) {
        return BadCoating("coating \"" + name + "\" has " + std::to_string(layers.size()) +
                          " layers; the limit is " + std::to_string(kMaxCoatingLayers));
    }
    for (std::size_t i = 0; i < layers.size(); ++i) {
        if (const std::string fault = LayerFault(layers[i]); !fault.empty()) {
            return BadCoating("layer " + std::to_string(i) + " of coating \"" + name +
                              "\": " + fault);
        }
    }
    CoatingDesign out;
    out.name_ = std::move(name);
    out.layers_ = std::move(layers);
    return out;
}

Coating CoatingDesign::For(const Glass& rare, const Glass& dense) const {
    Coating out{name_, layers_, ""};
    switch (kind_) {
        case Kind::kStack:
            break;
        case Kind::kV:
            LayV(rare, dense, design_nm_, out);
            break;
        case Kind::kBroadband:
            LayBroadband(rare, dense, design_nm_, out);
            break;
        case Kind::kMultilayer:
            LayMultilayer(dense, design_nm_, out);
            break;
    }
    return out;
}

Result<CoatingDesign> BuiltInCoating(std::string_view name) {
    if (name == "bare" || name == "none") return CoatingDesign();
    using Kind = CoatingDesign::Kind;
    const auto designed = [&](Kind kind, int design_nm) {
        CoatingDesign out;
        out.name_ = name;
        out.kind_ = kind;
        out.design_nm_ = design_nm;
        return out;
    };
    if (const auto nm = DesignWavelength(name, "mgf2")) {
        return CoatingDesign::Stack(std::string(name), {Quarters(kMgf2Index, 1, *nm)});
    }
    if (const auto nm = DesignWavelength(name, "mgf2-disp")) {
        return CoatingDesign::Stack(std::string(name), {Quarters(Material("MgF2"), 1, *nm)});
    }
    if (const auto nm = DesignWavelength(name, "v")) return designed(Kind::kV, *nm);
    if (const auto nm = DesignWavelength(name, "broadband")) return designed(Kind::kBroadband, *nm);
    if (const auto nm = DesignWavelength(name, "multi")) return designed(Kind::kMultilayer, *nm);
    return BadCoating("unknown coating \"" + std::string(name) +
                      "\"; known are \"bare\", \"mgf2-NNN\", \"mgf2-disp-NNN\", \"v-NNN\", "
                      "\"broadband-NNN\" and \"multi-NNN\" with NNN from 300 to 1100 nm");
}

Result<CoatingDesign> CoatingDesignByName(std::string_view name,
                                          const CoatingDefinitions& defined) {
    const auto found = defined.find(std::string(name));
    if (found != defined.end()) return found->second;
    Result<CoatingDesign> built_in = BuiltInCoating(name);
    if (built_in.ok() || defined.empty()) return built_in;
    std::string own;
    for (const auto& [key, design] : defined) {
        if (!own.empty()) own += ", ";
        own += key;
    }
    return BadCoating(built_in.error().message + ", and of this lens " + own);
}

}  // namespace flare
