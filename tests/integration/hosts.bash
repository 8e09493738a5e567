# Hosts for cases that need several machines: network namespaces, each with one cable to a bridge or
# to a switch of ours that makes bad weather. Sourced by the cases, after tools.bash.
#
# Nothing has a name outside: the case's own namespace holds the bridge, each host's belongs to a
# process of the case, and all of it goes when they do.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

readonly far='udpm://239.255.76.67:7667?ttl=1'

# make_hosts COUNT: hosts 1 to COUNT with the addresses 10.77.0.1 and on, each at the end of a cable
# whose other end, port-1 and on, is here. Nothing joins the ports yet.
make_hosts() {
    host_count=$1
    local number
    for number in $(seq "$host_count"); do
        start "host-$number" "${without_route[@]}" sh -c 'echo up; exec sleep infinity'
    done
    for number in $(seq "$host_count"); do
        wait_for_line "host-$number" up
        ip link add "port-$number" type veth peer name eth0 netns "${process[host-$number]}"
        ip link set "port-$number" up
        nsenter "--net=/proc/${process[host-$number]}/ns/net" sh -c "
            ip link set lo up && ip address add 10.77.0.$number/24 dev eth0 &&
            ip link set eth0 up && ip route add 239.0.0.0/8 dev eth0"
    done
}

# on NUMBER COMMAND...: becomes the command, on that host. For `start`, which gives it a process.
on() {
    exec nsenter "--net=/proc/${process[host-$1]}/ns/net" "${@:2}"
}

# Joins the ports by the kernel's bridge: fair weather.
join_by_bridge() {
    local number
    ip link add bridge type bridge mcast_snooping 0
    ip link set bridge up
    for number in $(seq "$host_count"); do
        ip link set "port-$number" master bridge
    done
}

# join_by_switch LOSS TWICE DELAY-MS JITTER-MS: joins them by a switch that loses and doubles so many
# percent of the frames to each port and delays them, so that they overtake each other.
join_by_switch() {
    local number ports=()
    for number in $(seq "$host_count"); do
        ports+=("port-$number")
    done
    start switch switch "$@" "${ports[@]}"
    wait_for_line switch 'seed'
}

# cut_off NUMBER / mend NUMBER: pulls the cable of a host, and plugs it in again.
cut_off() {
    ip link set "port-$1" down
}

mend() {
    ip link set "port-$1" up
}

# A worker with one thread on every host but the first, named worker-2 and on.
start_workers() {
    local number
    for number in $(seq 2 "$host_count"); do
        start "worker-$number" on "$number" sobox-worker --url "$far" --threads 1
    done
}
