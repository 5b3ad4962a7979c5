#!/bin/bash
# Every message that docs/errors.md quotes is one that the program has: what stands between its ellipses is looked for
# in `kandil help messages`, and, since some are put together of parts, in the program's strings.
#
#     errors.sh KANDIL ERRORS.md
set -euo pipefail
messages=$("$1" help messages; strings -n 8 "$1")
missing=0
quotes=$(grep '^| `' "$2" | cut -d'|' -f2 | grep -o '`[^`]*`' | tr -d '`')
[ "$(wc -l <<< "$quotes")" -ge 15 ] || { echo "$2 quotes hardly any message" >&2; exit 1; }
while IFS= read -r quote; do
    quote=${quote#FILE.lua:LINE: }
    while IFS= read -r piece; do
        piece=$(sed 's/^[ ()]*//; s/[ ()]*$//' <<< "$piece")
        if [ "${#piece}" -ge 8 ] && ! grep -qF -- "$piece" <<< "$messages"; then
            echo "no message of the program says: $piece" >&2
            missing=1
        fi
    done <<< "${quote//…/$'\n'}"
done <<< "$quotes"
exit $missing
