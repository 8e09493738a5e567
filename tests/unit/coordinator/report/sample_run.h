// A small run folder made with the journal: two springs, four variables each, one of them fixed.
#ifndef SOBOX_TESTS_UNIT_COORDINATOR_REPORT_SAMPLE_RUN_H
#define SOBOX_TESTS_UNIT_COORDINATOR_REPORT_SAMPLE_RUN_H

#include "common/scenario/scenario_read.h"
#include "coordinator/journal/journal.h"

#include <glib.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <setjmp.h>

#include <cmocka.h>

static const char SAMPLE_SCENARIO[] = "name: sample\n"
                                      "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                                      "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                                      "springs:\n"
                                      "  - name: front\n"
                                      "    position: [-0.83, -0.75]\n"
                                      "    deformation: [0.0, 1.2]\n"
                                      "    force_x: {lower: 0, upper: [60e3, 450e3]}\n"
                                      "    force_y: {lower: 0, upper: 250e3}\n"
                                      "  - name: rail\n"
                                      "    position: [-0.83, -0.5]\n"
                                      "    deformation: [0.1, 0.9]\n"
                                      "    force_x: {lower: [1e3, 2e3], upper: [1e3, 8e3]}\n"
                                      "    force_y: {lower: 0, upper: 4e3}\n"
                                      "response: any\n"
                                      "firewall_distance: 0.25\n";

// A car that runs straight into a full barrier: its one spring stands before its COG, and pushes
// with the same force from the first touch on, in the middle half of the design space 500 to 700
// kN. Kinetic energy over force is the deformation: 0.377 to 0.528 m, so that every design passes
// the point at 0.25 m, the weakest the one at 0.5 m, and none the one at 0.75 m. The barrier never
// meets the other spring.
#define SAMPLE_STOPPED_DEEPEST (1650 * 17.889 * 17.889 / 2 / 500e3) // [m]
static const char SAMPLE_STOPPED[] = "name: stopped\n"
                                     "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889,\n"
                                     "          cog: [0.0, -0.75]}\n"
                                     "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                                     "springs:\n"
                                     "  - name: front\n"
                                     "    position: [-0.83, 0.0]\n"
                                     "    deformation: [0.0, 0.25, 0.5, 0.75, 1.0]\n"
                                     "    force_x: {lower: 400e3, upper: 800e3}\n"
                                     "    force_y: {lower: 0, upper: 0}\n"
                                     "  - name: idle\n"
                                     "    position: [0.4, 0.0]\n"
                                     "    length: 0.5\n"
                                     "    deformation: [0.0, 0.4]\n"
                                     "    force_x: {lower: 0, upper: 80e3}\n"
                                     "    force_y: {lower: 0, upper: 80e3}\n"
                                     "simulation: {integrator: event_verlet}\n"
                                     "response: any\n"
                                     "firewall_distance: 0.25\n";

enum sample_end { SAMPLE_UNTOUCHED, SAMPLE_UNFINISHED, SAMPLE_DONE, SAMPLE_NO_GOOD_DESIGN };

static inline int folder_make(void **state)
{
    *state = g_dir_make_tmp("sobox-report-XXXXXX", NULL);
    return *state != NULL ? 0 : -1;
}

static inline void folder_empty(const char *folder)
{
    GDir *dir = g_dir_open(folder, 0, NULL);
    for (const char *name; dir != NULL && (name = g_dir_read_name(dir)) != NULL;) {
        char *path = g_build_filename(folder, name, NULL);
        if (unlink(path) != 0) {
            folder_empty(path);
            rmdir(path);
        }
        g_free(path);
    }
    g_dir_close(dir);
}

static inline int folder_remove(void **state)
{
    folder_empty(*state);
    rmdir(*state);
    g_free(*state);
    return 0;
}

// The middle half of the design space.
static inline void sample_corridor(struct box *box, const struct box *space)
{
    box_init(box, space->count);
    for (uint32_t i = 0; i < space->count; i++) {
        double width = space->upper[i] - space->lower[i];
        box->lower[i] = space->lower[i] + 0.25 * width;
        box->upper[i] = space->lower[i] + 0.75 * width;
    }
}

static inline void sample_steps(struct journal *journal, uint32_t search, const struct box *space,
                                const struct box *corridor, bool any_good)
{
    struct verdict verdicts[8] = {[1] = {.violation = 9}, [5] = {.violation = 12}};
    for (size_t i = 0; !any_good && i < G_N_ELEMENTS(verdicts); i++)
        verdicts[i].violation = 7;
    struct journal_step step = {.search = search,
                                .phase = "seek",
                                .samples = 8,
                                .good = any_good ? 6 : 0,
                                .box = space,
                                .verdicts = verdicts};
    assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
    if (!any_good)
        return;
    step.step = 1;
    g_strlcpy(step.phase, "explore", sizeof step.phase);
    step.growth = 0.1;
    step.log_volume = -4.5;
    step.box = corridor;
    assert_int_equal(journal_append(journal, &step, NULL), STATUS_OK);
}

static inline void sample_finish(struct journal *journal, uint32_t search, enum sample_end end,
                                 const struct box *corridor)
{
    struct journal_search result = {.index = search,
                                    .status = "done",
                                    .box = *corridor,
                                    .log_volume = -4.5,
                                    .purity_samples = 1000,
                                    .purity_estimate = 1,
                                    .purity_lower95 = 0.99709,
                                    .evaluations = 1016,
                                    .steps = 2,
                                    .wall_ns = 250000000,
                                    .digest = digest_of("sample", 6)};
    if (end == SAMPLE_NO_GOOD_DESIGN) {
        g_strlcpy(result.status, "no_good_design", sizeof result.status);
        g_strlcpy(result.blocking_constraint, "s_L", sizeof result.blocking_constraint);
        result.purity_samples = 0;
        result.evaluations = 8;
        result.steps = 1;
    }
    assert_int_equal(journal_finish_search(journal, &result, NULL), STATUS_OK);
}

static inline void sample_fill(struct journal *journal, uint32_t search, enum sample_end end,
                               const struct box *space)
{
    struct box corridor;
    sample_corridor(&corridor, space);
    if (end != SAMPLE_UNTOUCHED)
        sample_steps(journal, search, space, &corridor, end != SAMPLE_NO_GOOD_DESIGN);
    if (end == SAMPLE_DONE || end == SAMPLE_NO_GOOD_DESIGN)
        sample_finish(journal, search, end, &corridor);
    box_fini(&corridor);
}

// Makes the run of a scenario in an existing folder, `searches` times the same.
static inline void sample_run(const char *folder, const char *yaml, uint32_t searches,
                              enum sample_end end)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "sample", yaml, strlen(yaml), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    struct journal_search records[4] = {0};
    assert_in_range(searches, 1, G_N_ELEMENTS(records));
    for (uint32_t i = 0; i < searches; i++)
        records[i] = (struct journal_search){.index = i,
                                             .text = scenario.text,
                                             .text_size = scenario.text_size,
                                             .scenario = scenario.digest,
                                             .seed = 1};
    struct journal_run run = {.version = "1.2.3", .search_count = searches};
    g_strlcpy(run.name, scenario.name, sizeof run.name);
    struct journal *journal;
    assert_int_equal(journal_create(&journal, folder, &run, records, NULL), STATUS_OK);
    for (uint32_t i = 0; i < searches; i++)
        sample_fill(journal, i, end, &scenario.design_space);
    enum run_state state = end == SAMPLE_UNTOUCHED || end == SAMPLE_UNFINISHED
                               ? RUN_STATE_INTERRUPTED
                               : RUN_STATE_DONE;
    assert_int_equal(journal_state(journal, state, 250000000, NULL), STATUS_OK);
    journal_close(journal);
    scenario_fini(&scenario);
}

// The cases of a sweep, one after the other.
struct sample_cases {
    const struct scenario *scenario;
    uint32_t next;
};

static inline enum status sample_next_case(void *user, struct journal_search *search, bool *more,
                                           struct error *error)
{
    (void)error;
    static const char *values[3][2] = {{"1", "[1, 2]"}, {"2", "[1, 2]"}, {"3", "[1, 2]"}};
    struct sample_cases *cases = user;
    const uint32_t index = cases->next;
    *more = index < 3;
    if (!*more)
        return STATUS_OK;
    *search = (struct journal_search){.index = cases->next++,
                                      .values = values[index],
                                      .text = cases->scenario->text,
                                      .text_size = cases->scenario->text_size,
                                      .scenario = cases->scenario->digest,
                                      .seed = 1};
    g_snprintf(search->name, sizeof search->name, "mass=%s,upper=#1", values[index][0]);
    return STATUS_OK;
}

// A sweep of three cases: one done, one without a good design, one that waits.
static inline void sample_sweep(const char *folder)
{
    static const char *const axes[] = {"vehicle.mass", "springs.0.force_x.upper"};
    struct scenario scenario;
    assert_int_equal(scenario_read_text(&scenario, "sample", SAMPLE_SCENARIO,
                                        strlen(SAMPLE_SCENARIO), NULL, 0, NULL),
                     STATUS_OK);
    struct sample_cases cases = {.scenario = &scenario};
    struct journal_run run = {.name = "masses", .version = "1.2.3"};
    struct journal *journal;
    assert_int_equal(
        journal_create_from(&journal, folder, &run, axes, 2, sample_next_case, &cases, NULL),
        STATUS_OK);
    sample_fill(journal, 0, SAMPLE_DONE, &scenario.design_space);
    sample_fill(journal, 1, SAMPLE_NO_GOOD_DESIGN, &scenario.design_space);
    assert_int_equal(journal_state(journal, RUN_STATE_INTERRUPTED, 1, NULL), STATUS_OK);
    journal_close(journal);
    scenario_fini(&scenario);
}

// The text of a file of the folder. The caller frees it.
static inline char *file_text(const char *folder, const char *name)
{
    char *path = g_build_filename(folder, name, NULL), *text = NULL;
    if (!g_file_get_contents(path, &text, NULL, NULL))
        fail_msg("%s is missing", path);
    g_free(path);
    return text;
}

static inline bool file_exists(const char *folder, const char *name)
{
    char *path = g_build_filename(folder, name, NULL);
    bool exists = access(path, F_OK) == 0;
    g_free(path);
    return exists;
}

static inline void assert_contains(const char *text, const char *part)
{
    if (strstr(text, part) == NULL)
        fail_msg("expected \"%s\" in:\n%s", part, text);
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, folder_make, folder_remove)

#endif
