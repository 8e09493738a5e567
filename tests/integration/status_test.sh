# Options, help and exit statuses that scripts rely on.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

scenario_without_a_good_design_ends_with_status_3()
{
    run 3 sobox-coordinator "$scenario" --out run --set firewall_distance=1.2
    expect_equal "$(json run/result.json '$.searches[0].status')" no_good_design status
    # What stands in the way most often.
    expect_said out 's_L'
}

every_program_tells_its_version()
{
    local program
    for program in sobox-coordinator sobox-worker sobox-simulate sobox-report sobox-monitor; do
        run 0 "$program" --version
        expect_said out "^$program [0-9]+[.][0-9]+[.][0-9]+$"
        [ ! -s err ] || fail "$program --version complains: $(cat err)"
    done
}

every_program_explains_itself()
{
    local program
    for program in sobox-coordinator sobox-worker sobox-simulate sobox-report sobox-monitor; do
        run 0 "$program" --help
        expect_said out 'Exit status'
        expect_said out '[-][-]version'
    done
}

wrong_usage_ends_with_status_2()
{
    local program
    for program in sobox-coordinator sobox-worker sobox-simulate sobox-report sobox-monitor; do
        run 2 "$program" --no-such-option
        expect_said err 'no-such-option'
    done
    run 2 sobox-coordinator
    run 2 sobox-simulate
    run 2 sobox-report
    run 2 sobox-coordinator "$scenario" "$scenario"
    run 2 sobox-coordinator "$scenario" --out run --workers -1
    run 2 sobox-coordinator "$scenario" --out run --threads -1
    run 2 sobox-coordinator "$scenario" --out run --mtu 60001
    run 2 sobox-coordinator "$scenario" --resume run
    run 2 sobox-worker --threads -1
    expect_no run
}

# Threads that spin while they wait starve each other wherever anything else runs (see
# common/base/wait_policy.h). The process number must stay: it is what signals are sent to.
threads_sleep_while_they_wait_unless_told_otherwise()
{
    local policy
    for policy in '' active; do
        start "worker-$policy" env -u OMP_WAIT_POLICY ${policy:+OMP_WAIT_POLICY=$policy} sobox-worker --url "$url"
        wait_for_line "worker-$policy" 'listening'
        expect_equal "$(tr '\0' '\n' <"/proc/${process[worker-$policy]}/environ" |
            sed -n 's/^OMP_WAIT_POLICY=//p')" "${policy:-passive}" 'how threads wait'
        signal TERM "worker-$policy"
        finish 0 "worker-$policy"
    done
}
