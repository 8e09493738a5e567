#!/bin/bash
# What a sweep costs beside its searches: three cars, three responses, SEEDS seeds, as one sweep on
# all cores, and each search by itself on one core, one after the other. Prints seconds and processor
# time of both, and checks that they gave the same digests.
#
#   tests/bench/sweep_bench.sh BUILD_DIR [SEEDS [WORKERS]]
#
# SEEDS is 20, which makes 180 searches; WORKERS is 0: the sweep in one process. With workers run it
# in tests/netns. Nothing else should run on the machine.
set -euo pipefail

build=$(cd "$1" && pwd)
seeds=${2:-20}
workers=${3:-0}
scenarios=$(cd "$(dirname "$0")/../../deploy/scenarios" && pwd)
PATH=$build/bin:$PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
TIMEFORMAT='%R %U %S'

sed "s/^replicates: .*/replicates: $seeds/; s|^base: |&$scenarios/|; s|csv: |&$scenarios/|" \
    "$scenarios/three-cars.yaml" >sweep.yaml
# Pictures take longer than searches, and one by one there would be many more of them: none is drawn.
mkdir bin
ln -s /bin/false bin/gnuplot
PATH=$PWD/bin:$PATH
{ time sobox-coordinator sweep.yaml --quiet --workers "$workers" --out sweep >/dev/null; } 2>together

: >digests
{
    time while IFS=, read -r number car response seed; do
        sobox-coordinator "$scenarios/$car-two-springs.yaml" --set "response=$response" \
            --set search.seed="$seed" --quiet --threads 1 --out "alone-$number" >/dev/null
        sqlite3 -readonly "alone-$number/run.db" 'SELECT hex(digest) FROM search' >>digests
        rm -r "alone-$number"
    done < <(sqlite3 -readonly sweep/run.db "SELECT number, name FROM search ORDER BY number" |
        sed 's/|/,/; s/response=//; s/seed=//')
} 2>apart

sqlite3 -readonly sweep/run.db 'SELECT hex(digest) FROM search ORDER BY number' |
    cmp -s - digests && digests=same || digests=DIFFERENT
designs=$(sqlite3 -readonly sweep/run.db 'SELECT sum(evaluations) FROM search')
awk -v searches="$(wc -l <digests)" -v designs="$designs" -v cores="$(nproc)" -v digests="$digests" '
    { wall[FILENAME] = $1; busy[FILENAME] = $2 + $3 }
    END {
        printf "%d searches, %d designs, %d cores; digests of sweep and searches: %s\n",
            searches, designs, cores, digests
        printf "%-22s %10s %16s %12s\n", "", "wall [s]", "processor [s]", "us a design"
        printf "%-22s %10.2f %16.2f %12.2f\n", "as a sweep", wall["together"], busy["together"],
            1e6 * busy["together"] / designs
        printf "%-22s %10.2f %16.2f %12.2f\n", "one by one, one core", wall["apart"], busy["apart"],
            1e6 * busy["apart"] / designs
        printf "the sweep took %.0f %% of the time that the searches alone would take %d cores\n",
            100 * wall["together"] / (busy["apart"] / cores), cores
    }' together apart
