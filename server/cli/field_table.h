// SPDX-License-Identifier: Apache-2.0
//
// The field data of a lens as tables for people, one for each section of an anamorphic lens.
#pragma once

#include <string>

#include "core/tracing/field_data.h"

namespace flare::cli {

std::string FieldTables(const Lens& lens, const FieldOptions& options = {});

}  // namespace flare::cli
