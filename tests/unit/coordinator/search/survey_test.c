#include "coordinator/search/survey.h"

#include "common/numeric/random.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.6g is not %.6g", value, expected);
}

// By hand: ten samples of [0, 1] and thirty of [0, 3]. A bad sample where both looked is one of 20
// a unit of length, one where only the second looked one of 10.
static void bad_samples_stand_for_what_was_looked_at(void **state)
{
    (void)state;
    struct box space = box_cube(1, 0, 10);
    struct box narrow = box_cube(1, 0, 1);
    struct box wide = box_cube(1, 0, 3);
    struct cloud first = CLOUD(1, 0.5);
    struct cloud second = CLOUD(1, 0.25, 2.0);
    struct survey survey;
    survey_init(&survey, &space);
    survey_add(&survey, &narrow, 10, &first, 100);
    survey_add(&survey, &wide, 30, &second, 100);
    assert_near(survey_share(&survey, &narrow), 2 / 20.0, 1e-12);
    assert_near(survey_share(&survey, &wide), (2 / 20.0 + 1 / 10.0) / 3, 1e-12);
    struct cloud inside;
    cloud_init(&inside, 1);
    double *mass = survey_inside(&survey, &wide, &inside);
    assert_int_equal(inside.count, 3);
    assert_near(mass[0], 1 / 60.0, 1e-12);
    assert_near(mass[2], 1 / 30.0, 1e-12);
    g_free(mass);
    cloud_fini(&inside);
    survey_fini(&survey);
    cloud_fini(&first);
    cloud_fini(&second);
    box_fini(&space);
    box_fini(&narrow);
    box_fini(&wide);
}

// A box that no step sampled, by the samples of twenty others that overlap it. Bad is x + y > 1.2.
static void shares_of_other_boxes_are_estimated(void **state)
{
    (void)state;
    struct box space = box_cube(2, 0, 1);
    struct box box = box_cube(2, 0, 1);
    struct survey survey;
    survey_init(&survey, &space);
    for (uint32_t step = 0; step < 20; step++) {
        for (uint32_t v = 0; v < 2; v++) {
            box.lower[v] = 0.2 * random_uniform(1, 0, step, 0, v);
            box.upper[v] = 0.8 + 0.2 * random_uniform(1, 0, step, 1, v);
        }
        struct cloud bad;
        cloud_init(&bad, 2);
        for (uint32_t i = 0; i < 1000; i++) {
            double point[2];
            for (uint32_t v = 0; v < 2; v++)
                point[v] =
                    box.lower[v] + random_uniform(2, 0, step, i, v) * (box.upper[v] - box.lower[v]);
            if (point[0] + point[1] > 1.2)
                cloud_add(&bad, point, 1, 1);
        }
        survey_add(&survey, &box, 1000, &bad, 1000000);
        cloud_fini(&bad);
    }
    box.lower[0] = box.lower[1] = 0.2;
    box.upper[0] = box.upper[1] = 0.8;
    assert_near(survey_share(&survey, &box), 0.16 / 2 / 0.36, 0.01);
    survey_fini(&survey);
    box_fini(&space);
    box_fini(&box);
}

// Steps go with their samples: what is forgotten does not count as looked at either.
static void oldest_steps_are_forgotten_whole(void **state)
{
    (void)state;
    struct box space = box_cube(1, 0, 1);
    struct cloud bad = CLOUD(1, 0.1, 0.6);
    struct survey survey;
    survey_init(&survey, &space);
    for (uint32_t step = 0; step < 5; step++)
        survey_add(&survey, &space, 10, &bad, 5);
    assert_int_equal(survey.step_count, 2);
    assert_int_equal(survey.bad.count, 4);
    assert_near(survey_share(&survey, &space), 0.2, 1e-12);
    survey_add(&survey, &space, 10, &bad, 1);
    assert_int_equal(survey.step_count, 1);
    assert_int_equal(survey.bad.count, 2);
    survey_fini(&survey);
    cloud_fini(&bad);
    box_fini(&space);
}

// A single design has no volume and tells of no box.
static void designs_tell_of_no_box(void **state)
{
    (void)state;
    struct box space = box_cube(1, 0, 1);
    struct box design = box_cube(1, 0.5, 0.5);
    struct cloud bad = CLOUD(1, 0.5);
    struct survey survey;
    survey_init(&survey, &space);
    survey_add(&survey, &design, 1, &bad, 100);
    assert_near(survey_share(&survey, &space), 0, 0);
    survey_fini(&survey);
    cloud_fini(&bad);
    box_fini(&space);
    box_fini(&design);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_samples_stand_for_what_was_looked_at),
        cmocka_unit_test(shares_of_other_boxes_are_estimated),
        cmocka_unit_test(oldest_steps_are_forgotten_whole),
        cmocka_unit_test(designs_tell_of_no_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
