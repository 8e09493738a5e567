#!/bin/sh
# The guard of a header is its path: common/base/error.h is guarded by SOBOX_COMMON_BASE_ERROR_H,
# so that no two headers can share one.
set -eu
find common worker coordinator monitor hub tests -name '*.h' | sort | {
    wrong=0
    while read -r header; do
        guard=SOBOX_$(printf '%s' "$header" | tr 'a-z/.-' 'A-Z___')
        awk -v header="$header" -v guard="$guard" '
            /^#/ { directive[++count] = $0 }
            END {
                if (directive[1] == "#ifndef " guard && directive[2] == "#define " guard &&
                    directive[count] == "#endif") exit 0
                print header ": expected everything guarded by " guard
                exit 1
            }' "$header" || wrong=1
    done
    exit $wrong
}
