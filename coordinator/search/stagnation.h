// Whether anything is still gained: the mean log-volume of the last steps' boxes against that of as
// many steps before.
//
//     log-volume      ___....----~~~~----....~~~
//                 .--'  |  before  |   last   |     stagnant: the second mean is no greater
//
// A box that is balanced goes up and down by chance; a mean over both windows is what can be
// compared. Means of logarithms are compared as products of volumes, so that every machine decides
// alike (volume.h).
#ifndef SOBOX_COORDINATOR_SEARCH_STAGNATION_H
#define SOBOX_COORDINATOR_SEARCH_STAGNATION_H

#include "coordinator/search/volume.h"

#include <stdbool.h>
#include <stdint.h>

struct stagnation {
    uint32_t window;        // [steps] of each mean; 0: nothing ever stagnates
    uint32_t steps;         // noted
    struct volume *volumes; // (2 x window) of the last steps
};

// Starts anew with windows of `window` steps. The caller releases it with stagnation_fini().
void stagnation_init(struct stagnation *stagnation, uint32_t window);

// Releases what it owns. A zeroed struct is fine, and never stagnates.
void stagnation_fini(struct stagnation *stagnation);

// Forgets the steps so far.
void stagnation_reset(struct stagnation *stagnation);

// Notes the volume of a step's box; returns whether nothing was gained over the last two windows.
bool stagnation_note(struct stagnation *stagnation, struct volume volume);

#endif
