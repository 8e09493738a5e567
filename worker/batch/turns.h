// Who is served next where several coordinators share a worker: each in its turn, with its oldest
// batch. In the order of arrival a coordinator that keeps eight batches here would get eight times
// as much as one that keeps one, and the other would see its leases end and dare even less.
//
//     coordinator A  [1][2][5][6][7]
//     coordinator B  [3]                  taken: 1 3 4 2 5 6 7
//     coordinator C  [4]
//
// A batch is a few milliseconds of work at most, whoever's it is, so turns by the batch are fair.
#ifndef SOBOX_WORKER_BATCH_TURNS_H
#define SOBOX_WORKER_BATCH_TURNS_H

#include <glib.h>
#include <stdint.h>

// What waits for its turn; part of the caller's own.
struct turn {
    uint64_t coordinator;
    uint64_t arrival; // of one coordinator's the least is first
    GList link;       // the machine's own
};

struct turns {
    GHashTable *clients; // coordinators for whom something waits
    GQueue order;        // the same, next first
};

void turns_init(struct turns *turns);
void turns_fini(struct turns *turns); // what waits is the caller's

// Adds one that waits for nothing any more. Who had nothing here is served after those who had.
void turns_add(struct turns *turns, struct turn *turn);

// Takes the next one; NULL when there is none.
struct turn *turns_take(struct turns *turns);

#endif
