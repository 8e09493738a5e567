#include "coordinator/search/relax.h"

#include <math.h>

static const double relax_first = 0.01;    // in the constraints' own scale
static const double relax_near = 0.1;      // of an amount: two that differ by less are one
static const double relax_back_part = 0.6; // of the amount that did not pass

void relax_init(struct relax *relax)
{
    *relax = (struct relax){.missed = INFINITY, .amount = relax_first};
}

bool relax_next(struct relax *relax, bool kept)
{
    if (kept)
        relax->kept = relax->amount;
    else
        relax->missed = relax->amount;
    relax->amount = isinf(relax->missed) ? 2 * relax->amount : (relax->kept + relax->missed) / 2;
    return ++relax->trials < RELAX_TRIALS &&
           !(relax->missed - relax->kept < relax_near * relax->missed);
}

void relax_back(struct relax *relax)
{
    relax->missed = relax->kept;
    relax->kept *= relax_back_part;
    relax->amount = relax->kept;
}
