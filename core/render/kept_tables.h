// SPDX-License-Identifier: Apache-2.0
//
// A lens's transmission tables, from where pictures are kept (render_keeper.h) or made anew.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh/transmission.h"
#include "core/render/renderer.h"

namespace flare {

// Takes all threads if they have to be made.
std::shared_ptr<const TransmissionTables> TablesOf(const Lens& lens,
                                                   std::vector<double> wavelengths_nm,
                                                   const RenderContext& context);

}  // namespace flare
