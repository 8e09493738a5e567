#include "common/sampling/sampling.h"

#include "common/numeric/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { VARIABLES = 5 };
static double lower[VARIABLES] = {0, -1e5, 3, 1e-3, -7};
static double upper[VARIABLES] = {1, 450e3, 3, 2e-3, -6.5};
static const struct box box = {.count = VARIABLES, .lower = lower, .upper = upper};

static struct sampling sampling_of(enum sampling_method method, uint32_t samples)
{
    return (struct sampling){.seed = 42, .step = 17, .samples = samples, .method = method};
}

// The coordinator remakes only the samples it needs: any of them alone is what it was among all.
static void picked_samples_are_those_of_the_step(void **state)
{
    (void)state;
    static const enum sampling_method methods[] = {
        SAMPLING_METHOD_UNIFORM, SAMPLING_METHOD_LATIN_HYPERCUBE, SAMPLING_METHOD_SOBOL};
    enum { SAMPLES = 300, PICKED = 100 };
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        const struct sampling sampling = sampling_of(methods[m], SAMPLES);
        static double all[VARIABLES * SAMPLES];
        static double picked[VARIABLES * PICKED];
        uint32_t index[PICKED];
        for (uint32_t i = 0; i < PICKED; i++)
            index[i] = i < 50 ? i + i / 7 : 100 + 4 * (i - 50) - i % 2;
        sampling_fill(&sampling, &box, 0, SAMPLES, all, SAMPLES);
        sampling_pick(&sampling, &box, index, PICKED, picked, PICKED);
        for (uint32_t v = 0; v < VARIABLES; v++) {
            for (uint32_t i = 0; i < PICKED; i++)
                assert_true(picked[v * PICKED + i] == all[v * SAMPLES + index[i]]);
        }
    }
}

// The vector code must give what the definition in random.h gives, bit for bit: workers and
// coordinator make the same samples apart.
static void uniform_samples_follow_the_definition(void **state)
{
    (void)state;
    const struct sampling sampling = sampling_of(SAMPLING_METHOD_UNIFORM, 1000);
    double values[VARIABLES * 130];
    sampling_fill(&sampling, &box, 77, 129, values, 130);
    for (uint32_t v = 0; v < VARIABLES; v++) {
        for (uint32_t i = 0; i < 129; i++) {
            double unit = random_uniform(42, 0, 17, 77 + i, v);
            double expected = lower[v] + unit * (upper[v] - lower[v]);
            assert_true(values[v * 130 + i] == expected);
        }
    }
}

// A step cut into batches in any way gives the samples of the whole step.
static void any_part_equals_the_whole(void **state)
{
    (void)state;
    for (int method = 0; method <= SAMPLING_METHOD_SOBOL; method++) {
        const struct sampling sampling = sampling_of((enum sampling_method)method, 300);
        double whole[VARIABLES * 300];
        sampling_fill(&sampling, &box, 0, 300, whole, 300);
        for (uint32_t first = 0, count = 1; first < 300; first += count, count = count * 2 + 1) {
            if (first + count > 300)
                count = 300 - first;
            double part[VARIABLES * 300];
            sampling_fill(&sampling, &box, first, count, part, count);
            for (uint32_t v = 0; v < VARIABLES; v++)
                assert_memory_equal(part + v * count, whole + v * 300 + first,
                                    count * sizeof *part);
        }
    }
}

// Nothing leaves the box by rounding; fixed variables keep their value exactly; and memory beyond
// `count` is the caller's own.
static void samples_stay_in_the_box(void **state)
{
    (void)state;
    for (int method = 0; method <= SAMPLING_METHOD_SOBOL; method++) {
        const struct sampling sampling = sampling_of((enum sampling_method)method, 4000);
        double *values = malloc(VARIABLES * 4001 * sizeof *values);
        for (uint32_t v = 0; v < VARIABLES; v++)
            values[v * 4001 + 4000] = -1234;
        sampling_fill(&sampling, &box, 0, 4000, values, 4001);
        for (uint32_t v = 0; v < VARIABLES; v++) {
            double sum = 0;
            for (uint32_t i = 0; i < 4000; i++) {
                double value = values[v * 4001 + i];
                assert_true(value >= lower[v] && value <= upper[v]);
                sum += value;
            }
            assert_true(values[v * 4001 + 4000] == -1234);
            // Within 5 standard errors of the middle.
            double width = upper[v] - lower[v];
            assert_true(fabs(sum / 4000 - (lower[v] + upper[v]) / 2) <= width * 0.0229);
        }
        free(values);
    }
}

// A number just below 1 times a wide interval may round up past its bound.
static void rounding_never_passes_the_upper_bound(void **state)
{
    (void)state;
    double tight_lower[] = {1e16};
    double tight_upper[] = {1e16 + 2};
    const struct box tight = {.count = 1, .lower = tight_lower, .upper = tight_upper};
    const struct sampling sampling = sampling_of(SAMPLING_METHOD_LATIN_HYPERCUBE, 512);
    double values[512];
    sampling_fill(&sampling, &tight, 0, 512, values, 512);
    for (int i = 0; i < 512; i++)
        assert_true(values[i] >= tight_lower[0] && values[i] <= tight_upper[0]);
}

// Each variable has exactly one sample in each stratum, whatever the number of samples.
static void latin_hypercube_fills_each_stratum_once(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 7, 64, 100, 200, 257, 1000};
    double unit_lower[] = {0, 0, 0};
    double unit_upper[] = {1, 1, 1};
    const struct box unit = {.count = 3, .lower = unit_lower, .upper = unit_upper};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        const uint32_t count = counts[c];
        const struct sampling sampling = sampling_of(SAMPLING_METHOD_LATIN_HYPERCUBE, count);
        double values[3 * 1000];
        sampling_fill(&sampling, &unit, 0, count, values, 1000);
        for (uint32_t v = 0; v < 3; v++) {
            char seen[1000] = {0};
            for (uint32_t i = 0; i < count; i++) {
                uint32_t stratum = (uint32_t)(values[v * 1000 + i] * count);
                assert_true(stratum < count && !seen[stratum]);
                seen[stratum] = 1;
            }
        }
    }
}

// The strata of two variables, and of two steps, must not follow each other: the correlation of
// 1000 pairs stays within 5 standard errors of none.
static void latin_hypercube_variables_are_independent(void **state)
{
    (void)state;
    double unit_lower[] = {-0.5, -0.5, -0.5, -0.5};
    double unit_upper[] = {0.5, 0.5, 0.5, 0.5};
    const struct box unit = {.count = 4, .lower = unit_lower, .upper = unit_upper};
    double values[5 * 1000];
    struct sampling sampling = sampling_of(SAMPLING_METHOD_LATIN_HYPERCUBE, 1000);
    sampling_fill(&sampling, &unit, 0, 1000, values, 1000);
    sampling.step++;
    const struct box first = {.count = 1, .lower = unit_lower, .upper = unit_upper};
    sampling_fill(&sampling, &first, 0, 1000, values + 4000, 1000);
    for (int a = 0; a < 5; a++) {
        for (int b = 0; b < a; b++) {
            double sum = 0;
            for (int i = 0; i < 1000; i++)
                sum += values[a * 1000 + i] * values[b * 1000 + i];
            assert_true(fabs(sum / 1000 * 12) < 5 / sqrt(1000));
        }
    }
}

// Two springs of two points: the curves are {0, 1}, {2, 3}, {4, 5}, {6, 7}; x is group 0, y is 1.
static struct curve_map two_springs(void)
{
    struct curve_map map;
    curve_map_init(&map, 8);
    map.count = 4;
    map.group_count = 2;
    for (uint32_t v = 0; v < 8; v++) {
        map.curve[v] = v / 2;
        map.group[v] = v / 2 % 2;
    }
    return map;
}

static const struct box corridor = {.count = 8,
                                    .lower = (double[]){0, 10, 0, 10, 0, 10, 0, 10},
                                    .upper = (double[]){1, 30, 1, 30, 1, 30, 1, 30}};

static double level_of(const double *values, uint32_t variable, uint32_t sample)
{
    return (values[variable * 3000 + sample] - corridor.lower[variable]) /
           (corridor.upper[variable] - corridor.lower[variable]);
}

// What the kinds of designs are (design.md section 4), by their definitions: levels within a curve
// agree, between curves only where they have to.
static void kinds_of_designs_are_what_they_say(void **state)
{
    (void)state;
    struct curve_map map = two_springs();
    double *values = calloc(8 * 3000, sizeof *values);
    for (int kind = DESIGN_KIND_CURVES; kind < DESIGN_KIND_COUNT; kind++) {
        struct sampling sampling = sampling_of(protocol_kind_method((enum design_kind)kind), 3000);
        sampling.curves = &map;
        sampling_fill(&sampling, &corridor, 0, 3000, values, 3000);
        uint32_t at_lower = 0, at_upper = 0, x_agree = 0, y_agree_with_x = 0;
        double sum = 0;
        for (uint32_t i = 0; i < 3000; i++) {
            for (uint32_t v = 0; v < 8; v += 2)
                assert_float_equal(level_of(values, v, i), level_of(values, v + 1, i), 1e-12);
            sum += level_of(values, 0, i);
            at_lower += values[i] == 0 && values[3000 + i] == 10;
            at_upper += values[i] == 1 && values[3000 + i] == 30;
            x_agree += fabs(level_of(values, 0, i) - level_of(values, 4, i)) < 1e-12;
            y_agree_with_x += fabs(level_of(values, 0, i) - level_of(values, 2, i)) < 1e-12;
        }
        assert_float_equal(sum / 3000, 0.5, 0.04);
        const bool extremes = kind == DESIGN_KIND_EXTREMES;
        assert_in_range(at_lower, extremes ? 900 : 0, extremes ? 1100 : 1);
        assert_in_range(at_upper, extremes ? 900 : 0, extremes ? 1100 : 1);
        if (kind == DESIGN_KIND_LEVELS)
            assert_int_equal(x_agree, 3000);
        else
            assert_true(x_agree < 1000);
        assert_true(y_agree_with_x < 1000);
    }
    free(values);
    curve_map_fini(&map);
}

// A worker makes any part of a step, the coordinator single samples: the same bits.
static void kinds_are_a_function_of_their_place(void **state)
{
    (void)state;
    struct curve_map map = two_springs();
    for (int kind = DESIGN_KIND_CURVES; kind < DESIGN_KIND_COUNT; kind++) {
        struct sampling sampling = sampling_of(protocol_kind_method((enum design_kind)kind), 300);
        sampling.curves = &map;
        double whole[8 * 300], part[8 * 37], one[8];
        sampling_fill(&sampling, &corridor, 0, 300, whole, 300);
        sampling_fill(&sampling, &corridor, 101, 37, part, 37);
        const uint32_t index = 123;
        sampling_pick(&sampling, &corridor, &index, 1, one, 1);
        for (uint32_t v = 0; v < 8; v++) {
            assert_true(part[v * 37 + 5] == whole[v * 300 + 106]);
            assert_true(one[v] == whole[v * 300 + index]);
        }
    }
    curve_map_fini(&map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picked_samples_are_those_of_the_step),
        cmocka_unit_test(uniform_samples_follow_the_definition),
        cmocka_unit_test(any_part_equals_the_whole),
        cmocka_unit_test(samples_stay_in_the_box),
        cmocka_unit_test(rounding_never_passes_the_upper_bound),
        cmocka_unit_test(latin_hypercube_fills_each_stratum_once),
        cmocka_unit_test(latin_hypercube_variables_are_independent),
        cmocka_unit_test(kinds_of_designs_are_what_they_say),
        cmocka_unit_test(kinds_are_a_function_of_their_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
