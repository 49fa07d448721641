// SPDX-License-Identifier: Apache-2.0
//
// A report in plain words: what was asked for, which plan was drawn, what is modelled, what is left
// out and how much light that is.
#pragma once

#include <string>

namespace flare::cli {

// `report` is the JSON text of GET /v1/reports/ID; what it does not say is passed over.
std::string ExplainReport(const std::string& report);

}  // namespace flare::cli
