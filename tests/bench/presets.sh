#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Error of the quality presets against `reference`, measured and estimated, for one lens and a light
# at infinity. Prints a Markdown table.
#   tests/bench/presets.sh [LENS [F_NUMBER [WIDTH [HEIGHT [FIELD_DEG]]]]]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
flare=build/release/bin/flare
lens=${1:-tronnier-double-gauss-50mm-f2} f=${2:-4} width=${3:-480} height=${4:-270} field=${5:-5}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# The light stands at the field angle, turned by 20 degrees about the axis.
light=$(python3 -c "from math import *; a, b = radians($field), radians(20)
print([-sin(a) * cos(b), sin(a) * sin(b), cos(a)])")
for preset in reference final preview draft; do
    cat >"$work/$preset.json" <<JSON
{"lens": "$lens", "f_number": $f,
 "image": {"width": $width, "height": $height, "sensor_width_mm": 36},
 "lights": [{"direction": $light, "irradiance": [1, 1, 1]}],
 "quality": {"preset": "$preset"}, "output": {"compression": "zip", "pixel": "float"}}
JSON
    "$flare" render "$work/$preset.json" -o "$work/$preset.exr" --report "$work/$preset.report.json"
done
echo "| preset | rel_l1 | estimated | ratio | energy | culled | rays traced | pieces |"
echo "|---|---|---|---|---|---|---|---|"
for preset in draft preview final; do
    "$flare" compare "$work/$preset.exr" "$work/reference.exr" --json >"$work/$preset.compare.json"
    python3 - "$work/$preset.compare.json" "$work/$preset.report.json" "$preset" <<'PY'
import json, sys
metrics = json.load(open(sys.argv[1]))
report = json.load(open(sys.argv[2]))
all_ = metrics.get("all", metrics)
work = report["work"]
measured, estimate = all_["rel_l1"], report["estimated_error"]
print(f"| {sys.argv[3]} | {measured:.4f} | {estimate['rel_l1']:.4f} | {estimate['rel_l1'] / measured:.1f} "
      f"| {all_['energy']:+.5f} | {estimate['culling']:.5f} | {work['rays_traced']} | {work['polygons']} |")
PY
done
