# A network that does not work is said to be so at once, with the remedy.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_expect_remedy()
{
    expect_said err 'no route for multicast.*ip route add'
}

coordinator_without_a_multicast_route_names_the_remedy()
{
    run 1 "${without_route[@]}" sobox-coordinator "$scenario" --out run --url "$url"
    _expect_remedy
    expect_no run
}

local_workers_without_a_multicast_route_name_the_remedy()
{
    run 1 "${without_route[@]}" sobox-coordinator "$scenario" --out run --workers 2
    _expect_remedy
    expect_no run
    wait_until 'the local workers are gone' no_process_left
}

worker_without_a_multicast_route_names_the_remedy()
{
    run 1 "${without_route[@]}" sobox-worker --url "$url"
    _expect_remedy
}

# The default uses no network at all.
worker_inside_needs_no_network()
{
    run 0 "${without_route[@]}" sobox-coordinator "$scenario" --out run
    expect_files run/result.json
}

# Each program listens on the ports of what it wants to hear; only those must be free to share.
port_held_by_another_program_is_named()
{
    local port
    for port in 7667 7668 7669; do
        start "holder-$port" occupy "$port"
        wait_for_line "holder-$port" occupied
        if [ "$port" = 7667 ]; then
            run 1 sobox-worker --url "$url"
        else
            run 1 sobox-coordinator "$scenario" --out run --url "$url"
            expect_no run
        fi
        expect_said err "port $port is in use"
        signal TERM "holder-$port"
        finish 143 "holder-$port"
    done
}

url_that_cannot_be_opened_is_refused()
{
    local wrong
    for wrong in 'http://example.org' 'udpm://127.0.0.1:7667' 'udpm://:7667' 'udpm://239.255.76.67' \
        'udpm://239.255.76.67:65534' 'udpm://239.255.76.67:7667?ttl=many' 'nonsense' ''; do
        run 2 sobox-coordinator "$scenario" --out run --url "$wrong"
        expect_said err 'udpm://'
        expect_no run
        run 2 sobox-worker --url "$wrong"
        expect_said err 'udpm://'
    done
}
