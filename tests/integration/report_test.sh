# Plots and exports of a run folder.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# Everything but the journal can be made from it again.
report_is_made_from_the_journal_alone()
{
    run 0 sobox-coordinator "$scenario" --out run
    cp -r run whole
    rm run/result.json run/corridors.csv run/history.csv run/corridors.svg
    run 0 sobox-report run
    expect_same_run whole run
    expect_files run/corridors.svg
}

_interrupted_run()
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run
    hold coordinator run 3
    press_ctrl_c coordinator
    go_on coordinator
    finish 130 coordinator
}

run_that_was_interrupted_can_be_reported()
{
    _interrupted_run
    run 0 sobox-report run
    expect_files run/corridors.svg run/corridors.csv
    expect_equal "$(json run/result.json '$.searches[0].status')" interrupted 'status in result.json'
}

run_that_was_killed_can_be_reported()
{
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run
    hold coordinator run 3
    signal KILL coordinator
    finish 137 coordinator
    run 0 sobox-report run
    expect_files run/corridors.svg
}

run_that_goes_on_can_be_reported()
{
    start coordinator sobox-coordinator "$scenario" --out run --url "$url"
    wait_for_line coordinator 'waiting for a worker'
    run 0 sobox-report run
    start worker sobox-worker --url "$url"
    finish 0 coordinator
}

# Beside a coordinator that writes step after step, and again and again: each report shows one moment
# of the run and does not disturb it.
run_in_full_swing_can_be_reported()
{
    run 0 sobox-coordinator "$scenario" "${steady[@]}" --out calm
    start coordinator sobox-coordinator "$scenario" "${steady[@]}" --out run
    local count
    for count in 2 5 8; do
        wait_for_steps run "$count"
        run 0 sobox-report run
        [ "$(json run/result.json '$.searches[0].steps')" -ge "$count" ] ||
            fail "the report lacks steps: $(json run/result.json '$.searches[0].steps') of $count"
    done
    finish 0 coordinator
    expect_same_run calm run
}

_begins_with() # FILE BYTES
{
    [ "$(head -c "${#2}" "$1")" = "$2" ] || fail "$1 is none: it begins with $(head -c 16 "$1")"
}

picture_comes_as_svg_png_and_pdf()
{
    run 0 sobox-coordinator "$scenario" --out run
    run 0 sobox-report run --png --pdf
    _begins_with run/corridors.svg '<?xml'
    head -c 8 run/corridors.png | grep -qa PNG || fail 'corridors.png is none'
    _begins_with run/corridors.pdf '%PDF'
    run 0 sobox-report run --out other.pdf
    _begins_with other.pdf '%PDF'
    run 2 sobox-report run --out other.bmp
    expect_said err 'svg'
}

# The user may edit the script that drew the picture, and draw it again.
script_of_the_picture_is_left_for_editing()
{
    run 0 sobox-coordinator "$scenario" --out run
    expect_files run/corridors.gp
    rm run/corridors.svg
    (cd run && run 0 gnuplot corridors.gp)
    expect_files run/corridors.svg
}

second_run_is_laid_over_the_first()
{
    run 0 sobox-coordinator "$scenario" --out rotating --set response=rotating
    run 0 sobox-coordinator "$scenario" --out glancing --set response=glancing_off
    cp rotating/corridors.svg alone.svg
    run 0 sobox-report rotating --compare glancing
    ! cmp -s alone.svg rotating/corridors-compared.svg || fail 'the second run does not show'
    expect_said out 'corridors-compared.svg'
    cmp alone.svg rotating/corridors.svg || fail 'the picture of the run alone was drawn over'
    run 2 sobox-report rotating --compare nowhere
    expect_said err nowhere
}

# Everything divided by its greatest value: no force of the design space may be read from the picture,
# its script or the table.
normalised_report_shows_no_force()
{
    run 0 sobox-coordinator "$scenario" --out run
    grep -qE '>[^<]*kN' run/corridors.svg || fail 'the plain picture names no unit of force'
    run 0 sobox-report run --normalise
    ! grep -qE '>[^<]*(kN|450)' run/corridors-normalised.svg ||
        fail 'the normalised picture shows forces'
    ! grep -qwE '450|450e3|450000' run/corridors-normalised.gp || fail 'the script of the picture has forces'
    expect_said out '^ +0.250 +[01][.][0-9]{3} '
    ! grep -qE 'kN|[[]m[]]' out || fail 'the normalised table has units'
    run 0 sobox-report run
    expect_said out '^ +1.200 +[0-9]+[.][0-9] '
}

folder_without_a_run_is_refused()
{
    mkdir empty
    run 2 sobox-report empty
    expect_said err empty
    run 2 sobox-report nowhere
    expect_said err nowhere
    expect_no nowhere
}

picture_is_told_to_be_missing_when_gnuplot_is()
{
    run 0 sobox-coordinator "$scenario" --out run
    mkdir programs
    ln -s "$(command -v sobox-report)" programs/
    ln -s "$(command -v sobox-coordinator)" programs/
    run 1 env PATH="$folder/programs" sobox-report run
    expect_said err gnuplot
    # The corridors themselves do not depend on it.
    run 0 env PATH="$folder/programs" sobox-coordinator "$scenario" --out plain
    expect_files plain/corridors.csv
    expect_said err gnuplot
    expect_no plain/corridors.svg
}

# What other departments get, and what they send back.
corridors_go_out_as_curves_and_measured_ones_are_checked()
{
    local format
    run 0 sobox-coordinator "$scenario" --out run
    for format in ls-dyna openradioss csv json; do
        run 0 sobox-report run --export "$format" --units kN-mm-ms --out curves
    done
    expect_files curves/curves.k curves/curves.inc curves/curves.csv curves/curves.json
    expect_equal "$(grep -c '^\*DEFINE_CURVE_TITLE' curves/curves.k)" 6 'curves of one spring'
    { echo spring,direction,deformation,force
      awk -F , '$3 == "middle" {print $1 "," $2 "," $4 "," $5}' curves/curves.csv; } >middle.csv
    run 0 sobox-report run --check middle.csv --units kN-mm-ms
    expect_said out '^front F_x: inside its corridor from 0 to 1200 mm'
    run 3 sobox-report run --check middle.csv --units N-mm-ms
    expect_said out '^front F_x: leaves its corridor'
    run 2 sobox-report run --export ls-dyna --units stone-inch-s --out none
    expect_said err 'expected one of N-m-s'
    run 2 sobox-report run --export ls-dyna
    expect_said err 'expected --out with the folder'
    echo spring,force >wrong.csv
    echo front,1 >>wrong.csv
    run 2 sobox-report run --check wrong.csv
    expect_said err '^wrong\.csv:1:8: expected direction'
}

# A car of 264 kJ that 400 kN stop head-on after 0.66 m at the latest: it passes the point at 0.5 m and
# never the one at 0.75 m.
_write_stopped()
{
    cat >stopped.yaml <<'END'
name: stopped
vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889, cog: [0.0, -0.75]}
barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}
springs:
  - name: front
    position: [-0.83, 0.0]
    deformation: [0.0, 0.25, 0.5, 0.75, 1.0, 1.25]
    force_x: {lower: 400e3, upper: 800e3}
    force_y: {lower: 0, upper: 1e3}
response: any
firewall_distance: 0.25
search: {samples: 200, exploration_steps: 10, consolidation_steps: 10, target_purity: 0.9,
         certificate_samples: 1000}
END
}

# The marks are in whatever shows corridors, also when all is made again from the journal alone.
points_that_no_design_reaches_are_marked_everywhere()
{
    _write_stopped
    local unreached=$'1,no\n1.25,no\n1,no\n1.25,no'
    run 0 sobox-coordinator stopped.yaml --out run
    expect_said out '^\*      1\.000 '
    expect_said out '^\*      1\.250 '
    expect_equal "$(grep -c '^\*  ' out)" 2 'marked rows'
    expect_said out '^\* none of 2,048 simulated designs'
    expect_equal "$(grep -c ,yes run/corridors.csv)" 8 'points that are reached'
    expect_equal "$(grep ,no run/corridors.csv | cut -d , -f 4,9)" "$unreached" 'those that are not'
    expect_said run/corridors.svg 'hatched: reached by none of 2,048 designs'
    expect_equal "$(json run/result.json '$.searches[0].reach.springs[0].points_reached')" 4 'points'
    expect_equal "$(sqlite3 :memory: "SELECT abs(json_extract(readfile('run/result.json'),
        '\$.searches[0].reach.springs[0].deformation_max_m') - 0.66) < 0.01")" 1 'deepest design'

    cp -r run again
    rm again/result.json again/corridors.* again/history.csv
    run 0 sobox-report again
    cmp run/corridors.csv again/corridors.csv || fail 'the marks are others when made again'
    run 0 sobox-report run --export csv --units N-mm-s --out curves
    expect_equal "$(grep -c ',no$' curves/curves.csv)" 12 'points out of reach of six curves'
    printf 'spring,direction,deformation,force\nfront,x,0,6e5\nfront,x,1,6e5\nfront,x,1.25,1e5\n' \
        >measured.csv
    run 3 sobox-report run --check measured.csv
    expect_said out 'all of it beyond 0\.75 m, where none of 2,048 simulated designs'

    run 0 sobox-coordinator "$scenario" --out short
    run 0 sobox-report run --compare short --out both.svg
    expect_said both.svg 'hatched: reached by none'
}

# The report of a sweep goes to people who see nothing else of it.
reports_of_sweeps_show_what_no_design_reaches()
{
    _write_stopped
    printf 'sweep: stops\nbase: stopped.yaml\naxes:\n  - {path: vehicle.mass, values: [1500, 1650]}\n' \
        >stops.yaml
    run 0 sobox-coordinator stops.yaml --out run
    expect_equal "$(grep ,no run/corridors.csv | cut -d , -f 1,3,4)" \
        $'0,x,1\n0,x,1.25\n0,y,1\n0,y,1.25\n1,x,1\n1,x,1.25\n1,y,1\n1,y,1.25' 'points of both cases'
    run 0 sobox-report run --html stops.html
    expect_said stops.html 'dashed: reached by none of 2,048 designs'
    run 0 sobox-report run --cases '*' --out cases.svg
    expect_said cases.svg 'dashed: reached by none of 2,048 designs'
}
