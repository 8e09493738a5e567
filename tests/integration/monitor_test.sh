# The monitor shows what goes on and changes nothing.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

run_and_its_waiting_are_shown()
{
    start monitor sobox-monitor --url "$url"
    wait_for_line monitor 'no run is heard'
    start coordinator sobox-coordinator "$scenario" --out run --url "$url"
    wait_for_line monitor 'short.*waiting'
    start worker sobox-worker --url "$url"
    finish 0 coordinator
    wait_for_line monitor 'short.*done'
    press_ctrl_c monitor
    finish 0 monitor
}

json_is_one_object_a_line()
{
    start monitor sobox-monitor --url "$url" --json
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url"
    wait_for_line monitor '"short"'
    signal TERM monitor
    finish 0 monitor
    local line
    while read -r line; do
        printf '%s' "$line" >line.json
        expect_equal "$(sqlite3 :memory: "SELECT json_valid(readfile('line.json'))")" 1 "$line"
    done <monitor.out
}

# A pipe that is closed, as by head, ends it without a word.
monitor_ends_when_nobody_reads()
{
    start monitor sh -c 'sobox-monitor --url "$0" --json | head -n 1' "$url"
    finish 0 monitor
}

# A monitor that hangs fills its own socket's buffer and nobody else's; one that is killed is missed
# by nobody.
hanging_and_killed_monitors_change_nothing()
{
    run 0 sobox-coordinator "$scenario" --out alone "${steady[@]}"
    start hanging sobox-monitor --url "$url"
    start killed sobox-monitor --url "$url" --http 127.0.0.1:0
    wait_for_line killed 'the page is at'
    start worker sobox-worker --url "$url"
    start coordinator sobox-coordinator "$scenario" --out watched --url "$url" "${steady[@]}"
    hold coordinator watched 3
    signal STOP hanging
    signal KILL killed
    go_on coordinator
    finish 0 coordinator
    expect_same_run alone watched
    signal CONT hanging
    wait_for_line hanging 'short.*done'
}

sealed_run_is_shown_to_those_who_have_the_key()
{
    run 0 sobox-coordinator --new-key sobox.key
    start stranger sobox-monitor --url "$url"
    start friend sobox-monitor --url "$url" --key-file sobox.key --http 127.0.0.1:0
    start worker sobox-worker --url "$url" --key-file sobox.key
    run 0 sobox-coordinator "$scenario" --out run --url "$url" --key-file sobox.key "${steady[@]}"
    wait_for_line friend 'short.*done'
    signal TERM stranger
    finish 0 stranger
    ! grep short stranger.out || fail 'a monitor without the key shows the run'
}
