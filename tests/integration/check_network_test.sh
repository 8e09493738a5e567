# sobox-worker --check-network finds what is wrong with a network by itself and names the remedy.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables
# shellcheck source=tests/integration/hosts.bash
source "$here/hosts.bash"

_check() # STATUS [OPTION...]
{
    run "$1" sobox-worker --check-network "${@:2}"
}

_expect_wrong() # COUNT
{
    expect_equal "$(grep -c '^WRONG' out || true)" "$1" "things wrong in: $(cat out)"
}

_check_on() # NUMBER [OPTION...]
{
    nsenter "--net=/proc/${process[host-$1]}/ns/net" \
        sobox-worker --check-network --url "$far" "${@:2}" >"check-$1.out" 2>"check-$1.err"
}

# Whether a machine finds this, and ends with this status. A worker says each second that it is there,
# and on a busy machine later.
_finds() # STATUS NUMBER PATTERN [OPTION...]
{
    local status=0
    _check_on "$2" "${@:4}" || status=$?
    [ "$status" -eq "$1" ] && grep -qE "$3" "check-$2.out"
}

# Whether two machines that look at the same time find this. On a busy machine one may be done before
# the other begins.
_find() # STATUS-1 PATTERN-1 STATUS-2 PATTERN-2
{
    local status=0 both
    _finds "$1" 1 "$2" &
    both=$!
    _finds "$3" 2 "$4" || status=1
    wait $both || status=1
    return $status
}

_firewall() # NUMBER RULE...
{
    local host=$1
    shift
    nsenter "--net=/proc/${process[host-$host]}/ns/net" sh -c "
        nft add table ip wall && nft 'add chain ip wall in { type filter hook input priority 0; }' &&
        nft add rule ip wall in $*"
}

missing_route_is_found()
{
    ip route del 239.0.0.0/8 dev lo
    _check 1 --url "$far"
    expect_said out '^WRONG +no route for multicast.*ip route add'
    _expect_wrong 1
}

route_that_stays_on_the_machine_is_found()
{
    _check 1 --url "$far"
    expect_said out '^WRONG .*goes to lo and reaches no other machine.*ip route replace 239.0.0.0/8'
    _expect_wrong 1
    _check 0 --url "$url"
    expect_said out '^note +ttl=0: messages stay on this machine'
    expect_said out '^good .*come back to it on ports 7667 to 7669'
}

taken_ports_are_found()
{
    start holder occupy 7668
    wait_for_line holder occupied
    _check 1 --url "$url"
    expect_said out '^WRONG +port 7668 is in use'
    _expect_wrong 1
}

small_receive_buffer_is_told()
{
    _check 0 --url "$url&recv_buf_size=100000"
    expect_said out '^note +recv_buf_size=100000'
}

firewall_on_the_machine_itself_is_found()
{
    make_hosts 1
    _firewall 1 udp dport 7669 drop
    start check on 1 sobox-worker --check-network --url "$far"
    finish 1 check
    expect_said check.out '^WRONG .*port 7669 does not come back: a firewall'
}

machines_that_hear_each_other_say_so()
{
    make_hosts 2
    join_by_bridge
    wait_until 'both hear the other' _find \
        0 '^good +10.77.0.2 hears this machine, and is heard' \
        0 '^good +10.77.0.1 hears this machine, and is heard'
    expect_said check-1.out '^good +multicast to 239.255.76.67 leaves by eth0'
}

# Both sides know that something is wrong, each what it can see.
firewall_between_machines_is_found()
{
    make_hosts 2
    join_by_bridge
    _firewall 2 ip saddr 10.77.0.1 udp dport 7668 drop
    wait_until 'one port is missed' _find \
        0 '^good +10.77.0.2 hears this machine' \
        1 '^WRONG +10.77.0.1 is not heard on port 7668 \(outcomes\)'
    _firewall 2 ip saddr 10.77.0.1 drop
    wait_until 'one machine is deaf' _find \
        1 '^WRONG +10.77.0.2 is heard but does not hear this machine' \
        0 '^note +no other machine was heard'
}

workers_elsewhere_are_heard_and_their_keys_compared()
{
    make_hosts 2
    join_by_bridge
    run 0 sobox-coordinator --new-key key
    start worker on 2 sobox-worker --url "$far" --threads 1 --key-file key
    wait_for_line worker 'listening on'
    wait_until 'the worker is heard' _finds \
        1 1 '^WRONG +10.77.0.2 seals its messages with a key.*--key-file'
    expect_said check-1.out '^good +10.77.0.2 is heard: a worker'
    wait_until 'it is heard with the key' _finds \
        0 1 '^good +10.77.0.2 is heard: a worker' --key-file key
}

hub_that_is_not_there_is_found()
{
    _check 1 --url tcpq://127.0.0.1:7700
    expect_said out '^WRONG +no hub at 127.0.0.1:7700 \(connection refused\): start .sobox-hub'
    _check 1 --url tcpq://10.77.0.9:7700
    expect_said out '^WRONG +10.77.0.9:7700 cannot be reached'
    make_hosts 2
    join_by_bridge
    _firewall 2 tcp dport 7700 drop
    start check on 1 sobox-worker --check-network --url tcpq://10.77.0.2:7700
    finish 1 check
    expect_said check.out '^WRONG +10.77.0.2:7700 does not answer.*firewall'
}

_hub_has_worker()
{
    _check 0 --url tcpq://127.0.0.1:7700 --key-file key
    grep -qE '^good +1 worker is there' out
}

hub_is_tried_through_and_through()
{
    run 0 sobox-coordinator --new-key key
    start hub sobox-hub --listen 127.0.0.1:7700 --key-file key
    wait_for_line hub 'listening at'
    start worker sobox-worker --url tcpq://127.0.0.1:7700 --key-file key --threads 1
    wait_for_line worker 'listening on'
    _check 1 --url tcpq://127.0.0.1:7700
    expect_said out '^WRONG +the hub does not pass .*it has a key'
    wait_until 'the worker is heard' _hub_has_worker
    expect_said out '^good +messages come back through it'
    signal STOP hub
    _check 1 --url tcpq://127.0.0.1:7700 --key-file key
    expect_said out '^WRONG +what listens at 127.0.0.1:7700 does not say hello'
}

what_is_no_network_is_refused()
{
    _check 2 --url memq://
    expect_said err 'memq:// is no network'
    _check 2 --url nonsense
    _check 2 --url tcpq://localhost:7700
}
