# A sweep: many searches that share the workers, may be ended at any time, and give what each of
# their scenarios gives alone.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# A sweep of SEEDS seeds times two masses.
_write_sweep() # SEEDS
{
    cat >sweep.yaml <<EOF
sweep: masses
base: $scenario
axes:
  - {path: vehicle.mass, values: [1500, 1650]}
replicates: $1
EOF
}

# What a sweep is worth, without the time it took.
_rows() # RUN
{
    journal "$1" 'SELECT number, name, status, hex(digest), hex(bounds) FROM search ORDER BY number'
}

_expect_same_sweep() # RUN RUN
{
    [ -n "$(_rows "$1")" ] || fail "$1 has no rows"
    expect_equal "$(_rows "$2")" "$(_rows "$1")" "the searches of $2 beside those of $1"
    cmp "$1/corridors.csv" "$2/corridors.csv" || fail "the corridors of $1 and $2 differ"
    cmp "$1/history.csv" "$2/history.csv" || fail "the histories of $1 and $2 differ"
}

every_case_gives_the_digest_of_its_scenario_alone()
{
    _write_sweep 3
    run 0 sobox-coordinator sweep.yaml --out run
    expect_said out 'masses, 6 searches'
    expect_equal "$(journal run 'SELECT state FROM run')" 'done' 'state of the run'
    run 0 sobox-coordinator "$scenario" --set vehicle.mass=1650 --seed 3 --out alone
    expect_equal "$(journal run "SELECT hex(digest) FROM search WHERE name = 'mass=1650,seed=3'")" \
        "$(journal alone 'SELECT hex(digest) FROM search')" 'digest of the case'
}

sweep_is_the_same_over_any_workers_and_threads()
{
    _write_sweep 4
    run 0 sobox-coordinator sweep.yaml --out one --threads 1
    run 0 sobox-coordinator sweep.yaml --out many --threads 4
    _expect_same_sweep one many
    run 0 sobox-coordinator sweep.yaml --out workers --workers 3
    _expect_same_sweep one workers
}

sweep_killed_in_its_middle_resumes_to_the_same_rows()
{
    _write_sweep 2
    run 0 sobox-coordinator sweep.yaml --out calm "${steady[@]}"
    local count
    start coordinator sobox-coordinator sweep.yaml --out run "${steady[@]}"
    for count in 10 60 120; do
        hold coordinator run "$count"
        signal KILL coordinator
        finish 137 coordinator
        start coordinator sobox-coordinator --resume run --threads 1
    done
    finish 0 coordinator
    _expect_same_sweep calm run
}

ctrl_c_in_a_sweep_over_worker_processes_resumes_to_the_same_rows()
{
    _write_sweep 2
    run 0 sobox-coordinator sweep.yaml --out calm "${steady[@]}"
    start coordinator sobox-coordinator sweep.yaml --out run --workers 2 "${steady[@]}"
    hold coordinator run 50
    press_ctrl_c coordinator
    go_on coordinator
    finish 130 coordinator
    expect_said coordinator.err '--resume run'
    run 0 sobox-coordinator --resume run
    _expect_same_sweep calm run
}

# The parts of a sweep that several coordinators, or sessions, carry out make up the whole.
parts_of_a_sweep_make_up_the_whole()
{
    _write_sweep 3
    run 0 sobox-coordinator sweep.yaml --out whole
    run 0 sobox-coordinator sweep.yaml --out shard1 --shard 1/2
    run 0 sobox-coordinator sweep.yaml --out shard2 --shard 2/2
    expect_equal "$({
        journal shard1 'SELECT name, hex(digest) FROM search'
        journal shard2 'SELECT name, hex(digest) FROM search'
    } | sort)" "$(journal whole 'SELECT name, hex(digest) FROM search' | sort)" 'rows of the shards'

    run 0 sobox-coordinator sweep.yaml --out parts --stop-after 2
    expect_said err '4 of 6 searches wait.*--resume parts'
    run 0 sobox-coordinator --resume parts --only '*seed=3'
    expect_said err '2 of 6 searches wait'
    run 2 sobox-coordinator --resume parts --only '*seed=3'
    expect_said err "matches no search"
    run 0 sobox-coordinator --resume parts
    _expect_same_sweep whole parts
    run 1 sobox-coordinator --resume parts
    expect_said err 'this run is done'
}

# Two coordinators, each with its part of the sweep, and workers that serve both at once and keep the
# scenarios of both.
parts_over_one_set_of_workers_make_up_the_whole()
{
    _write_sweep 2
    run 0 sobox-coordinator sweep.yaml --out whole "${steady[@]}"
    start worker1 sobox-worker --url "$url" --threads 1
    start worker2 sobox-worker --url "$url" --threads 3
    start one sobox-coordinator sweep.yaml "${steady[@]}" --url "$url" --shard 1/2 --out one
    start two sobox-coordinator sweep.yaml "${steady[@]}" --url "$url" --shard 2/2 --out two
    finish 0 one
    finish 0 two
    expect_equal "$({
        journal one 'SELECT name, status, hex(digest), hex(bounds) FROM search'
        journal two 'SELECT name, status, hex(digest), hex(bounds) FROM search'
    } | sort)" "$(journal whole 'SELECT name, status, hex(digest), hex(bounds) FROM search' | sort)" \
        'rows of the two coordinators'
    expect_equal "$({
        sed 1d one/summary.csv
        sed 1d two/summary.csv
    } | cut -d, -f1-5 | sort)" "$(sed 1d whole/summary.csv | cut -d, -f1-5 | sort)" \
        'rows of the two summaries'
}

only_runs_what_it_names_or_says_how_names_look()
{
    _write_sweep 3
    run 0 sobox-coordinator sweep.yaml --out run --only 'mass=1650,seed=[12]'
    expect_equal "$(journal run 'SELECT group_concat(name) FROM search')" \
        'mass=1650,seed=1,mass=1650,seed=2' 'names of the searches'
    run 2 sobox-coordinator sweep.yaml --out none --only 'weight=*'
    expect_said err "names like 'mass=1500,seed=1'"
    expect_no none
}

dry_run_prints_the_cases_and_an_estimate_and_writes_nothing()
{
    _write_sweep 2
    run 0 sobox-coordinator sweep.yaml --dry-run
    expect_equal "$(head -n 4 out)" "mass=1500,seed=1
mass=1500,seed=2
mass=1650,seed=1
mass=1650,seed=2" 'the cases'
    expect_said out '4 searches of 20800 designs in all'
    expect_said out '^(about [0-9.]+ (s|min)|less than a second) on [0-9]+ core'
    expect_no runs
}

# A case in which nothing is good is a row; only when all are so is it said with the exit status.
case_without_a_good_design_is_a_row()
{
    _write_sweep 1
    sed -i 's/path: .*/path: firewall_distance, values: [0.25, 1.2]}/' sweep.yaml
    run 0 sobox-coordinator sweep.yaml --out run
    expect_equal "$(journal run 'SELECT group_concat(status) FROM search')" 'done,no_good_design' \
        'status of the searches'
    run 3 sobox-coordinator sweep.yaml --out none --only '*=1.2,*'
}

# An unlikely case is pointed at in the sweep's own file, by its name; one that cannot be meant ends
# the sweep before it starts.
implausible_cases_are_named()
{
    _write_sweep 1
    sed -i 's/path: .*/path: vehicle.speed, values: [17.889, 64.4]}/' sweep.yaml
    run 0 sobox-coordinator sweep.yaml --dry-run
    expect_said err '^sweep.yaml:4:[0-9]+: warning: vehicle.speed: .*64.4 km/h.*in the case speed=64.4,'
    expect_said err '1 of 2 cases are unlikely'
    sed -i 's/64.4/17889/' sweep.yaml
    run 2 sobox-coordinator sweep.yaml --out run
    expect_said err '^sweep.yaml:4:[0-9]+: vehicle.speed: .*in the case speed=17889,'
    expect_no run
}

# Somebody changed what one search has done so far: it cannot go on, the others can.
search_that_fails_is_a_row_and_not_the_end()
{
    _write_sweep 2
    start coordinator sobox-coordinator sweep.yaml --out run "${steady[@]}"
    hold coordinator run 12
    signal KILL coordinator
    finish 137 coordinator
    sqlite3 run/run.db 'UPDATE step SET bounds = zeroblob(length(bounds)) WHERE id = 1'
    run 1 sobox-coordinator --resume run
    expect_said err 'step 1 of the journal is not what the search asks for'
    expect_said err '1 of 4 searches could not be carried out.*--resume run'
    expect_equal "$(journal run 'SELECT count(*) FROM search WHERE finished')" 3 'searches done'
    expect_said run/summary.csv '^"mass=1500,seed=1",1500,1,failed,'
}

invalid_case_is_named_before_anything_starts()
{
    _write_sweep 1
    sed -i 's/1500, 1650/1500, -3/' sweep.yaml
    run 2 sobox-coordinator sweep.yaml --out run
    expect_said err '^sweep\.yaml:4:[0-9]+: vehicle\.mass: expected more than 0 kg, found -3 \(in the case mass=-3,seed=1'
    expect_one_line err
    expect_no run
    run 0 sobox-coordinator sweep.yaml --out run --keep-going
    expect_said err '^sweep\.yaml:4:.*mass=-3'
    expect_said err '1 case is left out'
    expect_equal "$(journal run 'SELECT group_concat(name) FROM search')" 'mass=1500,seed=1' 'names'
}

mistakes_in_a_sweep_are_told_with_their_place()
{
    _write_sweep 0
    run 2 sobox-coordinator sweep.yaml
    expect_said err '^sweep\.yaml:5:13: replicates: expected a whole number'
    _write_sweep 2
    sed -i 's/vehicle.mass/vehicle.masss/' sweep.yaml
    run 2 sobox-coordinator sweep.yaml
    expect_said err "^sweep\.yaml:4:.*unknown key 'masss'; did you mean 'mass'"
    _write_sweep 90000
    run 2 sobox-coordinator sweep.yaml
    expect_said err 'at most 100000 cases'
    expect_no runs
}

# The journal holds the scenarios of the cases: what is written into the sweep's file or its base later
# changes nothing, and giving the file again is refused, as it would look as if it did.
sweep_changed_since_goes_on_as_it_was_begun()
{
    cp "$scenario" base.yaml
    _write_sweep 2
    sed -i 's|^base: .*|base: base.yaml|' sweep.yaml
    run 0 sobox-coordinator sweep.yaml --out calm
    run 0 sobox-coordinator sweep.yaml --out run --stop-after 1
    sed -i 's/1650/1800/' sweep.yaml
    sed -i 's/0.25/0.30/' base.yaml
    run 2 sobox-coordinator sweep.yaml --resume run
    expect_said err '--resume continues a run as it was begun: it goes without a scenario'
    run 2 sobox-coordinator sweep.yaml --out run
    expect_said err 'run: the run folder is not empty'
    run 0 sobox-coordinator --resume run
    _expect_same_sweep calm run
}

sweep_options_want_a_sweep()
{
    local option
    for option in --only=x --shard=1/2 --stop-after=3 --keep-going --dry-run; do
        run 2 sobox-coordinator "$scenario" "$option"
        expect_said err "${option%=*} goes with a sweep"
    done
    _write_sweep 1
    for option in --shard=0/2 --shard=3/2 --shard=1 --shard=1/2x --stop-after=-1; do
        run 2 sobox-coordinator sweep.yaml "$option"
        expect_said err "${option%%=*}"
    done
    run 2 sobox-coordinator sweep.yaml --set vehicle.mass=3
    expect_said err 'vehicle\.mass is changed by the sweep'
    run 2 sobox-coordinator sweep.yaml --resume runs/masses
    expect_no runs
}

# What a colleague is sent: one HTML file, or Markdown with its pictures.
sweep_is_reported_with_tables_and_pictures()
{
    _write_sweep 2
    sed -i '/vehicle.mass/a\  - {path: response, values: [any, glancing_off]}' sweep.yaml
    run 0 sobox-coordinator sweep.yaml --out run
    expect_files run/summary.csv run/result.json run/history.csv
    expect_equal "$(wc -l <run/summary.csv)" 9 'lines of summary.csv'
    run 0 sobox-report run --html report.html --markdown report.md
    expect_files report.html report.md report-1.svg report-2.svg report-3.svg
    expect_equal "$(grep -c '<svg' report.html)" 3 'pictures of the report'
    expect_said report.md '^\| 1500 \| any \| 2 \| 2 \|'
    run 0 sobox-report run --against mass
    run 0 sobox-report run --against mass,response --out map.png
    run 0 sobox-report run --cases '*,seed=1' --out cases.pdf
    expect_files run/volume.svg run/volume.gp map.png cases.pdf
    run 2 sobox-report run --cases 'weight*'
    expect_said err "names like 'mass=1500,response=any,seed=1'"
    run 2 sobox-report run --against weight
    expect_said err 'vehicle.mass, response, search.seed'
    run 0 sobox-coordinator "$scenario" --out single
    run 2 sobox-report single --html no.html
    expect_said err 'not a sweep'
    expect_no no.html
}

_digests() # RUN
{
    journal "$1" 'SELECT hex(digest) FROM search ORDER BY number'
}

# The overlap of a crash is where the barrier's face ends. barrier.overlap is only a measure: under a
# response that does not use it, each of its values gives the same search, and that is said.
overlap_that_is_swept_changes_the_crash()
{
    cat >edges.yaml <<EOF
sweep: edges
base: $scenario
axes: [{path: barrier.edge_y, values: [-0.61, -0.455]}]
EOF
    run 0 sobox-coordinator edges.yaml --out edges
    ! grep -q 'barrier.overlap' err || fail 'barrier.overlap is noted'
    expect_equal "$(_digests edges | sort -u | wc -l)" 2 'digests of two edges'
    sed 's/edge_y/overlap/; s/-0.61, -0.455/0.3, 0.455/; s/edges/measures/' edges.yaml >measures.yaml
    run 0 sobox-coordinator measures.yaml --out measures
    expect_equal "$(_digests measures | sort -u | wc -l)" 1 'digests of two measures'
    expect_said err 'barrier.overlap changes nothing in 2 of 2 cases: .* barrier.edge_y moves'
    run 0 sobox-coordinator measures.yaml --set response=rotating --out rotating
    ! grep -q 'barrier.overlap' err || fail 'barrier.overlap is noted'
    expect_equal "$(_digests rotating | sort -u | wc -l)" 2 'digests of two measures of AbWP'
}

# The sweep that the manual shows is one, and what it calls an overlap changes the crash.
sweep_of_the_manual_is_valid()
{
    awk '/^[.]SH SWEEPS/ { on = 1 } on && /^[.]fi/ { exit } on && !/^[.]/' \
        "$here/../../deploy/man/sobox-coordinator.1" | sed 's/\\-/-/g' |
        sed "s|^base: .*|base: $scenario|" >sweep.yaml
    printf 'response\nany\nglancing_off\n' >cases.csv
    run 0 sobox-coordinator sweep.yaml --dry-run
    ! grep -q 'barrier.overlap' err || fail 'barrier.overlap is noted'
    expect_said out '^edge_y=-0.61,firewall_distance=0.2,samples=100,mass=1500,'
    run 0 sobox-coordinator sweep.yaml --out run --only \
        'edge_y=*,firewall_distance=0.2,samples=100,mass=1500,*,response=any,seed=1'
    expect_equal "$(_digests run | sort -u | wc -l)" 2 'digests of the two overlaps'
}
