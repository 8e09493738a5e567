// The widest box without a bad design, by the cutting-set method (Mutapcic and Boyd, "Cutting-set
// methods for robust convex optimization with pessimizing oracles", Optimization Methods and
// Software 24, 2009): attack the box, turn each attack into a limit on the box, find the widest box
// under all limits, and attack that one.
//
//     centre --widest under the limits, within reach--> trial --attacked--> limits, least margin
//        ^                                                |
//        +------ better: it is the new centre; reach grows+
//                worse: the centre stays; reach shrinks
//
// An attack is a design at levels of the box, so its margin is a function of the box's sides; its
// value and slopes at the trial box make a linear limit. As in bundle methods a trial is better
// when its log-volume less a price on what its worst design lacks is; the price is above what a
// limit is worth, so that the best box is a good one. All limits are to keep a tolerance, which
// falls from step to step: it pays for what linear limits miss.
#ifndef SOBOX_COORDINATOR_SEARCH_CUTTING_SET_H
#define SOBOX_COORDINATOR_SEARCH_CUTTING_SET_H

#include "coordinator/search/adversary.h"
#include "coordinator/search/demands.h"

struct cut; // a limit, inside cutting_set.c

enum { CUTTING_SET_NOTHING = 255 }; // holds a side

struct cutting_set {
    const struct frame *frame;     // borrowed
    const struct demands *demands; // borrowed
    struct adversary adversary;
    uint32_t sides;       // 2 x free variables; all lengths in units of the design space
    double *centre;       // (sides) the best box so far
    double *kept;         // (sides) see cutting_set_keep()
    double *trial;        // (sides) what is attacked next
    double centre_margin; // least margin measured in the centre; -infinity before the first
    bool centre_clean;    // no sample of its step was bad
    double reach;         // by how much of a width a side may move in one step
    double tolerance;     // margin that limits keep, and
    double least;         // the least that it falls to
    double price;         // of a unit of margin, in log-volume
    double shadow;        // what a unit of tolerance costs, as the last trial had it
    struct cut *cuts;     // (cut_count)
    uint32_t cut_count;
    uint32_t step;
    bool refined;   // see cutting_set_refine()
    double fall;    // of the tolerance, a step
    uint32_t still; // steps since the centre became better by more than a trifle
    double mended;  // tolerance after the last bad design that was found late
    bool standing;  // the centre is attacked, and stays as it is
    struct box box; // all variables: the trial
};

// Starts with the box `start` (free variables), which need not be good. What is pointed at is
// borrowed, `start` until return. The caller releases it with cutting_set_fini().
void cutting_set_init(struct cutting_set *set, const struct frame *frame,
                      const struct demands *demands, const struct curve_map *curves,
                      uint32_t constraints, uint32_t samples, uint64_t seed,
                      const struct box *start);

// A small box around a design (free variables), inside the design space.
void cutting_set_around(const struct box *space, const double *design, struct box *box);

// Releases it. A zeroed struct is fine.
void cutting_set_fini(struct cutting_set *set);

// What to attack: the box of all variables (borrowed), and with what.
const struct box *cutting_set_box(const struct cutting_set *set);

// Takes the verdicts of the attack and makes the next trial.
void cutting_set_complete(struct cutting_set *set, const struct sampling *sampling,
                          const struct verdict *verdicts, struct adversary_report *report);

// Lets the tolerance fall to its least within some twenty steps: what is left is to be exact.
void cutting_set_refine(struct cutting_set *set);

// Lets all limits be missed by up to `amount` from now on (in the constraints' own scale; 0: by
// nothing), and sets out from the centre again.
void cutting_set_relax(struct cutting_set *set, double amount);

// Keeps the centre if it is larger than what is kept, and goes back to what is kept.
void cutting_set_keep(struct cutting_set *set);
void cutting_set_take_back(struct cutting_set *set);

// Whether the tolerance is at its least and nothing has been gained for some steps.
bool cutting_set_resting(const struct cutting_set *set);

// From now on attacks the centre as it is, with many fresh scouts beside the known attacks.
void cutting_set_stand(struct cutting_set *set);

// Puts a box (free variables) in the centre's place while it stands, exact to the bit.
void cutting_set_place(struct cutting_set *set, const struct box *box);

// Moves on from a centre in which a bad design was found: wants a greater margin of all limits.
void cutting_set_mend(struct cutting_set *set);

// By how much a box is better than another: log-volume, less what its worst known design lacks.
double cutting_set_merit(const struct cutting_set *set);

// What holds the sides of the centre: for each side (2 x free variables) the constraint that it
// gives way to at the highest price, or CUTTING_SET_NOTHING; and for each constraint the log-volume
// that one of its margin is worth.
void cutting_set_holders(const struct cutting_set *set, uint8_t *holders, double *worth);

// The centre in the design space's own units (free variables).
void cutting_set_centre(const struct cutting_set *set, struct box *box);

#endif
