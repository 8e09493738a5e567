# From the boxes of components to the springs of a scenario, from the command line.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_boxes=$here/../../deploy/scenarios/sedan-components.csv
_ten=$here/../../deploy/scenarios/sedan-ten-springs.yaml

# A scenario whose springs the program wrote is the shipped one: a crash of it has the same
# outcomes, to the last digit.
springs_of_the_sedan_crash_as_its_scenario_does()
{
    run 0 sobox-springs "$_boxes" --face-x=-2.08 --edge-y=-0.455 --width 1.15 --output springs.yaml
    expect_equal "$(wc -c <out)" 0 'bytes on standard output'
    sed '/^springs:/,/^response:/{/^response:/!d}' "$_ten" >made.yaml
    cat springs.yaml >>made.yaml
    run 0 sobox-simulate "$_ten" --design upper
    mv out shipped
    run 0 sobox-simulate made.yaml --design upper
    cmp shipped out || fail 'the outcomes differ'
}

overlaps_gaps_and_what_lies_beside_the_face_are_told()
{
    cat >boxes.csv <<'CSV'
name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m
rail,,-2.0,-1.0,-0.6,-0.4,0.4,0.5
wheel,,-1.5,-0.8,-0.9,-0.58,0.2,0.5
CSV
    run 0 sobox-springs boxes.csv --edge-y=-0.45
    expect_said err 'groups rail and wheel overlap: y -0.6 .. -0.58, z 0.4 .. 0.5 m [(]20 cm2[)]'
    expect_said err 'no component stands at y -0.58 .. -0.45, z 0.2 .. 0.4 m [(]260 cm2[)]'
    expect_said err 'group rail: 50 mm of its 200 mm in y lie beside the barrier'
    expect_said err 'the springs have no force_x and force_y'
    expect_said out 'length: 1$'
}

wrong_input_is_pointed_at()
{
    run 2 sobox-springs
    expect_said err 'no components: expected sobox-springs COMPONENTS.csv'
    run 2 sobox-springs none.csv
    expect_said err 'none.csv'
    run 2 sobox-springs "$_boxes" --face-x=-1.9
    expect_said err 'sedan-components.csv:13:1: x_min_m: expected at least -1.9 m'
    run 2 sobox-springs "$_boxes" --width 1.15
    expect_said err 'a --width of more than 0 m beside an --edge-y'
    sed 's/-1.46,-1.08/-1460,-1080/' "$_boxes" >boxes.csv
    run 2 sobox-springs boxes.csv
    expect_said err '^boxes.csv:8:12: x_min_m: expected a place within .* [(]in millimetres[?][)]'
}

springs_that_cannot_be_written_fail()
{
    run 1 sobox-springs "$_boxes" --output none/springs.yaml
    expect_said err 'none/springs.yaml'
    run 1 bash -c 'sobox-springs "$1" >/dev/full' _ "$_boxes"
    expect_said err 'standard output: writing failed'
}

# Alone a curve gives its points; with the boxes of its spring it adds to theirs, which a curve of
# forces measured at the barrier does too: a design is such a table.
curves_choose_points()
{
    cat >curves.csv <<'CSV'
spring,deformation_m,force_x_N,force_y_N
wheel,0,50e3,0
wheel,0.2,50e3,0
wheel,0.3,50e3,0
wheel,0.5,300e3,0
wheel,0.4,0,0
wheel,0.8,300e3,0
wheel,1.2,300e3,0
tow-bar,0,1,0
tow-bar,1,1,0
CSV
    run 0 sobox-springs --curves curves.csv
    expect_said out 'deformation: [[]0, 0.3, 0.5, 1.2[]]$'
    expect_said err 'spring wheel: 1 rows go back'
    run 0 sobox-springs "$_boxes" --face-x=-2.08 --curves curves.csv
    expect_said out 'deformation: [[]0, 0.25, 0.3, 0.5, 0.62, 1, 1.2[]]$'
    expect_said err 'no group is called tow-bar'
    run 0 sobox-springs --curves curves.csv --points 3
    expect_said err 'spring wheel: 3 points miss the curve by [0-9.]* % of its greatest force'
    run 2 sobox-springs --curves curves.csv --tolerance 0
    expect_said err '--tolerance: expected more than 0'
    run 0 sobox-simulate "$_ten" --design centre
    run 2 sobox-springs --curves out
    expect_said err '^out:1:1: expected the columns spring, deformation_m'
}
