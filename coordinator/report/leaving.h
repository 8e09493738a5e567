// Whether and where a component's measured curve leaves its corridor.
//
//     force |        ____ measured
//           |   ____/____\______ upper
//           |  /   /      \            it leaves between the two places at which the lines cross
//           |_/___/________\____ lower
//             deformation
//
// Both are linear between their points, so between two neighbouring points of either the places are
// found exactly.
#ifndef SOBOX_COORDINATOR_REPORT_LEAVING_H
#define SOBOX_COORDINATOR_REPORT_LEAVING_H

#include <stdbool.h>
#include <stdint.h>

// A measured curve and the corridor that it is held against, in units of the reader's own.
struct leaving_curves {
    const double *x;           // (count) deformations, ascending
    const double *y;           // (count) forces
    uint32_t count;            // 2 ..
    const double *deformation; // (point_count) of the corridor, ascending
    const double *lower;       // (point_count)
    const double *upper;       // (point_count)
    uint32_t point_count;      // 2 ..
};

// A piece of the measured curve that is outside.
struct leaving_piece {
    double from, to; // deformations; equal where it is outside in one place alone
    bool above;      // the upper bound; else below the lower one
    double worst;    // the greatest distance from the bound, > 0
    double worst_at; // where
};

// Writes at most `room` pieces in the order of deformation and returns how many there are. Only the
// deformations that both curves have are looked at: `from` and `to` receive them, from > to when
// there are none.
uint32_t leaving_find(const struct leaving_curves *curves, struct leaving_piece *pieces,
                      uint32_t room, double *from, double *to);

#endif
