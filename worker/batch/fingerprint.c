#include "worker/batch/fingerprint.h"

#include "common/scenario/scenario_read.h"
#include "worker/batch/batch.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A sedan with two springs. Its design space is wide enough that the samples stop early and late,
// turn in and slide off, so that every branch of the kernel leaves its bits in the digest.
static const char fingerprint_scenario[] =
    "name: fingerprint\n"
    "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
    "barrier: {face_x: -2.08, edge_y: -0.455, width: 1.15, overlap: 0.455}\n"
    "springs:\n"
    "  - name: front\n"
    "    position: [-0.83, -0.75]\n"
    "    deformation: [0.0, 0.3, 0.6, 0.9, 1.2]\n"
    "    force_x: {lower: 0, upper: [80e3, 450e3, 450e3, 450e3, 450e3]}\n"
    "    force_y: {lower: 0, upper: 250e3}\n"
    "  - name: inner\n"
    "    position: [-0.83, -0.50]\n"
    "    deformation: [0.0, 0.4, 0.8]\n"
    "    force_x: {lower: 0, upper: 200e3}\n"
    "    force_y: {lower: -50e3, upper: 50e3}\n"
    "response: rotating\n"
    "firewall_distance: 0.25\n"
    "constraints: {yaw_deg: {min: -20, max: 20}}\n";

// Those that searches use, the thesis's pair and the defaults; they have kernels of their own.
static const char *const fingerprint_integrators[] = {
    "simulation={integrator: central_difference, reloading: thesis}",
    "simulation={integrator: event_verlet, reloading: crushed}",
};

enum {
    FINGERPRINT_SAMPLES = 4 * MODEL_BLOCK + 7, // the last block is not full
    FINGERPRINT_FIRST = 3,                     // nor does the first one begin at 0
};

// Feeds every outcome of every sample, then the verdicts.
static void feed_samples(struct digest_state *state, const struct scenario *scenario,
                         const struct model *model, const struct sampling *sampling)
{
    const struct batch batch = {
        .sampling = *sampling, .first = FINGERPRINT_FIRST, .count = FINGERPRINT_SAMPLES};
    const struct box *box = &scenario->design_space;
    const uint32_t outcome_count = model_outcome_count(model);
    double *values = aligned_alloc(64, box->count * MODEL_BLOCK * sizeof *values);
    double *outcomes = aligned_alloc(64, outcome_count * MODEL_BLOCK * sizeof *outcomes);
    assert(values != NULL && outcomes != NULL);

    for (uint32_t done = 0; done < batch.count; done += MODEL_BLOCK) {
        uint32_t left = batch.count - done;
        uint32_t count = left < MODEL_BLOCK ? left : MODEL_BLOCK;
        sampling_fill(sampling, box, batch.first + done, count, values, MODEL_BLOCK);
        model_evaluate(model, count, values, outcomes);
        for (uint32_t outcome = 0; outcome < outcome_count; outcome++)
            digest_doubles(state, outcomes + outcome * MODEL_BLOCK, count);
    }
    free(outcomes);
    free(values);

    struct verdict verdicts[FINGERPRINT_SAMPLES];
    digest_u64(state, batch_evaluate(scenario, model, box, &batch, 1, verdicts));
    for (uint32_t i = 0; i < batch.count; i++)
        digest_u64(state, (uint64_t)verdicts[i].constraint << 16 | verdicts[i].violation);
}

// Feeds what the scenario gives with one integrator, by each way of drawing random samples.
static void feed_integrator(struct digest_state *state, const char *integrator)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_text(&scenario, "fingerprint", fingerprint_scenario,
                           strlen(fingerprint_scenario), &integrator, 1, &error) != STATUS_OK) {
        fprintf(stderr, "the built-in scenario is broken: %s\n", error.text);
        abort();
    }
    struct model *model = model_create(&scenario);
    struct sampling sampling = {.seed = UINT64_C(0x50B0C0DE5EED), .step = 2, .samples = 4096};
    static const enum sampling_method method[] = {SAMPLING_METHOD_UNIFORM,
                                                  SAMPLING_METHOD_LATIN_HYPERCUBE};
    for (size_t i = 0; i < sizeof method / sizeof method[0]; i++) {
        sampling.method = method[i];
        feed_samples(state, &scenario, model, &sampling);
    }
    model_free(model);
    scenario_fini(&scenario);
}

struct digest fingerprint_compute(void)
{
    struct digest_state state;
    digest_start(&state);
    digest_bytes(&state, SOBOX_VERSION, strlen(SOBOX_VERSION));
    const size_t count = sizeof fingerprint_integrators / sizeof fingerprint_integrators[0];
    for (size_t i = 0; i < count; i++)
        feed_integrator(&state, fingerprint_integrators[i]);
    return digest_end(&state);
}
