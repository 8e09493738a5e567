#include "sample_run.h"

#include "coordinator/report/holding.h"
#include "coordinator/report/report.h"
#include "coordinator/search/search.h"

#include <math.h>

// Two sections in a row: the largest box is F1 in [294480, 516720], F2 in [516720, 627840] N.
static const char TWO_SECTIONS[] =
    "name: sections\n"
    "model: two_section_crash\n"
    "variables:\n"
    "  - {name: F1, lower: 1e5, upper: 1e6}\n"
    "  - {name: F2, lower: 1e5, upper: 1e6}\n"
    "parameters: {mass: 2000, d1: 0.3, d2: 0.3, speed: 15.6}\n"
    "constraints:\n"
    "  energy_remaining: {max: 0}\n"
    "  decel_max: {max: 313.92}\n"
    "  order: {max: 0}\n"
    "search: {samples: 100, exploration_steps: 30, consolidation_steps: 30, target_purity: 0.99,\n"
    "         certificate_samples: 2000";

// What workers do; with `hopeless` every design decelerates too much.
static void judge(const struct scenario *scenario, const struct search_request *request,
                  bool hopeless, struct verdict *verdicts)
{
    for (uint32_t i = 0; i < request->sampling.samples; i++) {
        double design[2];
        sampling_fill(&request->sampling, request->box, i, 1, design, 1);
        const double violations[] = {(243360 - 0.3 * (design[0] + design[1])) /
                                         scenario->constraints[0].scale,
                                     hopeless ? 0.5 + design[1] / 1e7 : design[1] / 627840 - 1,
                                     (design[0] - design[1]) / scenario->constraints[2].scale};
        verdicts[i] = (struct verdict){0};
        double worst = 0;
        for (uint8_t c = 0; c < 3; c++) {
            if (violations[c] > worst) {
                worst = violations[c];
                verdicts[i] =
                    (struct verdict){.violation = verdict_violation(worst), .constraint = c};
            }
        }
    }
}

static void finish(struct journal *journal, const struct search *search)
{
    struct search_result result;
    search_result(search, &result);
    struct journal_search record = {.box = *result.box,
                                    .log_volume = result.log_volume,
                                    .purity_samples = result.purity.samples,
                                    .purity_bad = result.purity.bad,
                                    .evaluations = result.evaluations,
                                    .steps = result.steps,
                                    .digest = result.digest};
    g_strlcpy(record.status, protocol_status_name(result.status), sizeof record.status);
    if (result.status == SEARCH_STATUS_NO_GOOD_DESIGN)
        g_strlcpy(record.blocking_constraint, "decel_max", sizeof record.blocking_constraint);
    assert_int_equal(journal_finish_search(journal, &record, NULL), STATUS_OK);
}

// Runs a search into a journal, as the coordinator does; ends after `steps_left` steps of the last
// phase if that is not negative.
static void run(const char *folder, const char *more, bool hopeless, int steps_left)
{
    char *yaml = g_strconcat(TWO_SECTIONS, more, "}\n", NULL);
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "test", yaml, strlen(yaml), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    const struct journal_search record = {.text = scenario.text,
                                          .text_size = scenario.text_size,
                                          .scenario = scenario.digest,
                                          .seed = 7};
    const struct journal_run head = {.name = "sections", .version = "1.2.3", .search_count = 1};
    struct journal *journal;
    assert_int_equal(journal_create(&journal, folder, &head, &record, NULL), STATUS_OK);
    struct search *search = search_create(&scenario, 7, 1);
    struct search_request request;
    struct verdict *verdicts = g_new(struct verdict, 5000);
    while (search_request(search, &request)) {
        if (request.phase == SEARCH_PHASE_EXPLAIN && steps_left >= 0 && steps_left-- == 0)
            break;
        judge(&scenario, &request, hopeless, verdicts);
        struct box box;
        box_init(&box, 2);
        box_assign(&box, request.box);
        search_complete(search, verdicts);
        const struct search_step *last = search_last_step(search);
        struct journal_step step = {.step = last->step,
                                    .samples = last->samples,
                                    .good = last->good,
                                    .log_volume = last->log_volume,
                                    .box = &box,
                                    .detail = request.detail,
                                    .sampling = request.sampling.method,
                                    .verdicts = verdicts};
        g_strlcpy(step.phase, protocol_phase_name(last->phase), sizeof step.phase);
        assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
        box_fini(&box);
    }
    if (!search_request(search, &request))
        finish(journal, search);
    assert_int_equal(journal_state(journal, RUN_STATE_DONE, 1, NULL), STATUS_OK);
    journal_close(journal);
    g_free(verdicts);
    search_free(search);
    scenario_fini(&scenario);
    g_free(yaml);
}

static char *printed(const char *folder, bool bounds, bool normalise)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    const struct report_table table = {.bounds = bounds, .normalise = normalise};
    assert_int_equal(report_print(folder, &table, out, NULL), STATUS_OK);
    fclose(out);
    return text;
}

static json_t *result_of(const char *folder)
{
    struct error error = {0};
    if (report_write(folder, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    char *text = file_text(folder, "result.json");
    json_t *json = json_loads(text, 0, NULL);
    assert_non_null(json);
    g_free(text);
    json_t *search = json_array_get(json_object_get(json, "searches"), 0);
    json_incref(search);
    json_decref(json);
    return search;
}

static const char *text_at(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

// From the journal alone: which constraint holds which bound, how good it is outside, and what each
// constraint is worth.
static void result_says_what_holds_each_corridor(void **state)
{
    run(*state, "", false, -1);
    json_t *search = result_of(*state);
    const json_t *f1 = json_array_get(json_object_get(search, "variables"), 0);
    const json_t *f2 = json_array_get(json_object_get(search, "variables"), 1);
    const json_t *lower = json_object_get(f1, "lower");
    assert_string_equal(text_at(lower, "holder"), "constraint");
    assert_string_equal(text_at(lower, "outcome"), "energy_remaining");
    assert_in_range(json_integer_value(json_object_get(lower, "samples")), 100, 500);
    assert_true(json_real_value(json_object_get(lower, "good_share")) > 0.5);
    assert_string_equal(text_at(json_object_get(f1, "upper"), "outcome"), "order");
    const json_t *upper = json_object_get(f2, "upper");
    assert_string_equal(text_at(upper, "outcome"), "decel_max");
    assert_float_equal(json_real_value(json_object_get(upper, "max")), 313.92, 0);
    const json_t *constraints = json_object_get(search, "constraints");
    assert_int_equal(json_array_size(constraints), 3);
    const json_t *decel = json_array_get(constraints, 1);
    assert_string_equal(text_at(decel, "outcome"), "decel_max");
    assert_float_equal(json_real_value(json_object_get(decel, "relaxed_by")), 3.1392, 1e-12);
    const double gain = json_real_value(json_object_get(decel, "log_volume_gain"));
    assert_true(gain > 0.04 && gain < 0.07); // 0.0557
    json_decref(search);
}

// The table of a run that has just ended stays short; sobox-report adds the bounds.
static void table_says_it_in_words(void **state)
{
    run(*state, "", false, -1);
    char *table = printed(*state, false, false);
    assert_contains(table, "what holds the corridors");
    assert_contains(table, "decel_max <= 313.92 m/s2");
    assert_contains(table, "   317.059 m/s2 ");
    assert_null(strstr(table, "lower bound held by"));
    g_free(table);
    table = printed(*state, true, false);
    assert_contains(table, "lower bound held by");
    assert_contains(table, "F1           energy_remaining <= 0 J");
    for (char **lines = g_strsplit(table, "\n", -1), **line = lines;; line++) {
        if (*line == NULL) {
            g_strfreev(lines);
            break;
        }
        assert_in_range(g_utf8_strlen(*line, -1), 0, 80);
    }
    g_free(table);
}

// What is shared without its numbers must not give the limits away.
static void normalised_table_has_no_limits(void **state)
{
    run(*state, "", false, -1);
    char *table = printed(*state, true, true);
    assert_contains(table, "decel_max");
    assert_null(strstr(table, "313.9"));
    assert_null(strstr(table, "317.0"));
    g_free(table);
}

// Switched off, the corridors are the same and nothing is claimed.
static void unexplained_corridors_claim_nothing(void **state)
{
    run(*state, ", explain_samples: 0", false, -1);
    json_t *search = result_of(*state);
    const json_t *f1 = json_array_get(json_object_get(search, "variables"), 0);
    assert_string_equal(text_at(json_object_get(f1, "lower"), "holder"), "unknown");
    const json_t *decel = json_array_get(json_object_get(search, "constraints"), 1);
    assert_null(json_object_get(decel, "log_volume_gain"));
    json_decref(search);
    char *table = printed(*state, true, false);
    assert_null(strstr(table, "what holds"));
    g_free(table);
}

// A run that is looked at while it explains shows its corridors, not the slab sampled last.
static void run_that_explains_shows_its_corridors(void **state)
{
    run(*state, "", false, 2);
    json_t *search = result_of(*state);
    const json_t *f2 = json_array_get(json_object_get(search, "variables"), 1);
    const json_t *corridor = json_object_get(f2, "corridor");
    const double lower = json_real_value(json_array_get(corridor, 0));
    const double upper = json_real_value(json_array_get(corridor, 1));
    assert_true(lower > 480e3 && lower < 540e3 && upper > 600e3 && upper < 640e3);
    assert_string_equal(text_at(json_object_get(f2, "lower"), "holder"), "unknown");
    json_decref(search);
}

// Nothing was found: what comes nearest, and by how much it misses, is what an engineer needs next.
static void least_violating_design_is_reported(void **state)
{
    run(*state, "", true, -1);
    json_t *search = result_of(*state);
    const json_t *least = json_object_get(search, "least_violating_design");
    assert_string_equal(text_at(least, "outcome"), "decel_max");
    const double missed = json_real_value(json_object_get(least, "missed_by"));
    assert_true(missed > 0.5 * 313.92 && missed < 0.53 * 313.92);
    const json_t *design = json_object_get(least, "design");
    assert_int_equal(json_array_size(design), 2);
    assert_string_equal(text_at(json_array_get(design, 1), "name"), "F2");
    const double f2 = json_real_value(json_object_get(json_array_get(design, 1), "value"));
    assert_true(f2 >= 1e5 && f2 < 3e5); // the lower it is, the less is missed
    json_decref(search);
    char *table = printed(*state, true, false);
    assert_contains(table, "in the way   decel_max <= 313.92 m/s2");
    assert_contains(table, "nearest      a design that misses decel_max <= 313.92 m/s2 by 16");
    g_free(table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(result_says_what_holds_each_corridor),
        IN_FOLDER(table_says_it_in_words),
        IN_FOLDER(normalised_table_has_no_limits),
        IN_FOLDER(unexplained_corridors_claim_nothing),
        IN_FOLDER(run_that_explains_shows_its_corridors),
        IN_FOLDER(least_violating_design_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
