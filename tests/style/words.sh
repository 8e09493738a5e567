#!/bin/sh
# Nothing unfinished is left in the tree, no line ends in blanks, and no C file has a tab. The inputs
# of the fuzz targets may be anything.
set -eu
files() {
    find . -path './.*' -prune -o -path './build*' -prune -o -path ./runs -prune -o \
        -path ./tests/data/fuzz -prune -o \
        -type f "$@" ! -path ./tests/style/words.sh -print
}
wrong=0
# grep succeeds when it finds something, which is the failure here.
! files | xargs grep -nHIwE 'TODO|FIXME|XXX|HACK|TBD' || wrong=1
! files ! -name '*.svg' | xargs grep -nHIE '[[:blank:]]+$' || wrong=1
! files -name '*.[ch]' | xargs grep -nHP '\t' || wrong=1
exit $wrong
