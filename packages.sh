#!/bin/bash
# Install what is missing of packages.txt. Changes nothing, and needs neither root nor network, when all is there.
set -euo pipefail

list="$(cd "$(dirname "$0")" && pwd)/packages.txt"
names=$(sed -e 's/#.*//' -e '/^[[:space:]]*$/d' "$list" | tr -d ' \t')

if ! command -v dpkg-query > /dev/null; then
    echo "kandil: packages.txt: this is not a Debian system, so nothing is installed; provide what the list names" >&2
    exit 0
fi

missing=""
for name in $names; do
    state=$(dpkg-query -W -f '${db:Status-Status}' "$name" 2> /dev/null || true)
    if [ "$state" != installed ]; then
        missing="$missing $name"
    fi
done
if [ -z "$missing" ]; then
    exit 0
fi

as_root=""
if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo > /dev/null; then
        echo "kandil: packages.txt: missing:$missing; run this as root, or have root run: apt-get install$missing" >&2
        exit 1
    fi
    as_root=sudo
fi

echo "installing:$missing"
# Recommended packages are left out: the list names all that is needed.
# shellcheck disable=SC2086 # the words are meant to be split
if ! { $as_root apt-get update -q &&
       $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing; }; then
    echo "kandil: packages.txt: apt-get could not install:$missing; its message stands above (network? sources?)" >&2
    exit 1
fi
