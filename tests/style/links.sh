#!/bin/sh
# A folder includes headers only of folders that its link line reaches, and of libraries that a
# link line on the way names: what a folder may know stands in its CMakeLists.txt. (The linker
# alone would not notice: a header of plain data needs nothing to link.)
# Folders that compute and decide include nothing that reaches clock, files, processes or network.
set -eu
{
    find common worker coordinator monitor hub -name CMakeLists.txt
    find common worker coordinator monitor hub -name '*.[ch]' | sort
} | xargs awk '
    function folder_of(path) {
        return match(path, "/[^/]*$") ? substr(path, 1, RSTART - 1) : "."
    }
    # The link line of a library or a program: LINKS and everything after it up to the bracket.
    function links_of(line) {
        sub(".*LINKS *", "", line)
        sub("[)].*", "", line)
        return line
    }
    # Everything that can be reached from these links, as "|a|b|".
    function reach(links, seen,    names, count, i) {
        count = split(links, names, " ")
        for (i = 1; i <= count; i++)
            if (!index(seen, "|" names[i] "|"))
                seen = reach(needs[names[i]], seen names[i] "|")
        return seen
    }
    function complain(what) {
        print FILENAME ":" FNR ": " what
        wrong = 1
    }
    BEGIN {
        library["glib.h"] = library["glib-unix.h"] = library["gio/gio.h"] = "PkgConfig::GLIB"
        library["glib/gstdio.h"] = "PkgConfig::GLIB"
        library["lcm/lcm.h"] = "PkgConfig::LCM"
        library["yaml.h"] = "PkgConfig::YAML"
        library["sqlite3.h"] = "PkgConfig::SQLITE"
        library["sodium.h"] = "PkgConfig::SODIUM"
        library["jansson.h"] = "PkgConfig::JANSSON"
        library["microhttpd.h"] = "PkgConfig::MICROHTTPD"
        library["curses.h"] = library["term.h"] = "PkgConfig::NCURSES"
        library["omp.h"] = "OpenMP::OpenMP_C"
        needs["sobox_lcmtypes"] = "PkgConfig::LCM"
        needs["PkgConfig::LCM"] = "PkgConfig::GLIB"
        # A scenario in memory is plain data that those who compute may know; reading one is not.
        plain["common/scenario/scenario.h"] = plain["common/scenario/outcome.h"] = 1
        plain["common/scenario/formula.h"] = 1
        pure["coordinator/search"] = pure["coordinator/schedule"] = 1
        pure["coordinator/dispatch"] = 1
        pure["common/sampling"] = pure["worker/kinematics"] = pure["worker/models"] = 1
        pure["worker/reduction"] = pure["worker/components"] = 1
    }
    /^sobox_library[(]/ {
        split($0, word, "[( )]")
        home["sobox_" word[2]] = folder_of(FILENAME)
        own[folder_of(FILENAME)] = "sobox_" word[2]
        needs["sobox_" word[2]] = links_of($0)
    }
    /^sobox_program[(]/ {
        split($0, word, "[( )]")
        program[folder_of(FILENAME) "/" word[3]] = links_of($0)
    }
    /^#include/ && FILENAME ~ /[.][ch]$/ {
        folder = folder_of(FILENAME)
        header = $2
        gsub("[<>\"]", "", header)
        if (FILENAME in program)
            known = reach(program[FILENAME], "|")
        else if (folder in own)
            known = reach(own[folder], "|")
        else {
            complain("no CMakeLists.txt says what this file may know")
            next
        }
        if (header in library && !index(known, "|" library[header] "|"))
            complain(header ": the link line does not reach " library[header])
        if (header ~ /^(common|worker|coordinator|monitor|hub)\// && !(header in plain)) {
            target = folder_of(header)
            if (!index(known, "|" own[target] "|"))
                complain(header ": the link line does not reach " target)
        }
        if (header ~ /^sobox_/ && !index(known, "|sobox_lcmtypes|"))
            complain(header ": the link line does not reach lcmtypes")
        if (folder in pure &&
            header ~ /^(time|unistd|fcntl|poll|signal)[.]h$|^sys\/|base\/(clock|log)[.]h$/)
            complain(header ": " folder " knows no clock, file, process or network")
    }
    # The monitor observes: it decides nothing, computes nothing, and works on a machine that has no
    # part in the run. Of the coordinator it knows the journal alone.
    END {
        for (path in program) {
            if (path !~ /^monitor[/]/)
                continue
            watches = 1
            known = reach(program[path], "|")
            for (name in home)
                if (home[name] ~ /^(worker|coordinator|hub)[/]/ && name != "sobox_journal" &&
                    index(known, "|" name "|")) {
                    print path ": its link line reaches " home[name]
                    wrong = 1
                }
            if (index(known, "|OpenMP::OpenMP_C|")) {
                print path ": its link line reaches OpenMP"
                wrong = 1
            }
        }
        if (!watches) {
            print "no program of the monitor was found"
            wrong = 1
        }
        exit wrong
    }'
