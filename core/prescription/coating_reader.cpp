// SPDX-License-Identifier: Apache-2.0
#include "core/prescription/coating_reader.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/prescription/document_fields.h"
#include "core/prescription/toml_document.h"

namespace flare {
namespace {

constexpr std::size_t kMaxCoatingNameBytes = 100;
constexpr std::size_t kMaxCoatingFileBytes = std::size_t{1} << 16;

// A layer is of a known material or of a constant index.
Result<CoatingLayer> ReadLayer(const DocumentNode& node, const std::string& owner) {
    Fields fields(node, owner);
    fields.Allow({"material", "n", "k", "thickness_nm"}, {});
    CoatingLayer out{1.0, 0.0};
    fields.Require("thickness_nm");
    fields.Read("thickness_nm", out.thickness_nm);
    std::string name;
    std::optional<double> n, k;
    const bool named = fields.Read("material", name);
    fields.Read("n", n);
    fields.Read("k", k);
    if (fields.error().has_value()) return *fields.error();

    if (named == n.has_value() || (named && k.has_value())) {
        return Error{"bad_lens", owner + " needs either \"material\" or \"n\" (and \"k\")",
                     node.where};
    }
    if (named) {
        const Result<CoatingMaterial> material = MaterialByName(name);
        if (!material) {
            return Error{"bad_lens", owner + ": " + material.error().message,
                         fields.Find("material")->where};
        }
        out.material = *material;
    } else {
        out.material = std::complex<double>(*n, k.value_or(0.0));
    }
    if (const std::string fault = LayerFault(out); !fault.empty()) {
        return Error{"bad_lens", owner + ": " + fault, node.where};
    }
    return out;
}

void ReadLayers(Fields& fields, const std::string& owner, std::vector<CoatingLayer>& out) {
    const DocumentNode* node = fields.Require("layers");
    if (node == nullptr) return;
    if (node->array() == nullptr) {
        fields.Fail("\"layers\" of " + owner + " must be an array, not " + TypeNameOf(*node),
                    node->where);
        return;
    }
    const DocumentNode::Array& rows = *node->array();
    if (rows.size() > static_cast<std::size_t>(kMaxCoatingLayers)) {
        fields.Fail(owner + " has " + std::to_string(rows.size()) + " layers; the limit is " +
                        std::to_string(kMaxCoatingLayers),
                    node->where);
        return;
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Result<CoatingLayer> layer =
            ReadLayer(rows[i], "layer " + std::to_string(i) + " of " + owner);
        if (!layer) {
            fields.Fail(layer.error().message, layer.error().where, layer.error().code);
            return;
        }
        out.push_back(*layer);
    }
}

// The fields of a coating's table but its name.
Result<CoatingDesign> ReadBody(Fields& fields, const std::string& name, const std::string& where) {
    const std::string owner = "coating \"" + name + "\"";
    std::vector<CoatingLayer> layers;
    std::string notes, source;
    ReadLayers(fields, owner, layers);
    fields.Read("notes", notes);
    fields.Read("source", source);
    if (fields.error().has_value()) return *fields.error();
    Result<CoatingDesign> design = CoatingDesign::Stack(name, std::move(layers));
    if (!design) return Error{design.error().code, design.error().message, where};
    design->notes = std::move(notes);
    design->source = std::move(source);
    return design;
}

bool SoundName(const std::string& name) {
    return !name.empty() && name.size() <= kMaxCoatingNameBytes &&
           std::all_of(name.begin(), name.end(), [](char c) {
               const auto byte = static_cast<unsigned char>(c);
               return byte >= 0x20 && byte != 0x7f;
           });
}

Error BadName(const std::string& where) {
    return {"bad_lens",
            "the name of a coating must have 1 to " + std::to_string(kMaxCoatingNameBytes) +
                " bytes and no control characters",
            where};
}

}  // namespace

Result<CoatingDesign> ReadCoating(const DocumentNode& node, const std::string& name) {
    if (!SoundName(name)) return BadName(node.where);
    Fields fields(node, "coating \"" + name + "\"");
    fields.Allow({"layers", "notes", "source"}, {});
    return ReadBody(fields, name, node.where);
}

Result<CoatingDesign> ReadCoatingToml(std::string_view text) {
    if (text.size() > kMaxCoatingFileBytes) {
        return Error{"bad_lens",
                     "a coating file may have " + std::to_string(kMaxCoatingFileBytes) +
                         " bytes, not " + std::to_string(text.size()),
                     ""};
    }
    const Result<DocumentNode> root = ParseToml(text, "bad_lens");
    if (!root) return root.error();
    Fields fields(*root, "the coating");
    fields.Allow({"name", "layers", "notes", "source"}, {});
    fields.Require("name");
    std::string name;
    fields.Read("name", name);
    if (fields.error().has_value()) return *fields.error();
    if (!SoundName(name)) return BadName(fields.Find("name")->where);
    return ReadBody(fields, name, fields.Find("name")->where);
}

Result<CoatingDefinitions> ReadCoatingDefinitions(const DocumentNode& node) {
    if (node.table() == nullptr) {
        return Error{"bad_lens",
                     std::string("\"coatings\" must be a table, not ") + TypeNameOf(node),
                     node.where};
    }
    if (node.table()->size() > static_cast<std::size_t>(kMaxCoatingDefinitions)) {
        return Error{"bad_lens",
                     "a lens may define " + std::to_string(kMaxCoatingDefinitions) +
                         " coatings, not " + std::to_string(node.table()->size()),
                     node.where};
    }
    CoatingDefinitions out;
    for (const auto& [name, child] : *node.table()) {
        Result<CoatingDesign> design = ReadCoating(child, name);
        if (!design) return design.error();
        out.emplace(name, std::move(*design));
    }
    return out;
}

}  // namespace flare
