#!/bin/sh
# clang-format decides the layout of every source file.
set -eu
wrong=$(find common worker coordinator monitor hub tests -name '*.[ch]' \
    -exec clang-format --dry-run --Werror {} + 2>&1 | sed -n 's/:[0-9]*:[0-9]*: error:.*//p' | sort -u)
for source in $wrong; do
    echo "$source: expected the layout of: clang-format -i $source"
done
[ -z "$wrong" ]
