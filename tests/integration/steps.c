// steps RUN COUNT SECONDS [PROCESS]: waits until the journal of a run folder holds COUNT steps,
// then stops PROCESS, which writes it: whatever is done next is done in mid-run, on any machine.
// Prints how many steps there are then. Fails after SECONDS, and when the run had ended before it
// could be stopped.
//
// A program of its own, because a run of the tests takes a fifth of a second, and a shell that
// starts sqlite3 again and again is too slow for that where many others want the processor.
#include "common/base/clock.h"

#include <signal.h>
#include <sqlite3.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    INTERVAL_NS = 500000, // between two looks
    BUSY_MS = 1000,       // the last one out locks the journal for a moment
};

static sqlite3 *journal;

static _Noreturn void __attribute__((format(printf, 1, 2))) fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("steps: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(EXIT_FAILURE);
}

// False as long as the run folder is not there or has no tables yet. The connection is kept:
// opening one costs more than asking.
static bool journal_open(const char *run)
{
    if (journal != NULL)
        return true;
    char *path = sqlite3_mprintf("%s/run.db", run);
    const bool opened = sqlite3_open_v2(path, &journal, SQLITE_OPEN_READONLY, NULL) == SQLITE_OK;
    sqlite3_free(path);
    if (opened) {
        sqlite3_busy_timeout(journal, BUSY_MS);
        return true;
    }
    sqlite3_close(journal);
    journal = NULL;
    return false;
}

// One integer; -1 while it cannot be told. A journal whose writer was killed may have to be opened
// anew.
static long long ask(const char *run, const char *question)
{
    if (!journal_open(run))
        return -1;
    sqlite3_stmt *statement = NULL;
    long long answer = -1;
    if (sqlite3_prepare_v2(journal, question, -1, &statement, NULL) == SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW)
        answer = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    if (answer < 0) {
        sqlite3_close(journal);
        journal = NULL;
    }
    return answer;
}

static long long steps_of(const char *run)
{
    return ask(run, "SELECT count(*) FROM step");
}

int main(int argc, char **argv)
{
    if (argc != 4 && argc != 5)
        fail("steps RUN COUNT SECONDS [PROCESS]");
    const char *run = argv[1];
    const long long wanted = atoll(argv[2]);
    const int64_t end_ns = clock_monotonic_ns() + atoll(argv[3]) * CLOCK_SECOND_NS;
    long long steps;
    while ((steps = steps_of(run)) < wanted) {
        if (clock_monotonic_ns() > end_ns)
            fail("waited %s s in vain until %s has %lld steps: it has %lld", argv[3], run, wanted,
                 steps);
        nanosleep(&(struct timespec){.tv_nsec = INTERVAL_NS}, NULL);
    }
    if (argc == 5) {
        if (kill((pid_t)atol(argv[4]), SIGSTOP) != 0)
            fail("the program that writes %s has ended before it could be stopped", run);
        steps = steps_of(run);
        if (ask(run, "SELECT count(*) FROM run WHERE state = 'running'") != 1)
            fail("%s had ended after %lld steps before it could be stopped", run, steps);
    }
    printf("%lld\n", steps);
    sqlite3_close(journal);
    return EXIT_SUCCESS;
}
