#!/bin/bash
# What lost packets cost: the same search over workers on hosts of their own (network namespaces on
# a bridge), while the bridge drops 0, 1, 10 and 30 % of the packets to each host, once around and
# again ROUNDS times. Prints the middle of each loss's times and the throughput relative to the one
# without loss in the same run; compare nothing else.
#
#   tests/netns tests/bench/loss_bench.sh BUILD_DIR [WORKERS [ROUNDS [SCENARIO.yaml [OPTION...]]]]
#
# Needs nft (package nftables). Options are the coordinator's.
set -euo pipefail

bench=$(cd "$(dirname "$0")" && pwd)
here=$bench/../integration
build=$(cd "$1" && pwd)
workers=${2:-2}
rounds=${3:-5}
problem=$(realpath "${4:-$bench/../../deploy/scenarios/sedan-two-springs.yaml}")
shift $(($# < 4 ? $# : 4))
PATH=$build/bin:$PATH
# shellcheck source=tests/integration/tools.bash
source "$here/tools.bash"
# shellcheck source=tests/integration/hosts.bash
source "$here/hosts.bash"
command -v nft >/dev/null || fail 'nft is missing: install nftables'

lose() { # PERCENT of what the bridge hands to each port
    nft flush chain bridge weather forward
    [ "$1" -eq 0 ] ||
        nft add rule bridge weather forward numgen random mod 100 '<' "$1" drop
}

middle() { # of the numbers in a file
    sort -g "$1" | awk '{value[NR] = $1} END {print value[int((NR + 1) / 2)]}'
}

begin
make_hosts $((workers + 1))
join_by_bridge
nft add table bridge weather
nft add chain bridge weather forward '{ type filter hook forward priority 0; }'
start_workers
losses=(0 1 10 30)
for round in $(seq "$rounds"); do
    for loss in "${losses[@]}"; do
        lose "$loss"
        (on 1 sobox-coordinator "$problem" --quiet --out "run-$loss-$round" --url "$far" "$@") \
            >"coordinator.out" 2>"coordinator.err"
        json "run-$loss-$round/result.json" '$.searches[0].wall_s' >>"wall-$loss"
    done
done

calm=$(middle wall-0)
printf '%d workers, %d steps, middle of %d runs\n' "$workers" \
    "$(json run-0-1/result.json '$.searches[0].steps')" "$rounds"
printf '%8s %10s %12s %12s  %s\n' 'loss' wall_s ms/step throughput digest
for loss in "${losses[@]}"; do
    awk -v loss="$loss" -v wall="$(middle "wall-$loss")" -v calm="$calm" \
        -v steps="$(json run-0-1/result.json '$.searches[0].steps')" \
        -v digest="$(digest "run-$loss-1")" 'BEGIN {
        printf "%6d %% %10.3f %12.3f %10.0f %%  %s\n",
               loss, wall, 1000 * wall / steps, 100 * calm / wall, digest }'
done
