#!/bin/sh
# manual.sh PROGRAM PAGE: the manual page describes exactly the options that the program has, so
# that neither an option stays untold nor a page tells of one that is gone.
set -eu
program=$1 page=$2
told=$(mktemp) described=$(mktemp)
trap 'rm -f "$told" "$described"' EXIT

# Options as the help lists them: a line each, "  -q, --quiet   ..." or "  --out=DIR   ...".
"$program" --help | grep -E '^ +-' | grep -oE -e '--[a-z][a-z-]*' | sort -u >"$told"
# Options as the page describes them: each opens a tagged paragraph.
sed 's/\\-/-/g' "$page" | grep -A 1 '^[.]TP' | grep -E '^[.](B|BR|BI|IR) ' |
    grep -oE -e '--[a-z][a-z-]*' | sort -u >"$described"

[ -s "$told" ] || { echo "$program --help lists no option"; exit 1; }
if ! diff "$told" "$described"; then
    echo "${page##*/}: expected the options of --help (<); the page describes those of (>)"
    exit 1
fi
