# LCM's own lcm-spy with sobox's messages: the classes that deploy/lcm-spy makes for it.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

readonly spy=$here/../../deploy/lcm-spy

_need_java() {
    [ -n "${SOBOX_BROWSER-}" ] || skip 'tests/run --browser carries it out'
}

_has_grown() {
    [ -s "$1" ] && [ "$(wc -c <"$1")" -gt "$2" ]
}

# Every status message of a recorded run is decoded by the code of lcm-spy, with the right values.
recorded_messages_are_decoded()
{
    _need_java
    run 0 "$spy" --jar sobox.jar
    start logger lcm-logger --lcm-url='udpm://239.255.76.67:7669?ttl=0' --flush-interval=10 run.log
    start worker sobox-worker --url "$url"
    wait_until 'the logger hears the worker' _has_grown run.log 100
    run 0 sobox-coordinator "$scenario" --out run --url "$url" "${steady[@]}"
    signal TERM worker
    finish 0 worker
    signal INT logger
    wait_until 'the logger ends' _has_ended logger
    run 0 java -cp /usr/share/java/lcm.jar:/usr/share/java/jchart2d.jar:sobox.jar "$here/Decode.java" run.log
    ! grep -v ' sobox[.]' out | grep ^SOBOX || fail 'a message has no class'
    local type
    for type in run_status worker_status search_status step_status; do
        expect_said out "sobox[.]${type}_t"
    done
    # The last word of the search is its result.
    grep search_status_t out | tail -n 1 >last
    expect_said last "standing=2 .*evaluations=$(json run/result.json '$.searches[0].evaluations') "
}

wrong_use_is_told()
{
    run 2 "$spy" --port nowhere
    expect_said err 'expected batches, outcomes or status'
    run 2 "$spy" memq://
    expect_said err 'expected an URL like udpm://'
    run 0 "$spy" --help
    expect_said out 'cannot decode'
}
