#include "common/numeric/box.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static struct box box_of(uint32_t count, const double *lower, const double *upper)
{
    struct box box;
    box_init(&box, count);
    memcpy(box.lower, lower, count * sizeof *lower);
    memcpy(box.upper, upper, count * sizeof *upper);
    return box;
}

#define BOX(lower, upper) box_of(sizeof(lower) / sizeof *(lower), lower, upper)

static const double space_lower[] = {0, 5, -2};
static const double space_upper[] = {10, 5, 2};

// A fixed variable has no width; counted in, it would make every volume zero.
static void fixed_variables_do_not_count(void **state)
{
    (void)state;
    struct box space = BOX(space_lower, space_upper);
    struct box box = BOX(((double[]){0, 5, -1}), ((double[]){5, 5, 1}));
    assert_true(fabs(box_log_volume(&box, &space) - log(0.25)) < 1e-15);
    assert_true(box_log_volume(&space, &space) == 0);
    assert_int_equal(box_free_count(&space), 2);
    box_fini(&space);
    box_fini(&box);
}

// A box without width has no volume and says so.
static void flat_box_has_volume_minus_infinity(void **state)
{
    (void)state;
    struct box space = BOX(space_lower, space_upper);
    struct box box = BOX(((double[]){3, 5, -1}), ((double[]){3, 5, 1}));
    assert_true(box_log_volume(&box, &space) == -INFINITY);
    box_fini(&space);
    box_fini(&box);
}

// Bounds belong to the box; a coordinate that is not a number does not.
static void bounds_are_inside_and_nan_is_not(void **state)
{
    (void)state;
    struct box space = BOX(space_lower, space_upper);
    assert_true(box_contains(&space, space_lower));
    assert_true(box_contains(&space, space_upper));
    assert_false(box_contains(&space, (double[]){1, 5.5, 0}));
    assert_false(box_contains(&space, (double[]){1, 5, NAN}));
    box_fini(&space);
}

// A box lies inside itself, and not once a bound sticks out.
static void inside_compares_every_bound(void **state)
{
    (void)state;
    struct box space = BOX(space_lower, space_upper);
    struct box box;
    box_init(&box, 3);
    box_assign(&box, &space);
    assert_true(box_inside(&box, &space));
    assert_true(box_equal(&box, &space));
    box.upper[2] = nextafter(2, 3);
    assert_false(box_inside(&box, &space));
    assert_true(box_inside(&space, &box));
    assert_false(box_equal(&box, &space));
    box_fini(&space);
    box_fini(&box);
}

// 0 and -0 compare equal as numbers; a digest sees their bits, so equality must too.
static void equality_is_of_bits(void **state)
{
    (void)state;
    struct box plus = BOX(((double[]){0.0}), ((double[]){1.0}));
    struct box minus = BOX(((double[]){-0.0}), ((double[]){1.0}));
    assert_false(box_equal(&plus, &minus));
    box_fini(&plus);
    box_fini(&minus);
}

// Releasing what was never filled is safe, on every exit ladder.
static void zeroed_box_can_be_released(void **state)
{
    (void)state;
    struct box box = {0};
    box_fini(&box);
    box_fini(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fixed_variables_do_not_count),
        cmocka_unit_test(flat_box_has_volume_minus_infinity),
        cmocka_unit_test(bounds_are_inside_and_nan_is_not),
        cmocka_unit_test(inside_compares_every_bound),
        cmocka_unit_test(equality_is_of_bits),
        cmocka_unit_test(zeroed_box_can_be_released),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
