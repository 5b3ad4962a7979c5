#!/bin/bash
# What a step costs in which a scenario sets 10 000 entities, by every way: bash tests/bench/entities.sh [KANDIL]
set -euo pipefail
cd "$(dirname "$0")/../.."
kandil=${1:-build/release/kandil}
for way in empty compute assign field kept set part turn get change query query_part query_change; do
    "$kandil" run tests/bench/entities.lua --frames 40 --set "param.way=$way" --profile table --quiet |
        awk -v way="$way" '$1 == "scenario" { printf "%-14s %s\n", way, $0 }'
done
