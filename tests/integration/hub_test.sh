# Where there is no multicast programs meet at a hub: the run is the same to the bit, the hub may die,
# and clients of any kind harm nobody.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

readonly hub=tcpq://127.0.0.1:7700

_start_hub() # OPTION...
{
    start hub sobox-hub --listen 127.0.0.1:7700 "$@"
    wait_for_line hub 'listening at 127.0.0.1:7700'
}

_start_workers()
{
    start worker-1 sobox-worker --url $hub --threads 1 "$@"
    start worker-2 sobox-worker --url $hub --threads 1 "$@"
}

# What the hub counted, when it is asked for it: "LABEL" stands behind its number.
_count() # LABEL
{
    signal USR1 hub
    wait_for_line hub "[0-9]+ $1"
    count=$(grep -oE "[0-9]+ $1" hub.err | tail -n 1 | cut -d ' ' -f 1)
}

_has_counted() # LEAST LABEL
{
    _count "$2"
    [ "$count" -ge "$1" ]
}

# None of it is a matter of multicast: there is not even a route for it.
run_through_a_hub_gives_the_same_bits()
{
    ip route del 239.0.0.0/8 dev lo
    run 0 sobox-coordinator "$scenario" --out alone
    _start_hub
    _start_workers
    start monitor sobox-monitor --url $hub --json
    run 0 sobox-coordinator "$scenario" --url $hub --out shared
    expect_same_run alone shared
    wait_for_line monitor '"short"'
    signal TERM hub
    finish 0 hub
    expect_said hub.err ' 0 lost to slow clients'
}

# Everybody waits, and is told so, whoever is there first.
hub_may_come_last()
{
    start coordinator sobox-coordinator "$scenario" --url $hub --out shared
    start worker sobox-worker --url $hub --threads 1
    wait_for_line coordinator 'no hub at 127.0.0.1:7700 \(Connection refused\)'
    wait_for_line worker 'no hub at 127.0.0.1:7700'
    _start_hub
    wait_for_line worker 'the hub at 127.0.0.1:7700 is there'
    finish 0 coordinator
}

# What was under way is lost with the hub; leases end, and the batches are done again.
hub_killed_and_started_anew_changes_nothing()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    _start_hub
    _start_workers
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --url $hub --out stormy
    local when
    for when in 2 10 18; do
        hold coordinator stormy $when
        signal KILL hub
        finish 137 hub
        _start_hub
        go_on coordinator
    done
    finish 0 coordinator
    expect_same_run calm stormy
    expect_said worker-1.err 'no hub at 127.0.0.1:7700'
}

# A hub that hangs takes nobody with it: no program waits for it in the middle of a message.
hub_that_hangs_can_be_left()
{
    _start_hub
    start worker sobox-worker --url $hub --threads 1
    wait_for_line worker 'listening on'
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --url $hub --out run
    hold coordinator run 1
    signal STOP hub
    go_on coordinator
    signal TERM worker
    finish 0 worker
    signal INT coordinator
    finish 130 coordinator
    signal CONT hub
}

# LCM's own logger, as Debian ships it, hears every message, unchanged. (It is there when it has heard
# something: the hub counts it before it has subscribed.)
lcm_logger_records_through_the_hub()
{
    _start_hub
    _start_workers
    start logger lcm-logger --lcm-url=tcpq://127.0.0.1:7700 log
    wait_until 'the logger hears the workers' grep -qs SOBOX_WORKER log
    run 0 sobox-coordinator "$scenario" --url $hub --out run
    wait_until 'the log has the status of the run' grep -qs SOBOX_RUN log
    signal INT logger
    wait_until 'the logger ends' _has_ended logger
    # A log has each message behind its channel: played into a hub it is a run to watch.
    start monitor sobox-monitor --url $hub --json
    wait_for_line monitor .
    run 0 lcm-logplayer --lcm-url=tcpq://127.0.0.1:7700 log
    wait_for_line monitor '"short"'
}

# It costs its queue and nothing else.
stopped_client_harms_nobody()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    _start_hub --queue 60000
    _start_workers
    start logger lcm-logger --lcm-url=tcpq://127.0.0.1:7700 log
    wait_until 'the logger hears the workers' grep -qs SOBOX_WORKER log
    signal STOP logger
    # The kernel holds a few megabytes for it before the hub must.
    start flood hub_flood 127.0.0.1 7700 SOBOX_OTHER 400 50000
    finish 0 flood
    wait_for_line hub 'reads too slowly or not at all'
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --url $hub --out shared
    expect_same_run calm shared
    signal CONT logger
}

# Without the key nobody's message is passed on, so a stranger can disturb nothing.
key_is_checked_at_the_hub()
{
    run 0 sobox-coordinator --new-key key
    run 0 sobox-coordinator --new-key other-key
    run 0 sobox-coordinator "$scenario" --out alone
    _start_hub --key-file key
    _start_workers --key-file key
    start clear sobox-worker --url $hub --threads 1
    start other sobox-worker --url $hub --threads 1 --key-file other-key
    start flood hub_flood 127.0.0.1 7700 SOBOX_OUTCOME 50 1000
    finish 0 flood
    run 0 sobox-coordinator "$scenario" --url $hub --key-file key --out shared
    expect_same_run alone shared
    # Each message of the flood, and some of both workers.
    wait_until 'strangers were refused' _has_counted 52 'without the right seal'
}

# Bytes of any kind, and connections by the dozen.
hostile_clients_harm_nobody()
{
    run 0 sobox-coordinator "$scenario" --out alone
    _start_hub --clients 8
    _start_workers
    wait_until 'the workers are there' _has_counted 2 'clients of'
    local one
    for _ in $(seq 30); do
        exec {one}<>/dev/tcp/127.0.0.1/7700
    done
    printf 'GET / HTTP/1.1\r\n\r\n' >&"$one"
    # A hello and a message of 4 GB that never ends.
    exec {large}<>/dev/tcp/127.0.0.1/7700
    printf '\x28\x76\x17\xfb\0\0\1\0\0\0\0\1\0\0\0\1A\xff\xff\xff\xff more' >&"$large"
    wait_until 'somebody is cut off' _has_said_cut_off
    run 0 sobox-coordinator "$scenario" --url $hub --out shared
    expect_same_run alone shared
}

_has_said_cut_off()
{
    grep -q 'is cut off: no hello' hub.err && grep -q 'is cut off: all places' hub.err
}

wrong_usage_of_the_hub_is_refused()
{
    local wrong
    for wrong in '--listen nonsense' '--listen localhost:7700' '--listen 127.0.0.1' \
        '--listen 239.255.76.67:7700' '--listen 127.0.0.1:70000' '--clients 0' '--queue 10' \
        '--message x' '--key-file nowhere' 'argument'; do
        # shellcheck disable=SC2086 # two words
        run 2 sobox-hub $wrong
        expect_one_line err
    done
    run 1 sobox-hub --listen 10.1.2.3:7700
    expect_said err 'cannot listen at 10.1.2.3:7700'
    _start_hub
    run 1 sobox-hub --listen 127.0.0.1:7700
    expect_said err 'in use'
    run 2 sobox-worker --url tcpq://localhost:7700
    expect_said err 'expected numbers'
}
