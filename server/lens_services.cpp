// SPDX-License-Identifier: Apache-2.0
#include "server/lens_services.h"

#include "server/translate/lens_json.h"

namespace flare {

Result<std::string> ServeLens(const std::string& name, const LensState& state,
                              const LensLibrary& lenses) {
    const auto file = lenses.Find(name);
    if (!file) return file.error();
    const Result<LensInState> shown = SetState(*file, state);
    if (!shown) return shown.error();
    return LensJson(**file, *shown, true);
}

Result<std::string> ServeGhosts(const std::string& name, const GhostQuery& query,
                                const ServiceContext& context) {
    const auto file = context.lenses.Find(name);
    if (!file) return file.error();
    const Result<RankedGhosts> ghosts = RankGhostsFor(
        *file, query, {context.threads, context.meshes, context.cancel, context.now_ms});
    if (ghosts) return GhostListJson(*ghosts, query);
    Error error = ghosts.error();
    if (!error.where.empty()) error.where.insert(0, "?");
    return error;
}

}  // namespace flare
