# What a run writes is whole or absent, and where it cannot write it says so before it begins.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

run_folder_holds_every_file()
{
    run 0 sobox-coordinator "$scenario" --out run
    expect_files run/run.db run/result.json run/corridors.csv run/history.csv run/corridors.svg
    expect_equal "$(head -n 1 run/corridors.csv)" \
        search,spring,direction,deformation_m,lower_N,upper_N,design_lower_N,design_upper_N,reached \
        'columns of corridors.csv'
    expect_equal "$(head -n 1 run/history.csv)" \
        search,phase,step,samples,good,growth,log_volume 'columns of history.csv'
    expect_equal "$(wc -l <run/corridors.csv)" 11 'lines of corridors.csv'
    expect_equal "$(json run/result.json '$.name')" short 'name in result.json'
    expect_equal "$(json run/result.json '$.searches[0].status')" 'done' 'status in result.json'
    expect_equal "$(json run/result.json '$.searches[0].seed')" 1 'seed in result.json'
    expect_equal "$(($(wc -l <run/history.csv) - 1))" \
        "$(json run/result.json '$.searches[0].steps')" 'steps'
    expect_equal "$(journal run 'SELECT sum(samples) FROM step')" \
        "$(json run/result.json '$.searches[0].evaluations')" 'evaluations'
}

# Lower, upper and share of each point, purity and its bound, cost, files.
table_of_corridors_ends_a_run()
{
    run 0 sobox-coordinator "$scenario" --out run
    expect_said out front
    expect_said out '[Pp]urity'
    expect_said out 'run/corridors\.svg'
    expect_said out 'run/result\.json'
    expect_equal "$(grep -cE '^ +[0-9]\.[0-9]{3}( +[0-9.]+){6}$' out)" 5 'rows of the table'
}

quiet_run_says_nothing_on_standard_error()
{
    run 0 sobox-coordinator "$scenario" --out run --quiet
    [ ! -s err ] || fail "said with --quiet: $(cat err)"
}

# Each run has a folder of its own, without being asked for.
folder_is_picked_when_none_is_named()
{
    run 0 sobox-coordinator "$scenario"
    run 0 sobox-coordinator "$scenario"
    expect_same_run runs/short runs/short-2
}

folder_that_is_not_empty_is_left_alone()
{
    mkdir full
    echo mine >full/notes
    run 2 sobox-coordinator "$scenario" --out full
    expect_said err 'full.*not empty'
    expect_equal "$(ls -A full)" notes 'content of the folder'
}

empty_folder_is_used()
{
    mkdir empty
    run 0 sobox-coordinator "$scenario" --out empty
    expect_files empty/result.json
}

# Root may write nearly everywhere, so the obstacles are a file in the way and a system's folder.
folder_that_cannot_be_made_is_refused()
{
    echo mine >file
    run 2 sobox-coordinator "$scenario" --out file
    expect_said err '^[^ ]*file'
    expect_equal "$(cat file)" mine 'content of the file'
    run 2 sobox-coordinator "$scenario" --out file/below
    expect_said err 'file/below'
    run 2 sobox-coordinator "$scenario" --out /proc/run
    expect_said err '/proc/run'
}

# Carries out FUNCTION with a disk of SIZE under the folder "disk", in a mount namespace so that the
# disk goes with it. (In a chroot the mounts cannot be made private first; there the disk is
# unmounted again.)
_with_small_disk() # SIZE FUNCTION
{
    local private=(unshare -m)
    "${private[@]}" true 2>/dev/null || private=(unshare -m --propagation unchanged)
    mkdir disk
    # shellcheck disable=SC2163 # the function that $2 names
    export -f "$2" run fail expect_said expect_no expect_files expect_equal journal digest json
    export folder patience scenario
    # shellcheck disable=SC2016 # expanded by the inner shell
    "${private[@]}" bash -euo pipefail -c '
        mount -t tmpfs -o "size=$1" none disk
        trap "umount disk" EXIT
        "$2"' disk "$1" "$2"
}

_run_cannot_begin()
{
    run 1 sobox-coordinator "$scenario" --out disk/run
    expect_said err 'disk/run.*(full|space)'
    expect_no disk/run
}

disk_that_is_full_from_the_start_is_left_clean()
{
    _with_small_disk 16k _run_cannot_begin
}

_run_stops_and_goes_on()
{
    run 0 sobox-coordinator "$scenario" --out calm
    run 1 sobox-coordinator "$scenario" --out disk/run
    expect_said err '(full|space)'
    expect_no disk/run/result.json
    expect_no disk/run/corridors.csv
    [ "$(journal disk/run 'PRAGMA integrity_check')" = ok ] || fail 'the journal is damaged'
    mount --options-mode ignore -o remount,size=10m none disk
    run 0 sobox-coordinator --resume disk/run
    expect_equal "$(digest disk/run)" "$(digest calm)" 'digest after the disk was full'
}

# The journal stays whole, no result pretends to be one, and with room again the run goes on.
disk_that_fills_in_mid_run_stops_it_and_loses_nothing()
{
    _with_small_disk 140k _run_stops_and_goes_on
}

# Started with its streams closed, a program that opens files and sockets gets their numbers: what it
# says must not be written into those.
closed_streams_leave_the_run_as_it_is()
{
    run 0 sobox-coordinator "$scenario" --out calm
    run 0 bash -c "exec sobox-coordinator '$scenario' --out untold --workers 2 2>&-"
    expect_same_run calm untold
    run 1 bash -c "exec sobox-coordinator '$scenario' --out silent --workers 2 <&- >&- 2>&-"
    expect_same_run calm silent
    expect_equal "$(journal silent 'PRAGMA integrity_check')" ok 'state of the journal'
}

# The last words of a program wait in a buffer, and are lost with it if nobody looks.
standard_output_that_takes_nothing_is_told()
{
    local program
    for program in coordinator worker simulate report monitor; do
        run 1 bash -c "exec sobox-$program --version >/dev/full"
        # The thread sanitizer empties the buffer before the program looks, and keeps the reason.
        expect_said err 'standard output: (No space left on device|writing failed)'
    done
    run 1 bash -c "exec sobox-coordinator '$scenario' --out run >/dev/full"
    expect_equal "$(grep -c error: err)" 1 'times it was said'
}

trajectory_may_go_into_a_pipe()
{
    run 0 bash -c "sobox-simulate '$scenario' --trajectory /dev/stderr 2>&1 >/dev/null | cat"
    expect_equal "$(head -n 1 out | cut -d , -f 1-4)" time_s,x_m,y_m,yaw_rad 'columns'
    # Never named /dev/full: a program that errs would put a file there.
    run 1 bash -c "exec sobox-simulate '$scenario' --trajectory /proc/self/fd/3 3>/dev/full"
    expect_said err '/proc/self/fd/3: cannot be written: No space left on device'
}
