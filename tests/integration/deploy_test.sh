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
