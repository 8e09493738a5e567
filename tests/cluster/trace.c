#include "tests/cluster/trace.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t trace_seed;
static bool trace_wanted;

void trace_start(uint64_t seed, bool wanted)
{
    trace_seed = seed;
    trace_wanted = wanted;
}

void trace_line(int64_t now_ns, const char *who, const char *format, ...)
{
    if (!trace_wanted)
        return;
    printf("%12.6f %-12s ", (double)now_ns * 1e-9, who);
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
}

_Noreturn void trace_fail(int64_t now_ns, const char *format, ...)
{
    fflush(stdout);
    fprintf(stderr, "storm %llu failed at %.6f s: ", (unsigned long long)trace_seed,
            (double)now_ns * 1e-9);
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, "\nwatch it again: cluster_test --seed %llu --storms 1 --trace\n",
            (unsigned long long)trace_seed);
    exit(EXIT_FAILURE);
}
