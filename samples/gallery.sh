#!/bin/bash
# Render a picture of every sample into docs/images/gallery (JPEG, 320x180), for docs/gallery.md.
#
#     bash samples/gallery.sh [KANDIL]
set -euo pipefail
cd "$(dirname "$0")/.."
kandil=${1:-build/release/kandil}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p docs/images/gallery

seconds() { # SAMPLE: the moment that shows its idea
    case $1 in
    00*) echo 0.7 ;;
    02*) echo 2.6 ;;
    04*) echo 2.4 ;;
    08*) echo 1.2 ;;
    10*) echo 3.2 ;;
    11*) echo 6.1 ;;
    13*) echo 1 ;;
    *) echo 1.5 ;;
    esac
}

for sample in samples/[0-9]*.lua; do
    name=$(basename "$sample" .lua)
    "$kandil" run "$sample" --seconds "$(seconds "$name")" --size 640x360 --out "$work/$name.png" --quiet
    ffmpeg -loglevel error -y -i "$work/$name.png" -vf scale=320:-1:flags=area -q:v 3 "docs/images/gallery/$name.jpg"
done
