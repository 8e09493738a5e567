# One scenario and one seed give one result, to the bit. Everything that differs between these runs
# changes the order in which outcomes arrive, and must not show.
# shellcheck shell=bash disable=SC2154 # tools.bash gives the variables

same_digest_in_two_runs()
{
    run 0 sobox-coordinator "$scenario" --out once
    run 0 sobox-coordinator "$scenario" --out twice
    expect_same_run once twice
}

# Otherwise the cases here could pass with a digest of nothing.
another_seed_gives_another_digest()
{
    run 0 sobox-coordinator "$scenario" --out one --seed 1
    run 0 sobox-coordinator "$scenario" --out two --seed 2
    [ "$(digest one)" != "$(digest two)" ] || fail 'seeds 1 and 2 give one digest'
}

same_digest_for_one_and_two_threads()
{
    run 0 sobox-coordinator "$scenario" --out one --threads 1
    run 0 sobox-coordinator "$scenario" --out two --threads 2
    expect_same_run one two
}

# Batches are cut by the workers' speed, so other workers mean other batches.
same_digest_for_1_2_and_5_worker_processes()
{
    run 0 sobox-coordinator "$scenario" --out inside
    local workers
    for workers in 1 2 5; do
        run 0 sobox-coordinator "$scenario" --out "$workers" --workers "$workers"
        expect_same_run inside "$workers"
    done
}

same_digest_for_worker_processes_with_one_and_two_threads()
{
    run 0 sobox-coordinator "$scenario" --out one --workers 2 --threads 1
    run 0 sobox-coordinator "$scenario" --out two --workers 2 --threads 2
    expect_same_run one two
}

same_digest_for_larger_messages()
{
    run 0 sobox-coordinator "$scenario" --out small --workers 2
    run 0 sobox-coordinator "$scenario" --out large --workers 2 --mtu 60000
    expect_same_run small large
}

same_digest_with_running_and_local_workers_together()
{
    run 0 sobox-coordinator "$scenario" --out inside
    start worker sobox-worker --url "$url"
    run 0 sobox-coordinator "$scenario" --out together --url "$url" --workers 1
    expect_same_run inside together
}
