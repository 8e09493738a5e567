# One design through the model, from the command line.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_print_outcome() # NAME
{
    sqlite3 :memory: "SELECT json_extract(readfile('out'), '\$.$1')"
}

# The search and the program for one design must mean the same by good: the middle of the corridors that a run found is a good design.
centre_of_the_found_corridors_is_good()
{
    run 0 sobox-coordinator "$scenario" --out run
    awk -F, '
        NR > 1 { force[$3, $4] = ($5 + $6) / 2; if ($3 == "x") point[++count] = $4 }
        END {
            print "spring,branch,deformation_m,force_x_N,force_y_N"
            for (i = 1; i <= count; i++)
                printf "front,load,%s,%.17g,%.17g\n", point[i], force["x", point[i]],
                    force["y", point[i]]
        }' run/corridors.csv >design.csv
    run 0 sobox-simulate "$scenario" --design design.csv
    expect_equal "$(_print_outcome good)" 1 'good'
    expect_equal "$(_print_outcome 'violated[0]')" '' 'constraints that the design violates'
}

outcomes_are_one_json_object()
{
    run 0 sobox-simulate "$scenario" --design centre
    local name
    for name in s_L s_L_min AbWAP AbWP yaw_deg travel_x travel_y; do
        expect_equal "$(sqlite3 :memory: "SELECT json_type(readfile('out'), '\$.$name')")" real \
            "type of $name"
    done
}

# Without any force the car flies on: speed x duration forwards, and straight.
design_without_forces_flies_on()
{
    run 0 sobox-simulate "$scenario" --design lower
    expect_equal "$(sqlite3 :memory: "SELECT abs(json_extract(readfile('out'), '\$.travel_x')
        - 17.889 * 0.150) < 1e-9")" 1 'travel_x is speed times duration'
    expect_equal "$(_print_outcome good)" 0 'good'
    expect_said out 's_L'
}

# A car that turns beyond 90 degrees has no springs any more: its outcomes are numbers that nobody should
# take for a crash, so it is said. A light turntable with all its force inwards is turned right round.
turn_beyond_90_degrees_is_flagged()
{
    run 0 sobox-simulate "$scenario" --design centre
    expect_equal "$(_print_outcome yaw_beyond_90_deg)" 0 'the usual crash turns beyond 90 degrees'
    run 0 sobox-simulate "$scenario" --design upper --set vehicle.yaw_inertia=200 --set 'springs.0.force_y={lower: 0, upper: 0}'
    expect_equal "$(_print_outcome yaw_beyond_90_deg)" 1 'the spun car turns beyond 90 degrees'
    expect_equal "$(sqlite3 :memory: "SELECT json_extract(readfile('out'), '$.yaw_max_deg') > 90")" 1 'yaw_max_deg'
    run 0 sobox-simulate "$scenario" --design upper --set 'springs.0.force_y={lower: 0, upper: 0}' \
        --set 'cases=[{name: usual}, {name: spun, vehicle.yaw_inertia: 200}]'
    expect_equal "$(sqlite3 :memory: "SELECT json_extract(readfile('out'), '$.\"usual.yaw_beyond_90_deg\"'),
        json_extract(readfile('out'), '$.\"spun.yaw_beyond_90_deg\"')")" '0|1' 'flags of the cases'
}

_columns() # FILE COLUMN...
{
    head -n 1 "$1" | tr , '\n'
}

trajectory_is_written_from_the_first_to_the_last_instant()
{
    run 0 sobox-simulate "$scenario" --design centre --trajectory path.csv
    expect_equal "$(_columns path.csv | head -n 7 | paste -sd ,)" \
        time_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps 'columns of the car'
    expect_equal "$(_columns path.csv | tail -n +8 | paste -sd ,)" \
        front.length_m,front.deformation_m,front.force_x_N,front.force_y_N,front.contact \
        'columns of the spring'
    # 150 steps of 1 ms and the start.
    expect_equal "$(wc -l <path.csv)" 152 'lines'
    expect_equal "$(tail -n 1 path.csv | awk -F, '{printf "%.3f", $1}')" 0.150 'last instant'
}

trajectory_compared_with_itself_has_no_error()
{
    run 0 sobox-simulate "$scenario" --design centre --trajectory path.csv
    cut -d , -f 1-4 path.csv >reference.csv
    run 0 sobox-simulate "$scenario" --design centre --compare reference.csv
    expect_said out 'x_m'
    expect_said out 'yaw_rad'
    expect_equal "$(sqlite3 :memory: "SELECT max(value) < 1e-9 FROM json_tree(readfile('out'))
        WHERE key IN ('x_m', 'y_m', 'yaw_rad')")" 1 'errors are nought'
}

trajectory_compared_with_a_shifted_one_has_the_shift_as_error()
{
    run 0 sobox-simulate "$scenario" --design centre --trajectory path.csv
    awk -F, 'NR == 1 {print "time_s,x_m"} NR > 1 {printf "%s,%.17g\n", $1, $2 + 0.25}' path.csv \
        >reference.csv
    run 0 sobox-simulate "$scenario" --design centre --compare reference.csv
    expect_equal "$(sqlite3 :memory: "SELECT abs(value - 0.25) < 1e-9
        FROM json_tree(readfile('out')) WHERE key = 'x_m'")" 1 'error of x_m'
}

wrong_design_is_refused()
{
    run 2 sobox-simulate "$scenario" --design nowhere.csv
    expect_one_line err
    expect_said err 'nowhere.csv'
    printf 'spring,branch,deformation_m,force_x_N,force_y_N\nfront,load,0,many,0\n' >wrong.csv
    run 2 sobox-simulate "$scenario" --design wrong.csv
    expect_one_line err
    expect_said err '^wrong.csv:2'
    printf 'spring,branch,deformation_m,force_x_N,force_y_N\nrear,load,0,0,0\n' >wrong.csv
    run 2 sobox-simulate "$scenario" --design wrong.csv
    expect_said err '^wrong.csv:2.*rear'
    printf 'time_s,x_m\n0,0\n' >wrong.csv
    run 2 sobox-simulate "$scenario" --design wrong.csv
    expect_said err '^wrong.csv:1'
    run 2 sobox-simulate "$scenario" --design centre --compare wrong-too.csv
    expect_said err 'wrong-too.csv'
}
