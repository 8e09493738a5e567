// How a box grows before it is sampled: each side by a share of the box's own width there, so that
// a wide design space does not matter, steered by the share of good samples that the growth brings.
#ifndef SOBOX_COORDINATOR_SEARCH_GROWTH_H
#define SOBOX_COORDINATOR_SEARCH_GROWTH_H

#include "common/numeric/box.h"

#include <stdbool.h>

struct growth {
    double rate; // how far each side moves out, in widths of the box there
};

// Starts with a large rate: a box begins as a point, and a growth that was too much is taken back.
void growth_init(struct growth *growth);

// Moves each side of `box` out, at most to `space`. Where the box is narrow a fiftieth of the
// design space counts as its width, so that a point can grow. `grown` may be `box`.
void growth_apply(const struct growth *growth, const struct box *box, const struct box *space,
                  struct box *grown);

// Whether so few samples of a grown box were good that trimming it would be guesswork: the growth
// is to be taken back.
bool growth_too_much(double good_share);

// Changes the rate so that the next step keeps 70 to 80 % of its samples good.
void growth_steer(struct growth *growth, double good_share);

// Lowers the rate to one for a box that has a width in every variable: what makes a box of a point
// would make the box so much larger that the next steps are spent on taking it back.
void growth_calm(struct growth *growth);

// Whether the rate has become so small that the box does not grow any more.
bool growth_exhausted(const struct growth *growth);

#endif
