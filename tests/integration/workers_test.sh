# Workers come and go in mid-run, and nothing is lost or counted twice: the result is that of a run
# without them.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# The batches that the killed worker held are handed out again when it has been silent.
batches_of_a_killed_worker_are_done_by_the_others()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start one sobox-worker --url "$url" --threads 1
    start two sobox-worker --url "$url" --threads 1
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url"
    hold coordinator stormy 2
    signal KILL one
    go_on coordinator
    finish 0 coordinator
    expect_same_run calm stormy
}

# The same for a worker that the coordinator started itself.
killed_local_worker_is_noticed_and_done_without()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --workers 2
    hold coordinator stormy 2
    kill -KILL "$(local_workers coordinator | head -n 1)"
    go_on coordinator
    finish 0 coordinator
    expect_said coordinator.err 'local worker .* ended'
    expect_same_run calm stormy
}

# Nobody is left to do the work and nobody can come: to wait would be to wait for ever.
run_fails_when_all_local_workers_are_killed()
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run --workers 1
    hold coordinator run 2
    kill -KILL "$(local_workers coordinator | head -n 1)"
    go_on coordinator
    finish 1 coordinator
    expect_said coordinator.err 'all local workers have ended.*--resume'
    expect_equal "$(journal run 'SELECT state FROM run')" failed 'state of the run'
}

# Killing the only worker stops the run in its middle whatever the machine's speed; the one that
# comes then must fetch scenario and box by itself.
worker_started_in_mid_run_takes_over()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start first sobox-worker --url "$url" --threads 1
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url"
    hold coordinator stormy 2
    signal KILL first
    go_on coordinator
    start second sobox-worker --url "$url"
    finish 0 coordinator
    expect_same_run calm stormy
}

# A frozen worker looks like a slow one: its batches lapse, and what it sends when it thaws is late
# and counts at most once.
frozen_worker_holds_nothing_up_and_thaws_without_harm()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start one sobox-worker --url "$url" --threads 1
    start two sobox-worker --url "$url" --threads 1
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out stormy --url "$url"
    hold coordinator stormy 2
    signal STOP one
    go_on coordinator
    wait_for_steps stormy 6
    signal CONT one
    finish 0 coordinator
    expect_same_run calm stormy
}

worker_on_another_machine_joins_in()
{
    run 0 sobox-coordinator "$scenario" --out here
    make_other_machine
    local far='udpm://239.255.76.67:7667?ttl=1'
    start worker "${on_other_machine[@]}" sobox-worker --url "$far"
    run 0 sobox-coordinator "$scenario" --out there --url "$far"
    expect_same_run here there
    # Without a key anybody on that network could take part, and the user is told.
    expect_said err 'leave this machine without a key'
}

coordinator_without_a_worker_says_what_it_waits_for()
{
    start coordinator sobox-coordinator "$scenario" --out run --url "$url"
    wait_for_line coordinator 'waiting for a worker.*sobox-worker --url'
    start worker sobox-worker --url "$url"
    finish 0 coordinator
    expect_files run/result.json
}

# A worker serves one run after another, and runs beside each other, each with its own scenario.
worker_serves_run_after_run()
{
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out first --url "$url"
    run 0 sobox-coordinator "$scenario" --out second --url "$url" --set response=glancing_off
    run 0 sobox-coordinator "$scenario" --out third --url "$url"
    expect_same_run first third
    [ "$(digest first)" != "$(digest second)" ] || fail 'two responses give one digest'
}

two_runs_share_a_worker()
{
    start worker sobox-worker --url "$url"
    start one sobox-coordinator "$scenario" "${steady[@]}" --out one --url "$url"
    start two sobox-coordinator "$scenario" "${steady[@]}" --out two --url "$url"
    finish 0 one
    finish 0 two
    expect_same_run one two
}

worker_ends_with_ctrl_c()
{
    start worker sobox-worker --url "$url" --threads 1
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run --url "$url"
    hold coordinator run 1
    press_ctrl_c worker
    finish 0 worker
    go_on coordinator
    # It has said that it leaves, so the coordinator need not first miss it.
    wait_for_line coordinator 'waiting for a worker'
}
