// SPDX-License-Identifier: Apache-2.0
//
// Which ghost meshes a picture needs for one of its lights. Rendering asks for them one by one;
// warming asks for all of them beforehand. Both must mean the same, so both come here.
#pragma once

#include <vector>

#include "core/mesh/mesh_builder.h"
#include "core/render/flare_request.h"
#include "core/render/lights.h"
#include "core/render/quality.h"

namespace flare {

// What a preset asks of a mesh, in colour.
void SetQuality(const QualitySettings& settings, MeshSpec& spec);

// The mesh of one ghost.
MeshSpec MeshSpecFor(const FlareRequest& request, const BounceSequence& sequence,
                     const PlacedLight& light);

// Those of all ghosts of two reflections; ghosts of four are chosen when a picture is rendered.
std::vector<MeshSpec> MeshSpecsFor(const FlareRequest& request, const PlacedLight& light);

}  // namespace flare
