# The page of the monitor in a real browser: what a reader sees and does.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

# shellcheck source=tests/integration/driver.bash
source "$here/driver.bash"

# Starts a monitor with a page at a port that stays the same.
_start_page() {
    start "$1" sobox-monitor --http 127.0.0.1:8765 --quiet "${@:2}"
    wait_for_line "$1" 'the page is at'
}
readonly site=127.0.0.1:8765

_text() {
    script "return document.querySelector('$1').textContent"
}

_expect_text() { # CSS PATTERN
    _text "$1" >text
    grep -qE -e "$2" text || fail "$1: found '$(cat text)', expected '$2'"
}

page_follows_a_run_to_its_end()
{
    open_browser
    _start_page monitor --url "$url"
    visit "http://$site/"
    wait_for_page 'the page is live' 'document.querySelector("#link").dataset.state === "live"'
    _expect_text '#runs-empty' 'No run is heard yet'
    start worker sobox-worker --url "$url"
    start coordinator sobox-coordinator "$scenario" --out run --url "$url" "${steady[@]}" \
        --set search.samples=20000
    # In its middle: corridors are drawn, and move.
    wait_for_page 'corridors are drawn' 'document.querySelectorAll("#corridors canvas").length === 2'
    local before
    before=$(script 'return document.querySelector("#corridors canvas").getAttribute("aria-label")')
    wait_for_page 'corridors move' "document.querySelector('#corridors canvas').getAttribute('aria-label') !== $(_quote "$before")"
    wait_for_page 'samples are drawn' '/ (good|bad)|s_L_min/.test(document.querySelector("#xray canvas")?.getAttribute("aria-label"))'
    finish 0 coordinator
    wait_for_page 'the end is shown' 'document.querySelector("#run-state").textContent === "done"'
    # The corridor at the end is that of the run folder.
    wait_for_page 'the table of a chart opens' \
        '(() => { const b = document.querySelector("#corridors figure button"); if (b.getAttribute("aria-pressed") === "false") b.click(); return document.querySelector("#corridors td"); })()'
    expect_equal "$(printf '%.4g' "$(script 'return +document.querySelectorAll("#corridors tbody tr")[1].cells[2].textContent')")" \
        "$(printf '%.4g' "$(json run/result.json '$.searches[0].variables[1].corridor[1]')")" \
        'upper bound of the second variable'
    expect_quiet_console
    expect_no_other_host "$site"
    close_browser
}

# A pair is chosen by its names, and paged through with the keyboard; the step too.
pairs_of_variables_are_chosen_and_paged_through()
{
    open_browser
    run 0 sobox-coordinator "$scenario" --out run
    _start_page monitor --from run
    visit "http://$site/"
    wait_for_page 'samples are drawn' 'document.querySelector("#xray canvas")'
    script 'const x = document.querySelector("#xray-x"); x.selectedIndex = 0; x.dispatchEvent(new Event("change"));
        const y = document.querySelector("#xray-y"); y.selectedIndex = 1; y.dispatchEvent(new Event("change"))'
    expect_equal "$(_text '#xray-place')" 'pair 1 of 45' 'place of the pair'
    wait_for_page 'its points are drawn' '/The box: front Fx at 0 m .* front Fx at 0.3 m/.test(document.querySelector("#xray canvas").getAttribute("aria-label"))'
    press '#xray canvas' "$key_right"
    expect_equal "$(_text '#xray-place')" 'pair 2 of 45' 'place of the pair after it'
    wait_for_page 'the next pair is drawn' '/front Fx at 0 m .* front Fx at 0.6 m/.test(document.querySelector("#xray canvas").getAttribute("aria-label"))'
    click '#xray-before'
    click '#xray-before'
    expect_equal "$(_text '#xray-place')" 'pair 45 of 45' 'the pair before the first'
    _expect_text '#xray-step-text' '[(]latest[)]'
    press '#xray canvas' "$key_down"
    _expect_text '#xray-step-text' '^step [0-9]+, [a-z]+$'
    # Bad samples of that step have a reason, which has its line in the legend.
    script 'const s = document.querySelector("#xray-step"); s.value = 0; s.dispatchEvent(new Event("input"))'
    wait_for_page 'the reason is in the legend' '/s_L_min .*< 0.25 m/.test(document.querySelector("#xray .legend").textContent)'
    # What the chart offers to keep is a picture and a table.
    script 'const make = URL.createObjectURL; URL.createObjectURL = (blob) => { window.kept = blob; return make.call(URL, blob); };
        for (const b of document.querySelectorAll("#xray figcaption button")) { if (b.textContent === "SVG") b.click(); }
        window.kept.text().then((text) => { window.svg = text; })'
    wait_for_page 'the picture is made' 'window.svg'
    expect_equal "$(script 'const d = new DOMParser().parseFromString(window.svg, "image/svg+xml");
        return d.querySelector("parsererror") ? "broken" : d.documentElement.nodeName')" svg 'the picture'
    expect_equal "$(script 'return (window.svg.match(/<(circle|path transform)/g) || []).length')" 200 'samples in the picture'
    script 'for (const b of document.querySelectorAll("#xray figcaption button")) { if (b.textContent === "CSV") b.click(); }
        window.kept.text().then((text) => { window.csv = text; })'
    wait_for_page 'the table is made' 'window.csv?.split("\n").length === 202'
    expect_quiet_console
    close_browser
}

cases_of_a_sweep_are_sorted_filtered_and_chosen()
{
    open_browser
    cat >sweep.yaml <<EOF
sweep: masses
base: $scenario
axes:
  - {path: vehicle.mass, values: [1500, 1650, 1800]}
  - {path: response, values: [any, rotating]}
EOF
    run 0 sobox-coordinator sweep.yaml --out run
    _start_page monitor --from run
    visit "http://$site/"
    wait_for_page 'six cases are listed' 'document.querySelectorAll("#searches tbody tr").length === 6'
    _expect_text '#searches thead' 'Status.*vehicle.mass.*response'
    script 'const f = document.querySelector("#search-filter"); f.value = "rotating 1800"; f.dispatchEvent(new Event("input"))'
    wait_for_page 'one case is left' 'document.querySelectorAll("#searches tbody tr").length === 1'
    click '#searches .pick'
    wait_for_page 'it is shown' '/mass=1800,response=rotating/.test(document.querySelector("#run-title").textContent)'
    script 'const f = document.querySelector("#search-filter"); f.value = ""; f.dispatchEvent(new Event("input"))'
    wait_for_page 'all are back' 'document.querySelectorAll("#searches tbody tr").length === 6'
    script 'const h = document.querySelectorAll("#searches thead button")[3]; h.click(); h.click(); return 1' >/dev/null
    wait_for_page 'the heaviest comes first' 'document.querySelector("#searches tbody tr").cells[3].textContent === "1800"'
    script 'const a = document.querySelector("#sweep-axis"); a.selectedIndex = 2; a.dispatchEvent(new Event("change"))'
    wait_for_page 'the volume stands over the response' 'document.querySelector("#searches-chart canvas")'
    expect_quiet_console
    close_browser
}

# A monitor that ends leaves a picture that says it is old; one that takes its place is found again.
page_says_that_it_is_old_and_comes_back()
{
    open_browser
    run 0 sobox-coordinator "$scenario" --out run
    _start_page monitor --from run
    visit "http://$site/"
    wait_for_page 'the run is shown' 'document.querySelector("#run-state").textContent === "done"'
    signal TERM monitor
    finish 0 monitor
    wait_for_page 'the picture is marked as old' '!document.querySelector("#stale").hidden && document.body.classList.contains("is-stale")'
    _expect_text '#stale' 'This picture is old'
    # What the browser says of the refused connection is no complaint of the page.
    _ask POST "$session/se/log" '{"type": "browser"}'
    _start_page again --from run
    wait_for_page 'it is live again' 'document.querySelector("#link").dataset.state === "live" && document.querySelector("#stale").hidden'
    expect_equal "$(script 'return document.querySelectorAll("#runs tbody tr").length')" 1 'runs shown'
    close_browser
}

# Two runs at once: what is drawn belongs to the chosen one, also right after another choice.
two_runs_are_never_mixed()
{
    open_browser
    _start_page monitor --url "$url"
    start worker sobox-worker --url "$url"
    start first sobox-coordinator "$scenario" --out first --url "$url" "${steady[@]}" --set name=first --set search.samples=100000
    start second sobox-coordinator "$scenario" --out second --url "$url" "${steady[@]}" --set name=second --set search.samples=100000 \
        --set springs.0.name=rear
    visit "http://$site/"
    wait_for_page 'both runs are listed' 'document.querySelectorAll("#runs tbody tr").length === 2'
    local round name
    for round in 1 2 3; do
        for name in first second; do
            script "[...document.querySelectorAll('#runs .pick')].find((b) => b.textContent === '$name').click()"
            expect_equal "$(script "
                const spring = '$name' === 'first' ? 'front' : 'rear';
                return [...document.querySelectorAll('#corridors h3')].every((h) => h.textContent.startsWith(spring)) ? 1 : 0")" 1 "charts of $name alone, round $round"
            wait_for_page "$name is shown" "document.querySelector('#run-title').textContent === '$name'"
        done
    done
    press_ctrl_c first 2>/dev/null || true # over by now, perhaps
    press_ctrl_c second 2>/dev/null || true
    close_browser
}

# Three sizes, light and dark: nothing sticks out sideways, and every control has a name. With
# PICTURES=FOLDER in the environment the pictures are kept there.
page_fits_phone_desk_and_projector()
{
    open_browser
    run 0 sobox-coordinator "$scenario" --out run
    _start_page monitor --from run
    visit "http://$site/"
    wait_for_page 'samples are drawn' 'document.querySelector("#xray canvas")'
    local size scheme width height density
    for size in '390 844 2' '1280 900 1' '1920 1080 1'; do
        for scheme in light dark; do
            prefer $scheme
            read -r width height density <<<"$size"
            resize "$width" "$height" "$density"
            wait_for_page "the page is $scheme" "document.documentElement.dataset.theme === '$scheme'"
            wait_for_page "nothing sticks out at $size" 'document.documentElement.scrollWidth <= innerWidth'
            picture "page-$width-$scheme.png" "$width" "$density"
        done
    done
    expect_equal "$(script 'return [...document.querySelectorAll("button, select, input, canvas, a")].filter((e) =>
        !(e.textContent.trim() || e.getAttribute("aria-label") || e.closest("label") || e.labels?.length)).length')" 0 'controls without a name'
    [ -z "${PICTURES-}" ] || cp page-*.png "$PICTURES"
    expect_quiet_console
    close_browser
}
