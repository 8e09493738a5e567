# A box of corridors, perhaps edited, is certified as it is.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_search() # DIR [OPTION...]
{
    run 0 sobox-coordinator "$scenario" --set search.promise=every --out "$@"
}

_certify() # BOX DIR [OPTION...]
{
    run 0 sobox-coordinator --certify "$1" "$scenario" --set search.promise=every --out "${@:2}"
}

# The corridors come out as they went in, to the bit, and what was found of them is found again.
corridors_of_a_run_are_certified_again()
{
    _search found
    _certify found again
    cmp found/corridors.csv again/corridors.csv || fail 'the corridors are others'
    expect_equal "$(json again/result.json '$.searches[0].status')" 'done' 'status'
    expect_equal "$(journal again "SELECT count(*) FROM step WHERE phase NOT IN ('certify', 'explain')")" \
        0 'steps of a search'
    _certify found/corridors.csv workers --workers 2
    expect_same_run again workers
}

# Corridors that were widened by hand are kept as they are, and the design that breaks them shows.
widened_corridors_are_told_to_be_bad()
{
    _search found
    awk -F, -v OFS=, 'NR > 1 { $5 = $7 } { print }' found/corridors.csv >wide.csv
    _certify wide.csv wide
    expect_equal "$(json wide/result.json '$.searches[0].status')" purity_missed 'status'
    expect_equal "$(cut -d, -f1-6 wide/corridors.csv)" "$(cut -d, -f1-6 wide.csv)" 'corridors'
    [ "$(json wide/result.json '$.searches[0].kinds.extremes.bad')" -gt 0 ] ||
        fail 'no bad design was found'
}

# One box in every case of a sweep.
box_is_certified_in_every_case_of_a_sweep()
{
    _search found
    cp "$scenario" base.yaml
    printf '%s\n' 'sweep: masses' 'base: base.yaml' 'axes: [{path: vehicle.mass, values: [1650, 2200]}]' \
        >sweep.yaml
    run 0 sobox-coordinator --certify found sweep.yaml --set search.promise=every --out masses
    expect_equal "$(json masses/result.json '$.searches[0].status')" 'done' 'status of the car'
    expect_equal "$(json masses/result.json '$.searches[1].status')" purity_missed \
        'status of a heavier one'
}

broken_boxes_are_pointed_at()
{
    _search found
    _refused_box() # PATTERN
    {
        run 2 sobox-coordinator --certify box.csv "$scenario" --out none
        expect_one_line err
        expect_said err "$1"
        expect_no none
    }
    : >box.csv
    _refused_box '^box.csv:1:1: expected the columns'
    head -1 found/corridors.csv >box.csv
    _refused_box '^box.csv:1:1: expected a row for every variable'
    sed 3d found/corridors.csv >box.csv
    _refused_box "^box.csv:1:1: .*front.force_x\[1\] is missing"
    awk -F, -v OFS=, 'NR == 2 { $5 = 3; $6 = 2 } { print }' found/corridors.csv >box.csv
    _refused_box '^box.csv:2:[0-9]+: front.force_x\[0\]: expected an upper bound at least'
    awk -F, -v OFS=, 'NR == 2 { $6 = 60001 } { print }' found/corridors.csv >box.csv
    _refused_box '^box.csv:2:[0-9]+: front.force_x\[0\]: .*inside the design space, 0 to 60000'
    awk -F, -v OFS=, 'NR > 1 { $6 = $5 } { print }' found/corridors.csv >box.csv
    _refused_box '^box.csv:1:1: every corridor is a single value'
    run 2 sobox-coordinator --certify found --resume found
    expect_said err '^--certify begins a run of its own'
}

# Bounds come out as multiples, inside of those of a box that is rounded, in a search too, and by any
# workers.
bounds_are_rounded_inwards()
{
    _not_rounded() # DIR
    {
        awk -F, 'NR > 1 && ($5 % 10000 || $6 % 10000)' "$1/corridors.csv"
    }
    _search rounded --round 10e3
    expect_equal "$(_not_rounded rounded)" '' 'bounds that are no multiples'
    expect_equal "$(json rounded/result.json '$.searches[0].status')" 'done' 'status'
    expect_equal "$(json rounded/result.json '$.searches[0].round.left')" '[]' 'bounds left'
    expect_said out '^rounded +inwards to multiples of 10000$'
    _search workers --round 10e3 --workers 2
    expect_same_run rounded workers
    _search found
    _certify found inside --round 10e3
    expect_equal "$(_not_rounded inside)" '' 'bounds that are no multiples'
    paste -d, found/corridors.csv inside/corridors.csv |
        awk -F, 'NR > 1 && ($14 < $5 || $15 > $6) { exit 1 }' || fail 'a bound was moved outwards'
    run 2 sobox-coordinator "$scenario" --out none --round 70e3
    expect_said err '^--set search.round=70e3:1:1: search.round: front.force_x\[0\], 0 to 60000, has no'
}

# The strongest car is to stay inside, and its forces are no multiples: such bounds stay as they are
# found, and that is told.
bounds_that_cannot_be_rounded_are_told()
{
    run 1 sobox-coordinator "$scenario" --out coarse --round 60e3 \
        --set 'search.reference=[60e3, 450e3, 450e3, 450e3, 450e3, 0, 0, 0, 0, 0]'
    expect_said err 'search.round is too coarse: in 1 of 1 boxes'
    expect_said out '^rounded +inwards to multiples of 60000, but for these'
    expect_equal "$(json coarse/result.json '$.searches[0].round.left[0]')" 'front.force_x[1]' 'left'
}
