# Whatever is wrong with a scenario, the programs end with status 2 and one line that says where,
# what, and what would be right.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# _refused EDIT PATTERN: a scenario changed by this sed command is refused, with a line that names a
# place in the file and matches the pattern.
_refused()
{
    sed -E "$1" "$scenario" >edited.yaml
    ! cmp -s "$scenario" edited.yaml || fail "the edit '$1' changes nothing"
    local program
    for program in coordinator simulate; do
        if [ $program = coordinator ]; then
            run 2 sobox-coordinator edited.yaml --out run
        else
            run 2 sobox-simulate edited.yaml --design centre
        fi
        expect_one_line err
        expect_said err '^edited\.yaml:[0-9]+:[0-9]+: '
        expect_said err "$2"
        [ ! -s out ] || fail "printed besides: $(cat out)"
        expect_no run
    done
}

missing_file_is_named()
{
    run 2 sobox-coordinator nowhere.yaml --out run
    expect_one_line err
    expect_said err 'nowhere\.yaml.*[Nn]o such file'
    expect_no run
}

broken_yaml_is_refused()
{
    _refused 's/^vehicle:/vehicle: [/' '.'
}

unknown_key_is_refused()
{
    _refused 's/^  mass:/  weight: 3\n&/' '^edited.yaml:[0-9]+:3: vehicle.*weight'
}

missing_key_is_refused()
{
    _refused '/^  mass:/d' 'mass'
}

doubled_key_is_refused()
{
    _refused 's/^  mass:.*/&\n&/' 'mass'
}

wrong_type_is_refused()
{
    _refused 's/^  mass:.*/  mass: heavy/' '^edited.yaml:[0-9]+:9: vehicle.mass.*heavy'
    _refused 's/^  mass:.*/  mass: [1, 2]/' 'vehicle.mass'
    _refused 's/^vehicle:.*/vehicle: 3\nx:/' 'vehicle|x'
    _refused 's/deformation: .*/deformation: 3/' 'springs.*deformation'
}

number_that_is_none_is_refused()
{
    _refused 's/^  mass:.*/  mass: .nan/' 'vehicle.mass'
    _refused 's/^  mass:.*/  mass: .inf/' 'vehicle.mass'
    _refused 's/^  mass:.*/  mass: 1e999/' 'vehicle.mass'
}

negative_mass_is_refused()
{
    _refused 's/^  mass:.*/  mass: -3/' 'vehicle.mass.*-3'
}

unordered_deformation_points_are_refused()
{
    _refused 's/0\.30, 0\.60/0.60, 0.30/' 'deformation.*ascending|deformation.*above'
    _refused 's/0\.30, 0\.60/0.30, 0.30/' 'deformation'
}

too_few_deformation_points_are_refused()
{
    _refused 's/deformation: .*/deformation: [0.0]/' 'deformation'
    _refused 's/deformation: .*/deformation: []/' 'deformation'
}

forces_that_do_not_match_the_points_are_refused()
{
    _refused 's/upper: \[60e3, /upper: [/' 'force_x'
}

lower_above_upper_is_refused()
{
    _refused 's/lower: 0, upper: 250e3/lower: 300e3, upper: 250e3/' 'force_y.*lower'
}

design_space_without_a_free_variable_is_refused()
{
    _refused 's/lower: 0, upper: .*\}/lower: 5, upper: 5}/' 'every force is fixed'
}

overlap_of_zero_is_refused()
{
    _refused 's/overlap:.*/overlap: 0/' 'barrier.overlap'
}

time_step_that_fits_no_duration_is_refused()
{
    _refused 's/^search:/simulation: {time_step: 0}\n&/' 'time_step'
    _refused 's/^search:/simulation: {time_step: -1e-3}\n&/' 'time_step'
    _refused 's/^search:/simulation: {duration: 0.01, time_step: 0.02}\n&/' 'time_step'
}

spring_behind_the_barrier_is_refused()
{
    _refused 's/position: .*/position: [-2.5, -0.75]/' 'springs'
}

file_that_is_no_scenario_is_refused()
{
    : >empty.yaml
    run 2 sobox-coordinator empty.yaml --out run
    expect_said err '^empty\.yaml:1:1: '
    printf 'mass: \377\376\n' >bytes.yaml
    run 2 sobox-coordinator bytes.yaml --out run
    expect_said err '^bytes\.yaml:1:'
    run 2 sobox-coordinator . --out run
    expect_one_line err
    expect_no run
}

# An override is read like the file and its error names the option.
wrong_override_is_refused()
{
    local override
    for override in vehicle.mass=-3 vehicle.weight=3 response=sideways springs.7.name=x \
        vehicle.mass nothing=1 =3 search.seed=1.5; do
        run 2 sobox-coordinator "$scenario" --out run --set "$override"
        expect_one_line err
        expect_no run
    done
    run 2 sobox-coordinator "$scenario" --out run --seed many
    expect_one_line err
}

# Whatever the locale: in none of them does a name have to be plain ASCII.
override_may_be_written_in_any_alphabet()
{
    run 0 env LC_ALL=C sobox-coordinator "$scenario" --set 'name=Weißer Käfer' --out 'über alles'
    expect_equal "$(json 'über alles/result.json' '$.name')" 'Weißer Käfer' 'name'
    run 0 env LC_ALL=C sobox-simulate "$scenario" --set 'name=Weißer Käfer'
}

# Read twice, a pipe would be empty or never end.
scenario_in_a_pipe_is_refused()
{
    run 2 bash -c "cat '$scenario' | sobox-coordinator /dev/stdin --out run"
    expect_said err '/dev/stdin:1:1: expected a file, found a pipe'
    expect_no run
}

# What cannot be meant is refused with the likely slip.
implausible_scenario_is_refused()
{
    _refused 's/^  mass:.*/  mass: 1.65/' ':[0-9]+:9: vehicle.mass: .*likely slip: 1.65 t'
    _refused 's/^  face_x:.*/  face_x: -2080/' 'barrier.face_x: .*likely slip: -2080 mm'
    _refused 's/450e3/450/g; s/60e3/60/; s/upper: 250e3/upper: 250/' 'force_x.*likely slip: forces in kN'
}

# What is unlikely is said when a run begins and in all that comes of it; a design space of which
# all is good is told by the search.
unlikely_scenario_is_warned_of()
{
    printf 'front.force_x[0],front.force_x[1],front.force_x[2],front.force_x[3],front.force_x[4],%s\n%s\n' \
        'front.force_y[0],front.force_y[1],front.force_y[2],front.force_y[3],front.force_y[4]' \
        '1e3,2e3,3e3,4e3,5e3,1e3,1e3,1e3,1e3,1e3' >designs.csv
    local said='^--set vehicle.speed=64.4:1:1: warning: vehicle.speed: .*likely slip: 64.4 km/h'
    run 3 sobox-coordinator "$scenario" --set vehicle.speed=64.4 --out fast
    expect_said err "$said"
    expect_said out '^warning      vehicle.speed: '
    expect_said fast/result.json '"vehicle.speed: speed is 64.4 m/s'
    run 0 sobox-coordinator "$scenario" --set vehicle.speed=64.4 --out study --evaluate designs.csv
    expect_said err "$said"
    run 0 sobox-simulate "$scenario" --set vehicle.speed=64.4
    expect_said err "$said"
    expect_said out '"vehicle.speed: speed is 64.4 m/s'

    run 0 sobox-coordinator "$scenario" --set vehicle.speed=4 --set firewall_distance=0.01 --out slow
    expect_said out '^warning      design space: all of [0-9]+ designs of it are good'
    expect_said slow/result.json '"design space: all of'
    run 0 sobox-coordinator "$scenario" --out usual
    ! grep -q '^warning ' out || fail "warned of a usual car: $(cat out)"
}

# Text of any file, with an escape sequence in it, is shown without what a terminal would obey.
escape_sequences_never_reach_the_terminal()
{
    local owned=$'\e]0;owned\a' c1=$'\xc2\x9b31m'
    printf 'time_s,x_m\n%s,1\n' "$owned" >motion.csv
    printf 'spring,branch,deformation_m,force_x_N,force_y_N\n%s,load,0,1,1\n' "$owned$c1" >design.csv
    printf 'time_s,spring,x_N\n%s,1,2\n' "$owned" >forces.csv
    printf '%s\n1\n' "$owned" >designs.csv
    printf 'case,vehicle.mass\n%s,1500\n%s,1600\n' "$c1" plain >cases.csv
    printf 'sweep: cases\nbase: %s\naxes: [{csv: cases.csv}]\n' "$scenario" >sweep.yaml
    printf 'name: "\\e]0;owned\\a"\n' >named.yaml
    printf 'na%sme: 3\n' "$owned" >raw.yaml
    local -a commands=(
        "2 sobox-simulate $scenario --compare motion.csv"
        "2 sobox-simulate $scenario --design design.csv"
        "2 sobox-simulate named.yaml"
        "2 sobox-simulate raw.yaml"
        "2 sobox-simulate $owned.yaml"
        "2 sobox-simulate $scenario --set vehicle.mass=$owned"
        "2 sobox-barrier-forces $scenario --forces forces.csv --out out.csv"
        "2 sobox-coordinator $scenario --evaluate designs.csv --out study"
        "0 sobox-coordinator sweep.yaml --out run"
        "0 sobox-coordinator sweep.yaml --dry-run"
        "0 sobox-report run"
    )
    local command
    for command in "${commands[@]}"; do
        # shellcheck disable=SC2086 # the words of a command
        run $command
        if LC_ALL=C grep -qP '[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]' out err; then
            fail "a control character from $command: $(cat -v out err)"
        fi
    done
}
