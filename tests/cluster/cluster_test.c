// cluster_test [--storms N] [--seed S] [--trace]: N storms (60 by default) with the seeds S, S + 1,
// ... (1 by default), and as many calm days for comparison. A storm that fails prints its seed and
// how to watch it again; the same seed is the same storm.
#include "tests/cluster/storm.h"
#include "tests/cluster/trace.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>

struct options {
    gint64 storms;
    gint64 seed;
    gboolean trace;
};

struct total {
    uint64_t packets;
    uint64_t faults;
    uint64_t batches;
    uint64_t samples;
    uint64_t evaluated;
    uint64_t released;
    uint64_t copies;
    uint64_t duplicates;
    int64_t after_ns; // longest
};

static void total_add(struct total *total, const struct storm_report *report)
{
    total->packets += report->packets;
    total->faults += report->faults;
    total->batches += report->batches;
    total->samples += report->samples;
    total->evaluated += report->evaluated;
    total->released += report->counters.released;
    total->copies += report->counters.copies;
    total->duplicates += report->counters.duplicates;
    if (report->after_ns > total->after_ns)
        total->after_ns = report->after_ns;
}

static void total_print(const char *what, gint64 count, const struct total *total)
{
    printf("%" G_GINT64_FORMAT " %s: %llu packets, %llu faults, %llu batches sent, %llu samples "
           "wanted, %llu evaluated, %llu leases released, %llu copies, %llu duplicates, at most "
           "%.3f s after the weather cleared\n",
           count, what, (unsigned long long)total->packets, (unsigned long long)total->faults,
           (unsigned long long)total->batches, (unsigned long long)total->samples,
           (unsigned long long)total->evaluated, (unsigned long long)total->released,
           (unsigned long long)total->copies, (unsigned long long)total->duplicates,
           (double)total->after_ns * 1e-9);
}

static bool options_read(struct options *options, int argc, char **argv)
{
    const GOptionEntry entries[] = {
        {"storms", 0, 0, G_OPTION_ARG_INT64, &options->storms, "how many (60)", "N"},
        {"seed", 0, 0, G_OPTION_ARG_INT64, &options->seed, "of the first one (1)", "S"},
        {"trace", 0, 0, G_OPTION_ARG_NONE, &options->trace, "print what happens", NULL},
        {0},
    };
    GOptionContext *context = g_option_context_new("- a simulated cluster in bad weather");
    g_option_context_add_main_entries(context, entries, NULL);
    GError *error = NULL;
    bool read = g_option_context_parse(context, &argc, &argv, &error);
    if (!read) {
        fprintf(stderr, "cluster_test: %s\n", error->message);
        g_error_free(error);
    }
    g_option_context_free(context);
    return read;
}

static void run_all(const struct problem *problem, const struct options *options, bool calm)
{
    struct total total = {0};
    for (gint64 i = 0; i < options->storms; i++) {
        uint64_t seed = (uint64_t)(options->seed + i);
        trace_start(seed, options->trace);
        struct storm_report report;
        storm_run(problem, seed, calm, &report);
        total_add(&total, &report);
    }
    total_print(calm ? "calm days" : "storms", options->storms, &total);
}

int main(int argc, char **argv)
{
    struct options options = {.storms = 60, .seed = 1};
    if (!options_read(&options, argc, argv))
        return 2;
    printf("seed %" G_GINT64_FORMAT "\n", options.seed);
    struct problem problem;
    problem_init(&problem);
    run_all(&problem, &options, true);
    run_all(&problem, &options, false);
    problem_fini(&problem);
    return EXIT_SUCCESS;
}
