// Boxes whose largest volume is known, reached from random starts: all their designs are good, the
// exact worst corner among them.
#include "coordinator/search/robust.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/attacked.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { STEPS = 200, STARTS = 6, SEEDS = 3 };

// ---- Problems, in units of 1 ----

static void sphere(uint32_t variables, const double *design, double *margins)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] * design[v];
    margins[0] = sqrt(variables) / 2 - sqrt(sum);
}

static void ellipse(uint32_t variables, const double *design, double *margins)
{
    (void)variables;
    const double along = (design[0] + design[1]) * M_SQRT1_2;
    const double across = (design[1] - design[0]) * M_SQRT1_2;
    margins[0] = 1 - along * along / 4 - across * across;
}

// Sections of equal length in a row: the energy that is left, the order in which they fold, the
// force on the last one. Forces in units of the greatest one allowed, energy 0.62 of that force
// over the whole length.
static const double energy = 0.62;

static void ordered_crash(uint32_t variables, const double *design, double *margins)
{
    margins[0] = -energy;
    margins[1] = INFINITY;
    margins[2] = 1 - design[variables - 1];
    for (uint32_t v = 0; v < variables; v++) {
        margins[0] += design[v] / variables;
        if (v > 0)
            margins[1] = fmin(margins[1], design[v] - design[v - 1]);
    }
}

// Widths (U D_n - E) / (n D_k) for a length of 1 / n each: D_k = k / n.
static double ordered_crash_log_volume(uint32_t variables)
{
    double sum = 0;
    for (uint32_t k = 1; k <= variables; k++)
        sum += log((1 - energy) / k);
    return sum;
}

// Two paths of five points: energy by the trapezoid rule, and the greatest sum of forces.
static void corridor_crash(uint32_t variables, const double *design, double *margins)
{
    const uint32_t points = variables / 2;
    margins[0] = -energy;
    margins[1] = INFINITY;
    for (uint32_t k = 0; k < points; k++) {
        const double force = design[k] + design[points + k];
        margins[0] += force * (k == 0 || k + 1 == points ? 0.5 : 1) / (points - 1);
        margins[1] = fmin(margins[1], 1 - force);
    }
}

// Of the room 1 - energy each of the ten widths has an equal part, by its share of the length: an
// end point has an eighth, an inner one a quarter of the length.
static double corridor_crash_log_volume(void)
{
    const double part = (1 - energy) / 10;
    return 4 * log(part * 8) + 6 * log(part * 4);
}

// Good in either of two balls, of which the second one is larger: boxes that straddle both are bad.
static void two_balls(uint32_t variables, const double *design, double *margins)
{
    double one = 0, two = 0;
    for (uint32_t v = 0; v < variables; v++) {
        one += pow(design[v] + 0.5, 2);
        two += pow(design[v] - 0.4, 2);
    }
    margins[0] = fmax(0.3 - sqrt(one), 0.5 - sqrt(two));
}

// ---- Searching ----

// Random designs all over the space, or, where there are two balls, around the middle of either.
static void draw_start(const struct attacked *problem, uint64_t seed, uint32_t number,
                       double *start)
{
    const struct box *space = &problem->frame.space;
    for (uint32_t v = 0; v < space->count; v++) {
        const double unit = random_uniform(seed, 0, 0, number, v);
        start[v] = space->lower[v] + unit * (space->upper[v] - space->lower[v]);
        if (problem->margins == two_balls)
            start[v] = (number % 2 == 0 ? -0.5 : 0.4) + 0.3 * (unit - 0.5);
    }
}

// Runs all steps from random starts; the box is the caller's.
static struct box grow(const struct attacked *problem, uint64_t seed)
{
    const uint32_t variables = problem->frame.space.count;
    struct demands demands = {0};
    demands_init(&demands, &problem->scenario.search, problem->frame.variables,
                 &problem->frame.space);
    struct cloud starts;
    cloud_init(&starts, variables);
    for (uint32_t i = 0; i < STARTS; i++) {
        double start[ATTACKED_VARIABLES_MAX];
        draw_start(problem, seed, i, start);
        cloud_add(&starts, start, 1, 0);
    }
    struct robust robust;
    attacked_robust(problem, &demands, seed, &starts, STEPS, &robust);
    for (uint32_t step = 0, spent = 0; !spent; step++) {
        assert_true(step < 2 * STEPS);
        struct cutting_set *set = robust_current(&robust);
        const struct moves *moves = adversary_moves(&set->adversary);
        const struct sampling sampling = {
            .seed = seed,
            .step = step,
            .samples =
                moves->attacks * moves_count(&problem->scenario.curves, cutting_set_box(set)),
            .method = SAMPLING_METHOD_MOVES,
            .curves = &problem->scenario.curves,
            .moves = moves};
        struct verdict *verdicts = g_new(struct verdict, sampling.samples);
        attacked_evaluate(problem, &sampling, cutting_set_box(set), verdicts);
        spent = robust_complete(&robust, &sampling, verdicts);
        g_free(verdicts);
    }
    struct box box;
    box_init(&box, variables);
    cutting_set_centre(robust_current(&robust), &box);
    robust_fini(&robust);
    cloud_fini(&starts);
    demands_fini(&demands);
    return box;
}

static double log_volume(const struct box *box)
{
    double sum = 0;
    for (uint32_t v = 0; v < box->count; v++)
        sum += log(box->upper[v] - box->lower[v]);
    return sum;
}

// Asserts that boxes of all seeds have at least `least` of the exact volume, never more than all of
// it but for what a limit's tolerance is worth, and no bad corner.
static void assert_reaches(attacked_margins *margins, uint32_t constraints, uint32_t variables,
                           double lower, double upper, double exact, double least)
{
    struct attacked problem;
    attacked_init(&problem, margins, constraints, variables, lower, upper);
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        struct box box = grow(&problem, seed);
        uint32_t corner;
        const double worst = variables <= 15 ? attacked_worst_corner(&problem, &box, &corner) : 0;
        const double ratio = exp(log_volume(&box) - exact);
        print_message("%u variables, seed %d: %.4f of the volume, worst corner %.2g\n", variables,
                      (int)seed, ratio, worst);
        if (!(ratio >= least && ratio <= 1 + 1e-6 && worst >= 0))
            fail_msg("%u variables, seed %d: expected %.2f to 1 of the volume and no bad corner, "
                     "found %.4f and a margin of %.2g",
                     variables, (int)seed, least, ratio, worst);
        box_fini(&box);
    }
    attacked_fini(&problem);
}

static void largest_boxes_of_few_variables_are_reached(void **state)
{
    (void)state;
    assert_reaches(sphere, 1, 2, -1, 1, 0, 0.97);
    assert_reaches(sphere, 1, 5, -1, 1, 0, 0.97);
    assert_reaches(ellipse, 1, 2, -2, 2, log(2), 0.97);
    assert_reaches(ordered_crash, 3, 3, 0, 1.2, ordered_crash_log_volume(3), 0.97);
    assert_reaches(ordered_crash, 3, 5, 0, 1.2, ordered_crash_log_volume(5), 0.97);
}

static void largest_boxes_of_many_variables_are_reached(void **state)
{
    (void)state;
    assert_reaches(sphere, 1, 10, -1, 1, 0, 0.95);
    assert_reaches(corridor_crash, 2, 10, 0, 1, corridor_crash_log_volume(), 0.95);
    assert_reaches(sphere, 1, 30, -1, 1, 0, 0.90);
}

// Starts in either ball and in none: the one that holds more wins, and no box straddles both.
static void the_larger_of_two_regions_is_taken(void **state)
{
    (void)state;
    assert_reaches(two_balls, 1, 3, -1, 1, 3 * log(1 / sqrt(3)), 0.97);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(largest_boxes_of_few_variables_are_reached),
        cmocka_unit_test(largest_boxes_of_many_variables_are_reached),
        cmocka_unit_test(the_larger_of_two_regions_is_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
