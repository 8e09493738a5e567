#!/bin/sh
# How long a search step takes through the cluster: one scenario in the process and over 1, 2 and 3
# worker processes, the same seed, so the same steps. Prints a table; compare its rows with each
# other, not with another machine's.
#
#   tests/netns tests/bench/cluster_bench.sh BUILD_DIR [SCENARIO.yaml [COORDINATOR OPTION...]]
set -eu
build=$1
scenario=${2:-$(dirname "$0")/../../deploy/scenarios/sedan-two-springs.yaml}
shift
[ $# -eq 0 ] || shift
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# One number of result.json, which has one key a line.
number() { sed -n "s/.*\"$2\": *\([0-9.e+-]*\).*/\1/p" "$folder/$1/result.json" | head -n 1; }

printf '%-12s %8s %8s %12s %10s %12s  %s\n' workers wall_s steps designs ms/step designs/s digest
for workers in in-process 1 2 3; do
    case $workers in
    in-process) option= ;;
    *) option="--workers $workers --threads 1" ;;
    esac
    # shellcheck disable=SC2086
    "$build/bin/sobox-coordinator" "$scenario" --quiet --out "$folder/$workers" $option "$@" >/dev/null
    digest=$(sed -n 's/.*"digest": *"\([0-9a-f]*\)".*/\1/p' "$folder/$workers/result.json")
    awk -v workers="$workers" -v wall="$(number "$workers" wall_s)" -v steps="$(number "$workers" steps)" \
        -v designs="$(number "$workers" evaluations)" -v digest="$digest" 'BEGIN {
        printf "%-12s %8.3f %8d %12d %10.3f %12.0f  %s\n",
               workers, wall, steps, designs, 1000 * wall / steps, designs / wall, digest }'
done
