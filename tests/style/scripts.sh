#!/bin/sh
# Every script of the tree passes shellcheck; one that is a program can be started.
set -eu
{
    grep -rlIE --exclude-dir='build*' --exclude-dir=.git --exclude-dir=runs '^#!/bin/(ba)?sh' .
    find tests -name '*.bash' -o -name '*_test.sh'
} | sort | {
    wrong=0
    while read -r script; do
        if head -n 1 "$script" | grep -q '^#!' && [ ! -x "$script" ]; then
            echo "$script: expected an executable file"
            wrong=1
        fi
        shellcheck --severity=warning --external-sources "$script" || wrong=1
    done
    exit $wrong
}
