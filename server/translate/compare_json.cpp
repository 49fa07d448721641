// SPDX-License-Identifier: Apache-2.0
#include "server/translate/compare_json.h"

#include "protocol/codec/json_writer.h"

namespace flare {
namespace {

using wire::JsonWriter;

void WriteMetrics(JsonWriter& json, const ErrorMetrics& metrics) {
    json.Member("rel_l1", metrics.rel_l1).Member("energy", metrics.energy);
    json.Member("rel_l2_blur2", metrics.rel_l2_blur2);
    json.Key("log_error_stops").BeginInlineObject();
    json.Member("mean", metrics.log_error_stops_mean).Member("p99", metrics.log_error_stops_p99);
    json.Member("epsilon", metrics.log_error_epsilon).End();
    json.Member("p999_ratio", metrics.p999_ratio).Member("max_abs", metrics.max_abs);
}

}  // namespace

std::string ComparisonJson(const Comparison& comparison) {
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject();
    WriteMetrics(json, comparison.all);
    json.Key("layers").BeginArray();
    for (const LayerComparison& layer : comparison.layers) {
        json.BeginObject().Member("layer", layer.layer);
        WriteMetrics(json, layer.metrics);
        json.End();
    }
    json.End().End();
    return json.Take();
}

}  // namespace flare
