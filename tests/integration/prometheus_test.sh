# The monitor's metrics, judged by Prometheus itself.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

_start_page() {
    start monitor sobox-monitor --url "$url" --http 127.0.0.1:0 --quiet
    wait_for_line monitor 'the page is at'
    page=$(sed -n 's/.*the page is at //p' monitor.err)
}

_metrics() {
    curl --silent --fail --max-time "$patience" --output metrics "${page}metrics"
}

_tells() {
    _metrics && grep -qE -e "$1" metrics
}

# Without a run, in its middle, and after it, when every kind of metric has had a value.
metrics_pass_the_check_of_promtool()
{
    _start_page
    _metrics
    run 0 promtool check metrics <metrics
    start worker sobox-worker --url "$url"
    start coordinator sobox-coordinator "$scenario" --out run --url "$url" "${steady[@]}"
    hold coordinator run 2
    # Without its worker the run goes on telling of its search until that is heard.
    signal STOP worker
    go_on coordinator
    wait_until 'the running search is told of' \
        _tells '^sobox_search_log_volume\{run="[0-9a-f]{16}",search="0"\} -'
    run 0 promtool check metrics <metrics
    signal CONT worker
    finish 0 coordinator
    wait_until 'the end of the run is told' \
        _tells '^sobox_run_state\{run="[0-9a-f]{16}",state="done"\} 1$'
    run 0 promtool check metrics <metrics
    expect_said metrics "^sobox_samples_total\{run=\"[0-9a-f]{16}\"\} $(json run/result.json '$.searches[0].evaluations')\$"
    expect_said metrics '^sobox_worker_busy_ratio\{id="[0-9a-f]{16}",worker=".*/[0-9]+"\} '
}

_scraped() {
    curl --silent --max-time 3 --output answer --data-urlencode "query=$1" \
        http://127.0.0.1:9090/api/v1/query &&
        [ -n "$(json answer '$.data.result[0].value[1]')" ]
}

prometheus_scrapes_a_run()
{
    _start_page
    cat >prometheus.yml <<EOC
global: {scrape_interval: 1s}
scrape_configs: [{job_name: sobox, static_configs: [{targets: ['${page:7:-1}']}]}]
EOC
    run 0 promtool check config prometheus.yml
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url"
    start prometheus prometheus --config.file=prometheus.yml --storage.tsdb.path=data \
        --web.listen-address=127.0.0.1:9090
    wait_until 'Prometheus has the samples' _scraped sobox_samples_total
    expect_equal "$(json answer '$.data.result[0].value[1]')" \
        "$(json run/result.json '$.searches[0].evaluations')" 'samples in Prometheus'
}

# Each metric that the dashboard asks for is one that the monitor tells.
dashboard_asks_for_metrics_that_are_there()
{
    _start_page
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out run --url "$url"
    _metrics
    local dashboard=$here/../../deploy/grafana/sobox.json metric
    expect_equal "$(sqlite3 :memory: "SELECT json_valid(readfile('$dashboard'))")" 1 'the dashboard is JSON'
    for metric in $(grep -oE 'sobox_[a-z_]+' "$dashboard" | sort -u); do
        expect_said metrics "^# TYPE $metric "
    done
}
