#include "common/numeric/curve_map.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// In models without curves each variable is its own.
static void every_variable_begins_as_a_curve_of_its_own(void **state)
{
    (void)state;
    struct curve_map map;
    curve_map_init(&map, 3);
    assert_int_equal(map.count, 3);
    assert_int_equal(map.group_count, 3);
    for (uint32_t v = 0; v < 3; v++) {
        assert_int_equal(map.curve[v], v);
        assert_int_equal(map.group[v], v);
    }
    curve_map_fini(&map);
    curve_map_fini(&map); // a zeroed one is fine
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_variable_begins_as_a_curve_of_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
