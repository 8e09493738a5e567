// The points of a picture: the very samples that were evaluated, each with what became of it.
#include "monitor/http/xray.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static double lower[] = {0, 10, 5}, upper[] = {1, 20, 5};
static struct verdict verdicts[] = {
    {0}, {.violation = VERDICT_NON_FINITE, .constraint = 1}, {.violation = 1 << 14}};

static struct album_picture picture_make(void)
{
    return (struct album_picture){
        .sampling = {.seed = 3, .step = 8, .samples = 50, .method = SAMPLING_METHOD_SOBOL},
        .phase = 1,
        .good = 40,
        .count = 3,
        .verdicts = verdicts,
        .sampled = {.count = 3, .lower = lower, .upper = upper},
        .box = {.count = 3, .lower = lower, .upper = upper},
    };
}

static json_t *points(const struct album_picture *picture, uint32_t x, uint32_t y)
{
    GString *text = g_string_new(NULL);
    assert_true(xray_points(picture, x, y, text));
    json_t *object = json_loads(text->str, 0, NULL);
    assert_non_null(object);
    g_string_free(text, TRUE);
    return object;
}

static double at(const json_t *object, size_t sample, size_t place)
{
    const json_t *point = json_array_get(json_object_get(object, "points"), sample);
    return json_number_value(json_array_get(point, place));
}

// What a worker would draw is drawn: coordinates come from the step's numbers, not from anywhere
// near them.
static void points_are_the_samples_of_the_step(void **state)
{
    (void)state;
    const struct album_picture picture = picture_make();
    double values[9];
    sampling_fill(&picture.sampling, &picture.sampled, 0, 3, values, 3);
    json_t *object = points(&picture, 1, 0);
    for (size_t i = 0; i < 3; i++) {
        assert_float_equal(at(object, i, 0), values[3 + i], 1e-7);
        assert_float_equal(at(object, i, 1), values[i], 1e-7);
    }
    assert_int_equal(at(object, 0, 2), -1);
    assert_int_equal(at(object, 1, 2), 1);
    const json_t *list = json_object_get(object, "points");
    assert_true(json_is_null(json_array_get(json_array_get(list, 1), 3))); // not finite
    assert_true(at(object, 2, 3) > 0);
    json_decref(object);
}

// A certificate tells good from bad and not why: no constraint is blamed.
static void certificate_blames_no_constraint(void **state)
{
    (void)state;
    struct album_picture picture = picture_make();
    picture.detail = VERDICT_DETAIL_SHARE;
    json_t *object = points(&picture, 0, 1);
    const json_t *list = json_object_get(object, "points");
    assert_true(json_is_null(json_array_get(json_array_get(list, 1), 2)));
    assert_true(json_is_null(json_array_get(json_array_get(list, 1), 3)));
    assert_int_equal(at(object, 0, 2), -1);
    json_decref(object);
}

static void variables_that_are_not_there_are_refused(void **state)
{
    (void)state;
    const struct album_picture picture = picture_make();
    GString *text = g_string_new(NULL);
    assert_false(xray_points(&picture, 3, 0, text));
    assert_false(xray_points(&picture, 0, UINT32_MAX, text));
    assert_int_equal(text->len, 0);
    g_string_free(text, TRUE);
}

// The table gives designs back to the bit, so that one can be simulated again.
static void table_is_exact(void **state)
{
    (void)state;
    const struct album_picture picture = picture_make();
    double values[9];
    sampling_fill(&picture.sampling, &picture.sampled, 0, 3, values, 3);
    GString *text = g_string_new(NULL);
    xray_csv(&picture, NULL, text);
    char **lines = g_strsplit(text->str, "\n", -1);
    assert_int_equal(g_strv_length(lines), 5); // a head, three samples, the end
    char **cells = g_strsplit(lines[1], ",", -1);
    assert_int_equal(g_strv_length(cells), 7);
    for (size_t v = 0; v < 3; v++)
        assert_true(g_ascii_strtod(cells[4 + v], NULL) == values[3 * v]);
    assert_true(g_str_has_prefix(lines[2], "1,0,1,"));
    g_strfreev(cells);
    g_strfreev(lines);
    g_string_free(text, TRUE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_the_samples_of_the_step),
        cmocka_unit_test(certificate_blames_no_constraint),
        cmocka_unit_test(variables_that_are_not_there_are_refused),
        cmocka_unit_test(table_is_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
