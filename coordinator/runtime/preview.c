#include "coordinator/runtime/preview.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "coordinator/runtime/progress.h"
#include "worker/batch/batch.h"
#include "worker/models/model.h"

#include <glib.h>
#include <inttypes.h>

// A probe is tried for so long: a few dozen steps of thesis size.
static const int64_t PROBE_NS = CLOCK_SECOND_NS / 4;

// What a step costs beside sampling and trimming: messages, schedule, journal. Measured with a
// model that costs next to nothing; it is what counts for such a model alone.
static const double STEP_S = 100e-6;

// Time spent on searches and what it bought.
struct measurement {
    int64_t spent_ns;
    uint64_t samples;
};

// What the searches come to when they use all their steps.
struct plan {
    uint32_t searches;
    uint64_t steps;
    uint64_t samples;
};

static void plan_add(struct plan *plan, const struct scenario *scenario)
{
    const struct scenario_search *search = &scenario->search;
    const uint64_t steps = 1 + (uint64_t)search->exploration_steps + search->consolidation_steps;
    plan->searches++;
    plan->steps += steps + 1; // the certificate's
    plan->samples += steps * search->samples + search->certificate_samples;
}

// Searches for a moment in this thread, sampling and trimming as a run would.
static void probe(const struct scenario *scenario, struct measurement *measurement)
{
    const int64_t start_ns = clock_monotonic_ns();
    struct model *model = model_create(scenario);
    struct search *search = search_create(scenario, scenario->search.seed, 1);
    struct search_request request;
    struct verdict *verdicts = NULL;
    int64_t now_ns = start_ns;
    while (now_ns - start_ns < PROBE_NS && search_request(search, &request)) {
        const uint32_t samples = request.sampling.samples;
        const struct batch batch = {
            .sampling = request.sampling, .count = samples, .detail = request.detail};
        verdicts = g_renew(struct verdict, verdicts, samples);
        batch_evaluate(scenario, model, request.box, &batch, 1, verdicts);
        search_complete(search, verdicts);
        measurement->samples += samples;
        now_ns = clock_monotonic_ns();
    }
    measurement->spent_ns += now_ns - start_ns;
    g_free(verdicts);
    search_free(search);
    model_free(model);
}

static void print_estimate(const struct plan *plan, const struct measurement *measurement,
                           int threads, FILE *out)
{
    const double sample_s =
        (double)measurement->spent_ns / CLOCK_SECOND_NS / (double)measurement->samples;
    const double total_s = sample_s * (double)plan->samples + STEP_S * (double)plan->steps;
    char duration[32], about[48] = "less than a second";
    if (total_s / threads >= 1)
        snprintf(about, sizeof about, "about %s", progress_duration(total_s / threads, duration));
    fprintf(out,
            "\n%" PRIu32 " search%s of %" PRIu64 " designs in all, %.2f us each with their part of "
            "the search:\n%s on %d core%s of this machine\n",
            plan->searches, plan->searches == 1 ? "" : "es", plan->samples, sample_s * 1e6, about,
            threads, threads == 1 ? "" : "s");
}

// Whether the case is one of the few to be tried.
static bool to_be_probed(uint32_t place, uint32_t count)
{
    return place == 0 || place == count / 2 || place == count - 1;
}

enum status preview_print(const struct sweep *sweep, const struct run_choice *choice, int threads,
                          FILE *out, struct error *error)
{
    struct run_cases cases;
    run_cases_init(&cases, sweep, choice);
    GArray *chosen = g_array_new(FALSE, FALSE, sizeof(uint32_t));
    struct plan plan = {0};
    uint32_t index;
    struct scenario scenario;
    enum status status;
    while ((status = run_cases_next(&cases, &index, &scenario, error)) == STATUS_OK &&
           index != UINT32_MAX) {
        char name[SWEEP_CASE_NAME_SIZE];
        fprintf(out, "%s\n", sweep_case_name(sweep, index, name));
        plan_add(&plan, &scenario);
        g_array_append_val(chosen, index);
        scenario_fini(&scenario);
    }
    if (status == STATUS_OK)
        status = run_cases_check(&cases, error);
    struct measurement measurement = {0};
    for (guint i = 0; i < chosen->len && status == STATUS_OK; i++) {
        if (!to_be_probed(i, chosen->len))
            continue;
        status = sweep_scenario(sweep, g_array_index(chosen, uint32_t, i), &scenario, error);
        if (status != STATUS_OK)
            break;
        probe(&scenario, &measurement);
        scenario_fini(&scenario);
    }
    if (status == STATUS_OK)
        print_estimate(&plan, &measurement, threads, out);
    g_array_unref(chosen);
    if (status == STATUS_OK && (fflush(out) != 0 || ferror(out)))
        status = error_set(error, STATUS_IO, "the cases could not be printed");
    return status;
}
