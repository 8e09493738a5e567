# Runs seen again: recorded by LCM's own tools, or from their journal.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# The status messages travel on the third port.
readonly status_url='udpm://239.255.76.67:7669?ttl=0'

# _start_page NAME ARGUMENT...: a monitor with a page, whose address is then in $page.
_start_page() {
    local name=$1
    shift
    start "$name" sobox-monitor --http 127.0.0.1:0 --quiet "$@"
    wait_for_line "$name" 'the page is at'
    page=$(sed -n 's/.*the page is at //p' "$name.err")
}

_state() {
    curl --silent --fail --max-time "$patience" --output "$1" "${page}state.json$2"
}

_tells() {
    _state "$1" '' && [ "$(json "$1" '$.runs[0].state')" = "$2" ]
}

# What the page draws of the only search: status, box and counts, to the last digit that is told.
_search() {
    _state "$1" "?run=$(json "$1" '$.runs[0].id')&search=0"
    json "$1" '$.chosen.bounds.lower'
    json "$1" '$.chosen.bounds.upper'
    json "$1" '$.chosen.state.status'
    json "$1" '$.chosen.state.evaluations'
    json "$1" '$.chosen.state.log_volume'
}

_has_grown() {
    [ "$(wc -c <"$1")" -gt "$2" ]
}

recorded_run_ends_with_the_same_corridors()
{
    _start_page live --url "$url"
    start logger lcm-logger --lcm-url="$status_url" --flush-interval=10 run.log
    start worker sobox-worker --url "$url"
    wait_until 'the logger hears the worker' _has_grown run.log 100
    run 0 sobox-coordinator "$scenario" --out run --url "$url" "${steady[@]}"
    wait_until 'the end is told' _tells live.json 'done'
    _search live.json >live.txt
    signal TERM worker
    finish 0 worker
    signal TERM live
    finish 0 live
    # The logger writes what it heard when it is asked to end.
    signal INT logger
    wait_until 'the logger ends' _has_ended logger

    _start_page again --url "$url"
    run 0 lcm-logplayer --speed=100 --lcm-url="$status_url" run.log
    wait_until 'the end is told again' _tells again.json 'done'
    _search again.json >again.txt
    cmp live.txt again.txt || fail "the corridors differ: $(diff live.txt again.txt)"
}

# The box of the journal is that of the result, and every step of the history is there.
run_folder_tells_the_whole_history()
{
    run 0 sobox-coordinator "$scenario" --out run
    _start_page monitor --from run
    wait_until 'the end is told' _tells state.json 'done'
    _search state.json >/dev/null
    expect_equal "$(json state.json '$.chosen.scenario.springs[0]')" front 'the first spring'
    expect_equal "$(json state.json '$.chosen.state.evaluations')" \
        "$(json run/result.json '$.searches[0].evaluations')" 'evaluations'
    expect_equal "$(printf '%.6g' "$(json state.json '$.chosen.bounds.upper[0]')")" \
        "$(printf '%.6g' "$(json run/result.json '$.searches[0].variables[0].corridor[1]')")" \
        'upper bound of the first variable'
    expect_equal "$(sqlite3 :memory: "SELECT max(value ->> 0) FROM
        json_each(readfile('state.json'), '\$.chosen.steps.points')")" \
        "$(journal run 'SELECT count(*) FROM step')" 'steps of the history'
}

# Nobody stays to look: the finished run is told once.
finished_run_folder_is_told_once()
{
    run 0 sobox-coordinator "$scenario" --out run
    run 0 sobox-monitor --from run
    expect_one_line out
    expect_said out 'short: done'
    run 0 sobox-monitor --from run --json
    expect_one_line out
    run 1 sobox-monitor --from nowhere
    run 2 sobox-monitor --from run --url "$url"
}

running_run_folder_is_followed()
{
    start coordinator sobox-coordinator "$scenario" --out run "${steady[@]}"
    hold coordinator run 2
    start monitor sobox-monitor --from run --plain
    wait_for_line monitor 'short: running'
    go_on coordinator
    finish 0 coordinator
    finish 0 monitor
    expect_said monitor.out 'short: done'
}

# What a live monitor shows of a step is what the journal tells of it: the same designs to the bit,
# with the same verdicts.
samples_seen_live_are_those_of_the_journal()
{
    _start_page live --url "$url"
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url"
    wait_until 'the end is told' _tells live.json 'done'
    local id step
    id=$(json live.json '$.runs[0].id')
    _state live.json "?run=$id&search=0"
    step=$(json live.json '$.chosen.samples.steps[0][0]')
    curl --silent --fail --output live.csv "${page}samples.csv?run=$id&search=0&step=$step"
    signal TERM live
    finish 0 live
    _start_page again --from run
    _state again.json "?run=$id&search=0"
    curl --silent --fail --output again.csv "${page}samples.csv?run=$id&search=0&step=$step"
    expect_said live.csv '^0,[01],.*[.]'
    # All but names: so short a run is over before the live monitor has heard its scenario.
    tail -n +2 live.csv | cut -d , -f 1,2,4- >live.txt
    tail -n +2 again.csv | cut -d , -f 1,2,4- >again.txt
    cmp live.txt again.txt || fail "the samples of step $step differ"
}
