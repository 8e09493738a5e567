#include "common/sampling/sobol.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const struct sampling sampling = {
    .seed = 5, .step = 9, .samples = 4096, .method = SAMPLING_METHOD_SOBOL};

// The first 2^k points have one point in each of 2^k strata, in every variable: also in those whose
// polynomial has a high degree, where a wrong recurrence would show.
static void each_variable_fills_its_strata(void **state)
{
    (void)state;
    static const uint32_t variables[] = {0, 1, 2, 3, 17, 100, 719, 4095};
    for (size_t v = 0; v < sizeof variables / sizeof *variables; v++) {
        struct sobol sobol;
        sobol_init(&sobol, &sampling, variables[v]);
        for (uint32_t count = 1; count <= 4096; count *= 2) {
            uint8_t seen[4096];
            memset(seen, 0, sizeof seen);
            for (uint32_t i = 0; i < count; i++) {
                double unit = sobol_of(&sobol, i);
                assert_true(unit >= 0 && unit < 1);
                uint32_t stratum = (uint32_t)(unit * count);
                assert_false(seen[stratum]);
                seen[stratum] = 1;
            }
        }
    }
}

// The first two variables form a (0, m, 2)-net: every division of the square into 256 equal
// rectangles by halving has one of 256 points in each.
static void first_two_variables_fill_every_rectangle(void **state)
{
    (void)state;
    struct sobol x;
    struct sobol y;
    sobol_init(&x, &sampling, 0);
    sobol_init(&y, &sampling, 1);
    for (uint32_t columns = 1; columns <= 256; columns *= 2) {
        const uint32_t rows = 256 / columns;
        uint8_t seen[256] = {0};
        for (uint32_t i = 0; i < 256; i++) {
            uint32_t column = (uint32_t)(sobol_of(&x, i) * columns);
            uint32_t row = (uint32_t)(sobol_of(&y, i) * rows);
            assert_false(seen[row * columns + column]);
            seen[row * columns + column] = 1;
        }
    }
}

// No two variables share a polynomial and its start: their points would coincide.
static void variables_differ(void **state)
{
    (void)state;
    enum { VARIABLES = 300, POINTS = 64 };
    static double points[VARIABLES][POINTS];
    for (uint32_t v = 0; v < VARIABLES; v++) {
        struct sobol sobol;
        sobol_init(&sobol, &sampling, v);
        for (uint32_t i = 0; i < POINTS; i++)
            points[v][i] = sobol_of(&sobol, i);
    }
    for (uint32_t a = 0; a < VARIABLES; a++) {
        for (uint32_t b = 0; b < a; b++) {
            double sum = 0;
            for (uint32_t i = 0; i < POINTS; i++)
                sum += (points[a][i] - 0.5) * (points[b][i] - 0.5);
            assert_true(sum / POINTS * 12 < 0.95 && sum / POINTS * 12 > -0.95);
        }
    }
}

// Another step is scrambled otherwise, or all steps would sample the same places.
static void steps_differ(void **state)
{
    (void)state;
    struct sampling next = sampling;
    next.step++;
    struct sobol one;
    struct sobol two;
    sobol_init(&one, &sampling, 3);
    sobol_init(&two, &next, 3);
    uint32_t same = 0;
    for (uint32_t i = 0; i < 256; i++)
        same += (uint32_t)(sobol_of(&one, i) * 256) == (uint32_t)(sobol_of(&two, i) * 256);
    assert_true(same < 16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_variable_fills_its_strata),
        cmocka_unit_test(first_two_variables_fill_every_rectangle),
        cmocka_unit_test(variables_differ),
        cmocka_unit_test(steps_differ),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
