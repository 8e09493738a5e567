// By how much bad designs may miss their limits, so that the wanted share of each kind of designs
// is still good: a search for one number.
//
// A box without a bad design is smaller than one of which a hundredth may be bad. Limits that may
// be missed by a little, the same little for all, lead from the one to the other: at each amount
// there is a widest box, and the more may be missed the larger it is and the greater its bad
// shares. The amount is doubled until a box has too many bad designs, then halved towards the last
// that had not.
//
//     missed   0   0.01  0.02  0.04         kept: the widest box whose kinds all have few enough
//              kept kept kept too many
//                            0.03 kept
#ifndef SOBOX_COORDINATOR_SEARCH_RELAX_H
#define SOBOX_COORDINATOR_SEARCH_RELAX_H

#include <stdbool.h>
#include <stdint.h>

enum { RELAX_TRIALS = 10 }; // amounts that are tried, at most

struct relax {
    double kept;   // the greatest amount whose box had few enough bad designs
    double missed; // the least that had too many; infinite before there is one
    double amount; // that is tried
    uint32_t trials;
};

// Starts with the first amount; 0 is known to be kept.
void relax_init(struct relax *relax);

// Takes what the box of the present amount showed, and moves on to the next; false when it is done.
bool relax_next(struct relax *relax, bool kept);

// Goes back after a certificate was missed: to the greatest amount below the one that was kept.
void relax_back(struct relax *relax);

#endif
