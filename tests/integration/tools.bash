# What the cases of the integration tests are written with: starting programs, waiting for a
# condition, looking into run folders. Sourced by run-case.
#
# Nothing here sleeps in the hope that something has happened by then: every wait names its
# condition and gives up, loudly, after PATIENCE seconds.
# shellcheck shell=bash disable=SC2034,SC2164 # the cases use the variables; set -e is on

readonly here
readonly scenario=$here/short.yaml
readonly url='udpm://239.255.76.67:7667?ttl=0'
# Options of a run that takes long enough to do something to it in its middle: one thread, so that a
# machine with many cores cannot outrun the test.
readonly steady=(--threads 1 --set search.samples=4000 --set search.exploration_steps=30
    --set search.target_purity=0.5)
readonly patience=${PATIENCE:-240}

declare -A process # of each started program, by the name the case gave it

# ---- Life of a case ----

begin() {
    folder=$(mktemp -d)
    trap end EXIT
    cd "$folder"
    # Children inherit it, and theirs do too: what is left at the end can be found by it, also after
    # its parent has gone.
    export SOBOX_CASE=$folder
    # Each started program leads a process group of its own and takes SIGINT as in a terminal.
    set -m
}

end() {
    local status=$? left
    set +e
    for left in $(processes_left); do
        kill -KILL "$left" 2>/dev/null
    done
    # A failure shows what every program said.
    [ "$status" -eq 0 ] || [ "$status" -eq 77 ] || tail -n 40 -- out err *.out *.err 2>/dev/null
    cd /
    rm -rf "$folder"
    exit "$status"
}

# The processes that the case started, itself excepted: those whose environment carries its name.
processes_left() {
    { env --unset=SOBOX_CASE grep -lszxF "SOBOX_CASE=$folder" /proc/[0-9]*/environ || true; } |
        cut -d / -f 3
}

fail() {
    # The innermost line that stands in a case's own file.
    local level=1
    while [[ ${BASH_SOURCE[level]} == */tools.bash ]]; do
        level=$((level + 1))
    done
    printf '%s:%s: %s\n' "${BASH_SOURCE[level]}" "${BASH_LINENO[level - 1]}" "$1" >&2
    exit 1
}

# skip WHY: the case cannot be carried out here; ctest shows it as skipped.
skip() {
    echo "skipped: $1"
    exit 77
}

# ---- Programs ----

# run STATUS COMMAND...: runs a program to its end and expects this exit status. What it said is in
# the files out and err.
run() {
    local expected=$1 status=0
    shift
    timeout --kill-after=1 "$patience" "$@" >out 2>err || status=$?
    [ "$status" -eq "$expected" ] || fail "$*: ended with status $status, expected $expected"
}

# start NAME COMMAND...: starts a program beside the case. What it says goes to NAME.out, NAME.err.
start() {
    local name=$1
    shift
    "$@" >"$name.out" 2>"$name.err" &
    process[$name]=$!
}

# signal SIGNAL NAME: to this program alone, not to those it started.
signal() {
    kill "-$1" "${process[$2]}"
}

# press_ctrl_c NAME: as a terminal does it, to the program and all that it started.
press_ctrl_c() {
    kill -INT -- "-${process[$1]}"
}

_has_ended() {
    ! kill -0 "${process[$1]}" 2>/dev/null
}

# finish STATUS NAME: waits for a started program to end by itself with this exit status.
finish() {
    local status=0
    wait_until "$2 ends" _has_ended "$2"
    wait "${process[$2]}" || status=$?
    [ "$status" -eq "$1" ] || fail "$2 ended with status $status, expected $1"
}

# The worker processes that a started coordinator started. (Other processes may end while they are
# looked at, which grep takes for a failure.)
local_workers() {
    { grep -lsxE "PPid:[[:blank:]]*${process[$1]}" /proc/[0-9]*/status || true; } | cut -d / -f 3
}

# ---- Waiting ----

# wait_until WHAT CONDITION...: until the command succeeds.
wait_until() {
    local what=$1 deadline=$((SECONDS + patience))
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$deadline" ] || fail "waited $patience s in vain until $what"
        sleep 0.01
    done
}

# wait_for_line NAME PATTERN: until the program has said this.
wait_for_line() {
    wait_until "$1 says '$2'" grep -qsE -e "$2" "$1.out" "$1.err"
}

# wait_for_steps RUN COUNT: until the journal holds so many steps: the run is under way, or over.
# `steps` becomes the number that it holds.
wait_for_steps() {
    steps=$(steps "$1" "$2" "$patience") || fail "$1 does not come to $2 steps"
}

# hold NAME RUN COUNT: stops the program that writes this run as soon as there are so many steps, so
# that what the case does next it does in mid-run, however slow the machine is then. Kill it, or
# let it `go_on`. (What it is sent meanwhile, SIGKILL excepted, it finds when it goes on.)
hold() {
    steps=$(steps "$2" "$3" "$patience" "${process[$1]}") || fail "$1 was not held at step $3"
}

go_on() {
    signal CONT "$1"
}

no_process_left() {
    [ -z "$(processes_left)" ]
}

# ---- Looking ----

# journal RUN SQL: asks the journal of a run folder. Who closes a database as its last user locks it
# for a moment.
journal() {
    sqlite3 -readonly -cmd '.timeout 10000' "$1/run.db" "$2"
}

# json FILE PATH: a value of a JSON file, for instance '$.searches[0].digest'.
json() {
    sqlite3 :memory: "SELECT json_extract(readfile('$1'), '$2')"
}

digest() {
    json "$1/result.json" '$.searches[0].digest'
}

# ---- Expectations ----

expect_equal() { # FOUND EXPECTED WHAT
    [ "$1" = "$2" ] || fail "$3: found '$1', expected '$2'"
}

expect_said() { # FILE PATTERN
    grep -qE -e "$2" "$1" || fail "expected in $1: $2"
}

expect_one_line() { # FILE
    expect_equal "$(wc -l <"$1")" 1 "lines of $1"
}

expect_no() { # PATH
    [ ! -e "$1" ] || fail "$1 is there: $(ls -la "$1")"
}

expect_files() { # PATH...
    local path
    for path; do
        [ -s "$path" ] || fail "$path is missing or empty"
    done
}

# expect_same_run RUN RUN: the same corridors, counts and history, to the bit.
expect_same_run() {
    [ -n "$(digest "$1")" ] || fail "$1 has no digest"
    expect_equal "$(digest "$2")" "$(digest "$1")" "digest of $2 beside that of $1"
    cmp "$1/corridors.csv" "$2/corridors.csv" || fail "the corridors of $1 and $2 differ"
    cmp "$1/history.csv" "$2/history.csv" || fail "the histories of $1 and $2 differ"
}

# ---- Machines ----

# Put before a command, they carry it out where multicast has no way to go, and on the second machine.
readonly without_route=(unshare -n)
on_other_machine=()

# Makes a second machine: a network namespace joined to this one by a cable. The cable carries the
# multicast from now on.
make_other_machine() {
    start other-machine "${without_route[@]}" sh -c 'echo up; exec sleep infinity'
    wait_for_line other-machine up
    on_other_machine=(nsenter "--net=/proc/${process[other-machine]}/ns/net")
    ip link add cable type veth peer name cable netns "${process[other-machine]}"
    ip address add 10.77.0.1/24 dev cable
    ip link set cable up
    ip route replace 239.0.0.0/8 dev cable
    "${on_other_machine[@]}" sh -c '
        ip link set lo up && ip address add 10.77.0.2/24 dev cable && ip link set cable up &&
        ip route add 239.0.0.0/8 dev cable'
}
