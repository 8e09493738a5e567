// What the cluster costs beside the computing: a bare coordinator (the dispatcher and the wire of
// the real one, no search and no journal) keeps two real workers of one thread each busy, and the
// real coordinator runs a search over the same two. Prints rows of CSV; tests/bench/cluster_bench
// runs it beside its peers and says what the columns mean.
//
//     cluster_rates PROGRAM_FOLDER SCENARIO_FOLDER [step | batches | bulk | share]
//
// The last argument takes one group of figures alone, as one does under a profiler. (Its processes
// are seen by perf record -g -a, or each by perf record -p.)
//
// Each figure is taken some rounds long; `best` is what the machine can do when others leave it
// alone, `median` what it did. Processor time is counted by the kernel a process, so other work on
// the machine disturbs it less than the clock on the wall.
#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/scenario/scenario_read.h"
#include "common/wire/codec.h"
#include "coordinator/runtime/dispatch_loop.h"
#include "worker/batch/batch.h"
#include "worker/batch/fingerprint.h"
#include "worker/runtime/worker.h"

#include <assert.h>
#include <glib.h>
#include <glib/gstdio.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define URL "udpm://239.255.76.67:7667?ttl=0"

enum {
    WORKERS = 2,
    ROUNDS = 7,
    KERNEL_BATCH = 400,
    KERNEL_DESIGNS = 64 * KERNEL_BATCH, // of a thread in a round: whole blocks, whole batches
    BOUNDS_MAX = 128, // twice the variables of any scenario here: the box goes with the batch
};

static const int64_t patience_ns = 20 * CLOCK_SECOND_NS; // for workers to come, for a step to end

// What a scenario is sampled with.
struct load {
    const char *scenario;   // file
    double share;           // of each variable's width in the design space, about its middle
    uint32_t samples;       // a step
    uint32_t batch_samples; // at most; 0: as the coordinator chooses
    uint32_t steps;         // a round
};

// One round, or one step where `steps` is 1.
struct round {
    double wall_s;
    double own_s;     // processor time of this process, LCM's thread included
    double workers_s; // of all workers
    uint64_t batches;
    uint64_t good; // samples
};

struct bench {
    const char *programs;
    pid_t workers[WORKERS];
    struct wire *wire;
    uint64_t run;
    struct digest fingerprint;
    // The load at hand.
    struct dispatch_loop *loop;
    struct scenario scenario;
    double bounds[BOUNDS_MAX];
    struct digest box;
    const struct load *load;
    uint32_t step;
    bool sampling; // the step is not done
    struct verdict *verdicts;
    struct verdict *unpacked;
};

static void give_up(const char *what)
{
    log_error("%s", what);
    exit(1);
}

static void expect_ok(enum status status, const struct error *error)
{
    if (status == STATUS_OK)
        return;
    log_failure(error);
    exit((int)status_exit(status));
}

// ---- Time ----

static double seconds(clockid_t clock)
{
    struct timespec time;
    if (clock_gettime(clock, &time) != 0)
        give_up("a process has no processor time: it has ended");
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double process_s(pid_t process)
{
    clockid_t clock;
    if (clock_getcpuclockid(process, &clock) != 0)
        give_up("a process has no processor time: it has ended");
    return seconds(clock);
}

static double workers_s(const struct bench *bench)
{
    double sum = 0;
    for (int i = 0; i < WORKERS; i++)
        sum += process_s(bench->workers[i]);
    return sum;
}

static int by_value(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double two = *(const double *)b;
    return (one > two) - (one < two);
}

// ---- Printing ----

static double load_average(void)
{
    double load[1] = {0};
    return getloadavg(load, 1) == 1 ? load[0] : -1;
}

static void print(const char *figure, double best, double median, const char *unit,
                  const char *target)
{
    printf("%s,sobox,%.4g,%.4g,%s,%s,%.1f\n", figure, best, median, unit, target, load_average());
    fflush(stdout);
}

// Sorts the values; the best is the least of times and the greatest of rates.
static void print_all(const char *figure, double *values, size_t count, bool greater_is_better,
                      const char *unit, const char *target)
{
    qsort(values, count, sizeof *values, by_value);
    print(figure, values[greater_is_better ? count - 1 : 0], values[count / 2], unit, target);
}

// ---- A coordinator without search and journal ----

static void send_batch(void *user, uint64_t worker, const struct batch_identity *batch)
{
    struct bench *bench = user;
    const uint32_t variables = bench->scenario.design_space.count;
    sobox_sample_batch_t message = {
        .header.run = (int64_t)bench->run,
        .holder = (int64_t)worker,
        .seed = 1,
        .batch = codec_batch(batch),
        .step_samples = (int32_t)bench->load->samples,
        .sampling = SAMPLING_METHOD_UNIFORM,
        .detail = VERDICT_DETAIL_FULL,
        .variables = (int32_t)variables,
        .text_size = (int32_t)(2 * variables * sizeof *bench->bounds),
        .text = (uint8_t *)bench->bounds,
    };
    memcpy(message.scenario, bench->scenario.digest.bytes, DIGEST_SIZE);
    memcpy(message.box, bench->box.bytes, DIGEST_SIZE);
    (void)!wire_publish(bench->wire, WIRE_SAMPLE_BATCH, &message); // lost: the lease brings it back
}

static void count_batch(void *user, const struct batch_identity *batch)
{
    struct bench *bench = user;
    memcpy(bench->verdicts + batch->first, bench->unpacked, batch->count * sizeof *bench->verdicts);
}

static void step_sampled(void *user, uint32_t search, uint32_t step)
{
    (void)search;
    (void)step;
    ((struct bench *)user)->sampling = false;
}

static void heard_outcome(void *user, enum wire_kind kind, const void *received)
{
    (void)kind;
    struct bench *bench = user;
    const sobox_outcome_batch_t *message = received;
    if ((uint64_t)message->header.run != bench->run || !bench->sampling ||
        (uint32_t)message->batch.step != bench->step ||
        (uint32_t)message->batch.count > bench->load->samples ||
        !verdict_unpack(bench->unpacked, (uint32_t)message->batch.count, VERDICT_DETAIL_FULL,
                        bench->scenario.constraint_count, message->packed,
                        (size_t)message->packed_size))
        return;
    const struct batch_identity batch = codec_identity(&message->batch);
    dispatch_loop_outcome(bench->loop, (uint64_t)message->header.sender, &batch,
                          (uint32_t)message->queue, message->service_ns);
}

// Without it nothing would wake a main loop in which everybody waits for something lost.
static gboolean each_second(gpointer user)
{
    (void)user;
    return G_SOURCE_CONTINUE;
}

static void tell_workers(struct bench *bench)
{
    sobox_run_status_t message = {.header.run = (int64_t)bench->run, .name = "bench"};
    memcpy(message.fingerprint, bench->fingerprint.bytes, DIGEST_SIZE);
    (void)!wire_publish(bench->wire, WIRE_RUN_STATUS, &message);
}

static void turn(int64_t since_ns, const char *awaited)
{
    g_main_context_iteration(NULL, TRUE);
    if (clock_monotonic_ns() - since_ns > patience_ns)
        give_up(awaited);
}

// A dispatcher of its own for each load: what the last one taught about times does not fit the
// next. It subscribes for good, so it has a wire of its own too.
static void start_dispatcher(struct bench *bench)
{
    static const struct coordinator_settings coordinator = {.url = URL, .open = true};
    static const struct dispatch_loop_calls calls = {
        .send = send_batch, .count = count_batch, .finished = step_sampled};
    struct schedule_settings schedule = schedule_settings_default();
    if (bench->load->batch_samples > 0)
        schedule.batch_samples_max[VERDICT_DETAIL_FULL] = bench->load->batch_samples;
    struct wire_settings settings = wire_settings_default();
    settings.url = URL;
    struct error error = {0};
    bench->run++;
    expect_ok(wire_open(&bench->wire, &settings, bench->run, &error), &error);
    expect_ok(wire_subscribe(bench->wire, WIRE_OUTCOME_BATCH, heard_outcome, bench, &error),
              &error);
    expect_ok(dispatch_loop_create(&bench->loop, bench->wire, bench->run, &coordinator, &schedule,
                                   &calls, bench, &error),
              &error);
    text_server_offer(dispatch_loop_texts(bench->loop), &bench->scenario.digest,
                      bench->scenario.text, bench->scenario.text_size);
    tell_workers(bench);
    const int64_t start_ns = clock_monotonic_ns();
    struct schedule_counters counters;
    do {
        turn(start_ns, "the workers do not come");
        dispatch_loop_counters(bench->loop, &counters);
    } while (counters.workers < WORKERS);
}

static void start_load(struct bench *bench, const struct load *load, const char *folder)
{
    struct error error = {0};
    char *path = g_build_filename(folder, load->scenario, NULL);
    expect_ok(scenario_read_file(&bench->scenario, path, NULL, 0, &error), &error);
    g_free(path);
    const struct box *space = &bench->scenario.design_space;
    const uint32_t count = space->count;
    assert(2 * count <= BOUNDS_MAX);
    for (uint32_t i = 0; i < count; i++) {
        const double cut = (1 - load->share) / 2 * (space->upper[i] - space->lower[i]);
        bench->bounds[i] = space->lower[i] + cut;
        bench->bounds[count + i] = space->upper[i] - cut;
    }
    bench->box = digest_of(bench->bounds, 2 * (size_t)count * sizeof *bench->bounds);
    bench->load = load;
    bench->step = 0;
    bench->verdicts = g_new0(struct verdict, load->samples);
    bench->unpacked = g_new0(struct verdict, load->samples);
    start_dispatcher(bench);
}

static void end_load(struct bench *bench)
{
    dispatch_loop_free(bench->loop);
    wire_close(bench->wire);
    g_free(bench->verdicts);
    g_free(bench->unpacked);
    scenario_fini(&bench->scenario);
}

static void sample_step(struct bench *bench)
{
    const int64_t start_ns = clock_monotonic_ns();
    bench->sampling = true;
    bench->step++;
    dispatch_loop_step(bench->loop, 0, bench->step, bench->load->samples, VERDICT_DETAIL_FULL);
    while (bench->sampling)
        turn(start_ns, "a step does not end");
}

static struct round sample_round(struct bench *bench, uint32_t steps)
{
    struct schedule_counters before;
    dispatch_loop_counters(bench->loop, &before);
    const double wall = seconds(CLOCK_MONOTONIC);
    const double own = seconds(CLOCK_PROCESS_CPUTIME_ID);
    const double workers = workers_s(bench);
    struct round round = {0};
    for (uint32_t i = 0; i < steps; i++) {
        sample_step(bench);
        round.good += verdict_good_count(bench->verdicts, bench->load->samples);
    }
    struct schedule_counters after;
    dispatch_loop_counters(bench->loop, &after);
    round.batches = after.batches_counted - before.batches_counted;
    round.workers_s = workers_s(bench) - workers;
    round.own_s = seconds(CLOCK_PROCESS_CPUTIME_ID) - own;
    round.wall_s = seconds(CLOCK_MONOTONIC) - wall;
    return round;
}

// ---- What the cores can do without a cluster ----

// One thread a worker, at the workers' priority, all at once: what else goes on in the machine, and
// what the cores share, then slows them as it slows the workers.
struct kernel {
    const struct bench *bench;
    bool whole;   // from random numbers to packed verdicts; else the model alone
    double cpu_s; // processor time of a design
};

static double time_model(const struct model *model, const struct batch *batch,
                         const struct box *box)
{
    double *values = aligned_alloc(64, sizeof *values * box->count * MODEL_BLOCK);
    double *outcomes =
        aligned_alloc(64, sizeof *outcomes * model_outcome_count(model) * MODEL_BLOCK);
    assert(values != NULL && outcomes != NULL);
    sampling_fill(&batch->sampling, box, 0, MODEL_BLOCK, values, MODEL_BLOCK);
    const double start = seconds(CLOCK_THREAD_CPUTIME_ID);
    for (uint32_t i = 0; i < KERNEL_DESIGNS; i += MODEL_BLOCK)
        model_evaluate(model, MODEL_BLOCK, values, outcomes);
    const double cpu_s = seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    free(values);
    free(outcomes);
    return cpu_s;
}

// In batches as the coordinator cuts them.
static double time_batches(const struct bench *bench, const struct model *model,
                           struct batch *batch, const struct box *box)
{
    struct verdict verdicts[KERNEL_BATCH];
    uint8_t *packed = g_malloc(verdict_packed_size_max(KERNEL_BATCH, VERDICT_DETAIL_FULL));
    const double start = seconds(CLOCK_THREAD_CPUTIME_ID);
    for (; batch->first < KERNEL_DESIGNS; batch->first += KERNEL_BATCH) {
        batch_evaluate(&bench->scenario, model, box, batch, 1, verdicts);
        verdict_pack(verdicts, KERNEL_BATCH, VERDICT_DETAIL_FULL, packed);
    }
    const double cpu_s = seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    g_free(packed);
    return cpu_s;
}

static void *run_kernel(void *user)
{
    struct kernel *kernel = user;
    const struct bench *bench = kernel->bench;
    const uint32_t count = bench->scenario.design_space.count;
    const struct box box = {
        .count = count, .lower = (double *)bench->bounds, .upper = (double *)bench->bounds + count};
    struct batch batch = {.sampling = {.seed = 1, .step = 1, .samples = KERNEL_DESIGNS},
                          .count = KERNEL_BATCH};
    const id_t self = (id_t)gettid();
    setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + WORKER_PRIORITY_DEFAULT);
    struct model *model = model_create(&bench->scenario);
    kernel->cpu_s = (kernel->whole ? time_batches(bench, model, &batch, &box)
                                   : time_model(model, &batch, &box)) /
                    KERNEL_DESIGNS;
    model_free(model);
    return NULL;
}

// Processor time that a design takes on one core [s], mean of the threads.
static double time_kernels(const struct bench *bench, bool whole)
{
    struct kernel kernels[WORKERS];
    pthread_t threads[WORKERS];
    double sum_s = 0;
    for (int i = 0; i < WORKERS; i++) {
        kernels[i] = (struct kernel){.bench = bench, .whole = whole};
        if (pthread_create(&threads[i], NULL, run_kernel, &kernels[i]) != 0)
            give_up("no thread");
    }
    for (int i = 0; i < WORKERS; i++) {
        pthread_join(threads[i], NULL);
        sum_s += kernels[i].cpu_s;
    }
    return sum_s / WORKERS;
}

// ---- The figures ----

static void measure_step(struct bench *bench, const char *folder)
{
    const struct load load = {
        .scenario = "sedan-two-springs.yaml", .share = 1, .samples = 200, .steps = 2000};
    start_load(bench, &load, folder);
    sample_round(bench, 200); // until the dispatcher knows the workers
    double *wall = g_new(double, load.steps);
    double own = 0;
    double workers = 0;
    for (uint32_t i = 0; i < load.steps; i++) {
        const struct round round = sample_round(bench, 1);
        wall[i] = 1e6 * round.wall_s;
        own += 1e6 * round.own_s;
        workers += 1e6 * round.workers_s;
    }
    print_all("step_of_200", wall, load.steps, false, "us", "<= 500");
    print("step_of_200_cpu_coordinator", own / load.steps, own / load.steps, "us", "");
    print("step_of_200_cpu_workers", workers / load.steps, workers / load.steps, "us", "");
    g_free(wall);
    end_load(bench);
}

static void measure_batches(struct bench *bench, const char *folder)
{
    const struct load load = {
        .scenario = "benchmarks/hypersphere-10.yaml",
        .share = 0.8, // a quarter is bad, as in exploration
        .samples = 200 * 2000,
        .batch_samples = 200,
        .steps = 2,
    };
    start_load(bench, &load, folder);
    sample_round(bench, 1);
    double rate[ROUNDS];
    double room[ROUNDS];
    double own[ROUNDS];
    double workers[ROUNDS];
    double good = 0;
    for (int i = 0; i < ROUNDS; i++) {
        const struct round round = sample_round(bench, load.steps);
        const double batches = (double)round.batches;
        rate[i] = batches / round.wall_s;
        room[i] = WORKERS * batches / (round.own_s + round.workers_s);
        own[i] = 1e6 * round.own_s / batches;
        workers[i] = 1e6 * round.workers_s / batches;
        good = (double)round.good / ((double)load.samples * load.steps);
    }
    print_all("batches_of_200", rate, ROUNDS, true, "1/s", ">= 20000");
    print_all("batches_of_200_by_cpu", room, ROUNDS, true, "1/s", ">= 20000");
    print_all("batch_of_200_cpu_coordinator", own, ROUNDS, false, "us", "");
    print_all("batch_of_200_cpu_workers", workers, ROUNDS, false, "us", "");
    print("batch_of_200_good", good, good, "1", "");
    end_load(bench);
}

static void measure_bulk(struct bench *bench, const char *folder)
{
    const struct load load = {
        .scenario = "sedan-ten-springs.yaml", .share = 1, .samples = 20000, .steps = 8};
    enum { KERNEL, KERNEL_WHOLE, SAMPLE, EFFICIENCY, EFFICIENCY_CPU, WHOLE_CPU, OWN, COUNT };
    double figures[COUNT][ROUNDS];
    double good = 0;
    start_load(bench, &load, folder);
    sample_round(bench, 1);
    for (int i = 0; i < ROUNDS; i++) {
        const double model_s = time_kernels(bench, false);
        const struct round round = sample_round(bench, load.steps);
        const double whole_s = time_kernels(bench, true);
        const double samples = (double)load.samples * load.steps;
        figures[KERNEL][i] = 1e6 * model_s;
        figures[KERNEL_WHOLE][i] = 1e6 * whole_s;
        figures[SAMPLE][i] = 1e6 * round.wall_s / samples;
        figures[EFFICIENCY][i] = 100 * model_s * samples / (WORKERS * round.wall_s);
        figures[EFFICIENCY_CPU][i] = 100 * model_s * samples / round.workers_s;
        figures[WHOLE_CPU][i] = 100 * whole_s * samples / round.workers_s;
        figures[OWN][i] = 100 * round.own_s / round.workers_s;
        good = (double)round.good / samples;
    }
    print_all("bulk_sample", figures[SAMPLE], ROUNDS, false, "us", "");
    print_all("bulk_kernel", figures[KERNEL], ROUNDS, false, "us", "<= 1.0");
    print_all("bulk_kernel_to_verdict", figures[KERNEL_WHOLE], ROUNDS, false, "us", "");
    print_all("bulk_efficiency", figures[EFFICIENCY], ROUNDS, true, "%", ">= 95");
    print_all("bulk_efficiency_cpu", figures[EFFICIENCY_CPU], ROUNDS, true, "%", ">= 95");
    print_all("bulk_efficiency_to_verdict_cpu", figures[WHOLE_CPU], ROUNDS, true, "%", "");
    print_all("bulk_cpu_coordinator", figures[OWN], ROUNDS, false, "% of workers", "");
    print("bulk_good", good, good, "1", "");
    end_load(bench);
}

// ---- Programs ----

static pid_t start_program(const char *folder, const char *program, const char *const *arguments)
{
    GPtrArray *line = g_ptr_array_new_with_free_func(g_free);
    g_ptr_array_add(line, g_build_filename(folder, program, NULL));
    for (; *arguments != NULL; arguments++)
        g_ptr_array_add(line, g_strdup(*arguments));
    g_ptr_array_add(line, NULL);
    GError *reason = NULL;
    GPid process = 0;
    if (!g_spawn_async(NULL, (char **)line->pdata, NULL,
                       G_SPAWN_DO_NOT_REAP_CHILD | G_SPAWN_STDOUT_TO_DEV_NULL, NULL, NULL, &process,
                       &reason))
        give_up(reason->message);
    g_ptr_array_free(line, TRUE);
    return process;
}

// Processor time of a program and its exit status, without that of the programs it started.
static double end_program(pid_t process)
{
    siginfo_t ended;
    if (waitid(P_PID, (id_t)process, &ended, WEXITED | WNOWAIT) != 0)
        give_up("cannot wait for a program");
    const double used_s = process_s(process);
    waitpid(process, NULL, 0);
    if (ended.si_code != CLD_EXITED || ended.si_status != 0)
        give_up("a program failed");
    return used_s;
}

// The real coordinator, with search and journal. `settings` are given to --set.
static struct round search(struct bench *bench, const char *scenario, const char *const *settings)
{
    char *run = g_dir_make_tmp("cluster_rates-XXXXXX", NULL);
    GPtrArray *arguments = g_ptr_array_new();
    const char *const fixed[] = {scenario, "--quiet", "--url", URL, "--out", run, "--threads", "1"};
    for (size_t i = 0; i < G_N_ELEMENTS(fixed); i++)
        g_ptr_array_add(arguments, (void *)fixed[i]);
    for (; *settings != NULL; settings++) {
        g_ptr_array_add(arguments, (void *)"--set");
        g_ptr_array_add(arguments, (void *)*settings);
    }
    g_ptr_array_add(arguments, NULL);
    struct round round = {0};
    const double workers = workers_s(bench);
    const double wall = seconds(CLOCK_MONOTONIC);
    round.own_s = end_program(
        start_program(bench->programs, "sobox-coordinator", (const char *const *)arguments->pdata));
    round.wall_s = seconds(CLOCK_MONOTONIC) - wall;
    round.workers_s = workers_s(bench) - workers;
    g_ptr_array_free(arguments, TRUE);
    GDir *folder = g_dir_open(run, 0, NULL);
    for (const char *name; folder != NULL && (name = g_dir_read_name(folder)) != NULL;) {
        char *path = g_build_filename(run, name, NULL);
        g_unlink(path);
        g_free(path);
    }
    g_dir_close(folder);
    g_rmdir(run);
    g_free(run);
    return round;
}

static void measure_share(struct bench *bench, const char *folder)
{
    static const char *const settings[] = {"search.samples=20000", "search.exploration_steps=20",
                                           "search.consolidation_steps=20", NULL};
    static const struct {
        const char *figure;
        const char *scenario;
    } cases[] = {
        {"coordinator_share_ten_springs", "sedan-ten-springs.yaml"},
        {"coordinator_share_two_springs", "sedan-two-springs.yaml"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        char *path = g_build_filename(folder, cases[i].scenario, NULL);
        double share[3];
        for (size_t k = 0; k < G_N_ELEMENTS(share); k++) {
            const struct round round = search(bench, path, settings);
            share[k] = 100 * round.own_s / round.workers_s;
        }
        print_all(cases[i].figure, share, G_N_ELEMENTS(share), false, "% of workers", "<= 5");
        g_free(path);
    }
}

static bool wanted(const char *group, const char *name)
{
    return group == NULL || strcmp(group, name) == 0;
}

int main(int argc, char **argv)
{
    log_start("cluster_rates", LOG_NORMAL);
    if (argc != 3 && argc != 4) {
        log_error("usage: cluster_rates PROGRAM_FOLDER SCENARIO_FOLDER [GROUP]");
        return 2;
    }
    const char *const group = argc == 4 ? argv[3] : NULL;
    struct bench bench = {
        .programs = argv[1],
        .run = (uint64_t)clock_monotonic_ns() | 1,
        .fingerprint = fingerprint_compute(),
    };
    // Children first: LCM's own thread and descriptors are nothing for them to inherit.
    char parent[16];
    g_snprintf(parent, sizeof parent, "%d", getpid());
    const char *const arguments[] = {"--url",   URL,        "--threads", "1",
                                     "--quiet", "--parent", parent,      NULL};
    for (int i = 0; i < WORKERS; i++)
        bench.workers[i] = start_program(bench.programs, "sobox-worker", arguments);

    g_timeout_add_seconds(1, each_second, NULL);

    if (wanted(group, "step"))
        measure_step(&bench, argv[2]);
    if (wanted(group, "batches"))
        measure_batches(&bench, argv[2]);
    if (wanted(group, "bulk"))
        measure_bulk(&bench, argv[2]);
    if (wanted(group, "share"))
        measure_share(&bench, argv[2]);

    for (int i = 0; i < WORKERS; i++) {
        kill(bench.workers[i], SIGTERM);
        waitpid(bench.workers[i], NULL, 0);
    }
    return 0;
}
