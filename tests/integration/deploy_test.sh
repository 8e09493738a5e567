# What installs the packages does so when it must, with the rights it needs, and says what it lacks.
# apt-get and its kin are stand-ins that tell how they were called.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

readonly installer=$here/../../deploy/install-packages

# _program NAME LINE: a program of this one line, on a PATH with nothing else but what scripts need.
_program()
{
    mkdir -p programs
    printf '#!/bin/bash\n%s\n' "$2" >"programs/$1"
    chmod +x "programs/$1"
}

_only_basic_programs()
{
    mkdir -p programs
    local tool
    for tool in awk bash cat dirname env mktemp rm; do
        ln -s "$(command -v "$tool")" programs/
    done
}

# A system on which all packages are installed but those named. (The stand-in is asked for one at a
# time, as the last argument.)
_debian_without() # PACKAGE...
{
    _only_basic_programs
    _program dpkg-query "case \" $* \" in *\" \${!#} \"*) exit 1 ;; esac; echo installed"
    _program apt-get "echo \"\$*\" >>$folder/asked"
    _program id 'echo 0'
}

nothing_is_asked_when_no_package_is_missing()
{
    _debian_without
    _program id 'echo 1000'
    run 0 env PATH="$folder/programs" "$installer" build test
    [ ! -s out ] || fail "said: $(cat out)"
    expect_no asked
}

only_missing_packages_are_installed()
{
    _debian_without cmake libcmocka-dev
    run 0 env PATH="$folder/programs" "$installer" build
    expect_said asked 'update'
    expect_said asked 'install .*--no-install-recommends cmake$'
    run 0 env PATH="$folder/programs" "$installer" build test
    expect_said asked 'install .*--no-install-recommends cmake libcmocka-dev$'
}

sudo_is_used_by_those_who_are_not_root()
{
    _debian_without cmake
    _program id 'echo 1000'
    _program sudo "echo sudo >>$folder/asked; \"\$@\""
    run 0 env PATH="$folder/programs" "$installer" build
    expect_equal "$(grep -c sudo asked)" 2 'calls of sudo'
}

missing_rights_are_told_with_the_packages()
{
    _debian_without cmake gnuplot-nox
    _program id 'echo 1000'
    run 1 env PATH="$folder/programs" "$installer" build
    expect_said err 'root or install sudo'
    expect_said err 'cmake gnuplot-nox'
    expect_no asked
}

other_systems_are_told_the_packages()
{
    _only_basic_programs
    run 1 env PATH="$folder/programs" "$installer" build
    expect_said err 'gcc libc6-dev cmake .*gnuplot-nox'
    expect_said err 'cmake --preset release'
}

output_of_a_failed_installation_is_shown()
{
    _debian_without cmake
    _program apt-get 'echo "E: no such mirror"; exit 100'
    run 1 env PATH="$folder/programs" "$installer" build
    expect_said err 'no such mirror'
    expect_said err 'installing the packages failed'
}

# ---- Installing the programs ----

# Anywhere, not only where it was configured for; each program has its manual page, and systemd finds
# nothing wrong with the units.
installation_is_complete_and_its_units_are_valid()
{
    local build program unit
    build=$(dirname "$(dirname "$(command -v sobox-worker)")")
    run 0 cmake --install "$build" --prefix "$folder/there"
    for program in coordinator worker hub monitor report simulate barrier-forces springs; do
        expect_files "there/bin/sobox-$program" "there/share/man/man1/sobox-$program.1"
    done
    expect_files there/share/sobox/scenarios/sedan-two-springs.yaml there/etc/default/sobox
    for unit in sobox-worker sobox-hub sobox-coordinator@; do
        expect_said "there/lib/systemd/system/$unit.service" "^ExecStart=$folder/there/libexec/sobox/"
    done
    run 0 env SYSTEMD_UNIT_PATH="$folder/there/lib/systemd/system:" systemd-analyze verify \
        --man=no there/lib/systemd/system/sobox-*.service
    [ ! -s err ] || fail "systemd-analyze said: $(cat err)"
    run 0 there/bin/sobox-coordinator "$scenario" --out run
}

# What a unit would start, with programs that tell how they were called.
_service() # STATUS ARGUMENT...
{
    mkdir -p there/bin there/etc/sobox state
    sed "s|@SOBOX_PREFIX@|$folder/there|; s|@SOBOX_ETC@|$folder/there/etc|" \
        "$here/../../deploy/systemd/service.in" >service
    chmod +x service
    local program
    for program in sobox-worker sobox-hub sobox-coordinator; do
        printf '#!/bin/sh\necho %s "$@"\n' "$program" >"there/bin/$program"
        chmod +x "there/bin/$program"
    done
    run "$1" env STATE_DIRECTORY="$folder/state" CREDENTIALS_DIRECTORY="$folder/credentials" \
        "${settings[@]}" ./service "${@:2}"
}

settings_of_services_become_options()
{
    local settings=()
    _service 0 worker
    expect_equal "$(cat out)" 'sobox-worker' 'the call'
    mkdir credentials
    echo none >credentials/key
    settings=(SOBOX_URL=tcpq://10.0.0.1:7700 SOBOX_THREADS=2 'SOBOX_WORKER_OPTIONS=--priority 0'
        SOBOX_LISTEN=0.0.0.0:7701)
    _service 0 worker
    expect_equal "$(cat out)" 'sobox-worker --url tcpq://10.0.0.1:7700 --threads 2 --priority 0' \
        'the call with settings'
    echo secret >credentials/key
    _service 0 hub
    expect_equal "$(cat out)" "sobox-hub --listen 0.0.0.0:7701 --key-file $folder/credentials/key" \
        'the call with a key'
}

# The first start begins a run, all others go on with it.
coordinator_service_resumes_what_it_began()
{
    local settings=()
    _service 0 coordinator study
    expect_equal "$(cat out)" \
        "sobox-coordinator $folder/there/etc/sobox/study.yaml --out $folder/state/study" 'the call'
    mkdir state/study
    touch state/study/run.db
    _service 0 coordinator study
    expect_equal "$(cat out)" "sobox-coordinator --resume $folder/state/study" 'the second call'
    local wrong
    for wrong in '' '../study' '.study' 'a/b'; do
        _service 2 coordinator "$wrong"
        expect_said err 'expected the name of a file'
    done
    _service 2 nobody
}
