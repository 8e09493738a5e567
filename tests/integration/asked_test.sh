# What engineers ask of a box beside being good, and what they are told about it, on a car.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_corridor() # FOLDER VARIABLE: its lower and upper bound
{
    sqlite3 :memory: "SELECT printf('%.17g %.17g', json_extract(value, '\$.corridor[0]'),
            json_extract(value, '\$.corridor[1]'))
        FROM json_each(readfile('$1/result.json'), '\$.searches[0].variables')
        WHERE json_extract(value, '\$.name') = '$2'"
}

_holder() # FOLDER VARIABLE BOUND: what holds it
{
    sqlite3 :memory: "SELECT json_extract(value, '\$.$3.holder')
        FROM json_each(readfile('$1/result.json'), '\$.searches[0].variables')
        WHERE json_extract(value, '\$.name') = '$2'"
}

_true() # EXPRESSION WHAT
{
    awk "BEGIN { exit !($1) }" || fail "$2: $1"
}

# A bound that is held stays where it is to the bit, and is said to be held; a variable held to one
# value has no width in the table and none in the log-volume.
held_bounds_stay()
{
    run 0 sobox-coordinator "$scenario" --out run --set \
        'search.hold={lower: {"front.force_y[1]": 150e3, "front.force_x[2]": 1e5}, upper: {"front.force_y[1]": 150e3}}'
    expect_equal "$(_corridor run 'front.force_y[1]')" '150000 150000' 'the value'
    expect_equal "$(_corridor run 'front.force_x[2]' | cut -d' ' -f1)" 100000 'the bound'
    expect_equal "$(_holder run 'front.force_x[2]' lower)" held 'what holds the bound'
    expect_said out ' held( |$)'
    _true "$(json run/result.json '$.searches[0].log_volume') > -100" 'log-volume'
    sobox-report run | grep -q '^  held by search.hold  *3' || fail 'three bounds are held'
}

# What must stay inside stays inside, in every bound.
reference_stays_inside()
{
    run 0 sobox-coordinator "$scenario" --out run --set \
        'search.reference={front.force_x: 55e3, front.force_y: 240e3}' --set vehicle.speed=8
    local bounds variable value
    for variable in 'force_x[0]:55000' 'force_x[2]:55000' 'force_y[1]:240000'; do
        value=${variable#*:}
        bounds=$(_corridor run "front.${variable%:*}")
        _true "${bounds% *} <= $value && $value <= ${bounds#* }" "$variable in $bounds"
    done
}

# A bad reference is refused at once, in words.
bad_reference_is_refused()
{
    run 3 sobox-coordinator "$scenario" --out run --set 'search.reference={front: 1e3}'
    expect_said out '^reference    search.reference is not a good design'
    expect_equal "$(json run/result.json '$.searches[0].evaluations')" 1 'designs'
    expect_equal "$(json run/result.json '$.searches[0].least_violating_design.outcome')" s_L_min \
        'what it violates'
}

# Corridors are no narrower than asked for, whatever that costs elsewhere.
minimum_widths_are_kept()
{
    run 0 sobox-coordinator "$scenario" --out run --set 'search.minimum_widths={front.force_y: 1e5}'
    local k bounds
    for k in 0 1 2; do
        bounds=$(_corridor run "front.force_y[$k]")
        _true "${bounds#* } - ${bounds% *} >= 1e5" "width of $k"
    done
}

# Tied variables have one corridor to the bit.
tied_corridors_are_one()
{
    run 0 sobox-coordinator "$scenario" --out run \
        --set 'search.tie=[["front.force_y[0]", "front.force_y[1]"]]'
    expect_equal "$(_corridor run 'front.force_y[1]')" "$(_corridor run 'front.force_y[0]')" 'corridor'
    expect_equal "$(_holder run 'front.force_y[1]' lower)" "$(_holder run 'front.force_y[0]' lower)" \
        'what holds it'
}

# A weight makes the corridors that it is given to wider, together.
weights_widen()
{
    run 0 sobox-coordinator "$scenario" --out plain
    run 0 sobox-coordinator "$scenario" --out weighted --set 'search.weights={front.force_x: 5}'
    local sum="SELECT sum(ln((upper_N - lower_N) / (design_upper_N - design_lower_N))) FROM c
        WHERE direction = 'x' AND design_upper_N > design_lower_N"
    local folder
    for folder in plain weighted; do
        sqlite3 :memory: ".import --csv $folder/corridors.csv c" "$sum" >"$folder.sum"
    done
    _true "$(cat weighted.sum) > $(cat plain.sum)" 'share of the weighted direction'
}

# Two cars at once: the box is no larger than that of the heavier one allows, and each constraint is
# told apart by its case.
cases_are_told_apart()
{
    run 0 sobox-coordinator "$scenario" --out run \
        --set 'cases=[{name: light, vehicle: {mass: 1500}}, {name: heavy, vehicle: {mass: 1800}}]'
    expect_said out '^  light\.s_L_min >= '
    expect_said out '^  heavy\.s_L_min >= '
    expect_said out 'good in light and heavy'
    local light heavy
    light=$(json run/result.json '$.searches[0].constraints[0].holds')
    heavy=$(json run/result.json '$.searches[0].constraints[1].holds')
    _true "$heavy >= $light" 'bounds that the heavy car holds'
}

# With a budget the explanation is part of it; without one it costs only what it says, and the
# corridors do not depend on it.
explanation_costs_what_it_says()
{
    local points=(--set search.promise=points)
    run 0 sobox-coordinator "$scenario" "${points[@]}" --out plain --set search.explain_samples=0
    run 0 sobox-coordinator "$scenario" "${points[@]}" --out explained \
        --set search.explain_samples=30
    expect_equal "$(digest explained)" "$(digest plain)" 'digest'
    local steps designs
    steps=$(grep -c '^0,explain,' explained/history.csv)
    designs=$(($(json explained/result.json '$.searches[0].evaluations') -
        $(json plain/result.json '$.searches[0].evaluations')))
    expect_equal "$designs" $((30 * steps)) 'designs just outside'
    [ "$steps" -gt 0 ] || fail 'no bound was looked at'
    expect_equal "$(grep -c '^0,explain,' plain/history.csv)" 0 'steps that were switched off'
    run 0 sobox-coordinator "$scenario" "${points[@]}" --out budget --set search.evaluations=6000
    _true "$(json budget/result.json '$.searches[0].evaluations') <= 6000" 'budget'
}
