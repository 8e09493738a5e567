// What the choices in the crash model change: the rule of reloading and the time step. Every
// scenario of deploy/scenarios with each of the three responses is searched, then random designs of
// its design space and of the box found are judged under each choice. Prints tables in Markdown.
//
//     crash_study reloading [DESIGNS]    verdicts under simulation.reloading thesis and crushed
//     crash_study steps [DESIGNS]        errors of s_L, AbWAP, AbWP at a range of time steps
//     crash_study flight [DESIGNS]       how long cars fly on after the last contact
//
// DESIGNS (default 4096) are drawn a scenario.
#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"
#include "worker/batch/batch.h"
#include "worker/models/small_overlap.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STUDY_THREADS = 2 };

static const char *const study_scenarios[] = {
    "sedan-two-springs", "sedan-ten-springs",      "suv-two-springs",
    "suv-ten-springs",   "sports-car-two-springs", "sports-car-ten-springs",
};
static const char *const study_responses[] = {"any", "rotating", "glancing_off"};

// Reads a shipped scenario with up to four overrides, the rest NULL; ends the program when it
// cannot.
static struct scenario study_scenario(const char *name, const char *const overrides[4])
{
    g_autofree char *path = g_strdup_printf(SOBOX_SOURCE_DIR "/deploy/scenarios/%s.yaml", name);
    size_t count = 0;
    while (count < 4 && overrides[count] != NULL) {
        count++;
    }
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_file(&scenario, path, overrides, count, &error) != STATUS_OK) {
        fprintf(stderr, "%s\n", error.text);
        exit(EXIT_FAILURE);
    }
    return scenario;
}

// ---- Designs ----

// What random designs of a box did. The same designs whatever the scenario's settings.
struct study_outcomes {
    uint32_t designs;
    uint32_t count;  // outcomes of a design
    double *outcome; // (count x designs)
};

static struct study_outcomes study_evaluate(const struct scenario *scenario, const struct box *box,
                                            uint32_t designs)
{
    const struct sampling sampling = {.seed = 7, .step = 1, .samples = designs};
    struct model *model = model_create(scenario);
    const uint32_t count = model_outcome_count(model);
    const struct study_outcomes done = {
        .designs = designs,
        .count = count,
        .outcome = g_new(double, (size_t)count *designs),
    };
#pragma omp parallel for schedule(dynamic)
    for (uint32_t first = 0; first < designs; first += MODEL_BLOCK) {
        const uint32_t block = MIN(designs - first, (uint32_t)MODEL_BLOCK);
        g_autofree double *values = g_new(double, (size_t)box->count *MODEL_BLOCK);
        g_autofree double *outcomes = g_new(double, (size_t)count *MODEL_BLOCK);
        sampling_fill(&sampling, box, first, block, values, MODEL_BLOCK);
        model_evaluate(model, block, values, outcomes);
        for (uint32_t i = 0; i < count; i++) {
            memcpy(done.outcome + (size_t)i * designs + first, outcomes + (size_t)i * MODEL_BLOCK,
                   block * sizeof *outcomes);
        }
    }
    model_free(model);
    return done;
}

static bool study_is_good(const struct scenario *scenario, const struct study_outcomes *outcomes,
                          uint32_t design)
{
    return batch_verdict(scenario, outcomes->outcome + design, outcomes->designs).violation ==
           VERDICT_GOOD;
}

static bool study_differs(const struct study_outcomes *a, const struct study_outcomes *b,
                          uint32_t design)
{
    for (uint32_t i = 0; i < a->count; i++) {
        const size_t at = (size_t)i * a->designs + design;
        if (memcmp(&a->outcome[at], &b->outcome[at], sizeof *a->outcome) != 0) {
            return true;
        }
    }
    return false;
}

// Searches a scenario to its end; the caller frees the search, which owns the result's box.
static struct search *study_search(const struct scenario *scenario, struct search_result *result)
{
    struct model *model = model_create(scenario);
    struct search *search = search_create(scenario, scenario->search.seed, STUDY_THREADS);
    struct search_request request;
    while (search_request(search, &request)) {
        const struct batch batch = {
            .sampling = request.sampling,
            .count = request.sampling.samples,
            .detail = request.detail,
        };
        g_autofree struct verdict *verdicts = g_new(struct verdict, batch.count);
        batch_evaluate(scenario, model, request.box, &batch, STUDY_THREADS, verdicts);
        search_complete(search, verdicts);
    }
    search_result(search, result);
    model_free(model);
    return search;
}

// ---- The rule of reloading ----

// Prints how many designs of a box are good, how many have any other outcome under the other rule,
// and how many become bad and good by it.
static void reloading_cells(const struct scenario *thesis, const struct scenario *crushed,
                            const struct box *box, uint32_t designs)
{
    struct study_outcomes before = study_evaluate(thesis, box, designs);
    struct study_outcomes after = study_evaluate(crushed, box, designs);
    uint32_t good = 0;
    uint32_t other = 0;
    uint32_t worse = 0;
    uint32_t better = 0;
    for (uint32_t i = 0; i < designs; i++) {
        const bool was_good = study_is_good(thesis, &before, i);
        const bool is_good = study_is_good(crushed, &after, i);
        good += was_good;
        other += study_differs(&before, &after, i);
        worse += was_good && !is_good;
        better += !was_good && is_good;
    }
    printf(" %u | %u | %u | %u |", good, other, worse, better);
    g_free(before.outcome);
    g_free(after.outcome);
}

static void reloading_row(const char *name, const char *response, uint32_t designs)
{
    g_autofree char *wanted = g_strdup_printf("response=%s", response);
    struct scenario scenarios[2];
    scenarios[0] = study_scenario(
        name, (const char *const[4]){wanted, "simulation.reloading=thesis", NULL, NULL});
    scenarios[1] = study_scenario(
        name, (const char *const[4]){wanted, "simulation.reloading=crushed", NULL, NULL});
    struct search_result found[2];
    struct search *searches[2];
    for (int rule = 0; rule < 2; rule++) {
        searches[rule] = study_search(&scenarios[rule], &found[rule]);
    }
    printf("| %s, %s |", name, response);
    reloading_cells(&scenarios[0], &scenarios[1], &scenarios[0].design_space, designs);
    reloading_cells(&scenarios[0], &scenarios[1], found[0].box, designs);
    printf(" %.2f | %.2f |\n", found[0].log_volume, found[1].log_volume);
    fflush(stdout);
    for (int rule = 0; rule < 2; rule++) {
        search_free(searches[rule]);
        scenario_fini(&scenarios[rule]);
    }
}

static void study_reloading(uint32_t designs)
{
    printf("%u designs a box; \"other\" have any other outcome under `crushed`, \"worse\" are good "
           "under `thesis` only, \"better\" under `crushed` only.\n\n"
           "| scenario | design space: good | other | worse | better | box found: good | other "
           "| worse | better | ln volume, thesis | crushed |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
           designs);
    for (size_t i = 0; i < G_N_ELEMENTS(study_scenarios); i++) {
        for (size_t j = 0; j < G_N_ELEMENTS(study_responses); j++) {
            reloading_row(study_scenarios[i], study_responses[j], designs);
        }
    }
}

// ---- The time step ----

// What the time step must not change by more than this for 99 % of the designs.
static const struct {
    enum outcome outcome;
    double bound;
} step_outcomes[] = {{OUTCOME_S_L, 1e-3}, {OUTCOME_ABWAP, 2e-3}, {OUTCOME_ABWP, 2e-3}};

static const char *const step_integrators[] = {
    "central_difference",
    "velocity_verlet",
    "event_verlet",
    "runge_kutta_4",
};
static const char *const step_sizes[] = {"2e-3",   "1.5e-3", "1.25e-3", "1e-3",  "5e-4",
                                         "2.5e-4", "1e-4",   "5e-5",    "2.5e-5"};
enum { STEP_SIZES = G_N_ELEMENTS(step_sizes), STEP_OUTCOMES = G_N_ELEMENTS(step_outcomes) };
static const char step_converged[] = "simulation.time_step=2e-6";

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

// The 99th percentile of the differences of one outcome.
static double step_error(const struct study_outcomes *coarse, const struct study_outcomes *fine,
                         enum outcome outcome)
{
    const size_t row = (size_t)outcome * coarse->designs;
    g_autofree double *difference = g_new(double, coarse->designs);
    for (uint32_t i = 0; i < coarse->designs; i++) {
        difference[i] = fabs(coarse->outcome[row + i] - fine->outcome[row + i]);
    }
    qsort(difference, coarse->designs, sizeof *difference, compare_numbers);
    return difference[(size_t)(0.99 * (coarse->designs - 1))];
}

static uint32_t step_verdicts_changed(const struct scenario *scenario,
                                      const struct study_outcomes *coarse,
                                      const struct study_outcomes *fine)
{
    uint32_t changed = 0;
    for (uint32_t i = 0; i < coarse->designs; i++) {
        changed += study_is_good(scenario, coarse, i) != study_is_good(scenario, fine, i);
    }
    return changed;
}

// Evaluates the design space of a scenario with an integrator and a time step.
static struct study_outcomes step_evaluate(const char *name, const char *integrator,
                                           const char *time_step, uint32_t designs)
{
    struct scenario scenario =
        study_scenario(name, (const char *const[4]){integrator, time_step, NULL, NULL});
    const struct study_outcomes outcomes =
        study_evaluate(&scenario, &scenario.design_space, designs);
    scenario_fini(&scenario);
    return outcomes;
}

// The responses have the same outcomes and differ in the verdicts.
static void step_rows(const char *name, const char *integrator, uint32_t designs,
                      const struct study_outcomes *fine)
{
    g_autofree char *chosen = g_strdup_printf("simulation.integrator=%s", integrator);
    for (int size = 0; size < STEP_SIZES; size++) {
        g_autofree char *step = g_strdup_printf("simulation.time_step=%s", step_sizes[size]);
        struct study_outcomes coarse = step_evaluate(name, chosen, step, designs);
        bool met = true;
        printf("| %s | %s | %s |", name, integrator, step_sizes[size]);
        for (int i = 0; i < STEP_OUTCOMES; i++) {
            const double error = step_error(&coarse, fine, step_outcomes[i].outcome);
            met &= error <= step_outcomes[i].bound;
            printf(" %.5f |", error);
        }
        for (size_t i = 0; i < G_N_ELEMENTS(study_responses); i++) {
            g_autofree char *response = g_strdup_printf("response=%s", study_responses[i]);
            struct scenario scenario =
                study_scenario(name, (const char *const[4]){response, NULL, NULL, NULL});
            printf(" %u |", step_verdicts_changed(&scenario, &coarse, fine));
            scenario_fini(&scenario);
        }
        printf(" %s |\n", met ? "yes" : "");
        fflush(stdout);
        g_free(coarse.outcome);
        if (met) {
            break;
        }
    }
}

static void study_steps(uint32_t designs)
{
    printf("%u designs of each design space against Runge-Kutta with 2 us: 99th percentile of the "
           "differences, and verdicts that change. Steps are halved until s_L is within 1 mm and "
           "AbWAP and AbWP within 0.002.\n\n"
           "| scenario | integrator | step [s] | s_L [m] | AbWAP | AbWP | any | rotating "
           "| glancing_off | met |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
           designs);
    for (size_t i = 0; i < G_N_ELEMENTS(study_scenarios); i++) {
        struct study_outcomes fine = step_evaluate(
            study_scenarios[i], "simulation.integrator=runge_kutta_4", step_converged, designs);
        for (size_t k = 0; k < G_N_ELEMENTS(step_integrators); k++) {
            step_rows(study_scenarios[i], step_integrators[k], designs, &fine);
        }
        g_free(fine.outcome);
    }
}

// ---- Free flight ----

enum { FLIGHT_BUNDLE = 16 }; // designs that AVX-512 takes through the steps together

// The steps up to the last one at which something touches, and at which something pushes.
struct flight {
    uint32_t contact;
    uint32_t force;
};

static struct flight flight_of(const struct kinematics_problem *problem, const double *rows,
                               uint32_t springs)
{
    struct flight flight = {0, 0};
    for (uint32_t step = 0; step < kinematics_row_count(problem); step++) {
        const double *spring =
            rows + (size_t)step * kinematics_column_count(problem) + KINEMATICS_COLUMN_SPRING;
        for (uint32_t i = 0; i < springs; i++, spring += KINEMATICS_SPRING_COLUMN_COUNT) {
            if (spring[KINEMATICS_SPRING_CONTACT] > 0.0) {
                flight.contact = step;
            }
            if (spring[KINEMATICS_SPRING_FORCE_X] != 0.0 ||
                spring[KINEMATICS_SPRING_FORCE_Y] != 0.0) {
                flight.force = step;
            }
        }
    }
    return flight;
}

// Prints which share of all steps comes after the last contact and after the last force, design by
// design and where a whole bundle is so far.
static void flight_cells(const struct scenario *scenario, const struct box *box, uint32_t designs)
{
    const struct sampling sampling = {.seed = 7, .step = 1, .samples = designs};
    struct kinematics_problem *problem = small_overlap_problem(
        scenario, NULL, (struct kinematics_omitted){.energies = true, .deformations = true});
    g_autofree double *values = g_new(double, (size_t)box->count *MODEL_BLOCK);
    g_autofree double *single = g_new(double, box->count);
    g_autofree double *results = g_new(double, kinematics_result_count(problem));
    g_autofree double *rows =
        g_new(double, (size_t)kinematics_row_count(problem) * kinematics_column_count(problem));
    double alone[2] = {0.0, 0.0};
    double together[2] = {0.0, 0.0};
    struct flight latest = {0, 0};
    const double steps = kinematics_row_count(problem) - 1.0;
    for (uint32_t i = 0; i < designs; i++) {
        if (i % MODEL_BLOCK == 0) {
            sampling_fill(&sampling, box, i, MODEL_BLOCK, values, MODEL_BLOCK);
        }
        for (uint32_t variable = 0; variable < box->count; variable++) {
            single[variable] = values[(size_t)variable * MODEL_BLOCK + i % MODEL_BLOCK];
        }
        kinematics_record(problem, single, results, rows);
        const struct flight flight = flight_of(problem, rows, scenario->spring_count);
        alone[0] += steps - flight.contact;
        alone[1] += steps - flight.force;
        latest.contact = MAX(latest.contact, flight.contact);
        latest.force = MAX(latest.force, flight.force);
        if ((i + 1) % FLIGHT_BUNDLE == 0) {
            together[0] += FLIGHT_BUNDLE * (steps - latest.contact);
            together[1] += FLIGHT_BUNDLE * (steps - latest.force);
            latest = (struct flight){0, 0};
        }
    }
    const double all = 0.01 * steps * designs; // [%]
    printf(" %.0f %% | %.0f %% | %.1f %% | %.1f %% |", alone[0] / all, alone[1] / all,
           together[0] / all, together[1] / all);
    kinematics_free(problem);
}

static void study_flight(uint32_t designs)
{
    designs = (designs - 1) / MODEL_BLOCK * MODEL_BLOCK + MODEL_BLOCK;
    printf(
        "%u designs a box: the share of all steps after the last contact of any spring, and after "
        "the last force of any; of a design, and where all %d of a bundle are so far.\n\n"
        "| scenario | design space: no contact | no force | bundle: no contact | no force "
        "| box found: no contact | no force | bundle: no contact | no force |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        designs, FLIGHT_BUNDLE);
    for (size_t i = 0; i < G_N_ELEMENTS(study_scenarios); i++) {
        for (size_t j = 0; j < G_N_ELEMENTS(study_responses); j++) {
            g_autofree char *wanted = g_strdup_printf("response=%s", study_responses[j]);
            struct scenario scenario = study_scenario(
                study_scenarios[i], (const char *const[4]){wanted, NULL, NULL, NULL});
            struct search_result found;
            struct search *search = study_search(&scenario, &found);
            printf("| %s, %s |", study_scenarios[i], study_responses[j]);
            flight_cells(&scenario, &scenario.design_space, designs);
            flight_cells(&scenario, found.box, designs);
            printf("\n");
            fflush(stdout);
            search_free(search);
            scenario_fini(&scenario);
        }
    }
}

// ---- The program ----

int main(int argc, char **argv)
{
    const char *study = argc > 1 ? argv[1] : "";
    const uint32_t designs = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 4096;
    if (designs == 0) {
        fprintf(stderr, "crash_study: expected a number of designs, found %s\n", argv[2]);
        return 2;
    }
    if (strcmp(study, "reloading") == 0) {
        study_reloading(designs);
        return 0;
    }
    if (strcmp(study, "steps") == 0) {
        study_steps(designs);
        return 0;
    }
    if (strcmp(study, "flight") == 0) {
        study_flight(designs);
        return 0;
    }
    fprintf(stderr, "expected: crash_study reloading|steps|flight [DESIGNS]\n");
    return 2;
}
