# Several seeds of one scenario: the best box is the result, and its bounds have a spread.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

best_of_several_seeds_is_the_result()
{
    run 0 sobox-coordinator "$scenario" --seeds 4 --out seeds
    expect_said out '^best of 4 seeds: seed=[1-4], response any$'
    expect_said out '^seeds +log-volume -.* spread '
    local best
    best=$(json seeds/result.json '$.seeds.best')
    expect_equal "$(sqlite3 :memory: "SELECT max(json_extract(value, '\$.log_volume')) =
        json_extract(readfile('seeds/result.json'), '\$.searches[$best].log_volume')
        FROM json_each(readfile('seeds/result.json'), '\$.searches')
        WHERE json_extract(value, '\$.status') = 'done'")" 1 'the best is the largest box'
    expect_equal "$(awk -F, 'NR > 1 { print $1, $10 != "" && $11 != "" }' seeds/corridors.csv | uniq)" \
        "$best 1" 'searches in corridors.csv, and whether bounds have a spread'
    expect_said seeds/corridors.gp 'spread_1_x'
    # Each of them is the search that it would be alone.
    run 0 sobox-coordinator "$scenario" --seed "$((best + 1))" --out alone
    expect_equal "$(json seeds/result.json "\$.searches[$best].digest")" "$(digest alone)" 'digest'
    expect_equal "$(cut -d, -f2-9 seeds/corridors.csv)" "$(cut -d, -f2-9 alone/corridors.csv)" 'best box'
    # What is shown where no search is asked for is the best one.
    run 0 sobox-report seeds --export csv --out curves
    run 0 sobox-report alone --export csv --out curves-alone
    expect_equal "$(grep -v '^#' curves/*.csv)" "$(grep -v '^#' curves-alone/*.csv)" 'curves'
    # The folder is a box to certify.
    run 0 sobox-coordinator --certify seeds "$scenario" --out certified
    expect_equal "$(cut -d, -f2-9 certified/corridors.csv)" "$(cut -d, -f2-9 alone/corridors.csv)" \
        'certified box'
}

seeds_go_with_searches_of_a_scenario()
{
    run 2 sobox-coordinator "$scenario" --seeds 1
    expect_said err '^--seeds 1: expected 2 to 100000$'
    run 2 sobox-coordinator --certify runs "$scenario" --seeds 3
    expect_said err '^--seeds begins searches: it goes without --certify$'
    printf '%s\n' 'sweep: s' "base: $scenario" 'replicates: 2' >sweep.yaml
    run 2 sobox-coordinator sweep.yaml --seeds 3
    expect_said err '^--seeds goes with a scenario, and sweep.yaml is a sweep'
    run 2 sobox-coordinator "$scenario" --seeds 3 --set search.seed=x
    expect_said err 'search.seed'
    run 0 sobox-coordinator "$scenario" --seeds 3 --dry-run
    expect_said out 'seed=3'
}
