#!/bin/bash
# What flickers while a camera moves slowly over a scene of tests/compare or samples:
# bash tests/compare/steady.sh ASSETS [SCENE [SIZE [OPTION...]]]
# Mean LDR-FLIP of neighbouring frames, the earlier one moved to where its surfaces are in the later one, after
# 24 frames in which bounced light settles; each line is a pair, the last one their mean.
set -euo pipefail
cd "$(dirname "$0")/../.."
assets=${1:?give the folder of the models}
scene=${2:-cornell}
size=${3:-320x180}
kandil=build/release/kandil
first=24 last=32
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

$kandil run tests/compare/steady.lua --set "param.scene=$scene" --asset-root "$assets" --asset-root samples \
    --size "$size" --fps 30 --frames $((last + 1)) --layers --out "$out/%04d.exr" --quiet "${@:4}"
echo "frames     final  direct indirect  seen again %"
for ((n = first; n < last; n++)); do
    $kandil compare "$(printf '%s/%04d.exr' "$out" "$n")" "$(printf '%s/%04d.exr' "$out" $((n + 1)))" --temporal |
        awk -v frames="$n $((n + 1))" '/seen again/ { for (i = 1; i < NF; i++) if ($(i + 1) == "%") seen = $i }
            $1 ~ /^(final|direct|indirect)$/ { flip[$1] = $2 }
            END { printf "%s     %s %s %s %s\n", frames, flip["final"], flip["direct"], flip["indirect"], seen }'
done | awk '{ print; for (i = 3; i <= 6; i++) sum[i] += $i; n++ }
    END { printf "mean      %.4f %.4f %.4f %.1f\n", sum[3] / n, sum[4] / n, sum[5] / n, sum[6] / n }'
