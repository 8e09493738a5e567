#include "coordinator/search/volume.h"

#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// A thousandth in each of 700 variables is 1e-2100: a double would call it zero and every box
// equal.
static void tiny_volumes_stay_apart(void **state)
{
    (void)state;
    struct box space = box_cube(700, 0, 1);
    struct box small = box_cube(700, 0, 1e-3);
    struct box smaller = box_cube(700, 0, 1e-3);
    smaller.upper[350] = 1e-3 * (1 - 1e-12);
    struct volume a = volume_of(&small, &space);
    struct volume b = volume_of(&smaller, &space);
    assert_true(volume_above(a, b));
    assert_false(volume_above(b, a));
    assert_false(volume_above(a, a));
    box_fini(&space);
    box_fini(&small);
    box_fini(&smaller);
}

// Without width in a free variable there is no volume; a fixed variable does not matter.
static void flat_box_has_none(void **state)
{
    (void)state;
    struct box space = box_cube(3, 0, 2);
    space.upper[1] = 0;
    struct box box = box_cube(3, 0, 1);
    box.upper[1] = 0;
    struct volume quarter = volume_of(&box, &space);
    assert_true(ldexp(quarter.mantissa, (int)quarter.exponent) == 0.25);
    box.upper[2] = 0;
    struct volume flat = volume_of(&box, &space);
    assert_true(flat.mantissa == 0);
    assert_true(volume_above(quarter, flat));
    assert_false(volume_above(flat, quarter));
    assert_false(volume_above(flat, flat));
    box_fini(&space);
    box_fini(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiny_volumes_stay_apart),
        cmocka_unit_test(flat_box_has_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
