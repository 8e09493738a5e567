# Whatever arrives on the ports, neither coordinator nor worker crashes, grows or goes astray.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# [KiB] a program may grow by under fire. Queues that were never used before fill up: 8192 messages
# a kind, the largest of them some KB.
readonly growth_max=100000

_memory() { # NAME: resident now [KiB]
    awk '/^VmRSS/ { print $2 }' "/proc/${process[$1]}/status"
}

# _under_fire COUNT OPTION...: a run that waits, mid-run and while it ends is fired at with COUNT
# packets of noise, damage and hostile numbers; the result is that of a calm run.
_under_fire() {
    local count=$1 before after name
    shift
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url" "$@"
    wait_for_line coordinator 'waiting for a worker'
    start monitor sobox-monitor --url "$url" --json "$@"
    wait_for_line monitor short
    before=$(_memory coordinator)
    # While it waits nothing but the packets happens.
    run 0 stranger forge "$count" 1
    after=$(_memory coordinator)
    [ $((after - before)) -lt $growth_max ] || fail "the coordinator grew from $before to $after KiB"

    start worker sobox-worker --url "$url" --threads 1 "$@"
    start stranger stranger forge "$count" 2
    finish 0 coordinator
    finish 0 stranger
    expect_same_run calm stormy
    [ "$(_memory worker)" -lt $((growth_max + before)) ] ||
        fail "the worker has grown to $(_memory worker) KiB"
    for name in worker monitor; do
        signal TERM $name
        finish 0 $name
    done
    # People are told, but not packet by packet.
    for name in coordinator worker monitor; do
        [ "$(wc -l <$name.err)" -lt 200 ] || fail "$name said $(wc -l <$name.err) lines"
    done
}

hundred_thousand_packets_do_not_disturb_a_run_in_clear()
{
    _under_fire 100000
}

hundred_thousand_packets_do_not_disturb_a_sealed_run()
{
    run 0 sobox-coordinator --new-key key
    _under_fire 100000 --key-file key
}
