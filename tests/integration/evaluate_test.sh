# The outcomes of a table of designs: the same file from any workers, over any network, after any
# interruption, and the same numbers that sobox-simulate gives for each design alone.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# A table of designs of the scenario of these tests, in a column order of its own, with numbers as
# people write them and as programs do.
_write_designs() # ROWS
{
    awk -v rows="$1" '
        function any() { return seed = (seed * 16807) % 2147483647 }
        BEGIN {
            seed = 4711
            printf "id"
            for (i = 0; i < 5; i++) printf ",front.force_y[%d],front.force_x[%d]", i, i
            print ""
            for (row = 1; row <= rows; row++) {
                printf "design %d", row
                for (i = 0; i < 5; i++)
                    printf i % 2 ? ",%.17g,%.1f" : ",%.6e,%d", any() / 8589.9, any() / 4772.2
                print ""
            }
        }'
}

_expect_same_outcomes() # RUN RUN
{
    cmp "$1/outcomes.csv" "$2/outcomes.csv" || fail "the outcomes of $1 and $2 differ"
}

# The names of outcomes that the table and sobox-simulate disagree about; numbers agree when they read
# back as the same.
_differing_outcomes() # ROW
{
    local violated
    violated=$(sqlite3 :memory: "SELECT group_concat(value, ';') FROM
        json_each(readfile('out'), '\$.violated')")
    awk -F '[,:]' -v row="$1" -v violated="$violated" '
        FNR == NR && FNR == 1 { for (i = 1; i <= NF; i++) column[$i] = i }
        FNR == NR && FNR == row + 1 { split($0, found, ",") }
        FNR == NR { next }
        { gsub(/[" ]/, "") }
        $1 == "violated" { exit } # to END
        $1 in column && $1 != "good" {
            compared++
            if (found[column[$1]] + 0 != $2 + 0) print $1
        }
        $1 == "good" && (($2 == "true") != found[column["good"]]) { print "good" }
        END {
            if (found[column["violated"]] != violated) print "violated"
            if (compared < 14) print "only " compared " were compared"
        }' run/outcomes.csv out
}

# Another path through the model: one design, its curves in a file.
outcomes_are_those_of_a_design_alone()
{
    _write_designs 6 >designs.csv
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out run
    expect_said out '^short: 6 designs, '
    local row good=0 bad=0
    for row in 1 2 3 4 5 6; do
        awk -F, -v row="$row" '
            NR == row + 1 {
                print "spring,branch,deformation_m,force_x_N,force_y_N"
                for (i = 0; i < 5; i++)
                    printf "front,load,%.1f,%s,%s\n", 0.3 * i, $(2 * i + 3), $(2 * i + 2)
            }' designs.csv >design.csv
        run 0 sobox-simulate "$scenario" --design design.csv
        expect_equal "$(_differing_outcomes "$row")" '' "outcomes of design $row unlike its own"
        if [ "$(json out '$.good')" = 1 ]; then good=$((good + 1)); else bad=$((bad + 1)); fi
    done
    [ "$good" -gt 0 ] && [ "$bad" -gt 0 ] || fail "$good good and $bad bad designs show nothing"
}

any_workers_threads_frames_and_keys_give_the_same_outcomes()
{
    _write_designs 20000 >designs.csv
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out one --threads 1 --mtu 1400
    expect_equal "$(wc -l <one/outcomes.csv)" 20001 'lines of outcomes.csv'
    expect_equal "$(sed -n 's/^design \([0-9]*\),.*/\1/p' one/outcomes.csv | sort -cn 2>&1)" '' \
        'disorder of the outcomes'
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out many --threads 4
    _expect_same_outcomes one many
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out local --workers 3 -v
    _expect_same_outcomes one local
    run 0 sobox-coordinator --new-key key
    start worker sobox-worker --url "$url" --key-file key
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out sealed --url "$url" \
        --key-file key
    _expect_same_outcomes one sealed
}

# Each frame may be lost, doubled or late, and each worker may die with what it holds.
bad_weather_and_dying_workers_change_nothing()
{
    # shellcheck source=tests/integration/hosts.bash
    source "$here/hosts.bash"
    _write_designs 20000 >designs.csv
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out calm
    make_hosts 4
    join_by_switch 5 10 0.3 1
    start_workers
    start coordinator on 1 sobox-coordinator --evaluate designs.csv "$scenario" --out stormy \
        --url "$far"
    wait_until 'outcomes are written' _has_outcomes stormy
    signal KILL worker-2
    finish 0 coordinator
    _expect_same_outcomes calm stormy
}

_has_outcomes() # RUN
{
    [ -e "$1/outcomes.csv" ] && [ "$(wc -l <"$1/outcomes.csv")" -gt 1 ]
}

_has_noted() # RUN
{
    [ -e "$1/evaluation.json" ] && [ "$(json "$1/evaluation.json" '$.rows')" -gt 0 ]
}

# A pipe holds the run in its middle: what came through it is evaluated, the rest never comes.
_start_with_half() # RUN
{
    mkfifo "$1.pipe"
    start "$1" sh -c "exec sobox-coordinator --evaluate - '$scenario' --out '$1' <'$1.pipe'"
    exec 9>"$1.pipe"
    head -c 3000000 designs.csv >&9
    wait_until 'the run has noted outcomes' _has_noted "$1"
}

# In a kill the last moment's work is lost, in an interruption nothing; either way the rest follows,
# from the same table in a file or through another pipe.
ended_run_goes_on_to_the_same_outcomes()
{
    _write_designs 40000 >designs.csv
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out calm
    _start_with_half killed
    signal KILL killed
    finish 137 killed
    exec 9>&-
    run 0 sobox-coordinator --resume killed --evaluate designs.csv
    expect_said out '^short: 40000 designs, '
    _expect_same_outcomes calm killed
    _start_with_half interrupted
    signal INT interrupted
    finish 130 interrupted
    expect_said interrupted.err 'sobox-coordinator --resume interrupted'
    exec 9>&-
    expect_equal "$(json interrupted/evaluation.json '$.state')" interrupted 'state'
    run 0 sh -c "sobox-coordinator --resume interrupted <designs.csv"
    _expect_same_outcomes calm interrupted
    run 1 sobox-coordinator --resume interrupted
    expect_said err 'is done'
}

# What stands before the row is kept, and once it is mended the rest follows. Who changes what is
# evaluated already is told.
row_that_is_none_stops_there_and_can_be_mended()
{
    _write_designs 40000 >whole.csv
    run 0 sobox-coordinator --evaluate whole.csv "$scenario" --out calm
    sed '39000s/,[^,]*$/,12O000/' whole.csv >designs.csv
    run 2 sobox-coordinator --evaluate designs.csv "$scenario" --out run --quiet
    expect_said err '^designs.csv:39000:[0-9]+: front.force_x.4.: expected a finite number, found "12O000"'
    [ "$(wc -l <run/outcomes.csv)" -gt 16384 ] || fail 'the rows before it are not there'
    expect_equal "$(json run/evaluation.json '$.state')" failed 'state'
    sed '10s/,[^,]*$/,0/' whole.csv >designs.csv
    run 2 sobox-coordinator --resume run
    expect_said err 'expected the table with which this evaluation was begun'
    cp whole.csv designs.csv
    run 0 sobox-coordinator --resume run
    _expect_same_outcomes calm run
}

_expect_refused() # PATTERN DESIGNS [OPTION...]
{
    run 2 sobox-coordinator --evaluate "$2" "$scenario" --out none "${@:3}"
    expect_said err "$1"
    expect_no none
}

wrong_tables_leave_nothing_behind()
{
    local header
    _write_designs 3 >good.csv
    header=$(head -n 1 good.csv)
    : >empty.csv
    _expect_refused '^empty.csv:1:1: expected a header' empty.csv
    _expect_refused '^none.csv: cannot be read: No such file' none.csv
    cut -d, -f 1-10 good.csv >columns.csv
    _expect_refused 'columns.csv:1:[0-9]+: expected a column for every variable .* front.force_x.4. is missing' \
        columns.csv
    sed '1s/front/rear/' good.csv >unknown.csv
    _expect_refused '^unknown.csv:1:4: expected the name of a variable .* found "rear' unknown.csv
    sed '3s/,[^,]*$//' good.csv >short.csv
    _expect_refused '^short.csv:3:[0-9]+: expected 11 fields, as in the header, found 10' short.csv
    sed '4s/,[^,]*$/,nan/' good.csv >nan.csv
    _expect_refused '^nan.csv:4:[0-9]+: front.force_x.4.: expected a finite number' nan.csv
    head -c -4 good.csv | sed '4s/,[^,]*$//' >cut.csv
    _expect_refused '^cut.csv:4:[0-9]+: .*the line is cut off' cut.csv
    { echo "$header" && head -c 2000000 /dev/zero | tr '\0' 1; } >huge.csv
    _expect_refused '^huge.csv:2:1: expected lines of at most 1048576 bytes' huge.csv
    _expect_refused '^--outcomes s_l: expected names of outcomes' good.csv --outcomes s_l
    sed 's/$/\r/' good.csv >windows.csv
    run 0 sobox-coordinator --evaluate windows.csv "$scenario" --out windows --outcomes s_L
    expect_equal "$(head -n 1 windows/outcomes.csv)" 'id,s_L,good,violated' 'header'
    expect_equal "$(wc -l <windows/outcomes.csv)" 4 'lines'
    echo "$header" >none.csv
    run 0 sobox-coordinator --evaluate none.csv "$scenario" --out nothing
    expect_said out '^short: 0 designs'
}

# A design that no frame holds needs larger messages, and the program says how large.
design_larger_than_a_message_is_refused()
{
    awk 'BEGIN {
        print "name: large\nmodel: hypersphere\nconstraints: {distance: {max: 0}}\nvariables:"
        for (i = 1; i <= 300; i++) printf "  - {name: v%d, lower: -1, upper: 1}\n", i
    }' >large.yaml
    awk 'BEGIN {
        for (i = 1; i <= 300; i++) printf "%sv%d", (i > 1 ? "," : ""), i
        print ""
        for (i = 1; i <= 300; i++) printf "%s0.5", (i > 1 ? "," : "")
        print ""
    }' >large.csv
    run 2 sobox-coordinator --evaluate large.csv large.yaml --out small --mtu 1400
    expect_said err 'does not fit a message: expected --mtu [0-9]+ or more'
    expect_no small
    run 0 sobox-coordinator --evaluate large.csv large.yaml --out large \
        --mtu "$(sed -n 's/.*--mtu \([0-9]*\).*/\1/p' err)"
    expect_equal "$(sed -n 's/,.*//; 2p' large/outcomes.csv)" 1 'the number of the design'
}

options_that_do_not_fit_together_are_refused()
{
    _write_designs 3 >designs.csv
    printf 'sweep: s\nbase: %s\nreplicates: 2\n' "$scenario" >sweep.yaml
    run 2 sobox-coordinator --evaluate designs.csv sweep.yaml
    expect_said err 'goes with a scenario, and sweep.yaml is a sweep'
    run 2 sobox-coordinator --evaluate designs.csv
    expect_said err 'no scenario'
    run 2 sobox-coordinator --evaluate designs.csv "$scenario" --seed 3
    expect_said err 'it goes without --seed'
    run 2 sobox-coordinator "$scenario" --outcomes s_L
    expect_said err '--outcomes goes with --evaluate'
    run 0 sobox-coordinator --evaluate designs.csv "$scenario" --out run
    run 2 sobox-coordinator --evaluate designs.csv "$scenario" --out run
    expect_said err 'the run folder is not empty'
    run 2 sobox-report run
    expect_said err 'evaluation'
}
