// How near each integrator comes to the crash that all converge to: tests/physics/reference.h, an
// independent way to it, over random designs of the shipped design spaces, on flat and rounded
// barriers. Prints a table in Markdown.
//
//     accuracy_study [DESIGNS]    (default 2048)
#include "common/sampling/sampling.h"
#include "common/scenario/scenario_read.h"
#include "tests/physics/reference_scenario.h"
#include "worker/batch/batch.h"
#include "worker/models/model.h"
#include "worker/models/small_overlap.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const study_scenarios[] = {
    "sedan-two-springs", "sedan-ten-springs",      "suv-two-springs",
    "suv-ten-springs",   "sports-car-two-springs", "sports-car-ten-springs",
};
static const char *const study_profiles[] = {"flat", "rounded"};
static const char *const study_responses[] = {"any", "rotating", "glancing_off"};
static const struct {
    const char *integrator;
    const char *time_step; // [s]
} study_schemes[] = {
    {"central_difference", "1e-3"}, {"central_difference", "2.5e-5"}, {"velocity_verlet", "1e-3"},
    {"runge_kutta_4", "1e-3"},      {"event_verlet", "1.5e-3"},       {"event_verlet", "1e-3"},
};

// What is held against the reference, in its own unit [m].
static const struct {
    enum kinematics_result result;
    size_t expected; // its offset in struct reference_outcome
} study_lengths[] = {
    {KINEMATICS_LENGTH_LAST, offsetof(struct reference_outcome, length_last)},
    {KINEMATICS_LENGTH_MIN, offsetof(struct reference_outcome, length_min)},
    {KINEMATICS_PILLAR_TRAVEL, offsetof(struct reference_outcome, pillar_travel)},
    {KINEMATICS_PROJECTION_TRAVEL, offsetof(struct reference_outcome, projection_travel)},
};
static const double study_bound = 1e-3; // [m] of each for 99 % of the designs

static struct scenario study_scenario(const char *name, const char *const *overrides, size_t count)
{
    g_autofree char *path = g_strdup_printf(SOBOX_SOURCE_DIR "/deploy/scenarios/%s.yaml", name);
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_file(&scenario, path, overrides, count, &error) != STATUS_OK) {
        fprintf(stderr, "%s\n", error.text);
        exit(EXIT_FAILURE);
    }
    return scenario;
}

// The designs, values[variable * designs + i], the same for all that is compared.
static double *study_designs(const struct scenario *scenario, uint32_t designs)
{
    const struct sampling sampling = {.seed = 7, .step = 1, .samples = designs};
    const struct box *box = &scenario->design_space;
    double *values = g_new(double, (size_t)box->count *designs);
    sampling_fill(&sampling, box, 0, designs, values, designs);
    return values;
}

static void study_expect(const struct scenario *scenario, const double *values, uint32_t designs,
                         struct reference_outcome *expected)
{
#pragma omp parallel for schedule(dynamic)
    for (uint32_t i = 0; i < designs; i++) {
        struct reference_crash crash = reference_crash_of(scenario);
        crash.step = 2e-5;
        reference_set_forces(&crash, values + i, designs);
        expected[i] = reference_evaluate(&crash);
    }
}

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

// The differences of one result, in order.
static void study_differences(size_t length, uint32_t designs, const double *results,
                              const struct reference_outcome *expected, double *difference)
{
    const double *row = results + (size_t)study_lengths[length].result * designs;
    for (uint32_t i = 0; i < designs; i++) {
        const char *at = (const char *)&expected[i] + study_lengths[length].expected;
        difference[i] = fabs(row[i] - *(const double *)(const void *)at);
    }
    qsort(difference, designs, sizeof *difference, compare_numbers);
}

// How many verdicts of a response are other ones with the reference's motion.
static uint32_t study_verdicts(const char *name, const char *response, uint32_t designs,
                               const double *results, uint32_t result_count,
                               const struct reference_outcome *expected)
{
    g_autofree char *wanted = g_strdup_printf("response=%s", response);
    struct scenario scenario = study_scenario(name, (const char *const[]){wanted}, 1);
    const size_t size = (size_t)result_count * designs;
    g_autofree double *as_is = g_memdup2(results, size * sizeof *results);
    g_autofree double *as_expected = g_memdup2(results, size * sizeof *results);
    for (uint32_t i = 0; i < designs; i++) {
        as_expected[KINEMATICS_LENGTH_LAST * designs + i] = expected[i].length_last;
        as_expected[KINEMATICS_LENGTH_MIN * designs + i] = expected[i].length_min;
        as_expected[KINEMATICS_PILLAR_TRAVEL * designs + i] = expected[i].pillar_travel;
        as_expected[KINEMATICS_PROJECTION_TRAVEL * designs + i] = expected[i].projection_travel;
        as_expected[KINEMATICS_YAW * designs + i] = expected[i].yaw;
        as_expected[KINEMATICS_YAW_MAX * designs + i] = expected[i].yaw_max;
    }
    small_overlap_outcomes(scenario.barrier.overlap, designs, as_is, designs);
    small_overlap_outcomes(scenario.barrier.overlap, designs, as_expected, designs);
    uint32_t changed = 0;
    for (uint32_t i = 0; i < designs; i++) {
        const bool good = batch_verdict(&scenario, as_is + i, designs).violation == VERDICT_GOOD;
        changed +=
            good != (batch_verdict(&scenario, as_expected + i, designs).violation == VERDICT_GOOD);
    }
    scenario_fini(&scenario);
    return changed;
}

static void study_row(const char *name, const char *profile, size_t scheme, uint32_t designs,
                      const double *values, const struct reference_outcome *expected)
{
    g_autofree char *shape = g_strdup_printf("barrier.profile=%s", profile);
    g_autofree char *integrator =
        g_strdup_printf("simulation.integrator=%s", study_schemes[scheme].integrator);
    g_autofree char *step =
        g_strdup_printf("simulation.time_step=%s", study_schemes[scheme].time_step);
    struct scenario scenario =
        study_scenario(name, (const char *const[]){shape, integrator, step}, 3);
    struct kinematics_problem *problem =
        small_overlap_problem(&scenario, NULL, (struct kinematics_omitted){.energies = true});
    const uint32_t result_count = kinematics_result_count(problem);
    g_autofree double *results = g_new0(double, (size_t)result_count *designs);
#pragma omp parallel for schedule(dynamic)
    for (uint32_t first = 0; first < designs; first += MODEL_BLOCK) {
        kinematics_evaluate(problem, MIN(designs - first, (uint32_t)MODEL_BLOCK), values + first,
                            results + first, designs);
    }
    printf("| %s, %s | %s, %g ms |", name, profile, study_schemes[scheme].integrator,
           1e3 * g_ascii_strtod(study_schemes[scheme].time_step, NULL));
    bool met = true;
    g_autofree double *difference = g_new(double, designs);
    for (size_t i = 0; i < G_N_ELEMENTS(study_lengths); i++) {
        study_differences(i, designs, results, expected, difference);
        const double most = difference[(size_t)(0.99 * (designs - 1))];
        met &= most <= study_bound;
        printf(" %.2f, %.2f |", 1e3 * most, 1e3 * difference[designs - 1]);
    }
    for (size_t i = 0; i < G_N_ELEMENTS(study_responses); i++) {
        printf(" %u |",
               study_verdicts(name, study_responses[i], designs, results, result_count, expected));
    }
    printf(" %s |\n", met ? "met" : "");
    fflush(stdout);
    kinematics_free(problem);
    scenario_fini(&scenario);
}

int main(int argc, char **argv)
{
    const uint32_t designs = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 2048;
    if (argc > 2 || designs == 0) {
        fprintf(stderr, "expected: accuracy_study [DESIGNS]\n");
        return 2;
    }
    printf("%u designs of each design space: for 99 %% of them, and the worst [mm]; verdicts that "
           "change.\n\n"
           "| scenario | scheme, step | s_L | s_L_min | A-pillar, lateral | its projection | any "
           "| rotating | glancing off | |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
           designs);
    g_autofree struct reference_outcome *expected = g_new(struct reference_outcome, designs);
    for (size_t i = 0; i < G_N_ELEMENTS(study_scenarios); i++) {
        for (size_t k = 0; k < G_N_ELEMENTS(study_profiles); k++) {
            g_autofree char *shape = g_strdup_printf("barrier.profile=%s", study_profiles[k]);
            struct scenario scenario =
                study_scenario(study_scenarios[i], (const char *const[]){shape}, 1);
            g_autofree double *values = study_designs(&scenario, designs);
            study_expect(&scenario, values, designs, expected);
            for (size_t scheme = 0; scheme < G_N_ELEMENTS(study_schemes); scheme++) {
                study_row(study_scenarios[i], study_profiles[k], scheme, designs, values, expected);
            }
            scenario_fini(&scenario);
        }
    }
    return 0;
}
