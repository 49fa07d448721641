// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/mesh_provider.h"

namespace flare {

Result<MeshProvider::Found> TracingMeshProvider::Get(const Fingerprint& /*key*/, const Build& build,
                                                     const CancelToken& cancel) {
    if (cancel.cancelled()) return Error{"cancelled", "the work was cancelled", ""};
    return Found{std::make_shared<const GhostMesh>(build()), false};
}

}  // namespace flare
