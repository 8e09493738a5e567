// Problems for the tests of the promise "every": margins of constraints as functions of a design,
// what workers do with a step of them, and searches of them without the rest of the program.
#ifndef SOBOX_TESTS_UNIT_COORDINATOR_SEARCH_ATTACKED_H
#define SOBOX_TESTS_UNIT_COORDINATOR_SEARCH_ATTACKED_H

#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"
#include "common/scenario/scenario.h"
#include "coordinator/search/cutting_set.h"
#include "coordinator/search/frame.h"
#include "coordinator/search/robust.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum { ATTACKED_CONSTRAINTS_MAX = 4, ATTACKED_VARIABLES_MAX = 64 };

// Fills in how far inside each constraint a design lies.
typedef void attacked_margins(uint32_t variables, const double *design, double *margins);

struct attacked {
    attacked_margins *margins;
    uint32_t constraints;
    struct scenario scenario; // its design space, curves and search settings
    struct frame frame;
};

// A problem on [lower, upper]^variables. The caller releases it with attacked_fini().
static inline void attacked_init(struct attacked *attacked, attacked_margins *margins,
                                 uint32_t constraints, uint32_t variables, double lower,
                                 double upper)
{
    memset(attacked, 0, sizeof *attacked);
    attacked->margins = margins;
    attacked->constraints = constraints;
    attacked->scenario.constraint_count = constraints;
    box_init(&attacked->scenario.design_space, variables);
    curve_map_init(&attacked->scenario.curves, variables);
    for (uint32_t v = 0; v < variables; v++) {
        attacked->scenario.design_space.lower[v] = lower;
        attacked->scenario.design_space.upper[v] = upper;
    }
    frame_init(&attacked->frame, &attacked->scenario);
}

static inline void attacked_fini(struct attacked *attacked)
{
    frame_fini(&attacked->frame);
    box_fini(&attacked->scenario.design_space);
    curve_map_fini(&attacked->scenario.curves);
}

enum { ATTACKED_SAMPLES = 200 }; // of a step of other kinds, as by default

// An adversary of the problem, without attacks.
static inline void attacked_adversary(const struct attacked *attacked, uint64_t seed,
                                      struct adversary *adversary)
{
    adversary_init(adversary, &attacked->frame, &attacked->scenario.curves, attacked->constraints,
                   ATTACKED_SAMPLES, seed);
}

// A cutting set of the problem that starts around a design.
static inline void attacked_set(const struct attacked *attacked, const struct demands *demands,
                                const double *start, struct cutting_set *set)
{
    struct box box;
    box_init(&box, attacked->frame.space.count);
    cutting_set_around(&attacked->frame.space, start, &box);
    cutting_set_init(set, &attacked->frame, demands, &attacked->scenario.curves,
                     attacked->constraints, ATTACKED_SAMPLES, 1, &box);
    box_fini(&box);
}

// Cutting sets of the problem from several starts.
static inline void attacked_robust(const struct attacked *attacked, const struct demands *demands,
                                   uint64_t seed, const struct cloud *starts, uint32_t steps,
                                   struct robust *robust)
{
    robust_init(robust, &attacked->frame, demands, &attacked->scenario.curves,
                attacked->constraints, ATTACKED_SAMPLES, seed, starts, steps);
}

// What workers do: full verdicts, and margins as batch.h has them.
static inline void attacked_evaluate(const struct attacked *attacked,
                                     const struct sampling *of_step, const struct box *box,
                                     struct verdict *verdicts)
{
    struct sampling sampling = *of_step;
    sampling.curves = &attacked->scenario.curves;
    const uint32_t samples = sampling.samples;
    const uint32_t per_attack = moves_count(sampling.curves, box);
    g_autofree double *values = g_new(double, (size_t)samples * box->count);
    sampling_fill(&sampling, box, 0, samples, values, samples);
    for (uint32_t i = 0; i < samples; i++) {
        double design[ATTACKED_VARIABLES_MAX], margins[ATTACKED_CONSTRAINTS_MAX];
        for (uint32_t v = 0; v < box->count; v++)
            design[v] = values[(size_t)v * samples + i];
        attacked->margins(box->count, design, margins);
        uint32_t worst = 0;
        for (uint32_t c = 1; c < attacked->constraints; c++)
            worst = margins[c] < margins[worst] ? c : worst;
        verdicts[i] = (struct verdict){.violation = verdict_violation(-margins[worst])};
        verdicts[i].constraint = verdicts[i].violation == VERDICT_GOOD ? 0 : (uint8_t)worst;
        const bool moves = sampling.method == SAMPLING_METHOD_MOVES;
        verdicts[i].margin = (float)margins[moves ? moves_target(&sampling, per_attack, i) : worst];
    }
}

// The least margin over all corners of a box of at most 20 variables, and where it is.
static inline double attacked_worst_corner(const struct attacked *attacked, const struct box *box,
                                           uint32_t *corner)
{
    double least = INFINITY;
    for (uint32_t at = 0; at < UINT32_C(1) << box->count; at++) {
        double design[ATTACKED_VARIABLES_MAX], margins[ATTACKED_CONSTRAINTS_MAX];
        for (uint32_t v = 0; v < box->count; v++)
            design[v] = at >> v & 1 ? box->upper[v] : box->lower[v];
        attacked->margins(box->count, design, margins);
        for (uint32_t c = 0; c < attacked->constraints; c++) {
            if (margins[c] < least) {
                least = margins[c];
                *corner = at;
            }
        }
    }
    return least;
}

#endif
