// SPDX-License-Identifier: Apache-2.0
#include "server/lens_services.h"

#include "core/render/ghost_list.h"
#include "server/translate/lens_json.h"

namespace flare {

Result<std::string> ServeLens(const std::string& name, const LensLibrary& lenses) {
    const auto lens = lenses.Find(name);
    if (!lens) return lens.error();
    return LensJson(**lens);
}

Result<std::string> ServeGhosts(const std::string& name, const GhostQuery& query,
                                const ServiceContext& context) {
    const auto found = context.lenses.Find(name);
    if (!found) return found.error();
    const std::shared_ptr<const Lens> lens = query.bare_glass ? (*found)->WithBareGlass() : *found;
    GhostListOptions options;
    if (query.wavelength_nm) options.wavelength_nm = *query.wavelength_nm;
    options.f_number = query.f_number;
    options.field_deg = query.field_deg;
    const Result<GhostList> list = RankGhosts(
        lens, options, {context.threads, context.meshes, context.cancel, context.now_ms});
    if (!list) return list.error();
    return GhostListJson(*lens, *list, options, query.bare_glass);
}

}  // namespace flare
