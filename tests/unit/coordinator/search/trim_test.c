#include "coordinator/search/trim.h"

#include "common/numeric/random.h"
#include "coordinator/search/volume.h"
#include "tests/unit/coordinator/search/cloud_of.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static double area(const struct box *box)
{
    double area = 1;
    for (uint32_t v = 0; v < box->count; v++)
        area *= box->upper[v] - box->lower[v];
    return area;
}

static struct box trimmed(const struct box *grown, const struct cloud *good,
                          const struct cloud *bad)
{
    const struct trim_options options = trim_options_default();
    struct box box;
    box_init(&box, grown->count);
    assert_true(trim(grown, NULL, good, bad, &options, &box));
    return box;
}

static void assert_none_inside(const struct box *box, const struct cloud *bad)
{
    for (uint32_t i = 0; i < bad->count; i++) {
        bool inside = true;
        for (uint32_t v = 0; v < box->count; v++)
            inside = inside && cloud_column(bad, v)[i] >= box->lower[v] &&
                     cloud_column(bad, v)[i] <= box->upper[v];
        assert_false(inside);
    }
}

// Worked out by hand: one bad sample to the right, one above; the equal coordinate of each must not
// be cut at, for it would cut the anchor off. The largest box is .9 x .8.
static void two_bad_samples_leave_the_largest_box(void **state)
{
    (void)state;
    struct box grown = box_cube(2, 0, 1);
    struct cloud good = CLOUD(2, .5, .5);
    struct cloud bad = CLOUD(2, .9, .5, .5, .8);
    struct box box = trimmed(&grown, &good, &bad);
    assert_true(fabs(area(&box) - 0.72) < 1e-15);
    assert_none_inside(&box, &bad);
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// Without a bad sample nothing moves: slack that moves sides for no reason loses volume each step.
static void no_bad_sample_changes_nothing(void **state)
{
    (void)state;
    struct box grown = box_cube(3, -1, 2);
    struct cloud good = CLOUD(3, 0, 0, 0);
    struct cloud bad;
    cloud_init(&bad, 3);
    struct box box = trimmed(&grown, &good, &bad);
    assert_true(box_equal(&box, &grown));
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
}

// Without a good sample there is nothing to cut towards; the caller is told.
static void no_good_sample_changes_nothing_and_says_so(void **state)
{
    (void)state;
    struct box grown = box_cube(2, 0, 1);
    struct cloud good = CLOUD(2, 5, 5); // outside
    struct cloud bad = CLOUD(2, .3, .3);
    struct box box = box_cube(2, 7, 8);
    const struct trim_options options = trim_options_default();
    assert_false(trim(&grown, NULL, &good, &bad, &options, &box));
    assert_true(box_equal(&box, &grown));
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// Sides that no bad sample touches stay where they are, also those of fixed variables.
static void one_free_variable_among_fixed_ones(void **state)
{
    (void)state;
    struct box grown = box_cube(3, 5, 5);
    grown.lower[1] = 0;
    grown.upper[1] = 10;
    struct cloud good = CLOUD(3, 5, 4, 5);
    struct cloud bad = CLOUD(3, 5, 7, 5, 5, 9, 5);
    struct box box = trimmed(&grown, &good, &bad);
    assert_true(box.lower[1] == 0);
    assert_true(box.upper[1] == nextafter(7, 0));
    assert_true(box.lower[0] == 5 && box.upper[0] == 5 && box.lower[2] == 5 && box.upper[2] == 5);
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// A bad sample on the very place of a good one cannot be cut off; it must not hang or crash.
static void bad_sample_on_the_anchor_is_left(void **state)
{
    (void)state;
    struct box grown = box_cube(2, 0, 1);
    struct cloud good = CLOUD(2, .5, .5);
    struct cloud bad = CLOUD(2, .5, .5, .9, .5);
    struct box box = trimmed(&grown, &good, &bad);
    assert_true(fabs(area(&box) - 0.9) < 1e-15);
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// Uniform points of [0, 1]^n, sorted into good and bad by a rule.
static void points(uint32_t variables, uint32_t count, uint64_t seed,
                   bool (*is_bad)(uint32_t variables, const double *), struct cloud *good,
                   struct cloud *bad)
{
    cloud_init(good, variables);
    cloud_init(bad, variables);
    for (uint32_t i = 0; i < count; i++) {
        double point[64];
        for (uint32_t v = 0; v < variables; v++)
            point[v] = random_uniform(seed, 0, 0, i, v);
        const bool spoiled = is_bad(variables, point);
        cloud_add(spoiled ? bad : good, point, 1, (uint16_t)(spoiled ? 1 + i % 3 : 0));
    }
}

static bool corner_is_bad(uint32_t variables, const double *point)
{
    for (uint32_t v = 0; v < variables; v++) {
        if (!(point[v] > 0.6 + 0.05 * v))
            return false;
    }
    return true;
}

// Bad where all coordinates are above .6, .65, .7: one cut is enough, and the cheapest one is the
// last. A trim that cuts sample by sample without pushing out again ends with several.
static void removed_corner_costs_one_cut(void **state)
{
    (void)state;
    struct box grown = box_cube(3, 0, 1);
    struct cloud good;
    struct cloud bad;
    points(3, 20000, 1, corner_is_bad, &good, &bad);
    struct box box = trimmed(&grown, &good, &bad);
    assert_none_inside(&box, &bad);
    uint32_t cuts = 0;
    for (uint32_t v = 0; v < 3; v++)
        cuts += (box.lower[v] > 0) + (box.upper[v] < 1);
    assert_int_equal(cuts, 1);
    assert_true(box.upper[2] >= 0.7 && box.upper[2] < 0.705);
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

static bool ball_is_good(uint32_t variables, const double *point)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += (point[v] - 0.5) * (point[v] - 0.5);
    return sum > 0.2;
}

// No bad sample is left inside, and every side rests on one or on the grown box: it cannot move
// out.
static void result_is_pure_and_maximal(void **state)
{
    (void)state;
    struct box grown = box_cube(6, 0, 1);
    struct cloud good;
    struct cloud bad;
    points(6, 3000, 2, ball_is_good, &good, &bad);
    assert_true(good.count > 100 && bad.count > 1000);
    struct box box = trimmed(&grown, &good, &bad);
    assert_none_inside(&box, &bad);
    for (uint32_t side = 0; side < 12; side++) {
        const uint32_t v = side / 2;
        double *bound = side % 2 == 0 ? &box.lower[v] : &box.upper[v];
        const double kept = *bound;
        const double end = side % 2 == 0 ? grown.lower[v] : grown.upper[v];
        if (kept == end)
            continue;
        *bound = nextafter(kept, end);
        struct cloud inside;
        cloud_init(&inside, 6);
        cloud_add_inside(&inside, &bad, &box);
        assert_true(inside.count > 0);
        cloud_fini(&inside);
        *bound = kept;
    }
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// The order in which samples arrive says nothing about them, so it must not change the box, even
// where violations are equal.
static void permuted_samples_give_the_same_box(void **state)
{
    (void)state;
    struct box grown = box_cube(6, 0, 1);
    struct cloud good;
    struct cloud bad;
    points(6, 800, 3, ball_is_good, &good, &bad);
    struct box box = trimmed(&grown, &good, &bad);
    struct cloud shuffled[2];
    const struct cloud *from[2] = {&good, &bad};
    for (int c = 0; c < 2; c++) {
        cloud_init(&shuffled[c], 6);
        for (uint32_t i = 0; i < from[c]->count; i++) {
            // 7919 is a prime above both counts: every point comes once.
            uint32_t place = (uint32_t)((uint64_t)(i + 1) * 7919 % from[c]->count);
            cloud_add(&shuffled[c], from[c]->values + place, from[c]->capacity,
                      from[c]->violation[place]);
        }
    }
    struct box again = trimmed(&grown, &shuffled[0], &shuffled[1]);
    assert_true(box_equal(&box, &again));
    box_fini(&again);
    box_fini(&box);
    box_fini(&grown);
    for (int c = 0; c < 2; c++)
        cloud_fini(&shuffled[c]);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// Candidates are carved in parallel; which one wins must not depend on who was first.
static void threads_do_not_change_the_box(void **state)
{
    (void)state;
    struct box grown = box_cube(8, 0, 1);
    struct box previous = box_cube(8, 0.3, 0.7);
    struct cloud good;
    struct cloud bad;
    points(8, 1000, 4, ball_is_good, &good, &bad);
    struct box boxes[3];
    const int threads[3] = {1, 4, 16};
    for (int i = 0; i < 3; i++) {
        struct trim_options options = trim_options_default();
        options.threads = threads[i];
        options.anchors = 4;
        box_init(&boxes[i], 8);
        assert_true(trim(&grown, &previous, &good, &bad, &options, &boxes[i]));
        assert_true(box_equal(&boxes[i], &boxes[0]));
    }
    for (int i = 0; i < 3; i++)
        box_fini(&boxes[i]);
    box_fini(&previous);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

// With edge 1 a cut lies on the last good sample before the bad one, with 0 just short of the bad.
static void edge_chooses_between_bad_and_good(void **state)
{
    (void)state;
    struct box grown = box_cube(1, 0, 10);
    struct cloud good = CLOUD(1, 2, 4, 6);
    struct cloud bad = CLOUD(1, 8, 9);
    struct trim_options options = trim_options_default();
    struct box box = box_cube(1, 0, 0);
    options.edge = 1;
    trim(&grown, NULL, &good, &bad, &options, &box);
    assert_true(box.lower[0] == 0 && box.upper[0] == 6);
    options.edge = 0;
    trim(&grown, NULL, &good, &bad, &options, &box);
    assert_true(box.lower[0] == 0 && box.upper[0] == nextafter(8, 0));
    box_fini(&box);
    box_fini(&grown);
    cloud_fini(&good);
    cloud_fini(&bad);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_bad_samples_leave_the_largest_box),
        cmocka_unit_test(no_bad_sample_changes_nothing),
        cmocka_unit_test(no_good_sample_changes_nothing_and_says_so),
        cmocka_unit_test(one_free_variable_among_fixed_ones),
        cmocka_unit_test(bad_sample_on_the_anchor_is_left),
        cmocka_unit_test(removed_corner_costs_one_cut),
        cmocka_unit_test(result_is_pure_and_maximal),
        cmocka_unit_test(permuted_samples_give_the_same_box),
        cmocka_unit_test(threads_do_not_change_the_box),
        cmocka_unit_test(edge_chooses_between_bad_and_good),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
