#!/bin/bash
# Compare the renderer with the path tracer on four scenes: bash tests/compare/run.sh ASSETS [OUT] [OPTION...]
# ASSETS holds cornell_box/, robot/ and sponza/; OUT (out/compare) gets a folder with report.html for each scene.
set -euo pipefail
cd "$(dirname "$0")/../.."
assets=${1:?give the folder of the models}
out=${2:-out/compare}
mkdir -p "$out"
for scene in cornell robot_in_box sponza night; do
    build/release/kandil compare "tests/compare/$scene.lua" --asset-root "$assets" --frame 20 --gi cones --spp 128 \
        --report "$out/$scene" "${@:3}"
done
