// From the forces on a barrier's nodes to the force-deformation curves of the springs in front of
// it (thesis 7.2.1): how a crash test or a finite-element crash becomes a design.
//
//     node forces (t, node) --patch--> spring forces (t) --yaw--> vehicle axes --motion--> F(s)
//
// At every time the vehicle's place says where each spring meets the barrier (patches.h) and how
// far it is deformed. Every node's force goes to the spring in whose patch it lies; the sums are
// turned by the yaw into the vehicle's axes. The way up to a spring's greatest deformation is its
// load branch, the way down from there its unload branch; where it went back and forth, the first
// pass counts, since a curve has one force at a deformation.
//
// Nothing here knows files: the table of forces, which may be far larger than memory, comes in
// pieces of whole lines.
#ifndef SOBOX_WORKER_REDUCTION_REDUCTION_H
#define SOBOX_WORKER_REDUCTION_REDUCTION_H

#include "worker/components/group.h"
#include "worker/models/design.h"
#include "worker/models/motion.h"
#include "worker/reduction/balance.h"

enum {
    REDUCTION_TIME_MAX = 200000, // times of a table: with 64 springs 0.3 GB
};

// What was made of a table.
struct reduction_summary {
    uint64_t node_forces;   // rows
    uint32_t times;         // different times
    double time_first;      // [s]
    double time_last;       // [s]
    double gap;             // [s] greatest time between two of the table's times
    double gap_start;       // [s] where it begins
    double impulse[2];      // [N s] on the vehicle, in road axes
    bool turned;            // forces were those on the barrier: they would have sped the vehicle up
    uint64_t outside_count; // forces other than 0 in no spring's patch
    double outside_share;   // their part of the sum of |force|, 0 .. 1
    double undeformed_share; // of forces in the patch of a spring that the barrier had not reached
    double repeated_share;   // of forces at deformations that the spring had passed before
    double yaw_max;          // [rad] greatest |yaw|; from a quarter turn on no spring has a patch
    struct balance balance;  // whether forces and motion belong to each other (doubts.h)
};

struct reduction;

// Begins a reduction. `scenario`, the `groups` of components of its springs (or NULL) and `motion`,
// which has all three quantities, stay in use, and so does `source`, which stands for the table in
// messages. The caller frees it; NULL with `error` set (STATUS_INVALID) when the springs' places do
// not tell them apart.
struct reduction *reduction_create(const struct scenario *scenario, const struct group_list *groups,
                                   const struct motion *motion, const char *source,
                                   struct error *error);
void reduction_free(struct reduction *reduction);

// Takes the next lines of the table, the first with its header: text that ends with a whole line,
// or with the table. Errors: STATUS_INVALID.
enum status reduction_read(struct reduction *reduction, const char *text, size_t size,
                           struct error *error) MUST_USE;

// Makes the curves, once everything was read. On success the caller releases the design; else it is
// left zeroed. Errors: STATUS_INVALID (fewer than two times, no force on any spring).
enum status reduction_finish(struct reduction *reduction, struct design *design,
                             struct reduction_summary *summary, struct error *error) MUST_USE;

#endif
