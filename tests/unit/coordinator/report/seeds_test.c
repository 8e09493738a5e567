// A run over seeds: its best box, and what its bounds are worth.
#include "coordinator/report/report.h"
#include "coordinator/report/seeds.h"

#include "sample_run.h"

#include <math.h>

enum { SEEDS = 4 }; // of which the last waits

static enum status next_seed(void *user, struct journal_search *search, bool *more,
                             struct error *error)
{
    (void)error;
    static const char *values[SEEDS][1] = {{"1"}, {"2"}, {"3"}, {"4"}};
    struct sample_cases *cases = user;
    const uint32_t index = cases->next;
    *more = index < SEEDS;
    if (!*more)
        return STATUS_OK;
    *search = (struct journal_search){.index = cases->next++,
                                      .values = values[index],
                                      .text = cases->scenario->text,
                                      .text_size = cases->scenario->text_size,
                                      .scenario = cases->scenario->digest,
                                      .seed = index + 1};
    g_snprintf(search->name, sizeof search->name, "seed=%u", index + 1);
    return STATUS_OK;
}

// Lower bounds are at 1, 2 and 3 N, upper ones at 5, 5 and 8 N. The largest box is not certified.
static void fill(struct journal *journal, uint32_t index, const struct box *space)
{
    static const double lower[] = {1, 2, 3}, upper[] = {5, 5, 8}, log_volume[] = {-4, -3, -1};
    struct box box;
    box_init(&box, space->count);
    for (uint32_t v = 0; v < box.count; v++) {
        box.lower[v] = space->lower[v] + lower[index];
        box.upper[v] = space->lower[v] + upper[index];
    }
    sample_steps(journal, index, space, &box, true);
    struct journal_search result = {.index = index,
                                    .box = box,
                                    .log_volume = log_volume[index],
                                    .purity_samples = 1000,
                                    .purity_estimate = 1,
                                    .purity_lower95 = 0.997,
                                    .evaluations = 1016,
                                    .steps = 2};
    g_strlcpy(result.status, index == 2 ? "purity_missed" : "done", sizeof result.status);
    assert_int_equal(journal_finish_search(journal, &result, NULL), STATUS_OK);
    box_fini(&box);
}

static void make_run(const char *folder, const char *axis, uint32_t finished)
{
    struct scenario scenario;
    assert_int_equal(scenario_read_text(&scenario, "sample", SAMPLE_SCENARIO,
                                        strlen(SAMPLE_SCENARIO), NULL, 0, NULL),
                     STATUS_OK);
    const char *axes[] = {axis};
    struct sample_cases cases = {.scenario = &scenario};
    struct journal_run run = {.name = "sample", .version = "1.2.3"};
    struct journal *journal;
    assert_int_equal(journal_create_from(&journal, folder, &run, axes, 1, next_seed, &cases, NULL),
                     STATUS_OK);
    for (uint32_t i = 0; i < finished; i++)
        fill(journal, i, &scenario.design_space);
    assert_int_equal(journal_state(journal, RUN_STATE_INTERRUPTED, 1, NULL), STATUS_OK);
    journal_close(journal);
    scenario_fini(&scenario);
}

// Of those that are done the largest box is the best, and every box counts for the spread.
static void best_box_and_spread_are_found(void **state)
{
    make_run(*state, "search.seed", 3);
    struct run_data data;
    struct seeds seeds;
    assert_int_equal(run_data_open(&data, *state, NULL), STATUS_OK);
    assert_true(seeds_alone(&data));
    assert_int_equal(seeds_read(&data, &seeds, NULL), STATUS_OK);
    assert_int_equal(seeds.best, 1);
    assert_int_equal(seeds.searches, 3);
    assert_true(seeds.log_volume == -3 && seeds.log_volume_least == -4);
    assert_true(fabs(seeds.log_volume_mean + 8.0 / 3) < 1e-12);
    for (uint32_t v = 0; v < seeds.spread.count; v++) {
        assert_true(fabs(seeds.spread.lower[v] - 1) < 1e-9);
        assert_true(fabs(seeds.spread.upper[v] - sqrt(3)) < 1e-9);
    }
    seeds_fini(&seeds);
    uint32_t shown;
    assert_int_equal(seeds_shown(&data, &shown, NULL), STATUS_OK);
    assert_int_equal(shown, 1);
    run_data_fini(&data);
}

// A run of other cases has no seeds, and one box alone no spread.
static void other_runs_have_no_spread(void **state)
{
    make_run(*state, "search.samples", 3);
    struct run_data data;
    assert_int_equal(run_data_open(&data, *state, NULL), STATUS_OK);
    assert_false(seeds_alone(&data));
    uint32_t shown;
    assert_int_equal(seeds_shown(&data, &shown, NULL), STATUS_OK);
    assert_int_equal(shown, 0);
    run_data_fini(&data);
    folder_empty(*state);
    make_run(*state, "search.seed", 1);
    struct seeds seeds;
    assert_int_equal(run_data_open(&data, *state, NULL), STATUS_OK);
    assert_int_equal(seeds_read(&data, &seeds, NULL), STATUS_OK);
    assert_int_equal(seeds.searches, 1);
    assert_true(isnan(seeds.spread.lower[0]));
    seeds_fini(&seeds);
    run_data_fini(&data);
    folder_empty(*state);
    make_run(*state, "search.seed", 0);
    assert_int_equal(report_write(*state, NULL), STATUS_OK);
}

// The best box alone is handed out, with the spread of its bounds.
static void files_have_the_best_box(void **state)
{
    make_run(*state, "search.seed", 3);
    assert_int_equal(report_write(*state, NULL), STATUS_OK);
    char *csv = file_text(*state, "corridors.csv");
    assert_contains(csv, ",reached,lower_spread_N,upper_spread_N\n1,");
    assert_null(strstr(csv, "\n0,"));
    assert_null(strstr(csv, "\n2,"));
    g_free(csv);
    char *json = file_text(*state, "result.json");
    assert_contains(json, "\"seeds\": {\n    \"best\": 1,\n    \"searches\": 3,");
    g_free(json);
}

// The last decimal that is shown is no smaller than the spread.
static void decimals_follow_from_the_spread(void **state)
{
    (void)state;
    assert_int_equal(seeds_decimals(0, 3), 3);
    assert_int_equal(seeds_decimals(NAN, 3), 3);
    assert_int_equal(seeds_decimals(0.37, 3), 1);
    assert_int_equal(seeds_decimals(3.7, 3), 0);
    assert_int_equal(seeds_decimals(37, 3), -1);
    assert_int_equal(seeds_decimals(1e-9, 3), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(best_box_and_spread_are_found),
        IN_FOLDER(other_runs_have_no_spread),
        IN_FOLDER(files_have_the_best_box),
        cmocka_unit_test(decimals_follow_from_the_spread),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
