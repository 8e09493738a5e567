#!/bin/sh
# prefixes.sh LIBRARY...: what a source file shows to others carries the file's name: box.c gives
# box_volume(), and everything else in it is static. The folder's name serves as well:
# wire/source.c may give wire_source_attach().
set -eu
for archive; do
    folder=$(basename "$archive" .a)
    nm --print-file-name --defined-only --extern-only "$archive" |
        awk -v folder="${folder#libsobox_}" '
            # LIBRARY:SOURCE.c.o:ADDRESS TYPE SYMBOL; names with two underscores or a dot are the compiler'"'"'s.
            {
                split($1, part, ":")
                file = part[2]
                sub("[.]c[.]o$", "", file)
            }
            $NF !~ /^(__|[.])/ && index($NF "_", file "_") != 1 &&
                index($NF "_", folder "_") != 1 {
                print folder "/" file ".c: " $NF ": expected a static function or a name that " \
                    "begins with " file "_ or " folder "_"
                wrong = 1
            }
            END { exit wrong }' || wrong=1
done
exit "${wrong-0}"
