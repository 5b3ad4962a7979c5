#!/bin/bash
# Every field that the chapters and the program's own messages name in kandil.get("…") can be read.
# Usage: reads.sh PROGRAM CHAPTER…
set -euo pipefail
program=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

read_fields() { # FILE: a scenario that reads each field on standard input
    {
        echo "kandil.spawn { camera = {} }"
        echo "function kandil.update()"
        sed 's/.*/assert(kandil.get("&") ~= nil, "&")/'
        echo "end"
    } > "$1"
}
run() {
    "$program" run "$1" --frames 1 --size 32x18 --gi none --out "$work/picture.png" --quiet
}

grep -ho 'kandil\.get("[^"]*")' "$@" | sed 's/.*("\(.*\)").*/\1/' | sort -u > "$work/named"
[ -s "$work/named" ] || { echo "no kandil.get in the chapters"; exit 1; }
read_fields "$work/named.lua" < "$work/named"
run "$work/named.lua"

echo 'kandil.get("nothing")' > "$work/wrong.lua"
if run "$work/wrong.lua" 2> "$work/message"; then
    echo "a path without a field was taken"
    exit 1
fi
grep -o 'such as [a-z_.]*' "$work/message" | sed 's/such as //' > "$work/offered"
[ -s "$work/offered" ] || { cat "$work/message"; exit 1; }
read_fields "$work/offered.lua" < "$work/offered"
run "$work/offered.lua"
