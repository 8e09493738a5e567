// What a worker spends on a design beside the kernel: making the sample and holding its outcomes
// against the constraints. The same designs of a shipped design space go through the bare kernel
// and through batch_evaluate(), on one core, round by round in turn. Prints CSV.
//
//     worker_bench [ROUNDS]    default 40
//
//     scenario,integrator,samples,kernel_us,worker_us,extra
//
// `samples` is the size of the batch, times are those of a design, the best of all rounds in the
// processor time of this thread. `extra` is worker over kernel less 1, the median over the rounds
// of what the two took one after the other: a busy machine slows both.
#include "common/scenario/scenario_read.h"
#include "worker/batch/batch.h"
#include "worker/models/small_overlap.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BENCH_SAMPLES_MAX = 4000 };

// The processor time of this thread [s].
static double bench_clock(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

struct bench {
    struct scenario scenario;
    struct model *model;
    struct kinematics_problem *problem; // that of the model
    struct batch batch;
    double *values;   // (blocks x variables x MODEL_BLOCK) the batch's designs
    double *outcomes; // (outcomes x MODEL_BLOCK)
    struct verdict *verdicts;
};

static void bench_init(struct bench *bench, const char *name, const char *integrator,
                       uint32_t samples)
{
    g_autofree char *path = g_strdup_printf(SOBOX_SOURCE_DIR "/deploy/scenarios/%s.yaml", name);
    // The rule of reloading for which the kernel has a variant with this integrator.
    g_autofree char *chosen =
        g_strdup_printf("simulation={integrator: %s, reloading: %s}", integrator,
                        strcmp(integrator, "central_difference") == 0 ? "thesis" : "crushed");
    struct error error = {0};
    if (scenario_read_file(&bench->scenario, path, (const char *const *)&chosen, 1, &error) !=
        STATUS_OK) {
        fprintf(stderr, "%s\n", error.text);
        exit(EXIT_FAILURE);
    }
    bench->model = model_create(&bench->scenario);
    bench->problem =
        small_overlap_problem(&bench->scenario, NULL,
                              (struct kinematics_omitted){.energies = true, .deformations = true});
    bench->batch = (struct batch){
        .sampling = {.seed = 1, .step = 1, .samples = samples},
        .count = samples,
    };
    const uint32_t variables = model_variable_count(bench->model);
    const size_t blocks = (samples - 1) / MODEL_BLOCK + 1;
    bench->values = g_new(double, blocks *variables *MODEL_BLOCK);
    bench->outcomes = g_new(double, (size_t)model_outcome_count(bench->model) * MODEL_BLOCK);
    bench->verdicts = g_new(struct verdict, samples);
    for (uint32_t first = 0; first < samples; first += MODEL_BLOCK) {
        sampling_fill(&bench->batch.sampling, &bench->scenario.design_space, first,
                      MIN(samples - first, (uint32_t)MODEL_BLOCK),
                      bench->values + (size_t)first * variables, MODEL_BLOCK);
    }
}

static void bench_fini(struct bench *bench)
{
    g_free(bench->verdicts);
    g_free(bench->outcomes);
    g_free(bench->values);
    kinematics_free(bench->problem);
    model_free(bench->model);
    scenario_fini(&bench->scenario);
}

static void bench_kernel(const struct bench *bench)
{
    const uint32_t variables = model_variable_count(bench->model);
    const uint32_t samples = bench->batch.count;
    for (uint32_t first = 0; first < samples; first += MODEL_BLOCK) {
        kinematics_evaluate(bench->problem, MIN(samples - first, (uint32_t)MODEL_BLOCK),
                            bench->values + (size_t)first * variables, bench->outcomes,
                            MODEL_BLOCK);
    }
}

static void bench_worker(const struct bench *bench)
{
    batch_evaluate(&bench->scenario, bench->model, &bench->scenario.design_space, &bench->batch, 1,
                   bench->verdicts);
}

// Seconds a design takes on the way given.
static double bench_time(const struct bench *bench, void (*way)(const struct bench *))
{
    const uint32_t turns = BENCH_SAMPLES_MAX / bench->batch.count;
    const double start = bench_clock();
    for (uint32_t turn = 0; turn < turns; turn++) {
        way(bench);
    }
    return (bench_clock() - start) / ((double)turns * bench->batch.count);
}

static int compare_numbers(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double other = *(const double *)b;
    return (one > other) - (one < other);
}

static void bench_run(const char *name, const char *integrator, uint32_t samples, uint32_t rounds)
{
    struct bench bench;
    bench_init(&bench, name, integrator, samples);
    double best[2] = {G_MAXDOUBLE, G_MAXDOUBLE};
    g_autofree double *extra = g_new(double, rounds);
    for (uint32_t round = 0; round < rounds; round++) {
        const double kernel = bench_time(&bench, bench_kernel);
        const double worker = bench_time(&bench, bench_worker);
        best[0] = MIN(best[0], kernel);
        best[1] = MIN(best[1], worker);
        extra[round] = worker / kernel - 1.0;
    }
    qsort(extra, rounds, sizeof *extra, compare_numbers);
    printf("%s,%s,%u,%.3f,%.3f,%.3f\n", name, integrator, samples, 1e6 * best[0], 1e6 * best[1],
           extra[rounds / 2]);
    fflush(stdout);
    bench_fini(&bench);
}

int main(int argc, char **argv)
{
    const uint32_t rounds = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 40;
    if (rounds == 0 || argc > 2) {
        fprintf(stderr, "expected: worker_bench [ROUNDS]\n");
        return 2;
    }
    static const char *const names[] = {"sedan-two-springs", "sedan-ten-springs"};
    static const char *const integrators[] = {"central_difference", "event_verlet"};
    static const uint32_t samples[] = {200, BENCH_SAMPLES_MAX};
    printf("scenario,integrator,samples,kernel_us,worker_us,extra\n");
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        for (size_t j = 0; j < G_N_ELEMENTS(integrators); j++) {
            for (size_t k = 0; k < G_N_ELEMENTS(samples); k++) {
                bench_run(names[i], integrators[j], samples[k], rounds);
            }
        }
    }
    return 0;
}
