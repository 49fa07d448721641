#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Error of the quality presets against `reference`, and the time each takes cold, for one lens and
# light. Prints a Markdown table.
#   tests/bench/presets.sh [LENS [F_NUMBER [WIDTH [HEIGHT]]]]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
flare=build/release/bin/flare
lens=${1:-tronnier-double-gauss-50mm-f2} f=${2:-4} width=${3:-480} height=${4:-270}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for preset in reference final preview draft; do
    cat >"$work/$preset.json" <<JSON
{"lens": "$lens", "f_number": $f, "iris": {"blades": 6, "roundness": 0.2, "rotation_deg": 10},
 "image": {"width": $width, "height": $height, "sensor_width_mm": 36},
 "lights": [{"direction": [-0.0872, 0.05, 0.9962], "irradiance": [1, 1, 1]}],
 "quality": {"preset": "$preset"}, "output": {"compression": "zip", "pixel": "float"}}
JSON
    "$flare" render "$work/$preset.json" -o "$work/$preset.exr" --report "$work/$preset.report.json"
done
echo "| preset | rel_l1 | energy | rays traced | pieces |"
echo "|---|---|---|---|---|"
for preset in draft preview final; do
    "$flare" compare "$work/$preset.exr" "$work/reference.exr" --json >"$work/$preset.compare.json"
    python3 - "$work/$preset.compare.json" "$work/$preset.report.json" "$preset" <<'PY'
import json, sys
metrics = json.load(open(sys.argv[1]))
report = json.load(open(sys.argv[2]))
all_ = metrics.get("all", metrics)
work = report["work"]
print(f"| {sys.argv[3]} | {all_['rel_l1']:.4f} | {all_['energy']:+.5f} | {work['rays_traced']} | {work['polygons']} |")
PY
done
