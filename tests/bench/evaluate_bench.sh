#!/bin/bash
# How fast a table of designs is evaluated: ROWS designs of the sedan with two springs, 18 columns of
# numbers and an id, about 160 bytes a row. With all outcomes writing them costs most, with one of
# them simulating and moving the designs does. Prints CSV.
#
#   tests/bench/evaluate_bench.sh BUILD_DIR [ROWS [WORKERS]]
#
# ROWS is a million. WORKERS is 0: one process; with workers run it in tests/netns.
set -euo pipefail

build=$(cd "$1" && pwd)
rows=${2:-1000000}
workers=${3:-0}
scenario=$(cd "$(dirname "$0")/../../deploy/scenarios" && pwd)/sedan-two-springs.yaml
PATH=$build/bin:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
TIMEFORMAT='%R %U %S'

awk -v rows="$rows" '
    function any(greatest) { seed = (seed * 16807) % 2147483647; return seed / 2147483647 * greatest }
    BEGIN {
        seed = 4711
        printf "id"
        for (i = 0; i < 9; i++) printf ",front.force_x[%d],front.force_y[%d]", i, i
        print ""
        for (row = 1; row <= rows; row++) {
            printf "d%d", row
            for (i = 0; i < 9; i++)
                printf ",%.1f,%.1f", any(i == 0 ? 60e3 : i == 1 ? 80e3 : 450e3), any(250e3)
            print ""
        }
    }' >designs.csv

measure() # NAME [OPTION...]
{
    local out=$1
    shift
    {
        time sobox-coordinator --evaluate designs.csv "$scenario" --quiet --workers "$workers" \
            --out "$out" "$@" >/dev/null
    } 2>taken.txt
    awk -v name="$out" -v rows="$rows" '{
        printf "%s,%d,%.2f,%.0f,%.2f,%.2f\n", name, rows, $1, rows / $1, 1e6 * $2 / rows,
            1e6 * $3 / rows
    }' taken.txt
}

echo 'outcomes,designs,wall_s,designs_per_s,user_us_each,system_us_each'
measure all
measure s_L --outcomes s_L
awk -F, '{ print $1 "," $2 }' all/outcomes.csv >expected
awk -F, '{ print $1 "," $2 }' s_L/outcomes.csv | cmp - expected
