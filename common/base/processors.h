// How many threads this process is to have where nobody says it with --threads: no more than it may
// use. Batch systems, containers and users say that in several ways, and the least of them holds:
//
//     affinity            taskset, cpusets, most batch systems
//     CPU quota           cpu.max of the process's control group and those above it
//     OMP_NUM_THREADS     what OpenMP programs are told by users and job scripts
//     OMP_THREAD_LIMIT    what OpenMP gives no program more than, --threads included
#ifndef SOBOX_COMMON_BASE_PROCESSORS_H
#define SOBOX_COMMON_BASE_PROCESSORS_H

#include <limits.h>

enum { PROCESSORS_NO_LIMIT = INT_MAX };

// 1 or more.
int processors_usable(void);

// The threads that `wanted` can be: what OMP_THREAD_LIMIT leaves of them.
int processors_limited(int wanted);

// What a value of OMP_NUM_THREADS ("4", or "4,2" by level) or OMP_THREAD_LIMIT allows;
// PROCESSORS_NO_LIMIT where there is none (NULL) or it says nothing.
int processors_of_variable(const char *value);

// What the text of cpu.max, "QUOTA PERIOD" or "max PERIOD", allows: whole processors, rounded up.
int processors_of_quota(const char *text);

#endif
