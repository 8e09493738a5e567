# A run may be ended at any time, in any way, and continued to the same bits.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_begin_and_end_run() # SIGNAL-FUNCTION OPTION...
{
    local how=$1
    shift
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run "$@"
    hold coordinator run 3
    "$how"
}

_ctrl_c()
{
    press_ctrl_c coordinator
    go_on coordinator
    finish 130 coordinator
    expect_said coordinator.err '--resume run'
    expect_equal "$(journal run 'SELECT state FROM run')" interrupted 'state of the run'
}

_kill()
{
    signal KILL coordinator
    finish 137 coordinator
}

_resume_gives_the_same()
{
    wait_until 'the local workers are gone' no_process_left
    expect_no run/result.json
    run 0 sobox-coordinator --resume run "$@"
    expect_same_run calm run
    expect_equal "$(journal run 'SELECT state FROM run')" 'done' 'state of the run'
}

ctrl_c_ends_a_run_that_resumes_to_the_same_bits()
{
    _begin_and_end_run _ctrl_c
    _resume_gives_the_same
}

# Ctrl-C reaches the workers as well, so the coordinator must not take their end for a failure.
ctrl_c_ends_local_workers_too()
{
    _begin_and_end_run _ctrl_c --workers 2
    _resume_gives_the_same --workers 1
}

# A service manager ends the coordinator alone; it must end its workers.
sigterm_to_the_coordinator_alone_ends_local_workers_too()
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run --workers 2
    hold coordinator run 2
    signal TERM coordinator
    go_on coordinator
    finish 130 coordinator
    wait_until 'the local workers are gone' no_process_left
}

killed_run_resumes_to_the_same_bits()
{
    _begin_and_end_run _kill
    _resume_gives_the_same
}

# Nobody is left to end them: they notice by themselves that they are orphans.
local_workers_end_when_the_coordinator_is_killed()
{
    _begin_and_end_run _kill --workers 2
    _resume_gives_the_same --workers 2
}

run_killed_again_and_again_resumes_to_the_same_bits()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run
    local count
    for count in 1 4 8 12; do
        hold coordinator run "$count"
        signal KILL coordinator
        finish 137 coordinator
        start coordinator sobox-coordinator --resume run
    done
    finish 0 coordinator
    expect_same_run calm run
}

# Two coordinators must never write one journal.
run_that_goes_on_cannot_be_resumed_beside()
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run --url "$url"
    wait_for_line coordinator 'waiting for a worker'
    run 1 sobox-coordinator --resume run
    expect_said err 'another coordinator|is being written|in use'
    start worker sobox-worker --url "$url"
    finish 0 coordinator
}

finished_run_is_not_run_again()
{
    run 0 sobox-coordinator "$scenario" --out run
    run 1 sobox-coordinator --resume run
    expect_said err 'done.*sobox-report run'
}

# What another version wrote may mean something else, and what it computed may have other bits.
journal_of_another_schema_is_refused()
{
    _interrupted_run_of 'UPDATE meta SET schema = 99'
    run 1 sobox-coordinator --resume run
    expect_said err 'run/run\.db.*(schema|version) 99'
    run 1 sobox-report run
    expect_said err 'run/run\.db.*(schema|version) 99'
}

run_of_another_version_is_not_continued()
{
    _interrupted_run_of "UPDATE run SET version = '0.0.1-of-old'"
    run 1 sobox-coordinator --resume run
    expect_said err '0\.0\.1-of-old'
    # Looking at it is another matter.
    run 0 sobox-report run
}

_interrupted_run_of() # SQL that changes its journal
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run
    hold coordinator run 1
    press_ctrl_c coordinator
    go_on coordinator
    finish 130 coordinator
    sqlite3 run/run.db "$1"
}

folder_without_a_run_cannot_be_resumed()
{
    mkdir empty
    run 2 sobox-coordinator --resume empty
    expect_said err 'empty.*run\.db'
    run 2 sobox-coordinator --resume absent
    expect_said err 'absent.*run\.db'
    expect_no absent
}
