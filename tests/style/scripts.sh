#!/bin/sh
# Every script of the tree passes shellcheck, and can be started.
set -eu
wrong=0
for script in $(grep -rlIE --exclude-dir='build*' --exclude-dir=.git --exclude-dir=runs \
    '^#!/bin/(ba)?sh' . | sort); do
    head -n 1 "$script" | grep -q '^#!' || continue
    if [ ! -x "$script" ]; then
        echo "$script: expected an executable file"
        wrong=1
    fi
    shellcheck --severity=warning --external-sources "$script" || wrong=1
done
exit $wrong
