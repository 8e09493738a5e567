# The monitor's web server, asked by curl as browsers and others ask.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# Starts a monitor with a page; its address is then in $page.
_start_page() {
    start monitor sobox-monitor --url "$url" --http 127.0.0.1:0 --quiet
    wait_for_line monitor 'the page is at'
    page=$(sed -n 's/.*the page is at //p' monitor.err)
}

# _fetch STATUS PATH [ARGUMENT]...: asks for a path and expects this HTTP status; the answer is in
# body, its headers in headers.
_fetch() {
    local expected=$1 path=$2
    shift 2
    local found
    found=$(curl --silent --max-time "$patience" --output body --dump-header headers \
        --write-out '%{http_code}' "$@" "${page%/}$path")
    expect_equal "$found" "$expected" "HTTP status of $path $*"
}

# Asks for the picture and takes a value out of it.
_state() {
    _fetch 200 "/state.json$1"
    json body "$2"
}

_bound() {
    printf '%.6g' "$(json "$1" "$2")"
}

page_and_its_files_come_from_the_program()
{
    _start_page
    _fetch 200 /
    local file
    for file in $(grep -oE '(href|src)="/[a-z]+[.](css|js)"' body | cut -d '"' -f 2); do
        _fetch 200 "$file"
        [ "$(wc -c <body)" -gt 1000 ] || fail "$file is nearly empty"
    done
    _fetch 404 /nothing
    _fetch 405 / --request POST --data x
    _fetch 404 '/../../etc/passwd' --path-as-is
}

# Nothing on the page refers to another host, and the browser is told to allow none.
nothing_comes_from_elsewhere()
{
    _start_page
    local file
    for file in / /page.css /page.js /figures.js /xray.js /sweep.js; do
        _fetch 200 "$file"
        expect_said headers "Content-Security-Policy: default-src 'none'"
        expect_said headers 'X-Content-Type-Options: nosniff'
        ! grep -i 'access-control' headers || fail "$file is offered to other sites"
        ! grep -E 'https?://' body | grep -v 'http://www.w3.org/2000/svg' ||
            fail "$file refers to another host"
    done
}

# A page of somebody else gets nothing: neither under a name that leads here, nor across sites.
other_sites_are_refused()
{
    _start_page
    local path
    for path in / /events /state.json; do
        _fetch 421 "$path" --header 'Host: evil.example:8765'
        _fetch 421 "$path" --header 'Host: localhost.evil.example'
    done
    _fetch 403 /events --header 'Sec-Fetch-Site: cross-site'
    _fetch 403 /state.json --header 'Sec-Fetch-Site: same-site'
    _fetch 200 / --header 'Sec-Fetch-Site: cross-site'
    _fetch 200 /state.json --header 'Host: localhost:9000'
}

# Requests without end and connections without number find limits, and the page is served after.
limits_hold()
{
    _start_page
    _fetch 431 / --header "X: $(head -c 40000 /dev/zero | tr '\0' x)"
    _fetch 400 '/events?run=nonsense'
    local i
    for i in $(seq 60); do
        start "viewer-$i" curl --silent --no-buffer --max-time 600 \
            --write-out 'status %{http_code}\n' "${page}events"
    done
    wait_until 'a viewer too many is refused' grep -qs 'status 503' viewer-{1..60}.out
    _fetch 200 /
    for i in $(seq 60); do
        signal TERM "viewer-$i" 2>/dev/null || true
    done
    wait_until 'there is room again' _streams
}

_streams() {
    curl --silent --max-time 3 "${page}events" >stream || true
    grep -qs '^data: ' stream
}

run_is_told_live_with_its_scenario()
{
    _start_page
    start stream curl --silent --no-buffer --max-time 600 "${page}events"
    wait_for_line stream '"reset":true'
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url" "${steady[@]}"
    wait_for_line stream '"state":"done"'
    expect_equal "$(grep -c reset stream.out)" 1 'events that begin anew'
    local id
    id=$(_state '' '$.runs[0].id')
    expect_equal "$(_state "?run=$id&search=0" '$.chosen.scenario.springs[0]')" front 'first spring'
    expect_equal "$(_state "?run=$id&search=0" '$.chosen.state.status')" 'done' 'status of the search'
    # The corridors at the end are those of the run folder, as precisely as they are told.
    _fetch 200 "/state.json?run=$id&search=0"
    expect_equal "$(_bound body '$.chosen.bounds.upper[0]')" \
        "$(_bound run/result.json '$.searches[0].variables[0].corridor[1]')" \
        'upper bound of the first variable'
    signal TERM stream
}

# Three cases, two of them over: a monitor that comes now hears of all, by name and with their results.
late_monitor_hears_of_all_cases()
{
    cat >sweep.yaml <<EOF
sweep: sizes
base: $scenario
axes:
  - {path: search.samples, values: [100, 150, 400000]}
EOF
    start worker sobox-worker --url "$url" --threads 1
    start coordinator sobox-coordinator sweep.yaml --out run --url "$url" --threads 1 \
        --set search.exploration_steps=100 --set search.consolidation_steps=100 \
        --set search.promise=points
    wait_until 'two cases are over' _are_over 2
    _start_page
    wait_until 'the monitor hears of all cases' _knows_all_cases
    expect_equal "$(json body '$.chosen.cases.axes[1]')" search.samples 'path of the axis'
    expect_equal "$(sqlite3 :memory: "SELECT value ->> 1 || ' ' || (value ->> 2) FROM
        json_each(readfile('body'), '\$.chosen.cases.cases') WHERE value ->> 0 = 1")" \
        'samples=150 150' 'the second case'
    press_ctrl_c coordinator
    finish 130 coordinator
}

_are_over() {
    [ "$(journal run 'SELECT count(*) FROM search WHERE finished' 2>/dev/null)" = "$1" ]
}

_knows_all_cases() {
    _fetch 200 /state.json
    local id
    id=$(json body '$.runs[0].id')
    [ -n "$id" ] || return 1
    _fetch 200 "/state.json?run=$id"
    [ "$(sqlite3 :memory: "SELECT count(*) FROM json_each(readfile('body'), '\$.searches')
        WHERE value ->> 'status' IN ('done', 'purity_missed', 'no_good_design')")" = 2 ] &&
        [ "$(sqlite3 :memory: "SELECT json_array_length(readfile('body'), '\$.chosen.cases.cases')")" = 3 ]
}

monitor_ends_with_viewers_connected()
{
    _start_page
    start stream curl --silent --no-buffer --max-time 600 "${page}events"
    wait_for_line stream '"reset":true'
    signal TERM monitor
    finish 0 monitor
}

address_that_is_none_is_refused()
{
    run 2 sobox-monitor --url "$url" --http example.org:80
    expect_said err 'expected ADDRESS:PORT'
    run 2 sobox-monitor --url "$url" --http 127.0.0.1:99999
    run 1 sobox-monitor --url "$url" --http 192.0.2.1:8765
    expect_said err '192.0.2.1:8765: '
}
