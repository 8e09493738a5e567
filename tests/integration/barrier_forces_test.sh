# From a barrier's forces to a design and back to the motion, from the command line.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# Writes forces.csv and motion.csv: those of a simulated design of the scenario's one spring at
# y = -0.75, each force shared by two nodes of the barrier.
_measure() # DESIGN [OPTION...]
{
    run 0 sobox-simulate "$scenario" --design "$@" --trajectory path.csv
    cut -d , -f 1-4 path.csv >motion.csv
    awk -F, '
        NR == 1 { print "time_s,node,y_m,z_m,normal_x_N,normal_y_N,shear_x_N,shear_y_N" }
        NR > 1 {
            x = cos($4) * $10 - sin($4) * $11
            y = sin($4) * $10 + cos($4) * $11
            for (node = 1; node <= 2; node++)
                printf "%s,%d,-0.%d,0.5,%.17g,0,0,%.17g\n", $1, node, 5 + node, -x / 2, -y / 2
        }' path.csv >forces.csv
}

# The forces of a known design, reduced and simulated again, move the car as the design did: exactly
# under central difference, which takes the forces at whole steps as they are recorded, and within
# some millimetres under event Verlet, which also knows what happened in between.
forces_of_a_design_give_its_motion_back()
{
    local whole=(--set 'simulation={integrator: central_difference, reloading: thesis}')
    _measure centre "${whole[@]}"
    run 0 sobox-barrier-forces "$scenario" --forces forces.csv --motion motion.csv \
        --output design.csv
    expect_equal "$(json out '$.forces_on')" barrier 'the side of the contact'
    expect_equal "$(json out '$.times')" 151 'times'
    run 0 sobox-simulate "$scenario" "${whole[@]}" --design design.csv --compare motion.csv
    expect_equal "$(sqlite3 :memory: "SELECT max(value) < 1e-6 FROM json_tree(readfile('out'))
        WHERE key IN ('x_m', 'y_m', 'yaw_rad')")" 1 'the motion comes back'
    _measure centre
    run 0 sobox-barrier-forces "$scenario" --forces forces.csv --motion motion.csv \
        --output design.csv
    run 0 sobox-simulate "$scenario" --design design.csv --compare motion.csv
    expect_equal "$(sqlite3 :memory: "SELECT max(value) < 5e-3 FROM json_tree(readfile('out'))
        WHERE key IN ('x_m', 'y_m', 'yaw_rad')")" 1 'the motion nearly comes back'
}

forces_are_read_from_a_pipe()
{
    _measure centre
    run 0 sobox-barrier-forces "$scenario" --forces forces.csv --motion motion.csv \
        --output design.csv
    run 0 sobox-barrier-forces "$scenario" --forces - --motion motion.csv --output piped.csv \
        <forces.csv
    cmp design.csv piped.csv || fail 'the design differs'
}

# A table of 30 MB goes through a program that may take 20 MB of data.
table_need_not_fit_memory()
{
    _measure centre
    awk -F, -v OFS=, '
        NR == 1 { print }
        NR > 1 { $5 /= 1500; $8 /= 1500
            for (i = 0; i < 1500; i++) { $2 = 2 * i + NR % 2; print } }' forces.csv >large.csv
    local limited=(bash -c 'ulimit -d 20000; exec "$@"' limited)
    # Under a sanitizer nothing starts with so little.
    "${limited[@]}" sobox-barrier-forces --version || limited=()
    run 0 "${limited[@]}" sobox-barrier-forces "$scenario" --forces large.csv \
        --motion motion.csv --output design.csv
    expect_equal "$(json out '$.node_forces')" 453000 'node forces'
}

# One group's box takes the whole face, as one spring does; a group of another name is of no use.
boxes_of_components_share_the_forces()
{
    _measure centre
    local arguments=("$scenario" --forces forces.csv --motion motion.csv)
    run 0 sobox-barrier-forces "${arguments[@]}" --output design.csv
    local spring
    spring=$(sed -n '2s/,.*//p' design.csv)
    { echo name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m
        echo "front,$spring,-2,-0.8,-0.9,-0.6,0.2,0.8"; } >boxes.csv
    run 0 sobox-barrier-forces "${arguments[@]}" --components boxes.csv --output boxed.csv
    cmp design.csv boxed.csv || fail 'the design differs'
    sed -i 's/,-2,/,wide,/' boxes.csv
    run 2 sobox-barrier-forces "${arguments[@]}" --components boxes.csv --output boxed.csv
    expect_said err '^boxes.csv:2:[0-9]*: x_min_m: expected a finite number'
    sed -i "s/wide/-2/; s/,$spring,/,other,/" boxes.csv
    run 2 sobox-barrier-forces "${arguments[@]}" --components boxes.csv --output boxed.csv
    expect_said err "spring $spring has no components"
}

wrong_forces_are_pointed_at()
{
    _measure centre
    local arguments=("$scenario" --motion motion.csv --output design.csv)
    { cat forces.csv; echo '0.1,1,-0.6,0.5,0,0,0,0'; } >wrong.csv
    run 2 sobox-barrier-forces "${arguments[@]}" --forces wrong.csv
    expect_one_line err
    expect_said err '^wrong.csv:304:1: time_s: '
    sed '3s/-0\.6/here/; 3s/-0\.7/here/' forces.csv >wrong.csv
    run 2 sobox-barrier-forces "${arguments[@]}" --forces wrong.csv
    expect_one_line err
    expect_said err '^wrong.csv:3:[0-9]*: y_m: .*here'
    head -c 3000000 /dev/zero | tr '\0' x >wrong.csv
    run 2 sobox-barrier-forces "${arguments[@]}" --forces wrong.csv
    expect_said err 'wrong.csv: expected lines'
    run 2 sobox-barrier-forces "${arguments[@]}" --forces nowhere.csv
    expect_said err 'nowhere.csv'
    run 2 sobox-barrier-forces "${arguments[@]}" --forces .
    expect_no design.csv
}

wrong_motion_is_pointed_at()
{
    _measure centre
    cut -d , -f 1-3 motion.csv >wrong.csv
    run 2 sobox-barrier-forces "$scenario" --forces forces.csv --motion wrong.csv --output d.csv
    expect_said err '^wrong.csv:1:1: .*yaw_rad'
    head -n 50 motion.csv >wrong.csv
    run 2 sobox-barrier-forces "$scenario" --forces forces.csv --motion wrong.csv --output d.csv
    expect_said err '^forces.csv:[0-9]*:1: time_s: expected 0 to '
    expect_no d.csv
}

missing_options_are_named()
{
    run 2 sobox-barrier-forces "$scenario"
    expect_said err '--forces'
    run 2 sobox-barrier-forces
    expect_said err 'SCENARIO.yaml'
    run 0 sobox-barrier-forces --version
    expect_said out '^sobox-barrier-forces [0-9]'
}

# A table with a hole, and a force beside the barrier: told, but no reason to stop.
doubts_are_noted()
{
    _measure centre
    awk -F, 'NR == 1 || $1 < 0.05 || $1 > 0.07 { print }
        NR == 9 { printf "%s,9,0.3,0.5,-1e5,0,0,0\n", $1 }' forces.csv >doubtful.csv
    run 0 sobox-barrier-forces "$scenario" --forces doubtful.csv --motion motion.csv \
        --output design.csv
    expect_said err 'nothing between 0.0[45]'
    expect_said err '1 node forces, .* outside all patches'
}

# Forces and motion of one car that cannot belong together: what is unlikely is noted, what cannot be
# meant ends the work. The table says what is done to which of the two.
contradictions_of_forces_and_motion_are_told()
{
    local what result slip program
    local arguments=("$scenario" --output design.csv)
    _measure centre
    run 0 sobox-barrier-forces "${arguments[@]}" --forces forces.csv --motion motion.csv
    expect_equal "$(cat err)" '' 'nothing to tell of the right ones'
    expect_equal "$(json out '$.balance.x_m.ratio' | awk '{ print ($1 > 0.98 && $1 < 1.02) }')" 1 \
        'the impulse closes'
    expect_equal "$(json out '$.doubts')" '[]' 'no doubts'
    rm design.csv
    while IFS='|' read -r what result slip program; do
        cp forces.csv changed-forces.csv
        cp motion.csv changed-motion.csv
        awk -F, -v OFS=, "NR == 1 { print; next } $program { print }" "$what.csv" \
            >"changed-$what.csv"
        run "$result" sobox-barrier-forces "${arguments[@]}" --forces changed-forces.csv \
            --motion changed-motion.csv
        expect_said err "$slip"
        if [ "$result" = 2 ]; then
            expect_no design.csv
        else
            expect_said out "$slip"
            rm design.csv
        fi
    done <<'END'
forces|2|forces in kN|{ $5 /= 1e3; $8 /= 1e3 }
forces|2|impulses in N s|{ a[$2] += 1e-3 * $5; b[$2] += 1e-3 * $8; $5 = a[$2]; $8 = b[$2] }
forces|0|half of the cells|$2 == 1
forces|0|y of forces or motion of opposite sign|{ $8 = -$8 }
forces|0|cut off|$1 < 0.04
motion|2|in mm|{ $2 *= 1e3; $3 *= 1e3 }
motion|0|y of forces or motion of opposite sign|{ $3 = -$3 }
motion|0|x_m begins with|{ $2 += 0.1 }
motion|0|vehicle.speed|{ $2 *= 0.5 }
END
    run 2 sobox-barrier-forces "${arguments[@]}" --forces forces.csv --motion motion.csv \
        --set vehicle.speed=17889
    expect_said err 'likely slip: 17889 mm/s'
    run 0 sobox-barrier-forces "${arguments[@]}" --forces forces.csv --motion motion.csv \
        --set vehicle.speed=64.4
    expect_said err 'begins at'
    expect_said err 'warning: vehicle.speed: .*likely slip: 64.4 km/h'
}
