#include "tests/cluster/problem.h"

#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"
#include "worker/batch/batch.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>

// One spring, few points, long time steps: a sample takes a microsecond. The searches differ in
// steps, samples and response, so that they end at different times and their batches in different
// sizes.
static const char problem_text[] = "name: storm\n"
                                   "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                                   "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                                   "springs:\n"
                                   "  - name: front\n"
                                   "    position: [-0.83, -0.75]\n"
                                   "    deformation: [0.0, 0.6, 1.2]\n"
                                   "    force_x: {lower: 0, upper: 450e3}\n"
                                   "    force_y: {lower: 0, upper: 250e3}\n"
                                   "simulation: {time_step: 5e-3}\n"
                                   "firewall_distance: 0.25\n"
                                   "search:\n"
                                   "  exploration_steps: 3\n"
                                   "  consolidation_steps: 2\n"
                                   "  promise: points\n"
                                   "  target_purity: 0.5\n";

static const char *const problem_overrides[PROBLEM_SEARCHES][4] = {
    {"search.samples=48", "search.certificate_samples=300", "response=any", "search.seed=1"},
    {"search.samples=100", "search.certificate_samples=100", "response=rotating", "search.seed=2"},
    {"search.samples=32", "search.certificate_samples=1000", "response=any", "search.seed=3"},
    {"search.samples=300", "search.certificate_samples=40", "response=any", "search.seed=4"},
};

// What comes back over the network is what was packed: shares lose constraint and violation.
static void verdicts_travel(struct verdict *verdicts, const struct search_request *request,
                            uint32_t constraint_count)
{
    uint32_t count = request->sampling.samples;
    uint8_t *packed = g_malloc(verdict_packed_size_max(count, request->detail));
    size_t size = verdict_pack(verdicts, count, request->detail, packed);
    bool whole = verdict_unpack(verdicts, count, request->detail, constraint_count, packed, size);
    g_assert_true(whole);
    g_free(packed);
}

// The whole search without a cluster.
static void problem_calm(struct problem *problem, uint32_t index)
{
    const struct scenario *scenario = &problem->scenarios[index];
    struct model *model = model_create(scenario);
    struct search *search = search_create(scenario, scenario->search.seed, 1);
    struct search_request request;
    while (search_request(search, &request)) {
        uint32_t count = request.sampling.samples;
        struct verdict *verdicts = g_new(struct verdict, count);
        struct batch batch = {
            .sampling = request.sampling, .first = 0, .count = count, .detail = request.detail};
        batch_evaluate(scenario, model, request.box, &batch, 1, verdicts);
        verdicts_travel(verdicts, &request, scenario->constraint_count);
        problem->samples[index] += count;
        search_complete(search, verdicts);
        g_free(verdicts);
    }
    struct search_result result;
    search_result(search, &result);
    problem->digests[index] = result.digest;
    search_free(search);
    model_free(model);
}

void problem_init(struct problem *problem)
{
    *problem = (struct problem){0};
    for (uint32_t i = 0; i < PROBLEM_SEARCHES; i++) {
        struct error error;
        enum status status = scenario_read_text(&problem->scenarios[i], "storm.yaml", problem_text,
                                                sizeof problem_text - 1, problem_overrides[i],
                                                G_N_ELEMENTS(problem_overrides[i]), &error);
        if (status != STATUS_OK) {
            fprintf(stderr, "%s\n", error.text);
            exit(EXIT_FAILURE);
        }
        problem_calm(problem, i);
    }
}

void problem_fini(struct problem *problem)
{
    for (uint32_t i = 0; i < PROBLEM_SEARCHES; i++)
        scenario_fini(&problem->scenarios[i]);
}
