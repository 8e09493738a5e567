#include "coordinator/search/widest.h"

#include "common/numeric/random.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { SIDES_MAX = 16, LIMITS_MAX = 8 };

// Problems that are written down as rows of slopes, in the unit cube unless told otherwise.
struct small {
    uint32_t variables;
    uint32_t limits;
    double slopes[LIMITS_MAX][SIDES_MAX]; // lower and upper bound of each variable in turn
    double constant[LIMITS_MAX];
    double tolerance;
    double price; // 0: so high that no limit is missed
    const double *weights;
    double least[SIDES_MAX];
    double most[SIDES_MAX]; // all 0: the unit cube
};

struct solved {
    double sides[SIDES_MAX];
    struct widest_answer answer;
};

static void solve(const struct small *small, struct solved *solved)
{
    const uint32_t sides = 2 * small->variables;
    double most[SIDES_MAX];
    const double *limit[LIMITS_MAX];
    bool cube = true;
    for (uint32_t i = 0; i < sides; i++)
        cube = cube && small->most[i] == 0;
    for (uint32_t i = 0; i < sides; i++) {
        most[i] = cube ? 1 : small->most[i];
        solved->sides[i] = small->least[i] + (0.3 + 0.3 * (i % 2)) * (most[i] - small->least[i]);
    }
    for (uint32_t i = 0; i < small->limits; i++)
        limit[i] = small->slopes[i];
    solved->answer = (struct widest_answer){.sides = solved->sides};
    widest(&(struct widest_problem){.variables = small->variables,
                                    .weights = small->weights,
                                    .least = small->least,
                                    .most = most,
                                    .limit_count = small->limits,
                                    .limit = limit,
                                    .constant = small->constant,
                                    .tolerance = small->tolerance,
                                    .price = small->price > 0 ? small->price : 1e4},
           &solved->answer);
    for (uint32_t i = 0; i < sides; i++)
        assert_true(solved->sides[i] >= small->least[i] && solved->sides[i] <= most[i]);
}

static double width(const struct solved *solved, uint32_t variable)
{
    return solved->sides[2 * variable + 1] - solved->sides[2 * variable];
}

static void assert_sides(const struct solved *solved, uint32_t variables, const double *expected)
{
    for (uint32_t i = 0; i < 2 * variables; i++) {
        if (!(fabs(solved->sides[i] - expected[i]) < 0.005))
            fail_msg("side %u: expected %.4f, found %.4f", i, expected[i], solved->sides[i]);
    }
}

// u_0 + u_1 <= 1: half each, and one of tolerance costs 2 / 1 of log-volume.
static const struct small one_limit = {
    .variables = 2, .limits = 1, .slopes = {{0, -1, 0, -1}}, .constant = {1}};

static void one_limit_is_shared_equally(void **state)
{
    (void)state;
    struct solved solved;
    solve(&one_limit, &solved);
    assert_sides(&solved, 2, (const double[]){0, 0.5, 0, 0.5});
    assert_true(solved.answer.excess >= 0 && solved.answer.excess < 1e-4);
    assert_true(fabs(solved.answer.shadow / 2 - 1) < 0.3); // as far as prices settle
}

// Two thirds go to the variable whose width counts twice.
static void weights_share_a_limit(void **state)
{
    (void)state;
    static const double weights[] = {2, 1};
    struct small small = one_limit;
    small.weights = weights;
    struct solved solved;
    solve(&small, &solved);
    assert_sides(&solved, 2, (const double[]){0, 2.0 / 3, 0, 1.0 / 3});
}

// The limit is to exceed the tolerance: 0.8 are left to be shared.
static void tolerance_is_kept(void **state)
{
    (void)state;
    struct small small = one_limit;
    small.tolerance = 0.2;
    struct solved solved;
    solve(&small, &solved);
    assert_sides(&solved, 2, (const double[]){0, 0.4, 0, 0.4});
    assert_true(fabs(solved.answer.shadow / (2 / 0.8) - 1) < 0.3);
}

// |x - 0.5| + |y - 0.5| <= 0.4 at the four corners: a square of side 0.4, in the middle. Lower
// bounds are held as well as upper ones.
static void diamond_holds_a_square(void **state)
{
    (void)state;
    static const struct small diamond = {
        .variables = 2,
        .limits = 4,
        .slopes = {{0, -1, 0, -1}, {1, 0, 0, -1}, {0, -1, 1, 0}, {1, 0, 1, 0}},
        .constant = {1.4, 0.4, 0.4, -0.6}};
    struct solved solved;
    solve(&diamond, &solved);
    assert_sides(&solved, 2, (const double[]){0.3, 0.7, 0.3, 0.7});
}

// The largest box of the ellipse with semi-axes 2 and 1 at 45 degrees, between its tangents at the
// corners of the answer (benchmark problem, moved into the unit cube): half-widths 1 / sqrt(2).
static void tangents_of_an_ellipse_hold_its_largest_box(void **state)
{
    (void)state;
    // Level A11 x^2 + 2 A12 x y + A22 y^2 with A11 = A22 = 5/8, A12 = -3/8, on [-2, 2]^2. The
    // corners (h, -h) and (-h, h) touch it: there its slopes are 2 h (A11 - A12) = 2 h in size.
    const double h = M_SQRT1_2, slope = 2 * h * 4; // over [0, 1], which is 4 long
    const struct small ellipse = {.variables = 2,
                                  .limits = 2,
                                  .slopes = {{0, -slope, slope, 0}, {slope, 0, 0, -slope}},
                                  .constant = {2, 2}};
    struct solved solved;
    solve(&ellipse, &solved);
    // Each limit alone bounds u_x - l_y, so only the sum of both widths is given by them.
    assert_true(fabs(width(&solved, 0) - 2 * h / 4) < 0.005);
    assert_true(fabs(width(&solved, 1) - 2 * h / 4) < 0.005);
}

// A lower bound that must not be below 0.6 and an upper one not above 0.4 miss both by t: then the
// width is 2 t - 0.2, and ln(width) - 20 t is greatest at a width of 0.1.
static void contradicting_limits_are_missed_alike(void **state)
{
    (void)state;
    static const struct small small = {.variables = 1,
                                       .limits = 2,
                                       .slopes = {{1, 0}, {0, -1}},
                                       .constant = {-0.6, 0.4},
                                       .price = 20};
    struct solved solved;
    solve(&small, &solved);
    assert_true(fabs(solved.answer.excess - 0.15) < 0.003);
    assert_sides(&solved, 1, (const double[]){0.45, 0.55});
}

// A side whose range has no width stands still: what it does not take the other variable has.
static void still_sides_stay(void **state)
{
    (void)state;
    struct small small = one_limit;
    static const double least[] = {0.1, 0.3, 0.25, 0}, most[] = {0.1, 0.3, 0.25, 1};
    memcpy(small.least, least, sizeof least);
    memcpy(small.most, most, sizeof most);
    small.least[3] = 0.3;
    struct solved solved;
    solve(&small, &solved);
    assert_true(solved.sides[0] == 0.1 && solved.sides[1] == 0.3 && solved.sides[2] == 0.25);
    assert_sides(&solved, 2, (const double[]){0.1, 0.3, 0.25, 0.7});
}

// Without limits a box fills its ranges.
static void nothing_in_the_way_fills_the_ranges(void **state)
{
    (void)state;
    static const struct small small = {
        .variables = 2, .least = {0.1, 0.4, 0, 0.5}, .most = {0.3, 0.9, 0.4, 1}};
    struct solved solved;
    solve(&small, &solved);
    assert_sides(&solved, 2, (const double[]){0.1, 0.9, 0, 1});
}

// One limit said eight times makes the matrix of Newton's step singular but for rounding.
static void equal_limits_are_one(void **state)
{
    (void)state;
    struct small small = one_limit;
    small.limits = LIMITS_MAX;
    for (uint32_t i = 0; i < LIMITS_MAX; i++) {
        memcpy(small.slopes[i], one_limit.slopes[0], sizeof small.slopes[i]);
        small.constant[i] = 1;
    }
    struct solved solved;
    solve(&small, &solved);
    assert_sides(&solved, 2, (const double[]){0, 0.5, 0, 0.5});
}

// The greatest log-volume of boxes with sides on a grid that keep the limits.
static double brute_force(const struct small *small)
{
    enum { GRID = 32 };
    double best = -INFINITY;
    double sides[4];
    for (int low_0 = 0; low_0 < GRID; low_0++) {
        for (int low_1 = 0; low_1 < GRID; low_1++) {
            for (int high_0 = low_0 + 1; high_0 <= GRID; high_0++) {
                for (int high_1 = low_1 + 1; high_1 <= GRID; high_1++) {
                    sides[0] = (double)low_0 / GRID;
                    sides[1] = (double)high_0 / GRID;
                    sides[2] = (double)low_1 / GRID;
                    sides[3] = (double)high_1 / GRID;
                    bool kept = true;
                    for (uint32_t i = 0; i < small->limits && kept; i++) {
                        double slack = small->constant[i] - small->tolerance;
                        for (int k = 0; k < 4; k++)
                            slack += small->slopes[i][k] * sides[k];
                        kept = slack >= 0;
                    }
                    if (kept)
                        best = fmax(best, log((sides[1] - sides[0]) * (sides[3] - sides[2])));
                }
            }
        }
    }
    return best;
}

// Any limits that leave the middle free: the box keeps them, and none of a grid of boxes that keep
// them is larger.
static void no_box_of_a_grid_is_wider(void **state)
{
    (void)state;
    for (uint32_t round = 0; round < 12; round++) {
        struct small small = {.variables = 2, .limits = 2 + round % 4, .tolerance = 0.01};
        for (uint32_t i = 0; i < small.limits; i++) {
            double middle = 0;
            for (uint32_t v = 0; v < 2; v++) {
                // The worst corner of a half-plane: the upper bound where the slope falls.
                const double slope = 2 * random_uniform(5, 0, round, i, v) - 1;
                small.slopes[i][2 * v + (slope < 0)] = slope;
                middle += slope / 2;
            }
            small.constant[i] = 0.1 + 0.3 * random_uniform(5, 0, round, i, 2) - middle;
        }
        struct solved solved;
        solve(&small, &solved);
        for (uint32_t i = 0; i < small.limits; i++) {
            double slack = small.constant[i] - small.tolerance;
            for (uint32_t k = 0; k < 4; k++)
                slack += small.slopes[i][k] * solved.sides[k];
            assert_true(slack >= -1e-4);
        }
        const double found = log(width(&solved, 0) * width(&solved, 1));
        const double best = brute_force(&small);
        if (!(found > best - 0.01))
            fail_msg("round %u: a box of ln(volume) %.4f, found %.4f", round, best, found);
    }
}

// The sum of all upper bounds of 720 variables: half each.
static void many_variables_share_a_limit(void **state)
{
    (void)state;
    enum { VARIABLES = 720 };
    double *rows = g_new0(double, 8 * VARIABLES);
    double *least = rows, *most = rows + 2 * (size_t)VARIABLES,
           *slopes = rows + 4 * (size_t)VARIABLES;
    double *sides = rows + 6 * (size_t)VARIABLES;
    for (uint32_t i = 0; i < 2 * VARIABLES; i++) {
        most[i] = 1;
        slopes[i] = i % 2 == 1 ? -1.0 / VARIABLES : 0;
        sides[i] = 0.2 + 0.1 * (i % 2);
    }
    const double constant = 0.5;
    const double *const limit = slopes;
    struct widest_answer answer = {.sides = sides};
    widest(&(struct widest_problem){.variables = VARIABLES,
                                    .least = least,
                                    .most = most,
                                    .limit_count = 1,
                                    .limit = &limit,
                                    .constant = &constant,
                                    .price = 1e5},
           &answer);
    double volume = 0;
    for (uint32_t v = 0; v < VARIABLES; v++)
        volume += log(sides[2 * (size_t)v + 1] - sides[2 * (size_t)v]);
    assert_true(fabs(volume / VARIABLES - log(0.5)) < 0.001);
    g_free(rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_limit_is_shared_equally),
        cmocka_unit_test(weights_share_a_limit),
        cmocka_unit_test(tolerance_is_kept),
        cmocka_unit_test(diamond_holds_a_square),
        cmocka_unit_test(tangents_of_an_ellipse_hold_its_largest_box),
        cmocka_unit_test(contradicting_limits_are_missed_alike),
        cmocka_unit_test(still_sides_stay),
        cmocka_unit_test(nothing_in_the_way_fills_the_ranges),
        cmocka_unit_test(equal_limits_are_one),
        cmocka_unit_test(no_box_of_a_grid_is_wider),
        cmocka_unit_test(many_variables_share_a_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
