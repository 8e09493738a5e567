# Models in closed form and cases, through the programs: the same way as the crash model, workers
# included.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_benchmarks=$here/../../deploy/scenarios/benchmarks

worker_processes_evaluate_other_models()
{
    local problem=$_benchmarks/two-section-crash.yaml
    run 0 sobox-coordinator "$problem" --out inside
    run 0 sobox-coordinator "$problem" --out outside --workers 2
    expect_same_run inside outside
    expect_equal "$(json inside/result.json '$.searches[0].status')" 'done' 'status'
    expect_equal "$(json inside/result.json '$.searches[0].variables[0].name')" F1 'variable'
    expect_equal "$(json inside/result.json '$.searches[0].variables[0].spring')" '' 'spring'
    expect_equal "$(cut -d , -f 1-4 inside/corridors.csv | sed -n 2p)" 0,F1,, 'place of a corridor'
    expect_files inside/{result.json,corridors.csv,corridors.svg,history.csv,run.db}
}

worker_processes_evaluate_all_cases()
{
    awk '{print} END {
        print "cases:"
        print "- {name: sedan}"
        print "- {name: wagon, vehicle.mass: 1830, vehicle.yaw_inertia: 3600}"}' "$scenario" >two.yaml
    run 0 sobox-coordinator two.yaml --out inside
    run 0 sobox-coordinator two.yaml --out outside --workers 2
    expect_same_run inside outside
    # What is good in both is good in the heavier one alone, but not the other way round.
    awk -F, '
        NR > 1 { force[$3, $4] = ($5 + $6) / 2; if ($3 == "x") point[++count] = $4 }
        END {
            print "spring,branch,deformation_m,force_x_N,force_y_N"
            for (i = 1; i <= count; i++)
                printf "front,load,%s,%.17g,%.17g\n", point[i], force["x", point[i]],
                    force["y", point[i]]
        }' inside/corridors.csv >design.csv
    run 0 sobox-simulate two.yaml --design design.csv
    expect_equal "$(json out '$.good')" 1 'good in both'
    run 0 sobox-simulate two.yaml --design design.csv --case wagon
    expect_equal "$(json out '$.good')" 1 'good in the wagon'
}

# The message that no design is good in every case must say in which one.
obstacle_names_its_case()
{
    awk '{print} END {print "cases: [{name: sedan}, {name: truck, vehicle.mass: 9000}]"}' \
        "$scenario" >two.yaml
    run 3 sobox-coordinator two.yaml --out run
    expect_equal "$(json run/result.json '$.searches[0].blocking_constraint')" truck.s_L_min 'obstacle'
}

formula_is_simulated()
{
    printf 'variable,value\nF2,500e3\nF1,400e3\n' >design.csv
    run 0 sobox-simulate "$_benchmarks/two-section-crash.yaml" --design design.csv
    expect_equal "$(json out '$.decel_max')" 250.0 'decel_max'
    expect_equal "$(json out '$.order')" -100000.0 'order'
    expect_equal "$(json out '$.good')" 1 'good'
    run 2 sobox-simulate "$_benchmarks/two-section-crash.yaml" --trajectory path.csv
    expect_one_line err
    expect_said err 'two_section_crash has no motion'
}

cases_are_simulated_together_or_alone()
{
    awk '{print} END {print "cases: [{name: a}, {name: b, vehicle.speed: 10}]"}' "$scenario" >two.yaml
    run 0 sobox-simulate two.yaml
    cp out both
    run 0 sobox-simulate two.yaml --case b
    expect_equal "$(json both '$."b.s_L"')" "$(json out '$.s_L')" 's_L of b'
    run 0 sobox-simulate "$scenario"
    expect_equal "$(json both '$."a.s_L"')" "$(json out '$.s_L')" 's_L of a'
    run 0 sobox-simulate two.yaml --case b --trajectory path.csv
    run 2 sobox-simulate two.yaml --trajectory path.csv
    expect_said err 'case'
    run 2 sobox-simulate two.yaml --case c
    expect_said err 'expected one of a, b'
    run 2 sobox-simulate "$scenario" --case a
    expect_said err 'has no cases'
}
