// SPDX-License-Identifier: Apache-2.0
#include "core/render/kept_tables.h"

#include <utility>

#include "core/render/render_keeper.h"

namespace flare {
namespace {

struct KeptTables {
    static constexpr KeptKind kKind = KeptKind::kTables;
    TransmissionTables tables;

    std::size_t bytes() const { return tables.bytes(); }
};

}  // namespace

std::shared_ptr<const TransmissionTables> TablesOf(const Lens& lens,
                                                   std::vector<double> wavelengths_nm,
                                                   const RenderContext& context) {
    if (!context.keeper) {
        return std::make_shared<const TransmissionTables>(lens, std::move(wavelengths_nm),
                                                          context.threads);
    }
    Fingerprinter key;
    key.Add("tables").Add(lens.fingerprint());
    for (const double nm : wavelengths_nm) key.Add(nm);
    std::shared_ptr<const KeptTables> kept = context.keeper->Find<KeptTables>(key.value());
    if (!kept) {
        kept = std::make_shared<const KeptTables>(
            KeptTables{TransmissionTables(lens, std::move(wavelengths_nm), context.threads)});
        context.keeper->Keep(key.value(), kept);
    }
    return {kept, &kept->tables};
}

}  // namespace flare
