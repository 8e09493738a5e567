// The engine alone: jobs of two scenarios and all sizes go in, and each must come out once with the
// verdicts, or outcomes of given designs, that one thread gives, however many threads cut them up.
#include "worker/runtime/engine.h"

#include "common/base/clock.h"
#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { MODELS = 2, DESIGNS = 1000, VARIABLES_MAX = 8 };

static const char crash[] = "name: engine\n"
                            "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                            "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                            "springs:\n"
                            "  - name: front\n"
                            "    position: [-0.83, -0.75]\n"
                            "    deformation: [0.0, 0.6, 1.2]\n"
                            "    force_x: {lower: 0, upper: [80e3, 450e3, 450e3]}\n"
                            "    force_y: {lower: 0, upper: 250e3}\n"
                            "response: any\n"
                            "firewall_distance: 0.25\n";

// Far cheaper a sample, and with fewer variables: threads must fit their room to either.
static const char sphere[] = "name: engine\n"
                             "model: hypersphere\n"

                             "variables:\n"
                             "  - {name: a, lower: -1, upper: 1}\n"
                             "  - {name: b, lower: -1, upper: 1}\n"
                             "constraints: {distance: {max: 0}}\n";

struct bench {
    struct scenario scenarios[MODELS];
    struct model *models[MODELS];
    struct engine *engine;
    double designs[DESIGNS * VARIABLES_MAX];
};

static int setup(void **state)
{
    static const char *const texts[MODELS] = {crash, sphere};
    struct bench *bench = g_new0(struct bench, 1);
    for (int i = 0; i < MODELS; i++) {
        struct error error;
        assert_int_equal(scenario_read_text(&bench->scenarios[i], "engine", texts[i],
                                            strlen(texts[i]), NULL, 0, &error),
                         STATUS_OK);
        bench->models[i] = model_create(&bench->scenarios[i]);
        assert_true(model_variable_count(bench->models[i]) <= VARIABLES_MAX);
    }
    for (size_t i = 0; i < G_N_ELEMENTS(bench->designs); i++)
        bench->designs[i] = (double)(i % 997) * 100;
    *state = bench;
    return 0;
}

static int teardown(void **state)
{
    struct bench *bench = *state;
    engine_free(bench->engine);
    for (int i = 0; i < MODELS; i++) {
        model_free(bench->models[i]);
        scenario_fini(&bench->scenarios[i]);
    }
    g_free(bench);
    return 0;
}

static void start(struct bench *bench, int threads)
{
    struct error error;
    assert_int_equal(engine_create(&bench->engine, threads, 0, &error), STATUS_OK);
}

// Job `index` of a mixture: sizes from one sample to many blocks, full verdicts and shares.
static struct engine_job *make_job(const struct bench *bench, uint32_t index)
{
    static const uint32_t counts[] = {1, 7, 8, 64, 65, 200, 400, DESIGNS};
    const int which = index % 3 == 0;
    struct engine_job *job = g_new0(struct engine_job, 1);
    job->work = (struct intake_work){
        .batch = {.identity = {.step = 2,
                               .batch = index,
                               .first = index * 1000,
                               .count = counts[index % G_N_ELEMENTS(counts)]},
                  .sampling = {.seed = 5, .step = 2, .samples = 1 << 20},
                  .detail = index % 5 == 0 ? VERDICT_DETAIL_SHARE : VERDICT_DETAIL_FULL},
        .scenario = &bench->scenarios[which],
        .model = bench->models[which],
        .box = &bench->scenarios[which].design_space,
    };
    if (index % 7 == 3)
        job->work.batch.designs = bench->designs;
    return job;
}

static void assert_outcomes_right(const struct engine_job *job)
{
    const struct model *model = job->work.model;
    const uint32_t count = job->work.batch.identity.count;
    const size_t outcome_count = (size_t)count * model_outcome_count(model);
    double *outcomes = g_new(double, outcome_count);
    struct batch_scratch scratch = {0};
    batch_evaluate_designs(model, job->work.batch.designs, count, &scratch, outcomes);
    batch_scratch_fini(&scratch);
    assert_int_equal(job->outcome_count, outcome_count);
    assert_memory_equal(job->outcomes, outcomes, outcome_count * sizeof(double));
    g_free(outcomes);
}

static void assert_job_right(const struct engine_job *job)
{
    if (job->work.batch.designs != NULL) {
        assert_outcomes_right(job);
        return;
    }
    const struct intake_work *work = &job->work;
    const struct batch batch = intake_samples(&work->batch);
    struct verdict *verdicts = g_new(struct verdict, batch.count);
    const uint32_t non_finite =
        batch_evaluate(work->scenario, work->model, work->box, &batch, 1, verdicts);
    uint8_t *packed = g_malloc(verdict_packed_size_max(batch.count, work->batch.detail));
    const size_t size = verdict_pack(verdicts, batch.count, work->batch.detail, packed);
    assert_int_equal(job->non_finite, non_finite);
    assert_int_equal(job->packed_size, size);
    assert_memory_equal(job->packed, packed, size);
    g_free(packed);
    g_free(verdicts);
}

static struct engine_job *wait_for_result(struct engine *engine)
{
    struct engine_job *job;
    while ((job = engine_collect(engine)) == NULL) {
        struct pollfd result = {.fd = engine_descriptor(engine), .events = POLLIN};
        assert_int_equal(poll(&result, 1, 60000), 1);
        engine_acknowledge(engine);
    }
    return job;
}

// Submits `count` jobs, at most `window` of them at once, and holds each against one thread.
static void assert_jobs_right(struct bench *bench, uint32_t count, uint32_t window)
{
    bool *seen = g_new0(bool, count);
    uint32_t submitted = 0;
    for (uint32_t collected = 0; collected < count; collected++) {
        while (submitted < count && submitted - collected < window)
            engine_submit(bench->engine, make_job(bench, submitted++));
        struct engine_job *job = wait_for_result(bench->engine);
        assert_false(seen[job->work.batch.identity.batch]);
        seen[job->work.batch.identity.batch] = true;
        assert_job_right(job);
        engine_job_free(job);
    }
    g_free(seen);
}

static void jobs_come_back_once_with_the_verdicts_of_one_thread(void **state)
{
    struct bench *bench = *state;
    start(bench, 4);
    assert_jobs_right(bench, 300, 20);
}

// More threads than the machine has cores, so that they are put aside anywhere.
static void many_threads_share_many_jobs(void **state)
{
    struct bench *bench = *state;
    start(bench, 32);
    assert_jobs_right(bench, 300, 300);
}

// Every job finds the threads asleep and must wake them.
static void one_job_at_a_time_wakes_the_threads(void **state)
{
    struct bench *bench = *state;
    start(bench, 8);
    assert_jobs_right(bench, 100, 1);
}

static void one_thread_does_all_alone(void **state)
{
    struct bench *bench = *state;
    start(bench, 1);
    assert_jobs_right(bench, 60, 10);
}

// The time that jobs are said to have taken is what the coordinator measures the worker by. Jobs
// that overlap must not count twice: all of them together took no longer than the clock on the
// wall, however many threads worked on however many jobs at once.
static void service_times_add_up_to_less_than_passed(void **state)
{
    struct bench *bench = *state;
    start(bench, 4);
    const int64_t start_ns = clock_monotonic_ns();
    for (uint32_t i = 0; i < 100; i++)
        engine_submit(bench->engine, make_job(bench, i));
    int64_t service_ns = 0;
    for (uint32_t i = 0; i < 100; i++) {
        struct engine_job *job = wait_for_result(bench->engine);
        assert_true(job->service_ns >= 0);
        service_ns += job->service_ns;
        engine_job_free(job);
    }
    assert_true(service_ns <= clock_monotonic_ns() - start_ns);
}

// A worker that leaves finishes what it began and nothing else; what comes back is whole.
static void stopped_engine_gives_only_whole_jobs(void **state)
{
    struct bench *bench = *state;
    start(bench, 4);
    for (uint32_t i = 0; i < 300; i++)
        engine_submit(bench->engine, make_job(bench, i));
    struct engine_job *first = wait_for_result(bench->engine);
    engine_stop(bench->engine);
    engine_stop(bench->engine);
    assert_job_right(first);
    engine_job_free(first);
    struct engine_job *job;
    while ((job = engine_collect(bench->engine)) != NULL) {
        assert_job_right(job);
        engine_job_free(job);
    }
}

static void engine_without_jobs_ends(void **state)
{
    struct bench *bench = *state;
    start(bench, 16);
    assert_null(engine_collect(bench->engine));
}

int main(void)
{
#define CLAIM(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
    const struct CMUnitTest tests[] = {
        CLAIM(jobs_come_back_once_with_the_verdicts_of_one_thread),
        CLAIM(many_threads_share_many_jobs),
        CLAIM(one_job_at_a_time_wakes_the_threads),
        CLAIM(one_thread_does_all_alone),
        CLAIM(service_times_add_up_to_less_than_passed),
        CLAIM(stopped_engine_gives_only_whole_jobs),
        CLAIM(engine_without_jobs_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
