#include "coordinator/search/explain.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// A problem: the relative violation of a constraint by one design.
typedef double problem_function(uint32_t constraint, const double *design, uint32_t variables);

// Energy, deceleration and order of two sections in a row. The largest box is F1 in
// [294480, 516720], F2 in [516720, 627840] N.
static double two_sections(uint32_t constraint, const double *design, uint32_t variables)
{
    (void)variables;
    if (constraint == 0)
        return (243360 - 0.3 * (design[0] + design[1])) / 243360;
    if (constraint == 1)
        return design[1] / 627840 - 1;
    return (design[0] - design[1]) / 1e6;
}

static double sphere(uint32_t constraint, const double *design, uint32_t variables)
{
    (void)constraint;
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] * design[v];
    return sqrt(sum) / (sqrt(variables) / 2) - 1;
}

// Under the plane x + 2 y + 5 z = 1.5: the largest box is [0, 0.5] x [0, 0.25] x [0, 0.1].
static double plane(uint32_t constraint, const double *design, uint32_t variables)
{
    (void)constraint;
    (void)variables;
    return (design[0] + 2 * design[1] + 5 * design[2]) / 1.5 - 1;
}

static double never_bad(uint32_t constraint, const double *design, uint32_t variables)
{
    (void)constraint;
    (void)design;
    (void)variables;
    return -1;
}

struct fixture {
    problem_function *problem;
    struct scenario scenario;
    struct box box;
    struct explain explain;
    uint32_t samples; // a bound
};

// A scenario and a box of `variables` intervals [0, 1], which the test narrows.
static void fixture_init(struct fixture *fixture, problem_function *problem, uint32_t variables,
                         uint32_t constraints)
{
    *fixture = (struct fixture){.problem = problem, .samples = 2000};
    scenario_init(&fixture->scenario);
    box_init(&fixture->scenario.design_space, variables);
    box_init(&fixture->box, variables);
    fixture->scenario.constraints = g_new0(struct scenario_constraint, constraints);
    fixture->scenario.constraint_count = constraints;
    for (uint32_t c = 0; c < constraints; c++)
        fixture->scenario.constraints[c] =
            (struct scenario_constraint){.min = -INFINITY, .max = 0, .scale = 10};
}

static void set_variable(struct fixture *fixture, uint32_t variable, double least, double lower,
                         double upper, double most)
{
    fixture->scenario.design_space.lower[variable] = least;
    fixture->scenario.design_space.upper[variable] = most;
    fixture->box.lower[variable] = lower;
    fixture->box.upper[variable] = upper;
}

static void fixture_fini(struct fixture *fixture)
{
    explain_fini(&fixture->explain);
    box_fini(&fixture->box);
    scenario_fini(&fixture->scenario);
}

// What workers do.
static struct verdict *judge(const struct fixture *fixture, const struct sampling *sampling,
                             const struct box *box)
{
    const uint32_t variables = box->count;
    struct verdict *verdicts = g_new0(struct verdict, sampling->samples);
    double *design = g_new(double, variables);
    for (uint32_t i = 0; i < sampling->samples; i++) {
        sampling_fill(sampling, box, i, 1, design, 1);
        double worst = 0;
        for (uint32_t c = 0; c < fixture->scenario.constraint_count; c++) {
            const double violation = fixture->problem(c, design, variables);
            if (!(violation > worst))
                continue;
            worst = violation;
            verdicts[i] = (struct verdict){.violation = verdict_violation(violation),
                                           .constraint = (uint8_t)c};
        }
    }
    g_free(design);
    return verdicts;
}

// Goes through the whole phase.
static void explain_all(struct fixture *fixture)
{
    struct explain *explain = &fixture->explain;
    explain_init(explain, &fixture->scenario, &fixture->box);
    struct sampling sampling = {.seed = 5, .step = 100, .samples = 20000};
    struct verdict *inside = judge(fixture, &sampling, &fixture->box);
    explain_take_inside(explain, inside, sampling.samples);
    g_free(inside);
    sampling.samples = fixture->samples;
    for (uint32_t i = 0; i < explain->step_count; i++) {
        const struct box *slab = explain_slab(explain, i);
        sampling.step++;
        struct verdict *verdicts = judge(fixture, &sampling, slab);
        assert_true(explain_take(explain, &sampling, slab, verdicts));
        g_free(verdicts);
    }
    explain_conclude(explain);
}

static void two_sections_init(struct fixture *fixture)
{
    fixture_init(fixture, two_sections, 2, 3);
    set_variable(fixture, 0, 1e5, 294480, 516720, 1e6);
    set_variable(fixture, 1, 1e5, 516720, 627840, 1e6);
}

static void assert_gain(const struct fixture *fixture, uint32_t constraint, double expected,
                        double tolerance)
{
    const struct explain_gain *gain = &fixture->explain.gains[constraint];
    if (!(fabs(gain->log_volume - expected) <= tolerance * expected) || gain->at_least)
        fail_msg("constraint %u: gain %.4f%s, expected %.4f", constraint, gain->log_volume,
                 gain->at_least ? " at least" : "", expected);
}

static void assert_holder(const struct fixture *fixture, uint32_t bound, uint32_t constraint)
{
    assert_int_equal(fixture->explain.bounds[bound].holder, EXPLAIN_CONSTRAINT);
    assert_int_equal(fixture->explain.bounds[bound].constraint, constraint);
}

// A slab that reached into the corridor, or out of the design space, would say nothing about the
// bound; one that took its thickness from the space would be far outside of a narrow corridor.
static void slabs_lie_just_outside(void **state)
{
    (void)state;
    struct fixture fixture;
    fixture_init(&fixture, plane, 3, 1);
    set_variable(&fixture, 0, 0, 0.2, 0.5, 1);
    set_variable(&fixture, 1, 0, 0, 0.25, 0.26);
    set_variable(&fixture, 2, 0, 0, 0.1, 1);
    explain_init(&fixture.explain, &fixture.scenario, &fixture.box);
    assert_int_equal(fixture.explain.step_count, 4);
    const struct box *slab = explain_slab(&fixture.explain, 0);
    assert_float_equal(slab->lower[0], 0.17, 1e-12);
    assert_float_equal(slab->upper[0], 0.2, 0);
    assert_float_equal(slab->upper[1], 0.25, 0);
    assert_float_equal(slab->upper[2], 0.1, 0);
    slab = explain_slab(&fixture.explain, 1);
    assert_float_equal(slab->lower[0], 0.5, 0);
    assert_float_equal(slab->upper[0], 0.53, 1e-12);
    slab = explain_slab(&fixture.explain, 2);
    assert_float_equal(slab->lower[1], 0.25, 0);
    assert_float_equal(slab->upper[1], 0.26, 0);
    fixture_fini(&fixture);
}

// No constraint holds a bound on the edge of the design space, one that is held, or a variable that
// has one value, and samples there would be wasted.
static void bounds_held_otherwise_need_no_samples(void **state)
{
    (void)state;
    struct fixture fixture;
    fixture_init(&fixture, sphere, 4, 1);
    set_variable(&fixture, 0, -1, -1, 0.5, 1);
    set_variable(&fixture, 1, 0.1, 0.1, 0.1, 0.1);
    set_variable(&fixture, 2, -1, -0.2, 0.3, 1);
    set_variable(&fixture, 3, -1, 0.3, 0.3, 1);
    struct scenario_hold *hold = &fixture.scenario.search.hold;
    hold->lower = g_new(double, 4);
    hold->upper = g_new(double, 4);
    for (int v = 0; v < 4; v++)
        hold->lower[v] = hold->upper[v] = NAN;
    hold->lower[2] = -0.2;
    hold->lower[3] = hold->upper[3] = 0.3;
    assert_int_equal(explain_steps_most(&fixture.scenario), 3);
    explain_all(&fixture);
    static const enum explain_holder holders[] = {
        EXPLAIN_DESIGN_SPACE, EXPLAIN_CONSTRAINT, EXPLAIN_FIXED, EXPLAIN_FIXED,
        EXPLAIN_HELD,         EXPLAIN_CONSTRAINT, EXPLAIN_HELD,  EXPLAIN_HELD};
    for (uint32_t i = 0; i < G_N_ELEMENTS(holders); i++) {
        const bool sampled = i == 1 || i == 5;
        assert_int_equal(fixture.explain.bounds[i].drawn, sampled ? fixture.samples : 0);
        if (!sampled)
            assert_int_equal(fixture.explain.bounds[i].holder, holders[i]);
    }
    fixture_fini(&fixture);
}

// Where nothing bad lies outside, the bound is free; next to the edge of the space it is the edge
// that holds it.
static void good_surroundings_hold_nothing(void **state)
{
    (void)state;
    struct fixture fixture;
    fixture_init(&fixture, never_bad, 1, 1);
    set_variable(&fixture, 0, 0, 0.4, 0.95, 1);
    explain_all(&fixture);
    assert_int_equal(fixture.explain.bounds[0].holder, EXPLAIN_NOTHING);
    assert_int_equal(fixture.explain.bounds[0].good, fixture.samples);
    assert_int_equal(fixture.explain.bounds[1].holder, EXPLAIN_DESIGN_SPACE);
    assert_float_equal(fixture.explain.gains[0].log_volume, 0, 0);
    fixture_fini(&fixture);
}

// The exact box: each side touches the constraint that the closed form says.
static void holders_are_the_constraints_that_touch(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    explain_all(&fixture);
    assert_holder(&fixture, 0, 0);
    assert_holder(&fixture, 1, 2);
    assert_holder(&fixture, 3, 1);
    assert_int_equal(fixture.explain.bounds[3].good, 0); // too much force, whatever the other one
    assert_int_equal(fixture.explain.bounds[3].violated, fixture.samples);
    assert_int_equal(fixture.explain.bounds[2].holder, EXPLAIN_CONSTRAINT); // order and energy
    assert_int_not_equal(fixture.explain.bounds[2].constraint, 1);
    fixture_fini(&fixture);
}

// With E the energy, D = d1 + d2, U the force limit, w2 = (U - E/D) / 2 and w1 = w2 D/d1: 1 % of
// either moves w2, and a box that may overlap in order by s is wider by s / w1.
static void gains_of_two_sections_are_those_of_the_closed_form(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    explain_all(&fixture);
    const double w2 = 111120;
    assert_gain(&fixture, 0, 2 * log(1 + 0.5 * 0.01 * 243360 / 0.6 / w2), 0.2);
    assert_gain(&fixture, 1, 2 * log(1 + 0.5 * 0.01 * 627840 / w2), 0.1);
    assert_gain(&fixture, 2, 1e4 / 222240, 0.25);
    fixture_fini(&fixture);
}

// A plane that moves out by 1 % takes every corridor along: n ln 1.01. The box is the exact one,
// wider by 1.1156, so that 0.5 % of it is bad, as a box is that the search certifies at 0.99.
static void gain_of_a_plane_is_that_of_all_corridors(void **state)
{
    (void)state;
    struct fixture fixture;
    fixture_init(&fixture, plane, 3, 1);
    set_variable(&fixture, 0, 0, 0, 0.5 * 1.1156, 1);
    set_variable(&fixture, 1, 0, 0, 0.25 * 1.1156, 1);
    set_variable(&fixture, 2, 0, 0, 0.1 * 1.1156, 1);
    explain_all(&fixture);
    assert_int_equal(fixture.explain.bounds[1].holder, EXPLAIN_CONSTRAINT);
    assert_gain(&fixture, 0, 3 * log(1.01), 0.25);
    fixture_fini(&fixture);
}

// A ball grows in all directions, so both bounds of a variable move: n ln 1.01. In two variables
// the box is pure; in ten it is one of purity 0.995, and the gain is a matter of shares.
static void gain_of_a_ball_counts_both_bounds(void **state)
{
    (void)state;
    static const struct {
        uint32_t variables;
        double half_width;
        double tolerance;
    } balls[] = {{2, 0.5, 0.2}, {10, 0.65, 0.3}};
    for (size_t i = 0; i < G_N_ELEMENTS(balls); i++) {
        struct fixture fixture;
        fixture_init(&fixture, sphere, balls[i].variables, 1);
        for (uint32_t v = 0; v < balls[i].variables; v++)
            set_variable(&fixture, v, -1, -balls[i].half_width, balls[i].half_width, 1);
        explain_all(&fixture);
        assert_gain(&fixture, 0, balls[i].variables * log(1.01), balls[i].tolerance);
        fixture_fini(&fixture);
    }
}

// 1 % of what? Of the scale of the violation, which is not zero where the limit is.
static void relaxing_a_limit_of_zero_goes_by_its_scale(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    explain_all(&fixture);
    assert_float_equal(fixture.explain.gains[0].amount, 0.1, 1e-15);
    fixture_fini(&fixture);
}

// Nobody knows what a constraint costs when the box itself was not looked at.
static void gain_needs_samples_of_the_box(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    explain_init(&fixture.explain, &fixture.scenario, &fixture.box);
    explain_conclude(&fixture.explain);
    assert_true(isnan(fixture.explain.gains[0].log_volume));
    assert_int_equal(fixture.explain.bounds[0].holder, EXPLAIN_UNKNOWN);
    fixture_fini(&fixture);
}

// Variables that share a corridor have one bound: what holds the one holds the other.
static void shared_corridors_count_their_samples_together(void **state)
{
    (void)state;
    struct fixture fixture;
    fixture_init(&fixture, plane, 3, 1);
    for (uint32_t v = 0; v < 3; v++)
        set_variable(&fixture, v, 0, 0, 0.18, 1);
    fixture.scenario.search.tie = g_new(uint32_t, 3);
    fixture.scenario.search.tie[0] = fixture.scenario.search.tie[2] = 0;
    fixture.scenario.search.tie[1] = 1;
    explain_all(&fixture);
    const struct explain_bound *bounds = fixture.explain.bounds;
    assert_int_equal(bounds[1].samples, 2 * fixture.samples);
    assert_int_equal(bounds[5].samples, 2 * fixture.samples);
    assert_int_equal(bounds[1].good, bounds[5].good);
    assert_int_equal(bounds[1].violated, bounds[5].violated);
    assert_int_equal(bounds[3].samples, fixture.samples);
    fixture_fini(&fixture);
}

// A corridor that minimum_widths or the reference keeps open says so.
static void demands_are_named(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    struct scenario_search *search = &fixture.scenario.search;
    search->minimum_widths = g_new0(double, 2);
    search->minimum_widths[0] = 516720 - 294480;
    search->reference = g_new(double, 2);
    search->reference[0] = 400e3;
    search->reference[1] = 627840;
    explain_all(&fixture);
    const struct explain_bound *bounds = fixture.explain.bounds;
    assert_true(bounds[0].at_minimum_width && bounds[1].at_minimum_width);
    assert_false(bounds[2].at_minimum_width || bounds[3].at_minimum_width);
    assert_true(bounds[3].at_reference);
    assert_false(bounds[0].at_reference || bounds[1].at_reference || bounds[2].at_reference);
    fixture_fini(&fixture);
}

// A journal may have been damaged: steps that do not belong to the box are not taken.
static void foreign_steps_are_refused(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    struct explain *explain = &fixture.explain;
    explain_init(explain, &fixture.scenario, &fixture.box);
    const struct sampling sampling = {.samples = 2};
    struct verdict verdicts[2] = {{0}, {.violation = 9, .constraint = 2}};
    assert_false(explain_take(explain, &sampling, &fixture.box, verdicts));
    verdicts[1].constraint = 3; // of three
    struct box slab;
    box_init(&slab, 2);
    box_assign(&slab, explain_slab(explain, 0));
    assert_false(explain_take(explain, &sampling, &slab, verdicts));
    verdicts[1].constraint = 2;
    assert_true(explain_take(explain, &sampling, &slab, verdicts));
    assert_false(explain_take(explain, &sampling, &slab, verdicts)); // the second bound is next
    for (uint32_t i = 1; i < 4; i++) {
        box_assign(&slab, explain_slab(explain, i));
        assert_true(explain_take(explain, &sampling, &slab, verdicts));
    }
    assert_false(explain_take(explain, &sampling, &slab, verdicts));
    box_fini(&slab);
    fixture_fini(&fixture);
}

// Many bounds must not cost more than the search, and no budget may be exceeded.
static void samples_follow_what_they_cost(void **state)
{
    (void)state;
    struct scenario_search search = {.explain_samples = SCENARIO_EXPLAIN_AUTO};
    assert_int_equal(explain_samples(&search, 36, 50000), 173);
    assert_int_equal(explain_samples(&search, 4, 50000), 500);
    assert_int_equal(explain_samples(&search, 1440, 50000), 20);
    assert_int_equal(explain_samples(&search, 0, 50000), 0);
    search.explain_samples = 1000;
    assert_int_equal(explain_samples(&search, 1440, 50000), 1000);
    search.evaluations = 53600;
    assert_int_equal(explain_samples(&search, 36, 50000), 100);
    assert_int_equal(explain_samples(&search, 361, 50000), 0);
    assert_int_equal(explain_samples(&search, 36, 60000), 0);
    search.explain_samples = 0;
    assert_int_equal(explain_samples(&search, 36, 0), 0);
}

// A tenth of the budget at most, and nothing where that would not be enough to say anything.
static void budget_sets_little_aside(void **state)
{
    (void)state;
    struct fixture fixture;
    two_sections_init(&fixture);
    struct scenario_search *search = &fixture.scenario.search;
    assert_int_equal(explain_reserve(&fixture.scenario), 0); // of no budget
    search->evaluations = 40000;
    assert_int_equal(explain_reserve(&fixture.scenario), 2000);
    search->evaluations = 4000;
    assert_int_equal(explain_reserve(&fixture.scenario), 400);
    search->evaluations = 390;
    assert_int_equal(explain_reserve(&fixture.scenario), 0);
    search->evaluations = 40000;
    search->explain_samples = 0;
    assert_int_equal(explain_reserve(&fixture.scenario), 0);
    fixture_fini(&fixture);
}

// Every holder has a name of its own.
static void holders_have_names(void **state)
{
    (void)state;
    for (int a = EXPLAIN_UNKNOWN; a <= EXPLAIN_FIXED; a++)
        for (int b = EXPLAIN_UNKNOWN; b < a; b++)
            assert_string_not_equal(explain_holder_name((enum explain_holder)a),
                                    explain_holder_name((enum explain_holder)b));
    assert_string_equal(explain_holder_name(EXPLAIN_DESIGN_SPACE), "design_space");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs_lie_just_outside),
        cmocka_unit_test(bounds_held_otherwise_need_no_samples),
        cmocka_unit_test(good_surroundings_hold_nothing),
        cmocka_unit_test(holders_are_the_constraints_that_touch),
        cmocka_unit_test(gains_of_two_sections_are_those_of_the_closed_form),
        cmocka_unit_test(gain_of_a_plane_is_that_of_all_corridors),
        cmocka_unit_test(gain_of_a_ball_counts_both_bounds),
        cmocka_unit_test(relaxing_a_limit_of_zero_goes_by_its_scale),
        cmocka_unit_test(gain_needs_samples_of_the_box),
        cmocka_unit_test(shared_corridors_count_their_samples_together),
        cmocka_unit_test(demands_are_named),
        cmocka_unit_test(foreign_steps_are_refused),
        cmocka_unit_test(samples_follow_what_they_cost),
        cmocka_unit_test(budget_sets_little_aside),
        cmocka_unit_test(holders_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
