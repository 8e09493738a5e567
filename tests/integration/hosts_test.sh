# A cluster of five hosts in every kind of trouble: packets that are lost, doubled and overtaken,
# machines that die or hang, a network that falls apart. The result is that of a run without any of
# it, to the bit.
#
# ROUNDS in the environment makes the runs that many times as long, with as many times the trouble;
# SEED repeats what chance decided.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables
# shellcheck source=tests/integration/hosts.bash
source "$here/hosts.bash"

readonly rounds=${ROUNDS:-1}

# Options of a run of about COUNT steps: small ones, as hard on the network as it gets.
_long_run() # COUNT
{
    options=(--set search.exploration_steps=$(($1 * rounds)) --set search.target_purity=0.5)
}

# What chance decides comes from a seed, which a failed test shows.
_draw_seed()
{
    seed=${SEED:-$RANDOM}
    RANDOM=$seed
    echo "seed $seed"
}

# draw FIRST LAST: `drawn` becomes one of these numbers.
_draw()
{
    drawn=$(($1 + RANDOM % ($2 - $1 + 1)))
}

_pause() # MILLISECONDS
{
    sleep "$(($1 / 1000)).$(printf %03d $(($1 % 1000)))"
}

_start_run()
{
    run 0 sobox-coordinator "$scenario" "${options[@]}" --out calm
    start_workers
    start coordinator on 1 sobox-coordinator "$scenario" "${options[@]}" --out stormy --url "$far"
}

# Waits until the run has gone on by so many steps.
_wait_for_more_steps() # COUNT
{
    wait_for_steps stormy 0
    wait_for_steps stormy $((steps + $1))
}

# Waits until the run has gone on by some steps, and to a moment somewhere in the next one.
_wait_at_random() # LEAST GREATEST
{
    _draw "$1" "$2"
    _wait_for_more_steps "$drawn"
    _draw 0 9
    _pause "$drawn"
}

# ---- Weather ----

_run_in_weather() # LOSS
{
    _long_run 100
    make_hosts 5
    join_by_switch "$1" 10 0.3 1
    _start_run
    finish 0 coordinator
    expect_same_run calm stormy
    signal TERM switch
    finish 0 switch
    cat switch.out
    expect_said switch.out ' [1-9][0-9]* doubled'
    [ "$1" -eq 0 ] || expect_said switch.out ' [1-9][0-9]* lost'
}

frames_delayed_doubled_and_overtaken_change_nothing()
{
    _run_in_weather 0
}

one_frame_in_100_lost_changes_nothing()
{
    _run_in_weather 1
}

one_frame_in_10_lost_changes_nothing()
{
    _run_in_weather 10
}

three_frames_in_10_lost_change_nothing()
{
    _run_in_weather 30
}

# ---- Workers ----

# A new worker starts on the host of each that is killed.
workers_killed_at_random_times_change_nothing()
{
    _draw_seed
    _long_run 200
    make_hosts 5
    join_by_switch 1 1 1 1
    _start_run
    wait_for_steps stormy 1
    local kills=0 number
    while [ "$kills" -lt $((8 * rounds)) ] && ! _has_ended coordinator; do
        _wait_at_random 2 15
        _draw 2 5
        number=$drawn
        signal KILL "worker-$number"
        finish 137 "worker-$number"
        start "worker-$number" on "$number" sobox-worker --url "$far" --threads 1
        kills=$((kills + 1))
    done
    finish 0 coordinator
    [ "$kills" -ge 4 ] || fail "only $kills workers were killed before the run was over"
    expect_same_run calm stormy
}

# Each in turn, until the others have gone on without it; two at once at times. What they answer when
# they thaw is long out of date.
workers_frozen_for_longer_than_their_leases_change_nothing()
{
    _long_run 120
    make_hosts 5
    join_by_switch 0 0 1 0
    _start_run
    wait_for_steps stormy 1
    local number next
    for number in 2 3 4 5; do
        next=$((number % 4 + 2))
        signal STOP "worker-$number"
        _wait_for_more_steps 5
        signal STOP "worker-$next"
        _wait_for_more_steps 5
        signal CONT "worker-$number"
        signal CONT "worker-$next"
    done
    finish 0 coordinator
    expect_same_run calm stormy
}

# Its kernel might give other bits: none of its outcomes counts, and the user is told why it idles.
worker_of_another_version_is_refused()
{
    _long_run 20
    make_hosts 5
    join_by_bridge
    run 0 sobox-coordinator "$scenario" "${options[@]}" --out calm
    start old on 2 sobox-worker-of-old --url "$far" --threads 1
    start coordinator on 1 sobox-coordinator "$scenario" "${options[@]}" --out stormy --url "$far"
    wait_for_line coordinator 'refused: its kernel or version differs'
    wait_for_line coordinator 'no worker is there \(1 refused\)'
    start worker on 3 sobox-worker --url "$far" --threads 1
    finish 0 coordinator
    expect_same_run calm stormy
    # It has nothing to do with this run, and waits for one that it fits.
    ! _has_ended old || fail 'the worker of another version has ended'
}

# ---- The network in pieces ----

# One half of the workers is cut off, then the other half, then the coordinator itself: each time the
# run must go on with those it reaches, and those that were cut off must find back.
partition_heals()
{
    _long_run 500
    make_hosts 5
    join_by_bridge
    _start_run
    wait_for_steps stormy 1
    cut_off 2
    cut_off 3
    _wait_for_more_steps 10
    mend 2
    mend 3
    cut_off 4
    cut_off 5
    _wait_for_more_steps 10
    cut_off 1
    _pause 500
    mend 4
    mend 5
    mend 1
    finish 0 coordinator
    expect_same_run calm stormy
}

# ---- The coordinator ----

coordinator_killed_twenty_times_resumes_to_the_same_bits()
{
    _draw_seed
    _long_run 600
    make_hosts 5
    join_by_switch 1 1 1 1
    _start_run
    local kills=0
    while [ "$kills" -lt $((20 * rounds)) ]; do
        kills=$((kills + 1))
        # 0 steps: while it still finds its feet.
        _wait_at_random 0 20
        hold coordinator stormy 0
        signal KILL coordinator
        finish 137 coordinator
        start coordinator on 1 sobox-coordinator --resume stormy --url "$far"
    done
    finish 0 coordinator
    expect_same_run calm stormy
}

# ---- Several runs ----

# What each of them gets of the workers is a claim of coordinator/schedule/sharing_test, whose clock is
# not the machine's.
two_coordinators_share_three_workers()
{
    local large=(--set search.samples=8000 --set search.exploration_steps=$((20 * rounds))
        --set search.target_purity=0.5)
    run 0 sobox-coordinator "$scenario" "${large[@]}" --out calm
    make_hosts 5
    join_by_bridge
    local number name
    start one on 1 sobox-coordinator "$scenario" "${large[@]}" --out one --url "$far"
    start two on 2 sobox-coordinator "$scenario" "${large[@]}" --out two --url "$far"
    # Neither begins before the other is there.
    for name in one two; do
        wait_for_line $name 'waiting for a worker'
    done
    for number in 3 4 5; do
        start "worker-$number" on "$number" sobox-worker --url "$far" --threads 1
    done
    for name in one two; do
        finish 0 $name
        expect_same_run calm $name
    done
}

# A small run beside one that would take all workers for as long as it lasts.
small_run_is_not_starved_by_a_huge_one()
{
    run 0 sobox-coordinator "$scenario" --out calm
    make_hosts 5
    join_by_bridge
    local number
    for number in 3 4 5; do
        start "worker-$number" on "$number" sobox-worker --url "$far" --threads 1
    done
    start huge on 1 sobox-coordinator "$scenario" --out huge --url "$far" \
        --set search.samples=1000000 --set search.exploration_steps=10000
    wait_for_steps huge 1
    start small on 2 sobox-coordinator "$scenario" --out small --url "$far"
    finish 0 small
    ! _has_ended huge || fail 'the huge run has ended'
    expect_same_run calm small
}
