#include "coordinator/search/demands.h"

#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const uint32_t all[3] = {0, 1, 2};

static void set(struct box *box, uint32_t variable, double lower, double upper)
{
    box->lower[variable] = lower;
    box->upper[variable] = upper;
}

static void assert_interval(const struct box *box, uint32_t variable, double lower, double upper)
{
    if (fabs(box->lower[variable] - lower) > 1e-9 || fabs(box->upper[variable] - upper) > 1e-9)
        fail_msg("variable %u: expected %g to %g, found %g to %g", variable, lower, upper,
                 box->lower[variable], box->upper[variable]);
}

// Whoever asks for nothing has boxes that are left alone, to the bit.
static void box_without_demands_stays(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 10);
    struct box box = box_cube(3, 0.1, 0.3);
    struct box same = box_cube(3, 0.1, 0.3);
    struct demands demands;
    demands_init(&demands, &(struct scenario_search){.samples = 1}, all, &space);
    assert_false(demands.any);
    assert_true(demands_meet(&demands, &box, DEMANDS_TIE_MEAN));
    assert_true(demands_meet(NULL, &box, DEMANDS_TIE_MEAN));
    assert_true(box_equal(&box, &same));
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&box);
    box_fini(&same);
}

// A corridor is widened about its middle, but not past the space and not at a held bound.
static void corridors_get_their_minimum_widths(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 10);
    struct box box = box_cube(3, 5, 6);
    set(&box, 1, 9, 9.5);
    set(&box, 2, 0, 1);
    double widths[3] = {3, 3, 3};
    double held[3] = {NAN, NAN, 0};
    const struct scenario_search settings = {.minimum_widths = widths, .hold.lower = held};
    struct demands demands;
    demands_init(&demands, &settings, all, &space);
    assert_true(demands_meet(&demands, &box, DEMANDS_TIE_MEAN));
    assert_interval(&box, 0, 4, 7);
    assert_interval(&box, 1, 7, 10);
    assert_interval(&box, 2, 0, 3);
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&box);
}

// The reference is taken in, and held bounds are put back, whatever moved them.
static void reference_stays_inside_and_held_bounds_stay(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 10);
    struct box box = box_cube(3, 4, 6);
    double reference[3] = {2, 5, 9};
    double held[3] = {NAN, 10, NAN};
    const struct scenario_search settings = {.reference = reference, .hold.upper = held};
    struct demands demands;
    demands_init(&demands, &settings, all, &space);
    assert_true(demands_meet(&demands, &box, DEMANDS_TIE_MEAN));
    assert_interval(&box, 0, 2, 6);
    assert_interval(&box, 1, 4, 10);
    assert_interval(&box, 2, 4, 9);
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&box);
}

// Tied corridors come to their mean, to what they have in common, or to all of them; where they
// have nothing in common the box is left as it was. Of two variables in three, the fixed one before
// them does not count.
static void tied_corridors_become_one(void **state)
{
    (void)state;
    static const uint32_t free_ones[2] = {1, 2};
    uint32_t tie[3] = {0, 1, 1};
    struct box space = box_cube(2, 0, 10);
    struct box box = box_cube(2, 2, 6);
    struct demands demands;
    demands_init(&demands, &(struct scenario_search){.tie = tie}, free_ones, &space);
    static const double expected[3][2] = {{3, 7}, {4, 6}, {2, 8}};
    for (int way = 0; way < 3; way++) {
        set(&box, 0, 2, 6);
        set(&box, 1, 4, 8);
        assert_true(demands_meet(&demands, &box, (enum demands_tie)way));
        for (uint32_t v = 0; v < 2; v++)
            assert_interval(&box, v, expected[way][0], expected[way][1]);
    }
    set(&box, 0, 1, 2);
    set(&box, 1, 3, 4);
    assert_false(demands_meet(&demands, &box, DEMANDS_TIE_INSIDE));
    assert_interval(&box, 0, 1, 2);
    assert_interval(&box, 1, 3, 4);
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&box);
}

// Half the width of a variable that counts twice costs as much as a quarter of a common one's.
static void widths_count_by_their_weights(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 8);
    struct box one = box_cube(3, 0, 8);
    struct box other = box_cube(3, 0, 8);
    double weights[3] = {2, 1, 0.5};
    struct demands demands;
    demands_init(&demands, &(struct scenario_search){.weights = weights}, all, &space);
    set(&one, 0, 1, 5);
    set(&other, 1, 1, 3);
    const struct volume halved = demands_volume(&demands, &one, &space);
    const struct volume quartered = demands_volume(&demands, &other, &space);
    assert_true(fabs(ldexp(halved.mantissa, (int)halved.exponent) - 0.25) < 1e-14);
    assert_true(fabs(ldexp(quartered.mantissa, (int)quartered.exponent) - 0.25) < 1e-14);
    set(&other, 1, 0, 8);
    set(&other, 2, 0, 7);
    const struct volume root = demands_volume(&demands, &other, &space);
    assert_true(fabs(ldexp(root.mantissa, (int)root.exponent) - sqrt(7.0 / 8)) < 1e-14);
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&one);
    box_fini(&other);
}

// Sides go inwards to multiples, but not where they are held, or where the width, the least width
// or the reference would be lost.
static void boxes_are_rounded_inwards(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 10);
    struct box box = box_cube(3, 1.5, 7.5);
    double widths[3] = {0, 5.5, 0}, held[3] = {1.5, NAN, NAN};
    const struct scenario_search settings = {.minimum_widths = widths, .hold.lower = held};
    struct demands demands;
    demands_init(&demands, &settings, all, &space);
    set(&box, 2, 3.5, 4.5);
    demands_round(&demands, 1, &box);
    assert_interval(&box, 0, 1.5, 7);
    assert_interval(&box, 1, 1.5, 7.5);
    assert_interval(&box, 2, 3.5, 4.5);
    demands_fini(&demands);
    double reference[3] = {5, 7.2, 5};
    demands_init(&demands, &(struct scenario_search){.reference = reference}, all, &space);
    set(&box, 2, 3.5, 6.5);
    demands_round(&demands, 1, &box);
    assert_interval(&box, 0, 2, 7);
    assert_interval(&box, 1, 1.5, 7.5);
    assert_interval(&box, 2, 4, 6);
    demands_fini(&demands);
    box_fini(&space);
    box_fini(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_rounded_inwards),
        cmocka_unit_test(box_without_demands_stays),
        cmocka_unit_test(corridors_get_their_minimum_widths),
        cmocka_unit_test(reference_stays_inside_and_held_bounds_stay),
        cmocka_unit_test(tied_corridors_become_one),
        cmocka_unit_test(widths_count_by_their_weights),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
