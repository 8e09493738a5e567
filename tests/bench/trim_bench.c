// How long a trim takes, by samples and variables: a box around a ball in which about a quarter of
// the samples are bad, as in exploration. Prints CSV: the median of the wall clock, and of the
// processor time, which other work on the machine disturbs less.
//
//     trim_bench [threads] [samples variables]...
#include "common/base/clock.h"
#include "common/numeric/random.h"
#include "coordinator/search/trim.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { REPEATS_MAX = 21 };

struct size {
    uint32_t samples;
    uint32_t variables;
};

static int64_t processor_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (int64_t)time.tv_sec * CLOCK_SECOND_NS + time.tv_nsec;
}

static int by_time(const void *a, const void *b)
{
    const int64_t one = *(const int64_t *)a;
    const int64_t two = *(const int64_t *)b;
    return (one > two) - (one < two);
}

static double median_ms(int64_t *times, int count)
{
    qsort(times, (size_t)count, sizeof *times, by_time);
    return 1e-6 * (double)times[count / 2];
}

// Points of [-1, 1]^n; the ball is as large as leaves a quarter of them outside: the sum of squares
// has mean n / 3 and variance 4 n / 45.
static void make_points(struct size size, struct cloud *good, struct cloud *bad)
{
    const double n = size.variables;
    const double limit = n / 3 + 0.674 * sqrt(4 * n / 45);
    double *point = g_new(double, size.variables);
    cloud_init(good, size.variables);
    cloud_init(bad, size.variables);
    for (uint32_t i = 0; i < size.samples; i++) {
        double sum = 0;
        for (uint32_t v = 0; v < size.variables; v++) {
            point[v] = 2 * random_uniform(1, 0, 0, i, v) - 1;
            sum += point[v] * point[v];
        }
        if (sum > limit)
            cloud_add(bad, point, 1, (uint16_t)(1 + 1000 * (sum - limit)));
        else if (good->count < 512)
            cloud_add(good, point, 1, 0);
    }
    g_free(point);
}

static void measure(struct size size, int threads)
{
    struct cloud good;
    struct cloud bad;
    make_points(size, &good, &bad);
    struct box grown;
    struct box trimmed;
    box_init(&grown, size.variables);
    box_init(&trimmed, size.variables);
    for (uint32_t v = 0; v < size.variables; v++) {
        grown.lower[v] = -1;
        grown.upper[v] = 1;
    }
    struct trim_options options = trim_options_default();
    options.threads = threads;
    int64_t wall[REPEATS_MAX];
    int64_t processor[REPEATS_MAX];
    int64_t total = 0;
    int repeats = 0;
    while (repeats < REPEATS_MAX && total < CLOCK_SECOND_NS) {
        const int64_t wall_start = clock_monotonic_ns();
        const int64_t processor_start = processor_ns();
        if (!trim(&grown, NULL, &good, &bad, &options, &trimmed))
            exit(1);
        processor[repeats] = processor_ns() - processor_start;
        wall[repeats] = clock_monotonic_ns() - wall_start;
        total += wall[repeats++];
    }
    printf("%u,%u,%u,%d,%.3f,%.3f,%.3f\n", size.samples, size.variables, bad.count, threads,
           median_ms(wall, repeats), median_ms(processor, repeats),
           box_log_volume(&trimmed, &grown));
    fflush(stdout);
    box_fini(&grown);
    box_fini(&trimmed);
    cloud_fini(&good);
    cloud_fini(&bad);
}

int main(int argc, char **argv)
{
    static const uint32_t samples[] = {200, 1000, 4000, 20000, 100000};
    static const uint32_t variables[] = {2, 18, 100, 700};
    const int threads = argc > 1 ? atoi(argv[1]) : 1;
    printf("samples,variables,bad,threads,wall_ms,processor_ms,log_volume\n");
    for (size_t v = 0; argc <= 3 && v < sizeof variables / sizeof *variables; v++) {
        for (size_t i = 0; i < sizeof samples / sizeof *samples; i++)
            measure((struct size){samples[i], variables[v]}, threads);
    }
    for (int i = 2; i + 1 < argc; i += 2)
        measure((struct size){(uint32_t)atoi(argv[i]), (uint32_t)atoi(argv[i + 1])}, threads);
    return 0;
}
