#!/bin/bash
# How long our own path tracer takes to come as near to the truth of the indirect term as a frame of the renderer does:
# bash tests/compare/curve.sh ASSETS [SCENE [SIZE [SAMPLES]]]
# SAMPLES (512) a pixel make the truth; the table has a line for each number of samples and one for the renderer.
set -euo pipefail
cd "$(dirname "$0")/../.."
assets=${1:?give the folder of the models}
scene=${2:-tests/compare/cornell.lua}
size=${3:-128x128}
samples=${4:-512}
kandil=build/release/kandil
out=out/compare/curve
mkdir -p "$out"
common=("$scene" --asset-root "$assets" --size "$size" --quiet)

# relMSE of a picture against the truth
error_of() { $kandil compare "$1" "$out/truth.exr" | awk 'END { print $4 }'; }
# seconds that a command takes
time_of() { local began ended; began=$(date +%s.%N); "$@"; ended=$(date +%s.%N); awk "BEGIN { print $ended - $began }"; }
trace() { $kandil reference "${common[@]}" --frame 20 --gathers inf --terms indirect --seed "$1" --spp "$2" --out "$3"; }

trace 1 "$samples" "$out/truth.exr"
mv "$out/truth_indirect.exr" "$out/truth.exr" 2>/dev/null || true
echo "what                 relMSE    seconds"
$kandil run "${common[@]}" --frames 21 --gi cones --view indirect --stats "$out/frame.json" --out "$out/frame.exr"
median=$(sed -n '/"frame_ms"/,/}/s/.*"median": *\([0-9.]*\).*/\1/p' "$out/frame.json" | head -1)
printf '%-20s %-9s %s\n' "frame of the renderer" "$(error_of "$out/frame.exr")" "$(awk "BEGIN { print $median / 1000 }")"
for ((n = 1; n <= samples / 4; n *= 2)); do
    seconds=$(time_of trace 2 $n "$out/traced.exr")
    mv "$out/traced_indirect.exr" "$out/traced.exr" 2>/dev/null || true
    printf '%-20s %-9s %s\n' "$n samples" "$(error_of "$out/traced.exr")" "$seconds"
done
