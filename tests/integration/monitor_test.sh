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
