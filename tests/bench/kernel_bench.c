// How fast one core evaluates designs, for problems of several sizes on every path the machine has,
// and how much of its fused multiply-add peak that is. Prints CSV.
//
//     kernel_bench                              measures
//     kernel_bench only CASE [PATH]             measures one case, for instance 5x3@1ms
//     kernel_bench count PAIRS POINTS DESIGNS   only evaluates so many designs, for
//     kernel_instructions
//
//     case,path,us_per_design,designs_per_s,gflops,share_of_fma_peak
//
// `case` is spring pairs x points of a curve @ time step, with `-events` for event Verlet, else
// central difference. Floating-point operations are counted as the kernel does them, a fused
// multiply-add as two, a division as one, comparisons and choices not; of event Verlet what central
// difference does. `-lean` leaves the springs' work out. Steps of free flight, which the kernel
// skips, count as if it took them, and so does the work.
#include "worker/kinematics/kinematics.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BENCH_DESIGNS = 64, BENCH_ROUNDS = 25 };

static const double bench_least_s = 0.005; // [s] a round lasts at least this: the clock is finer

// The processor time of this thread [s]: what others do on the machine does not count.
static double bench_clock(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

struct bench_case {
    uint32_t pairs;
    uint32_t points;
    double time_step; // [s]
    enum kinematics_integrator integrator;
    bool without_work;
};

// A sedan; springs from the wheel inwards, all struck by the barrier at first.
static struct kinematics_problem *bench_problem(const struct bench_case *bench)
{
    double deformation[32];
    for (uint32_t i = 0; i < bench->points; i++) {
        deformation[i] = 1.2 * i / (bench->points - 1);
    }
    struct kinematics_spring springs[KINEMATICS_SPRING_MAX];
    for (uint32_t i = 0; i < bench->pairs; i++) {
        const double inwards = bench->pairs > 1 ? (double)i / (bench->pairs - 1) : 0.0;
        springs[i] = (struct kinematics_spring){
            .position = {-0.83, -0.85 + 0.35 * inwards},
            .length = 1.25,
            .load = {deformation, bench->points},
        };
    }
    const struct kinematics_setup setup = {
        .mass = 1650.0,
        .yaw_inertia = 3000.0,
        .speed = 17.889,
        .face_x = -2.08,
        .edge_y = -0.455,
        .width = 1.15,
        .springs = springs,
        .spring_count = bench->pairs,
        .duration = 0.150,
        .time_step = bench->time_step,
        .integrator = bench->integrator,
        .reloading = bench->integrator == KINEMATICS_EVENT_VERLET ? KINEMATICS_RELOADING_CRUSHED
                                                                  : KINEMATICS_RELOADING_THESIS,
        .omitted = {.energies = bench->without_work, .deformations = true},
    };
    return kinematics_create(&setup);
}

// Operations of one design: setting up the coefficients, and the steps.
static double bench_flops(const struct bench_case *bench)
{
    const double steps = 0.150 / bench->time_step + 1.0;
    const double shared = 30 /* sine, cosine */ + 5 /* pose */ + 7 /* forces */ + 22 /* motion */ +
                          6 /* way */ + 2 /* observed */;
    const double spring =
        5 /* place */ + 2 * (2.0 * bench->points - 2.0) /* curve */ + 6 /* sums */ + 8 /* work */;
    return steps * (shared + bench->pairs * spring) + bench->pairs * bench->points * 2 * 5.0;
}

// Forces between nothing and the level of a sedan; any fixed sequence will do.
static void bench_fill(double *values, uint32_t value_count, uint32_t pairs)
{
    uint64_t state = 1;
    for (uint32_t i = 0; i < value_count * BENCH_DESIGNS; i++) {
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        values[i] = 450e3 / pairs * ((double)(state >> 11) * 0x1p-53);
    }
}

// Seconds a design takes: the best of some rounds.
static double bench_time(const struct kinematics_problem *problem, enum kinematics_path path,
                         const double *values, double *results)
{
    double best = G_MAXDOUBLE;
    for (int round = 0; round < BENCH_ROUNDS; round++) {
        uint64_t designs = 0;
        const double start = bench_clock();
        double elapsed;
        do {
            kinematics_evaluate_on(path, problem, BENCH_DESIGNS, values, results, BENCH_DESIGNS);
            designs += BENCH_DESIGNS;
            elapsed = bench_clock() - start;
        } while (elapsed < bench_least_s);
        best = MIN(best, elapsed / (double)designs);
    }
    return best;
}

#ifdef __x86_64__
#include <immintrin.h>

// Enough independent chains to hide the latency of two units: 16 x 8 lanes x 2 operations a turn.
__attribute__((target("avx512f"))) static double peak_turns_avx512(uint64_t turns)
{
    __m512d sum[16];
    for (int i = 0; i < 16; i++) {
        sum[i] = _mm512_set1_pd(i);
    }
    const __m512d a = _mm512_set1_pd(0.999);
    for (uint64_t turn = 0; turn < turns; turn++) {
#pragma GCC unroll 16
        for (int i = 0; i < 16; i++) {
            sum[i] = _mm512_fmadd_pd(sum[i], a, a);
        }
    }
    double total = 0.0;
    for (int i = 0; i < 16; i++) {
        total += _mm512_reduce_add_pd(sum[i]);
    }
    return total;
}

__attribute__((target("avx2,fma"))) static double peak_turns_avx2(uint64_t turns)
{
    __m256d sum[12];
    for (int i = 0; i < 12; i++) {
        sum[i] = _mm256_set1_pd(i);
    }
    const __m256d a = _mm256_set1_pd(0.999);
    for (uint64_t turn = 0; turn < turns; turn++) {
#pragma GCC unroll 12
        for (int i = 0; i < 12; i++) {
            sum[i] = _mm256_fmadd_pd(sum[i], a, a);
        }
    }
    double total = 0.0;
    for (int i = 0; i < 12; i++) {
        total += sum[i][0];
    }
    return total;
}

// The greatest rate of fused multiply-adds of one core [flop/s].
static double bench_peak(void)
{
    const bool wide = kinematics_path_supported(KINEMATICS_PATH_AVX512);
    if (!wide && !kinematics_path_supported(KINEMATICS_PATH_AVX2)) {
        return 0.0;
    }
    const uint64_t turns = 200000;
    const double flops = wide ? 16.0 * 8 * 2 : 12.0 * 4 * 2;
    double best = 0.0;
    volatile double keep;
    for (int round = 0; round < BENCH_ROUNDS; round++) {
        const double start = bench_clock();
        keep = wide ? peak_turns_avx512(turns) : peak_turns_avx2(turns);
        const double elapsed = bench_clock() - start;
        best = MAX(best, flops * (double)turns / elapsed);
    }
    (void)keep;
    return best;
}
#else
static double bench_peak(void)
{
    return 0.0; // not known here: the share prints as inf
}
#endif

// What to measure; NULL: all.
struct bench_wanted {
    const char *name;
    const char *path;
};

// Prints a row for each path.
static void bench_run(const struct bench_case *bench, const struct bench_wanted *wanted,
                      double peak)
{
    g_autofree char *name =
        g_strdup_printf("%ux%u@%gms%s%s", bench->pairs, bench->points, 1e3 * bench->time_step,
                        bench->integrator == KINEMATICS_EVENT_VERLET ? "-events" : "",
                        bench->without_work ? "-lean" : "");
    if (wanted->name != NULL && strcmp(wanted->name, name) != 0) {
        return;
    }
    struct kinematics_problem *problem = bench_problem(bench);
    const uint32_t value_count = kinematics_value_count(problem);
    double *values = g_new(double, (size_t)value_count *BENCH_DESIGNS);
    double *results = g_new(double, (size_t)kinematics_result_count(problem) * BENCH_DESIGNS);
    bench_fill(values, value_count, bench->pairs);
    for (int path = 0; path < KINEMATICS_PATH_COUNT; path++) {
        const char *path_name = kinematics_path_name((enum kinematics_path)path);
        if (!kinematics_path_supported((enum kinematics_path)path) ||
            (wanted->path != NULL && strcmp(wanted->path, path_name) != 0)) {
            continue;
        }
        const double time = bench_time(problem, (enum kinematics_path)path, values, results);
        const double rate = bench_flops(bench) / time;
        printf("%s,%s,%.3f,%.0f,%.2f,%.3f\n", name, path_name, 1e6 * time, 1.0 / time, 1e-9 * rate,
               rate / peak);
        fflush(stdout);
    }
    g_free(values);
    g_free(results);
    kinematics_free(problem);
}

// Evaluates designs for somebody who counts the instructions.
static int bench_count(char **arguments)
{
    const struct bench_case bench = {
        .pairs = (uint32_t)strtoul(arguments[0], NULL, 10),
        .points = (uint32_t)strtoul(arguments[1], NULL, 10),
        .time_step = 1e-3,
    };
    const uint32_t designs = (uint32_t)strtoul(arguments[2], NULL, 10);
    struct kinematics_problem *problem = bench_problem(&bench);
    const uint32_t value_count = kinematics_value_count(problem);
    double *values = g_new(double, (size_t)value_count *BENCH_DESIGNS);
    double *results = g_new(double, (size_t)kinematics_result_count(problem) * BENCH_DESIGNS);
    bench_fill(values, value_count, bench.pairs);
    for (uint32_t done = 0; done < designs; done += BENCH_DESIGNS) {
        kinematics_evaluate(problem, BENCH_DESIGNS, values, results, BENCH_DESIGNS);
    }
    g_free(values);
    g_free(results);
    kinematics_free(problem);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 5 && strcmp(argv[1], "count") == 0) {
        return bench_count(argv + 2);
    }
    const bool only = argc >= 3 && argc <= 4 && strcmp(argv[1], "only") == 0;
    if (argc != 1 && !only) {
        fprintf(stderr, "expected: kernel_bench [only CASE [PATH] | count PAIRS POINTS DESIGNS]\n");
        return 2;
    }
    const struct bench_wanted wanted = {only ? argv[2] : NULL, only ? argv[3] : NULL};
    static const uint32_t sizes[][2] = {{1, 9}, {5, 3}, {9, 3}, {40, 3}}; // pairs, points
    static const struct bench_case ways[] = {
        {.time_step = 1e-3},
        {.time_step = 1e-4},
        {.time_step = 1e-3, .without_work = true},
        {.time_step = 1e-3, .integrator = KINEMATICS_EVENT_VERLET},
        {.time_step = 1e-3, .integrator = KINEMATICS_EVENT_VERLET, .without_work = true},
    };
    const double peak = bench_peak();
    printf("# fma peak of one core: %.1f GFLOP/s\n", 1e-9 * peak);
    printf("case,path,us_per_design,designs_per_s,gflops,share_of_fma_peak\n");
    for (size_t way = 0; way < G_N_ELEMENTS(ways); way++) {
        for (size_t size = 0; size < G_N_ELEMENTS(sizes); size++) {
            struct bench_case bench = ways[way];
            bench.pairs = sizes[size][0];
            bench.points = sizes[size][1];
            bench_run(&bench, &wanted, peak);
        }
    }
    return 0;
}
