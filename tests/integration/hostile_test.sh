# Whatever arrives on the ports, neither coordinator nor worker crashes, grows or goes astray.
#
# PACKETS in the environment, a hundred thousand by default, says how many packets; each case says what
# they cost. More than a run outlasts go on at the worker and the monitor.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

readonly packets=${PACKETS:-100000}

# [KiB] a program may grow by under fire. Queues that were never used before fill up: 8192 messages
# a kind, the largest of them some KB.
readonly growth_max=100000

_memory() { # NAME: resident now [KiB]
    awk '/^VmRSS/ { print $2 }' "/proc/${process[$1]}/status"
}

_processor_time() { # NAME: used so far [ms]
    awk -v ticks="$(getconf CLK_TCK)" '{ print 1000 * ($14 + $15) / ticks }' \
        "/proc/${process[$1]}/stat"
}

# _under_fire OPTION...: a run that waits, mid-run and while it ends is fired at with packets of noise,
# damage and hostile numbers; the result is that of a calm run.
_under_fire() {
    local before after used name
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url" "$@"
    wait_for_line coordinator 'waiting for a worker'
    start monitor sobox-monitor --url "$url" --json "$@"
    wait_for_line monitor short
    before=$(_memory coordinator)
    used=$(_processor_time coordinator)
    # While it waits nothing but the packets happens.
    run 0 stranger forge "$packets" 1
    after=$(_memory coordinator)
    echo "$packets packets cost the coordinator $(($(_processor_time coordinator) - used)) ms of" \
        "processor time and $((after - before)) KiB"
    [ $((after - before)) -lt $growth_max ] || fail "the coordinator grew from $before to $after KiB"

    start worker sobox-worker --url "$url" --threads 1 "$@"
    start stranger stranger forge "$packets" 2
    finish 0 coordinator
    finish 0 stranger
    expect_same_run calm stormy
    after=$(_memory worker)
    [ "$after" -lt $((growth_max + before)) ] || fail "the worker has grown to $after KiB"
    echo "the worker's run and as many packets took it $(_processor_time worker) ms; it has $after KiB"
    for name in worker monitor; do
        signal TERM $name
        finish 0 $name
    done
    # People are told, but not packet by packet: some lines a second.
    for name in coordinator worker monitor; do
        [ "$(wc -l <$name.err)" -lt $((200 + 10 * SECONDS)) ] ||
            fail "$name said $(wc -l <$name.err) lines in $SECONDS s"
    done
}

packets_of_strangers_do_not_disturb_a_run_in_clear()
{
    _under_fire
}

packets_of_strangers_do_not_disturb_a_sealed_run()
{
    run 0 sobox-coordinator --new-key key
    _under_fire --key-file key
}
