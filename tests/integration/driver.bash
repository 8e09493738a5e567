# A real browser for the cases of the page: Chromium without a window, driven through chromedriver
# by the W3C WebDriver protocol, which curl speaks. Sourced by page_test.sh.
# shellcheck shell=bash disable=SC2034,SC2154 # others give and use the variables

readonly driver=http://127.0.0.1:9515 # the case's own network has its own ports
session=

# Skips the case, visibly, unless a browser is asked for: it is heavy, and so are its packages.
need_browser() {
    [ -n "${SOBOX_BROWSER-}" ] || skip 'tests/run --browser carries it out'
    command -v chromium >/dev/null && command -v chromedriver >/dev/null ||
        fail 'chromium and chromium-driver are missing: deploy/install-packages browser'
}

# _ask METHOD PATH [JSON]: an answer of the driver is in the file answer.
_ask() {
    local data=()
    [ $# -lt 3 ] || data=(--header 'Content-Type: application/json' --data-binary "$3")
    curl --silent --max-time "$patience" --request "$1" "${data[@]}" --output answer "$driver$2" ||
        fail "the driver does not answer to $1 $2"
    [ -z "$(json answer '$.value.error')" ] ||
        fail "$1 $2: $(json answer '$.value.error'): $(json answer '$.value.message' | head -c 400)"
}

_quote() {
    printf '%s' "$1" >quoted
    sqlite3 :memory: "SELECT json_quote(CAST(readfile('quoted') AS TEXT))"
}

_driver_is_up() {
    curl --silent --max-time 3 --output answer "$driver/status" && [ "$(json answer '$.value.ready')" = 1 ]
}

# Starts the browser with a window of that size.
open_browser() { # [WIDTH HEIGHT]
    need_browser
    start driver chromedriver --port=9515
    wait_until 'the driver is up' _driver_is_up
    # What Chromium would ask its maker for at every start has no way out of here.
    _ask POST /session '{"capabilities": {"alwaysMatch": {"browserName": "chrome",
        "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        "goog:chromeOptions": {"binary": "'"$(command -v chromium)"'", "args": ["--headless",
            "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-quic",
            "--no-first-run", "--disable-background-networking", "--disable-component-update",
            "--disable-sync", "--hide-scrollbars", "--user-data-dir='"$folder"'/browser",
            "--window-size='"${1:-1280},${2:-900}"'", "about:blank"]}}}}'
    session=/session/$(json answer '$.value.sessionId')
}

close_browser() {
    _ask DELETE "$session"
    signal TERM driver
    wait_until 'the driver ends' _has_ended driver
}

# visit URL
visit() {
    _ask POST "$session/url" "{\"url\": $(_quote "$1")}"
}

# script TEXT: runs a script in the page; what it returns, numbers and texts, is printed.
script() {
    _ask POST "$session/execute/sync" "{\"script\": $(_quote "$1"), \"args\": []}"
    json answer '$.value'
}

_holds() {
    [ "$(script "return ($1) ? 1 : 0")" = 1 ]
}

# wait_for_page WHAT EXPRESSION: until it holds in the page.
wait_for_page() {
    wait_until "$1" _holds "$2"
}

# press CSS KEYS: types into an element. Special keys are those of WebDriver.
press() {
    _ask POST "$session/element" "{\"using\": \"css selector\", \"value\": $(_quote "$1")}"
    local element
    element=$(sqlite3 :memory: "SELECT value FROM json_each(readfile('answer'), '\$.value')")
    _ask POST "$session/element/$element/value" "{\"text\": \"$2\"}"
}
readonly key_right='\ue014' key_down='\ue015'

# click CSS
click() {
    script "const e = document.querySelector($(_quote "$1")); e.scrollIntoView({block: 'center'}); e.click(); return 1" >/dev/null
}

_command() { # NAME PARAMETERS of the browser's own protocol
    _ask POST "$session/goog/cdp/execute" "{\"cmd\": \"$1\", \"params\": $2}"
}

# resize WIDTH HEIGHT [DEVICE-PIXELS]
resize() {
    _command Emulation.setDeviceMetricsOverride \
        "{\"width\": $1, \"height\": $2, \"deviceScaleFactor\": ${3:-1}, \"mobile\": false}"
}

# prefer light|dark: what the system would say.
prefer() {
    _command Emulation.setEmulatedMedia \
        "{\"features\": [{\"name\": \"prefers-color-scheme\", \"value\": \"$1\"}]}"
}

# picture FILE.png WIDTH [DEVICE-PIXELS]: the whole page as it is now, in a window as high as it.
picture() {
    local height
    height=$(script 'return document.documentElement.scrollHeight')
    resize "$2" "$height" "${3:-1}"
    wait_for_page 'the window is as high as the page' "innerHeight === $height"
    # Charts are drawn anew in the next frames.
    script 'window.painted = 0; requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => { window.painted = 1; })))'
    wait_for_page 'it is painted' 'window.painted === 1'
    _command Page.captureScreenshot '{"format": "png"}'
    json answer '$.value.data' | base64 --decode >"$1"
}

# Everything that the page put on its console, one a line; nothing is expected.
expect_quiet_console() {
    _ask POST "$session/se/log" '{"type": "browser"}'
    sqlite3 :memory: "SELECT value ->> 'message' FROM json_each(readfile('answer'), '\$.value')" >console
    sed -i '/^chrome:/d' console # of the tab that the browser opens by itself
    [ ! -s console ] || fail "the page complains: $(head -n 5 console)"
}

# expect_no_other_host HOST:PORT: every request since the start went there.
expect_no_other_host() {
    _ask POST "$session/se/log" '{"type": "performance"}'
    sqlite3 :memory: "
        WITH message AS (SELECT (value ->> 'message') AS text
            FROM json_each(readfile('answer'), '\$.value'))
        SELECT text ->> '\$.message.params.request.url' FROM message
        WHERE text ->> '\$.message.method' = 'Network.requestWillBeSent'" >requests
    [ -s requests ] || fail 'no request is known of'
    ! grep -vE "^(data:|blob:|chrome:|http://$1/)" requests || fail 'the page asks another host'
}
