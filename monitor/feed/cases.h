// What the cases of a sweep are called and what they have on its axes, as cases_t tells of them.
#ifndef SOBOX_MONITOR_FEED_CASES_H
#define SOBOX_MONITOR_FEED_CASES_H

#include "sobox_cases_t.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum { CASES_KNOWN_MAX = 16384 }; // cases of one sweep whose names are kept

struct cases_entry {
    char **texts; // name, then a value an axis; NULL: not heard of
    uint64_t changed;
};

struct cases {
    char **axes;      // "case", then the axes' paths; NULL: not heard of
    uint32_t columns; // texts a case; 0: nothing is heard
    GArray *entries;  // struct cases_entry, by index in the run
    uint64_t changed;
};

void cases_init(struct cases *cases);
void cases_fini(struct cases *cases);

// Takes a message that passed the wire's checks; what is new in it is marked with `version`.
// Returns whether anything is.
bool cases_hear(struct cases *cases, const sobox_cases_t *message, uint64_t version);

// The same for one row of texts (a NULL-terminated list, borrowed) that came another way: of the
// case `index`, or the axes' paths for -1.
bool cases_put(struct cases *cases, int32_t index, char *const *texts, uint64_t version);

// The texts of a case, or NULL.
char *const *cases_find(const struct cases *cases, uint32_t index);

#endif
