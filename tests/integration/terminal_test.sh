# The monitor on a terminal: tmux is the terminal, its keyboard and the eye.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_tmux() {
    tmux -S "$folder/terminal" -f /dev/null "$@"
}

# _open COLUMNS LINES [ENVIRONMENT...]: a terminal of that size with a monitor in it.
_open() {
    local columns=$1 lines=$2
    shift 2
    _tmux new-session -d -x "$columns" -y "$lines" \
        env LC_ALL=C.UTF-8 "$@" sh -c "sobox-monitor --url '$url'; echo 'ended with' \$?; exec cat"
}

_shows() {
    _tmux capture-pane -p >screen && grep -qE -e "$1" screen
}

_wait_for() {
    wait_until "the screen shows '$1'" _shows "$1"
}

_close() {
    _tmux kill-server 2>/dev/null || true # Ctrl-C ends the terminal with all in it
}

run_is_shown_on_the_full_screen_and_q_quits()
{
    _open 100 30
    _wait_for 'no run is heard yet'
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url"
    _wait_for '> short +done'
    _wait_for 'search 0: done'
    _wait_for 'ln\(volume\) +-[0-9.]+ '
    _wait_for '/[0-9]+ +[0-9]+ % '
    _tmux send-keys s
    _wait_for 'sort: busy'
    _tmux send-keys q
    _wait_for 'ended with 0'
    _close
}

resized_screen_is_drawn_anew()
{
    _open 100 30
    _wait_for 'WORKER +BUSY.*HEARD'
    _tmux resize-window -x 40 -y 10
    _wait_for 'sort: na?m?e?$|left/right'
    _shows 'HEARD' && fail 'the last column does not fit forty columns'
    _tmux resize-window -x 100 -y 30
    _wait_for 'WORKER +BUSY.*HEARD'
    _close
}

# Ctrl-C, and the signal that asks a program to end, leave the terminal as it was.
interrupted_screen_gives_the_terminal_back()
{
    _open 80 24
    _wait_for 'q quit'
    _tmux send-keys C-c
    wait_until 'the screen is gone' _is_gone
    _close
}

_is_gone() {
    ! _tmux has-session 2>/dev/null || ! _shows 'q quit'
}

terminal_that_cannot_be_painted_on_gets_lines()
{
    _open 80 24 TERM=dumb
    _wait_for 'no run is heard on'
    _close
}
