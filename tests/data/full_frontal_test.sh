#!/bin/bash
# full_frontal.py on a folder whose results are known by hand, with the traps of the real one: a moment
# labelled as a force, a failed cell, an engine's channel that ends early, offsets, negative forces, CRLF.
set -euo pipefail

script=$(readlink -f "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# NUMBER LAST EXPRESSION: a channel at 10 kHz from -50 ms, of the time t [s].
channel()
{
    awk -v last="$2" "BEGIN { for (i = -500; i <= last; i++) { t = i * 1e-4; after = t < 0 ? 0 : t
        printf \"%.6f\t%.6f\r\n\", t, $3 } }" >"test.$1"
}

channel 001 2999 '0.5 - (t < 0 ? 0 : 10)'     # left seat: 10 g
channel 002 2999 '-0.25 - (t < 0 ? 0 : 10)'   # right seat
channel 003 669 '0'                           # engine, failed
channel 004 2999 '(t < 0 ? 0 : -20)'          # engine: 20 g
channel 101 2999 '30 - 1e6 * after'           # cell of row 1, column 1
channel 102 2999 '5e5 * after'                # the same cell's moment
channel 103 2999 '-2e6 * after'               # row 1, column 2
channel 104 2999 '77777'                      # row 2, column 1, failed
channel 105 2999 '-12.5'                      # row 2, column 2: offset alone

record() # VEHICLE NUMBER SENSOR ATTACHMENT UNIT LAST STATUS
{
    printf '%s|%s|%s|NA|%s|XG|SEC|%s|2800|MAKER|01/JAN/2017|800|1|36.0|-500|%s|100|%s|P|TEXT\r\n' "$@"
}
{
    printf '# a comment\r\n----- EV5 -----\r\n----- VEHICLE -----\r\n1|16|03\r\n'
    printf -- '----- INSTRUMENTATION -----\r\n'
    record 1 1 AC FLLR "G'S" 2999 AM
    record 1 2 AC FLRR "G'S" 2999 AM
    record 1 3 AC ENGN "G'S" 669 CF
    record 1 4 AC ENGN "G'S" 2999 AM
    record 0 101 LC LC0101 NWT 2999 AM
    record 0 102 LC LC0101 NWM 2999 AM
    record 0 103 LC LC0102 NWT 2999 AM
    record 0 104 LC LC0201 NWT 2999 CF
    record 0 105 LC LC0202 NWT 2999 AM
    printf -- '----- END -----\r\n'
} >test.EV5

mkdir out
"$script" . out 2>said
grep -q 'LC0201 failed' said

expect() # FILE LINE WHAT
{
    local found
    found=$(sed -n "$2p" "out/$1")
    [ "$found" = "$3" ] || { echo "$1:$2: found '$found', expected '$3'"; exit 1; }
}
expect full_frontal_forces.csv 1 time_s,row1col1,row1col2,row2col1,row2col2
# At 50 ms 1e6 N/s have become 50 kN; at 0 the mean over the millisecond around it is 125 N, of which
# the table keeps tens.
expect full_frontal_forces.csv 52 0.050,50000,100000,0,0
expect full_frontal_forces.csv 2 0.000,120,250,0,0
expect full_frontal_forces.csv 152 0.150,150000,300000,0,0
# From 10 m/s at 10 g for 100 ms: v = 10 - 9.80665 = 0.1933, x = 1 - 0.4903 = 0.5097, and the engine
# at 20 g: v = -9.6133. The first sample before contact halves the first step's force: 0.5 mm/s less.
tail -n +102 out/full_frontal_motion.csv | head -n 1 | awk -F, '
    function near(value, expected) { return (value - expected) ^ 2 < 0.01 ^ 2 }
    !(near($1, 0.1) && near($2, -0.5097) && $3 == 0 && $4 == 0 && near($5, -0.5097) &&
      near($6, -0.5097) && near($7, -0.1933) && near($8, -0.1933) && near($9, 9.6133) && NF == 9) {
        print "motion: " $0
        exit 1
    }'

# A cell that ends too early is named.
head -n 1000 test.105 >short
mv short test.105
! "$script" . out 2>said
grep -q 'test.105: expected 3500 samples, found 1000' said
