// What engineers ask of every box that the search keeps, beside being good: bounds that stay where
// they are, a design that stays inside, widths below which a corridor is of no use, corridors that
// several variables share, and what a variable's width is worth. All in the free variables.
//
//     space   |-------------------------------|
//     held    ]                                    the lower bound is that of the space
//     box     |---------r-----|                    contains the reference r
//             |<- minimum ->|
//
// Held bounds are the space's own: the search looks nowhere else. So a box meets that demand by
// having the bound of the space. The others are met by moving sides a little after each step that
// moved them; where that takes in bad designs, later samples show it.
#ifndef SOBOX_COORDINATOR_SEARCH_DEMANDS_H
#define SOBOX_COORDINATOR_SEARCH_DEMANDS_H

#include "common/scenario/scenario.h"
#include "coordinator/search/volume.h"

struct demands {
    const struct box *space; // borrowed
    bool any;                // whether demands_meet() has anything to do
    bool *held;              // (sides) or NULL; side 2v is the lower bound of variable v
    double *reference;       // (variables) or NULL
    struct box around;       // holds the references of all variables that share a corridor
    double *minimum_widths;  // (variables) or NULL
    double *weights;         // (variables) or NULL
    uint32_t *tie;           // (variables) the first variable of those that share, or NULL
};

// How variables that share a corridor come to one.
enum demands_tie {
    DEMANDS_TIE_MEAN,   // of their corridors: after small moves
    DEMANDS_TIE_INSIDE, // what their corridors have in common: no bad design comes in
    DEMANDS_TIE_AROUND, // all of their corridors: of a design, which must stay inside
};

// Takes over what `settings` ask of those variables (`space`.count of them, indexes among all).
// Pointers of a zeroed struct are free. The caller releases it with demands_fini().
void demands_init(struct demands *demands, const struct scenario_search *settings,
                  const uint32_t *variables, const struct box *space);

// Releases what demands own. A zeroed struct is fine.
void demands_fini(struct demands *demands);

// Moves the sides of `box`, which lies in the space, until it meets the demands. Returns false, and
// leaves the box as it was, when corridors that are to share have nothing in common (only with
// DEMANDS_TIE_INSIDE). Without demands (NULL) every box meets them.
bool demands_meet(const struct demands *demands, struct box *box, enum demands_tie tie);

// Moves the sides of `box` inwards to multiples of `step` (> 0), but for sides that are held. An
// interval that would lose its width, its minimum width or the reference by that is left as it is.
void demands_round(const struct demands *demands, double step, struct box *box);

// The volume by which boxes are compared: each width to the power of its weight.
struct volume demands_volume(const struct demands *demands, const struct box *box,
                             const struct box *space);

#endif
