// SPDX-License-Identifier: Apache-2.0
//
// The report of a request: what the renderer did, as JSON, and the facts of it that may stand in
// the picture itself.
#pragma once

#include <string>

#include "core/image/flare_image.h"
#include "core/render/flare_request.h"
#include "core/render/report.h"
#include "server/translate/encoder_use.h"

namespace flare {

// What the service knows beyond the renderer's report. Strings that are empty are left out.
struct ReplyFacts {
    std::string id;  // of the report
    std::string request_hash;
    Quality asked;  // the request's quality; the request itself holds what was drawn
    std::string content_type;
    PixelWindow window;       // of the picture
    std::uint64_t bytes = 0;  // of the encoded picture
    double encode_ms = 0.0;
    int threads = 1;
    const EncoderUse* encoder = nullptr;  // whose state was used; null: none
};

// What the picture's channels are: a word of the request's "color_space", or "camera".
std::string ColorSpaceName(const FlareRequest& request);

// The whole report, readable.
std::string ReportJson(const FlareRequest& request, const Report& report, const ReplyFacts& reply);

// Id and totals on one line of ASCII, at most limits::kReportSummaryBytes: for the Flare-Report
// header.
std::string ReportSummaryJson(const FlareRequest& request, const Report& report,
                              const ReplyFacts& reply);

// Puts the lens, its state and the facts that follow from the request alone into the picture's
// header; nothing that depends on the machine, the cache or the time.
void AddFactAttributes(const FlareRequest& request, const Facts& facts,
                       const std::string& request_hash, FlareImage& image);

}  // namespace flare
