#include "coordinator/search/seek.h"

#include "common/numeric/random.h"
#include "common/numeric/verdict.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { SAMPLES = 200 };

// A good cube around (0.3, ...) in [-1, 1]^n; the violation is the distance from it.
struct target {
    double half; // below 0: there is none
};

static void sample(struct seek *seek, const struct target *target)
{
    const uint32_t variables = seek->space->count;
    struct cloud good;
    struct cloud bad;
    cloud_init(&good, variables);
    cloud_init(&bad, variables);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        double point[32];
        double worst = -1;
        for (uint32_t v = 0; v < variables; v++) {
            const double width = seek->box.upper[v] - seek->box.lower[v];
            point[v] = seek->box.lower[v] + random_uniform(1, 0, seek->round, i, v) * width;
            worst = fmax(worst, fabs(point[v] - 0.3) - target->half);
        }
        if (worst <= 0)
            cloud_add(&good, point, 1, 0);
        else
            cloud_add(&bad, point, 1, verdict_violation(worst));
    }
    seek_complete(seek, &good, &bad, SAMPLES);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// Where good designs are common the first round finds enough of them.
static void common_good_designs_need_one_round(void **state)
{
    (void)state;
    struct box space = box_cube(2, -1, 1);
    struct seek seek;
    seek_init(&seek, &space, 3);
    sample(&seek, &(struct target){.half = 0.5});
    assert_int_equal(seek.state, SEEK_FOUND);
    assert_int_equal(seek.round, 1);
    seek_fini(&seek);
    box_fini(&space);
}

// A region of a share of 1e-20: the violation leads there, and the box stays in the design space.
static void violation_leads_to_a_tiny_region(void **state)
{
    (void)state;
    struct box space = box_cube(10, -1, 1);
    struct seek seek;
    seek_init(&seek, &space, 3);
    while (seek.state == SEEK_LOOKING) {
        assert_true(box_inside(&seek.box, &space));
        sample(&seek, &(struct target){.half = 0.01});
    }
    assert_int_equal(seek.state, SEEK_FOUND);
    for (uint32_t v = 0; v < 10; v++)
        assert_true(fabs(cloud_column(&seek.good, v)[0] - 0.3) <= 0.01);
    seek_fini(&seek);
    box_fini(&space);
}

// No good design anywhere: it ends, and the least violating design is known.
static void seeking_ends_without_a_good_design(void **state)
{
    (void)state;
    struct box space = box_cube(3, -1, 1);
    struct seek seek;
    seek_init(&seek, &space, 3);
    while (seek.state == SEEK_LOOKING)
        sample(&seek, &(struct target){.half = -0.2});
    assert_int_equal(seek.state, SEEK_FAILED);
    assert_int_equal(seek.round, SEEK_WHOLE_ROUNDS + SEEK_NEAR_ROUNDS);
    for (uint32_t v = 0; v < 3; v++)
        assert_true(fabs(cloud_column(&seek.elite, v)[0] - 0.3) < 0.02);
    seek_fini(&seek);
    box_fini(&space);
}

// The middle of the good designs first, then the good one nearest to it, then one half-way out,
// then the one farthest from those chosen; none twice.
static void starts_lie_far_apart(void **state)
{
    (void)state;
    struct box space = box_cube(1, 0, 10);
    struct seek seek;
    seek_init(&seek, &space, 6);
    struct cloud good = CLOUD(1, 1, 3, 5, 5.1, 6, 9.9);
    struct cloud none;
    struct cloud starts;
    cloud_init(&none, 1);
    cloud_init(&starts, 1);
    seek_complete(&seek, &good, &none, 6);
    seek_starts(&seek, 4, &starts);
    assert_int_equal(starts.count, 4);
    assert_true(fabs(starts.values[0] - 5) < 1e-12);
    assert_true(starts.values[1] == 5);
    assert_true(starts.values[2] == 3);
    assert_true(starts.values[3] == 9.9);
    cloud_clear(&starts);
    seek_starts(&seek, 20, &starts);
    assert_int_equal(starts.count, 7);
    for (uint32_t i = 1; i < 7; i++) {
        for (uint32_t j = 1; j < i; j++)
            assert_true(starts.values[i] != starts.values[j]);
    }
    seek_fini(&seek);
    cloud_fini(&good);
    cloud_fini(&none);
    cloud_fini(&starts);
    box_fini(&space);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(common_good_designs_need_one_round),
        cmocka_unit_test(violation_leads_to_a_tiny_region),
        cmocka_unit_test(seeking_ends_without_a_good_design),
        cmocka_unit_test(starts_lie_far_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
