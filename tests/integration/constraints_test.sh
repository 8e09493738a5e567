# Constraints on any outcome, from the scenario to the corridors.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_outcome() # NAME, of the simulated design
{
    json out "\$.\"$1\""
}

# What spares the occupants is an upper bound: the structure must not be too stiff. The middle of the
# corridors under it keeps it.
upper_bounds_hold_in_the_corridors()
{
    local bounds=(--set 'constraints={decel_max_g: {max: 22}, s_L: {max: 0.45}}')
    run 0 sobox-coordinator "$scenario" --out free
    run 0 sobox-coordinator "$scenario" "${bounds[@]}" --out bound
    awk -F, '
        NR > 1 { force[$3, $4] = ($5 + $6) / 2; if ($3 == "x") point[++count] = $4 }
        END {
            print "spring,branch,deformation_m,force_x_N,force_y_N"
            for (i = 1; i <= count; i++)
                printf "front,load,%s,%.17g,%.17g\n", point[i], force["x", point[i]],
                    force["y", point[i]]
        }' bound/corridors.csv >design.csv
    run 0 sobox-simulate "$scenario" "${bounds[@]}" --design design.csv
    expect_equal "$(_outcome good)" 1 'good'
    expect_equal "$(sqlite3 :memory: "SELECT json_extract(readfile('out'), '\$.decel_max_g') <= 22
        AND json_extract(readfile('out'), '\$.s_L') <= 0.45")" 1 'within the bounds'
    [ "$(digest free)" != "$(digest bound)" ] || fail 'the bounds changed nothing'
}

# Every outcome that a design has can be bound from below and from above, by the name under which it
# is printed.
every_outcome_can_be_bound()
{
    run 0 sobox-simulate "$scenario" --design centre
    cp out usual
    local name value count=0
    while IFS='|' read -r name value; do
        run 0 sobox-simulate "$scenario" --design centre \
            --set "constraints={$name: {min: $value, max: $value}}"
        expect_equal "$(json out "\$.violated")" "$(json usual "\$.violated")" "$name bound to itself"
        run 0 sobox-simulate "$scenario" --design centre \
            --set "constraints={$name: {max: $(awk "BEGIN {print $value - 1}")}}"
        expect_equal "$(_outcome good)" 0 "good with $name above its bound"
        expect_said out "^    \"$name\"(,|\$)"
        run 0 sobox-simulate "$scenario" --design centre \
            --set "constraints={$name: {min: $(awk "BEGIN {print $value + 1}")}}"
        expect_said out "^    \"$name\"(,|\$)"
        count=$((count + 1))
    done < <(sqlite3 :memory: "SELECT key, printf('%!.17g', value) FROM json_each(readfile('usual'))
        WHERE type IN ('real', 'integer') AND key <> 'good'")
    [ "$count" -ge 14 ] || fail "$count outcomes"
}

# Bounds that contradict each other leave no design, and the run says which stood in the way.
contradicting_bounds_are_named()
{
    run 3 sobox-coordinator "$scenario" --set 'constraints={s_L_min: {max: 0.2}}' --out run
    expect_equal "$(json run/result.json '$.searches[0].status')" no_good_design 'status'
    expect_equal "$(json run/result.json '$.searches[0].blocking_constraint')" s_L_min 'obstacle'
}
