# A key keeps strangers out of a cluster: they can neither read along, nor take part, nor stop or
# change a run, and what they have recorded is worth nothing.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_new_key() { # FILE
    run 0 sobox-coordinator --new-key "$1"
}

# The 64 digits of a key.
_digits() { # FILE
    sed -n 2p "$1"
}

# Every way to run gives the same result with a key as without.
sealed_run_gives_the_same_result()
{
    _new_key key
    run 0 sobox-coordinator "$scenario" --out clear
    run 0 sobox-coordinator "$scenario" --out inside --key-file key
    expect_same_run clear inside
    run 0 sobox-coordinator "$scenario" --out local --key-file key --workers 2
    expect_same_run clear local
    start worker sobox-worker --url "$url" --key-file key --mtu 9000
    run 0 sobox-coordinator "$scenario" --out outside --key-file key --url "$url"
    expect_same_run clear outside
    run 0 sobox-coordinator "$scenario" --out large --key-file key --url "$url" --mtu 9000
    expect_same_run clear large
}

# A killed worker, a new one, and a resumed coordinator are all let in.
sealed_run_survives_its_workers_and_its_coordinator()
{
    _new_key key
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start first sobox-worker --url "$url" --key-file key
    start killed sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url" --key-file key
    hold killed stormy 2
    signal KILL first
    signal KILL killed
    start second sobox-worker --url "$url" --key-file key
    run 0 sobox-coordinator --resume stormy --url "$url" --key-file key
    expect_same_run calm stormy
}

keyed_machines_find_each_other()
{
    _new_key key
    run 0 sobox-coordinator "$scenario" --out here
    make_other_machine
    local far='udpm://239.255.76.67:7667?ttl=1'
    start worker "${on_other_machine[@]}" sobox-worker --url "$far" --key-file key
    run 0 sobox-coordinator "$scenario" --out there --url "$far" --key-file key
    expect_same_run here there
    ! grep 'without a key' err || fail 'there is a key'
}

# ---- The file ----

new_key_is_private_and_never_overwrites()
{
    local digits
    _new_key key
    expect_equal "$(stat -c %a key)" 600 'mode of the key'
    digits=$(_digits key)
    [[ $digits =~ ^[0-9a-f]{64}$ ]] || fail "digits of the key: $digits"
    run 2 sobox-coordinator --new-key key
    expect_said err 'never overwritten'
    expect_one_line err
    expect_equal "$(_digits key)" "$digits" 'the key'
    _new_key other
    [ "$(_digits other)" != "$digits" ] || fail 'two keys are the same'
    run 2 sobox-coordinator --new-key third "$scenario"
    expect_no third
}

_expect_refused() { # PATTERN
    local program
    for program in "sobox-coordinator $scenario --out run" sobox-worker sobox-monitor; do
        # shellcheck disable=SC2086 # a program with its arguments
        run 2 $program --key-file key
        expect_said err "$1"
        expect_one_line err
        expect_no run
    done
}

key_file_that_is_no_secret_is_refused()
{
    _expect_refused 'key: .*--new-key'
    _new_key key
    chmod 640 key
    _expect_refused "key: .*mode 0640.*'chmod 600 key'"
    chmod 604 key
    _expect_refused "key: .*mode 0604.*'chmod 600 key'"
    mv key target
    ln -s target key
    _expect_refused "'chmod 600 key'"
    rm key
    head -c 90 target >key
    chmod 600 key
    _expect_refused 'not a key file: expected .*64 hexadecimal digits'
    rm key
    mkdir key
    _expect_refused 'expected a key file'
}

# Not in the list of processes, not in their environment, not in what they write.
key_shows_nowhere()
{
    local digits pids
    _new_key key
    digits=$(_digits key)
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run --workers 1 --key-file key --verbose
    hold coordinator run 1
    pids="${process[coordinator]} $(local_workers coordinator)"
    local pid
    for pid in $pids; do
        ! grep -qa "${digits:0:16}" "/proc/$pid/cmdline" "/proc/$pid/environ" ||
            fail "the key is an argument or in the environment of $pid"
    done
    go_on coordinator
    finish 0 coordinator
    local bytes
    # shellcheck disable=SC2001 # two digits at a time
    bytes=$(sed 's/../\\x&/g' <<<"${digits:0:32}")
    ! LC_ALL=C grep -rqaP "${digits:0:16}|$bytes" run coordinator.err coordinator.out ||
        fail 'the key is in the run folder or a log'
}

# ---- Who has another key, or none ----

# never_used COORDINATOR-PATTERN WORKER-PATTERN -- COORDINATOR-OPTIONS -- WORKER-OPTIONS: such a
# worker gets no batch, both sides say why, and one with the right options does the work.
_never_used() {
    local told_coordinator=$1 told_worker=$2
    shift 3
    local options=()
    while [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    shift
    start stranger-worker sobox-worker --url "$url" "$@"
    wait_for_line stranger-worker 'listening on'
    start coordinator sobox-coordinator "$scenario" --out run --url "$url" "${options[@]}"
    wait_for_line coordinator "$told_coordinator"
    wait_for_line stranger-worker "$told_worker"
    wait_for_line coordinator 'waiting for a worker'
    start worker sobox-worker --url "$url" "${options[@]}"
    finish 0 coordinator
    signal TERM stranger-worker
    finish 0 stranger-worker
    expect_said stranger-worker.err 'ends after 0 batches'
}

worker_with_another_key_is_never_used_and_both_say_so()
{
    _new_key key
    _new_key other
    _never_used 'does not open.*another --key-file' 'does not open.*another --key-file' -- \
        --key-file key -- --key-file other
}

worker_without_the_key_is_never_used_and_both_say_so()
{
    _new_key key
    _never_used 'without a key.*not listened to' 'sealed with a key.*--key-file' -- --key-file key --
}

worker_with_a_key_is_never_used_by_a_run_without_and_both_say_so()
{
    _new_key key
    _never_used 'sealed with a key.*--key-file' 'without a key.*not listened to' -- -- --key-file key
}

# The names of the keys tell which is which.
name_of_a_key_is_the_same_everywhere()
{
    local name
    _new_key key
    _new_key other
    cp -p key copy
    start one sobox-worker --url "$url" --key-file key
    start two sobox-worker --url "$url" --key-file copy
    start three sobox-worker --url "$url" --key-file other
    wait_for_line one 'with the key ....-....'
    name=$(grep -oE 'key ....-....' one.err)
    wait_for_line two "with the $name"
    wait_for_line three 'with the key ....-....'
    ! grep -q "$name" three.err || fail 'two keys have one name'
}

# ---- Strangers ----

# Words of the scenario that cross the network when a worker asks for it.
readonly words=(springs deformation firewall_distance exploration_steps short)

# _recorded NAME OPTION...: a run with everything recorded that crossed the network.
_recorded() {
    local name=$1
    shift
    start "tape-$name" stranger record "$name.tape"
    wait_for_line "tape-$name" recording
    start "worker-$name" sobox-worker --url "$url" "$@"
    run 0 sobox-coordinator "$scenario" --out "$name" --url "$url" "$@"
    signal TERM "worker-$name"
    finish 0 "worker-$name"
    signal TERM "tape-$name"
    finish 143 "tape-$name"
    expect_files "$name.tape"
}

# Without a key every word can be read, so the same search finds nothing for no other reason.
stranger_reads_nothing()
{
    local word
    _new_key key
    _recorded clear
    _recorded sealed --key-file key
    for word in "${words[@]}"; do
        grep -qaF "$word" clear.tape || fail "'$word' was not recorded in clear"
        ! grep -qaF "$word" sealed.tape || fail "'$word' can be read"
    done
    grep -qa SOBOX_TEXT sealed.tape || fail 'no text was recorded'
}

# Everything that was sent in an earlier run, played again and again to a worker, a coordinator and a
# monitor of a later one: nobody rises from the dead, nothing is counted twice.
recording_of_an_earlier_run_is_worth_nothing()
{
    _new_key key
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    _recorded earlier --key-file key
    start monitor sobox-monitor --url "$url" --key-file key --json
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out later --url "$url" --key-file key
    run 0 stranger replay earlier.tape
    wait_for_line coordinator 'waiting for a worker'
    start worker sobox-worker --url "$url" --key-file key --threads 1
    wait_for_steps later 1
    for _ in 1 2 3 4 5; do
        run 0 stranger replay earlier.tape
        expect_said out 'replayed [1-9]'
    done
    finish 0 coordinator
    expect_same_run calm later
    wait_for_line monitor '"state": *"done"'
    signal TERM monitor
    finish 0 monitor
    tail -n 1 monitor.out >last.json
    expect_equal "$(sqlite3 :memory: "SELECT json_array_length(readfile('last.json'), '$.workers')")" 1 \
        'workers that the monitor knows'
    expect_equal "$(sqlite3 :memory: "SELECT json_array_length(readfile('last.json'), '$.runs')")" 1 \
        'runs that the monitor knows'
    expect_equal "$(json last.json '$.runs[0].samples')" \
        "$(json later/result.json '$.searches[0].evaluations')" 'samples'
}

# In mid-run a stranger repeats, damages and moves what it hears, and adds messages of its own.
stranger_neither_stops_nor_changes_a_run()
{
    _new_key key
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start worker sobox-worker --url "$url" --key-file key --threads 1
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url" --key-file key
    wait_for_steps stormy 1
    run 0 stranger forge 30000 1
    finish 0 coordinator
    expect_same_run calm stormy
    signal TERM worker
    finish 0 worker
}

# LCM's own logger goes on recording. It listens to one port, here that of the status messages.
lcm_logger_records_sealed_messages()
{
    _new_key key
    start logger lcm-logger -q --lcm-url="${url/7667/7669}" run.log
    start worker sobox-worker --url "$url" --key-file key
    wait_until 'the worker is in the log' grep -qsaF SOBOX_WORKER run.log
    run 0 sobox-coordinator "$scenario" --out run --url "$url" --key-file key
    wait_until 'the run is in the log' grep -qaF SOBOX_RUN run.log
    ! grep -qaF short run.log || fail 'the name of the run can be read in the log'
}
