#!/bin/bash
# Render the demo: install what is missing, build in release, and write pictures, a video and the profile to out/.
set -euo pipefail
cd "$(dirname "$0")/.."

bash packages.sh
cmake --preset release
cmake --build --preset release --target kandil

mkdir -p out
build/release/kandil run samples/01_cornell_walker.lua --frames 96 --size 640x360 \
    --out out/demo.png --out out/demo.mp4 --profile table --stats out/demo.json | tee out/demo_profile.txt

echo
echo "picture (last frame)  out/demo.png"
echo "video                 out/demo.mp4"
echo "profile table         out/demo_profile.txt"
echo "statistics            out/demo.json"
