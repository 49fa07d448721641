// SPDX-License-Identifier: Apache-2.0
//
// A ghost mesh as the bytes of a file, and back: docs/mesh-files.md has the layout. All numbers are
// little-endian; floats keep every bit, so a mesh that is read draws the same picture as the one
// that was written. Reading trusts nothing: a file of another version, under another key, cut off,
// with a flipped bit or with sizes that do not add up is refused, and no memory is taken for a size
// before the file has shown to be that long. Pure functions, safe from any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "core/mesh/ghost_mesh.h"

namespace flare {

// Raised when the layout changes; files of other versions are refused.
inline constexpr std::uint32_t kMeshFileVersion = 1;
inline constexpr std::size_t kMeshFileHeaderBytes = 56;

std::string EncodeMesh(const Fingerprint& key, const GhostMesh& mesh);

// Error code "bad_mesh_file", the message saying what is wrong with it.
Result<GhostMesh> DecodeMesh(const Fingerprint& key, std::string_view file);

}  // namespace flare
