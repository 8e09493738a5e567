#!/bin/sh
# clang-format decides the layout of every source file.
set -eu
find common worker coordinator monitor tests -name '*.[ch]' | sort | {
    wrong=0
    while read -r source; do
        clang-format "$source" | cmp -s - "$source" && continue
        echo "$source: expected the layout of: clang-format -i $source"
        wrong=1
    done
    exit $wrong
}
