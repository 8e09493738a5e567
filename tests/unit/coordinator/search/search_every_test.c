// Searches with the promise "every" from their first step to their last one.
#include "coordinator/search/search_every.h"

#include "coordinator/search/search.h"
#include "tests/unit/coordinator/search/attacked.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { VARIABLES = 6 };

// ---- Problems ----

static void sphere(uint32_t variables, const double *design, double *margins)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] * design[v];
    margins[0] = sqrt(variables) / 2 - sqrt(sum);
}

// A car's strength: the levels of all curves together have to be above one sum and below another.
// Independent points hardly ever reach either end, whole curves do.
static void strength(uint32_t variables, const double *design, double *margins)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] / variables;
    margins[0] = sum - 0.3;
    margins[1] = 0.7 - sum;
}

static void nowhere_good(uint32_t variables, const double *design, double *margins)
{
    (void)variables;
    margins[0] = -1 - fabs(design[0]);
}

static void set_up(struct attacked *problem, attacked_margins *margins, uint32_t constraints,
                   double lower, double upper)
{
    attacked_init(problem, margins, constraints, VARIABLES, lower, upper);
    struct scenario *scenario = &problem->scenario;
    scenario->search.samples = 200;
    scenario->search.exploration_steps = 60;
    scenario->search.consolidation_steps = 60;
    scenario->search.certificate_samples = 1000;
    scenario->search.target_purity = 0.99;
    scenario->search.promise = PROMISE_EVERY;
    // Two curves of three points, each a group of its own: 0 1 2 | 3 4 5.
    scenario->curves.count = scenario->curves.group_count = 2;
    for (uint32_t v = 0; v < VARIABLES; v++)
        scenario->curves.curve[v] = scenario->curves.group[v] = v / 3;
}

// ---- Searching ----

// What is left of a search.
struct ended {
    struct search_result result;
    struct box box;
    uint32_t steps[SEARCH_PHASE_COUNT]; // of each phase
    uint32_t first[SEARCH_PHASE_COUNT]; // step of each phase
    uint32_t attacks;                   // steps of moves among those of the certificate
};

static void complete(const struct attacked *problem, struct search *search, GPtrArray *journal)
{
    struct search_request request;
    assert_true(search_request(search, &request));
    struct verdict *verdicts = g_new(struct verdict, request.sampling.samples);
    attacked_evaluate(problem, &request.sampling, request.box, verdicts);
    g_ptr_array_add(journal, verdicts);
    search_complete(search, verdicts);
}

// Searches to the end. After `replay_at` steps (0: never) begins anew from the verdicts so far, as
// a coordinator does that was killed.
static struct ended run(const struct attacked *problem, uint64_t seed, uint32_t replay_at)
{
    struct ended ended = {0};
    struct search *search = search_create(&problem->scenario, seed, 1);
    GPtrArray *journal = g_ptr_array_new_with_free_func(g_free);
    struct search_request request;
    while (search_request(search, &request)) {
        if (ended.steps[request.phase]++ == 0)
            ended.first[request.phase] = request.sampling.step;
        ended.attacks += request.phase == SEARCH_PHASE_CERTIFY &&
                         request.sampling.method == SAMPLING_METHOD_MOVES;
        complete(problem, search, journal);
        if (journal->len != replay_at)
            continue;
        search_free(search);
        search = search_create(&problem->scenario, seed, 1);
        for (guint i = 0; i < journal->len; i++) {
            assert_true(search_request(search, &request));
            search_complete(search, g_ptr_array_index(journal, i));
        }
    }
    search_result(search, &ended.result);
    box_init(&ended.box, VARIABLES);
    box_assign(&ended.box, ended.result.box);
    ended.result.box = NULL;
    g_ptr_array_free(journal, TRUE);
    search_free(search);
    return ended;
}

static double least_corner(const struct attacked *problem, const struct box *box)
{
    uint32_t corner;
    return attacked_worst_corner(problem, box, &corner);
}

// ---- Claims ----

// The largest cube in a ball, with each kind of designs certified and attacked before.
static void the_box_holds_good_designs_only(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, sphere, 1, -1, 1);
    for (uint64_t seed = 1; seed <= 3; seed++) {
        struct ended ended = run(&problem, seed, 0);
        assert_int_equal(ended.result.status, SEARCH_STATUS_DONE);
        assert_true(ended.attacks > 10);
        for (int kind = DESIGN_KIND_POINTS; kind < DESIGN_KIND_COUNT; kind++) {
            assert_int_equal(ended.result.kinds[kind].bad, 0);
            assert_true(ended.result.kinds[kind].lower95 >= 0.99);
        }
        assert_true(least_corner(&problem, &ended.box) >= 0);
        const double exact = VARIABLES * log(0.5); // of the design space
        assert_true(ended.result.log_volume > exact + log(0.96));
        assert_true(ended.result.log_volume < exact + 1e-6);
        box_fini(&ended.box);
    }
    attacked_fini(&problem);
}

// By points alone a box that holds bad curves is certified; with every design promised it is not.
static void whole_curves_decide(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, strength, 2, 0, 1);
    struct ended every = run(&problem, 1, 0);
    problem.scenario.search.promise = PROMISE_POINTS;
    struct ended points = run(&problem, 1, 0);
    assert_int_equal(every.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(points.result.status, SEARCH_STATUS_DONE);
    assert_true(least_corner(&problem, &points.box) < -0.05);
    assert_true(least_corner(&problem, &every.box) >= 0);
    // All widths add up to 0.4 x 6: the widest box has 0.4 each.
    const double exact = VARIABLES * log(0.4);
    assert_true(fabs(every.result.log_volume - exact) < 0.04);
    box_fini(&every.box);
    box_fini(&points.box);
    attacked_fini(&problem);
}

// The promise of curves stands between the two: each kind keeps the wanted share, which a box
// without bad designs need not be asked for, and single bad designs may be left.
static void curves_are_promised_in_shares(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, strength, 2, 0, 1);
    struct ended every = run(&problem, 1, 0);
    problem.scenario.search.promise = PROMISE_CURVES;
    problem.scenario.search.target_purity = 0.4;
    struct ended curves = run(&problem, 1, 0);
    assert_int_equal(curves.result.status, SEARCH_STATUS_DONE);
    assert_true(curves.result.log_volume > every.result.log_volume + 0.1);
    for (int kind = DESIGN_KIND_POINTS; kind < DESIGN_KIND_COUNT; kind++)
        assert_true(curves.result.kinds[kind].lower95 >= 0.4);
    assert_true(curves.result.margin < 0);
    box_fini(&every.box);
    box_fini(&curves.box);
    attacked_fini(&problem);
}

// Killed in any phase, in the attack and between certificates too, a search ends with the same
// bits.
static void replayed_search_ends_with_the_same_digest(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, strength, 2, 0, 1);
    struct ended whole = run(&problem, 5, 0);
    const uint32_t certify = whole.first[SEARCH_PHASE_CERTIFY];
    const uint32_t cuts[] = {1,
                             whole.first[SEARCH_PHASE_EXPLORE] + 7,
                             whole.first[SEARCH_PHASE_CONSOLIDATE] + 2,
                             certify,
                             certify + 9,
                             certify + whole.attacks + 1,
                             whole.result.steps - 1};
    for (size_t i = 0; i < G_N_ELEMENTS(cuts); i++) {
        struct ended again = run(&problem, 5, cuts[i]);
        assert_true(digest_equal(&again.result.digest, &whole.result.digest));
        assert_true(box_equal(&again.box, &whole.box));
        assert_int_equal(again.result.evaluations, whole.result.evaluations);
        box_fini(&again.box);
    }
    struct ended other = run(&problem, 6, 0);
    assert_false(digest_equal(&other.result.digest, &whole.result.digest));
    box_fini(&other.box);
    box_fini(&whole.box);
    attacked_fini(&problem);
}

static void no_good_design_is_said(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, nowhere_good, 1, 0, 1);
    struct ended ended = run(&problem, 1, 0);
    assert_int_equal(ended.result.status, SEARCH_STATUS_NO_GOOD_DESIGN);
    assert_true(isinf(ended.result.log_volume));
    box_fini(&ended.box);
    attacked_fini(&problem);
}

// A variable that is fixed keeps its value, in the box and in all attacks.
static void fixed_variables_stay(void **state)
{
    (void)state;
    struct attacked problem;
    set_up(&problem, sphere, 1, -1, 1);
    frame_fini(&problem.frame);
    problem.scenario.design_space.lower[2] = problem.scenario.design_space.upper[2] = 0.25;
    frame_init(&problem.frame, &problem.scenario);
    struct ended ended = run(&problem, 1, 0);
    assert_int_equal(ended.result.status, SEARCH_STATUS_DONE);
    assert_true(ended.box.lower[2] == 0.25 && ended.box.upper[2] == 0.25);
    const double half = sqrt((1.5 - 0.0625) / 5); // of the other five
    assert_true(fabs(ended.result.log_volume - 5 * log(half)) < 0.04);
    box_fini(&ended.box);
    attacked_fini(&problem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_box_holds_good_designs_only),
        cmocka_unit_test(whole_curves_decide),
        cmocka_unit_test(curves_are_promised_in_shares),
        cmocka_unit_test(replayed_search_ends_with_the_same_digest),
        cmocka_unit_test(no_good_design_is_said),
        cmocka_unit_test(fixed_variables_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
