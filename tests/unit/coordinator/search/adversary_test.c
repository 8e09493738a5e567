#include "coordinator/search/adversary.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/attacked.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum {
    STEPS = 24, // of an attack on a box that stands still, as the search makes it
    SEEDS = 6,
};

// ---- Problems ----

// A plane with slopes of both signs.
static void plane(uint32_t variables, const double *design, double *margins)
{
    margins[0] = 1;
    for (uint32_t v = 0; v < variables; v++)
        margins[0] -= (v % 3 == 0 ? -0.5 : 0.1 * (v + 1)) * design[v];
}

static void sphere(uint32_t variables, const double *design, double *margins)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] * design[v];
    margins[0] = sqrt(variables) / 2 - sqrt(sum);
}

// Semi-axes 2 and 1 at 45 degrees.
static void ellipse(uint32_t variables, const double *design, double *margins)
{
    (void)variables;
    const double along = (design[0] + design[1]) * M_SQRT1_2;
    const double across = (design[1] - design[0]) * M_SQRT1_2;
    margins[0] = 1 - along * along / 4 - across * across;
}

// Sections in a row, of MN: energy, order (only the worst pair of neighbours counts), deceleration.
static void ordered_crash(uint32_t variables, const double *design, double *margins)
{
    margins[0] = -2;
    margins[1] = 1;
    margins[2] = 1 - design[variables - 1];
    for (uint32_t v = 0; v < variables; v++) {
        margins[0] += design[v];
        if (v > 0)
            margins[1] = fmin(margins[1], design[v] - design[v - 1]);
    }
}

// Two paths of half the points each: energy by the trapezoid rule, and the greatest sum of forces.
static void corridor_crash(uint32_t variables, const double *design, double *margins)
{
    const uint32_t points = variables / 2;
    margins[0] = -1;
    margins[1] = INFINITY;
    for (uint32_t k = 0; k < points; k++) {
        const double force = design[k] + design[points + k];
        margins[0] += force * (k == 0 || k + 1 == points ? 0.5 : 1) / (points - 1);
        margins[1] = fmin(margins[1], 1.5 - force);
    }
}

// Couplings of all pairs of variables, positive and negative: linear in each variable, so the worst
// design is a corner, and there are many corners from which no flip leads downhill.
static uint32_t couplings_round;

static void couplings(uint32_t variables, const double *design, double *margins)
{
    margins[0] = 0;
    for (uint32_t v = 0; v < variables; v++) {
        for (uint32_t w = 0; w < v; w++) {
            const double coupling = 2 * random_uniform(99, 0, couplings_round, v, w) - 1;
            margins[0] -= coupling * (2 * design[v] - 1) * (2 * design[w] - 1) / variables;
        }
    }
}

// The square of the distance from the middle along axes that are turned in every pair of variables:
// convex, so the worst design is a corner, but none that single variables lead to alone.
static void rotated(uint32_t variables, const double *design, double *margins)
{
    double turned[ATTACKED_VARIABLES_MAX];
    memcpy(turned, design, variables * sizeof *turned);
    for (uint32_t v = 0; v < variables; v++) {
        for (uint32_t w = 0; w < v; w++) {
            const double angle = M_PI * random_uniform(98, 0, couplings_round, v, w);
            const double x = turned[v] - 0.5, y = turned[w] - 0.5;
            turned[v] = 0.5 + cos(angle) * x - sin(angle) * y;
            turned[w] = 0.5 + sin(angle) * x + cos(angle) * y;
        }
    }
    margins[0] = 1;
    for (uint32_t v = 0; v < variables; v++)
        margins[0] -= pow(turned[v] - 0.5, 2) * pow(100, (double)v / (variables - 1)) / 100;
}

// Worst inside the box, off the middle: no corner is near.
static const double bowl_bottom = 0.37;

static void bowl(uint32_t variables, const double *design, double *margins)
{
    margins[0] = 0;
    for (uint32_t v = 0; v < variables; v++)
        margins[0] += pow(design[v] - bowl_bottom, 2) / variables;
}

// The last variable counts only where the first one is above a half.
static void switched(uint32_t variables, const double *design, double *margins)
{
    margins[0] = design[0] - (design[0] > 0.5 ? design[variables - 1] : 0);
}

// ---- Attacking ----

static void ignore(void *context, const struct attack_view *view)
{
    (void)context;
    (void)view;
}

typedef void attack_viewer(void *context, const struct attack_view *view);

// One step of an adversary in a box.
static void step_once(const struct attacked *problem, const struct box *box,
                      struct adversary *adversary, uint32_t step, attack_viewer *view,
                      void *context, struct adversary_report *report)
{
    const struct moves *moves = adversary_moves(adversary);
    const struct sampling sampling = {.seed = adversary->seed,
                                      .step = step,
                                      .samples = moves->attacks *
                                                 moves_count(&problem->scenario.curves, box),
                                      .method = SAMPLING_METHOD_MOVES,
                                      .curves = &problem->scenario.curves,
                                      .moves = moves};
    struct verdict *verdicts = g_new(struct verdict, sampling.samples);
    attacked_evaluate(problem, &sampling, box, verdicts);
    adversary_complete(adversary, &sampling, box, verdicts, view, context, report);
    g_free(verdicts);
}

static void begin(struct adversary *adversary, const struct attacked *problem, uint64_t seed)
{
    attacked_adversary(problem, seed, adversary);
    adversary->scouts = adversary->most / 2;
    adversary_begin(adversary);
}

// The least margin that an adversary finds in a box.
static double attack(const struct attacked *problem, const struct box *box, uint64_t seed)
{
    struct adversary adversary;
    begin(&adversary, problem, seed);
    double least = INFINITY;
    for (uint32_t step = 0; step < STEPS; step++) {
        struct adversary_report report;
        step_once(problem, box, &adversary, step, ignore, NULL, &report);
        assert_true(adversary.count <= adversary.most);
        least = fmin(least, report.margin);
    }
    adversary_fini(&adversary);
    return least;
}

// A box that lies askew in the design space, so that no corner is like another.
static struct box skew_box(const struct attacked *problem)
{
    const struct box *space = &problem->frame.all;
    struct box box;
    box_init(&box, space->count);
    for (uint32_t v = 0; v < space->count; v++) {
        const double width = space->upper[v] - space->lower[v];
        box.lower[v] = space->lower[v] + width * 0.4 * random_uniform(3, 0, 0, 0, v);
        box.upper[v] = space->upper[v] - width * 0.4 * random_uniform(3, 0, 0, 1, v);
    }
    return box;
}

// Asserts that adversaries of all seeds find the worst of all corners of a box.
static void assert_worst_corner_found(attacked_margins *margins, uint32_t constraints,
                                      uint32_t variables, double lower, double upper)
{
    struct attacked problem;
    attacked_init(&problem, margins, constraints, variables, lower, upper);
    struct box box = skew_box(&problem);
    uint32_t corner;
    const double worst = attacked_worst_corner(&problem, &box, &corner);
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        const double found = attack(&problem, &box, seed);
        if (!(found <= worst + 1e-5))
            fail_msg("%u variables, seed %d: the worst corner has a margin of %.5f, found %.5f",
                     variables, (int)seed, worst, found);
    }
    box_fini(&box);
    attacked_fini(&problem);
}

// ---- Claims ----

// Problems whose worst design is written down in the benchmarks: a corner of the box.
static void worst_corner_of_a_plane_is_found(void **state)
{
    (void)state;
    assert_worst_corner_found(plane, 1, 12, 0, 1);
}

static void worst_corner_in_sphere_and_ellipse_is_found(void **state)
{
    (void)state;
    assert_worst_corner_found(sphere, 1, 12, -1, 1);
    assert_worst_corner_found(ellipse, 1, 2, -1, 1);
}

// Several constraints, of which one is a maximum over pairs: the worst one is no constraint's
// alone.
static void worst_corner_of_a_crash_is_found(void **state)
{
    (void)state;
    assert_worst_corner_found(ordered_crash, 3, 5, 0, 1);
    assert_worst_corner_found(ordered_crash, 3, 12, 0, 1);
    assert_worst_corner_found(corridor_crash, 2, 10, 0, 1);
}

// Where effects of variables do not add, flips taken together mislead.
static void worst_corner_of_a_rotated_function_is_found(void **state)
{
    (void)state;
    for (couplings_round = 0; couplings_round < 3; couplings_round++)
        assert_worst_corner_found(rotated, 1, 12, 0, 1);
}

static void worst_of_many_locally_worst_corners_is_found(void **state)
{
    (void)state;
    for (couplings_round = 0; couplings_round < 3; couplings_round++)
        assert_worst_corner_found(couplings, 1, 12, 0, 1);
}

// Attacks move by tenths of a width inside a box, so they come to within a twentieth in every
// variable, not nearer.
static void worst_design_inside_is_found_to_a_twentieth(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, bowl, 1, 6, 0, 1);
    const double twentieth = 0.5 * MOVES_PROBE / MOVES_LEVEL_MAX;
    for (uint64_t seed = 1; seed <= SEEDS; seed++)
        assert_true(attack(&problem, &problem.frame.all, seed) <= twentieth * twentieth);
    attacked_fini(&problem);
}

struct slopes_seen {
    uint32_t count;
    const struct box *box;
};

// Of a plane every probe knows the slope, whichever bound it goes inwards from.
static void check_slopes(void *context, const struct attack_view *view)
{
    struct slopes_seen *seen = context;
    seen->count++;
    for (uint32_t v = 0; v < seen->box->count; v++) {
        const double slope = v % 3 == 0 ? 0.5 : -0.1 * (v + 1);
        const double width = seen->box->upper[v] - seen->box->lower[v];
        assert_true(fabs(view->slopes[v] * MOVES_LEVEL_MAX / width - slope) < 1e-4);
    }
}

static void slopes_are_those_of_the_margin(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, plane, 1, 9, 0, 1);
    struct box box = skew_box(&problem);
    struct adversary adversary;
    begin(&adversary, &problem, 1);
    struct slopes_seen seen = {.box = &box};
    struct adversary_report report;
    step_once(&problem, &box, &adversary, 0, check_slopes, &seen, &report);
    assert_true(seen.count > 2);
    adversary_fini(&adversary);
    box_fini(&box);
    attacked_fini(&problem);
}

static void count_idle(void *context, const struct attack_view *view)
{
    uint32_t *moved = context;
    *moved += view->attack->levels[0] == 0 && view->attack->levels[2] != 0;
}

// A variable that changes nothing in an attack gets the lower level: attacks that are the same
// crash become one.
static void idle_variables_get_the_lower_level(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, switched, 1, 3, 0, 1);
    struct adversary adversary;
    begin(&adversary, &problem, 1);
    adversary_add(&adversary, (const uint8_t[]){0, 0, MOVES_LEVEL_MAX}, 0, 0);
    uint32_t moved = 0;
    struct adversary_report report;
    step_once(&problem, &problem.frame.all, &adversary, 0, count_idle, &moved, &report);
    // With the first variable at its lower bound a probe of it stays below a half.
    assert_int_equal(moved, 0);
    adversary_fini(&adversary);
    attacked_fini(&problem);
}

// An attack that is there already is not taken up twice: the table is for different ones.
static void equal_attacks_are_one(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, ordered_crash, 3, 4, 0, 1);
    struct adversary adversary;
    attacked_adversary(&problem, 1, &adversary);
    static const uint8_t levels[] = {0, 9, 9, 9};
    adversary_add(&adversary, levels, 0, 1);
    adversary_add(&adversary, levels, 0, 2);
    assert_int_equal(adversary.count, 1);
    adversary_add(&adversary, levels, 1, 1);
    assert_int_equal(adversary.count, 2);
    adversary_fini(&adversary);
    attacked_fini(&problem);
}

// The step machine replays: the same seed and verdicts give the same attacks, others do not.
static void attacks_follow_the_seed(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, couplings, 1, 12, 0, 1);
    struct adversary one, again, other;
    begin(&one, &problem, 1);
    begin(&again, &problem, 1);
    begin(&other, &problem, 2);
    for (uint32_t step = 0; step < 6; step++) {
        struct adversary_report reports[3];
        step_once(&problem, &problem.frame.all, &one, step, ignore, NULL, &reports[0]);
        step_once(&problem, &problem.frame.all, &again, step, ignore, NULL, &reports[1]);
        step_once(&problem, &problem.frame.all, &other, step, ignore, NULL, &reports[2]);
        assert_true(reports[0].margin == reports[1].margin);
        assert_int_equal(reports[0].worst, reports[1].worst);
    }
    const struct moves *moves = adversary_moves(&one);
    const struct moves *moves_again = adversary_moves(&again);
    const struct moves *moves_other = adversary_moves(&other);
    assert_int_equal(moves_size(moves), moves_size(moves_again));
    assert_memory_equal(moves->rows, moves_again->rows, moves_size(moves));
    assert_true(moves_size(moves) != moves_size(moves_other) ||
                memcmp(moves->rows, moves_other->rows, moves_size(moves)) != 0);
    adversary_fini(&one);
    adversary_fini(&again);
    adversary_fini(&other);
    attacked_fini(&problem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worst_corner_of_a_plane_is_found),
        cmocka_unit_test(worst_corner_in_sphere_and_ellipse_is_found),
        cmocka_unit_test(worst_corner_of_a_crash_is_found),
        cmocka_unit_test(worst_corner_of_a_rotated_function_is_found),
        cmocka_unit_test(worst_of_many_locally_worst_corners_is_found),
        cmocka_unit_test(worst_design_inside_is_found_to_a_twentieth),
        cmocka_unit_test(slopes_are_those_of_the_margin),
        cmocka_unit_test(idle_variables_get_the_lower_level),
        cmocka_unit_test(equal_attacks_are_one),
        cmocka_unit_test(attacks_follow_the_seed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
