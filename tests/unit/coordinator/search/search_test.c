#include "coordinator/search/search.h"

#include "common/sampling/sampling.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

// A problem whose answer is known: the relative violation of one design.
typedef double problem_function(uint32_t variables, const double *design, size_t stride);

static double hypersphere(uint32_t variables, const double *design, size_t stride)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v * stride] * design[v * stride];
    return sqrt(sum) - sqrt(variables) / 2;
}

// Two sections in a row, 2000 kg at 15.6 m/s: enough energy, not too much deceleration, and the
// front one folds first. The largest box is F1 in [294480, 516720], F2 in [516720, 627840] N.
static double two_section_crash(uint32_t variables, const double *design, size_t stride)
{
    (void)variables;
    const double f1 = design[0];
    const double f2 = design[stride];
    const double energy = (2000 * 15.6 * 15.6 / 2 - 0.3 * (f1 + f2)) / 2.4336e5;
    const double deceleration = f2 / 2000 / (32 * 9.81) - 1;
    const double order = (f1 - f2) / 1e6;
    return fmax(energy, fmax(deceleration, order));
}

static const double crash_area = 222240.0 * 111120.0;

// Semi-axes 2 and 1 at 45 degrees: the largest box has half-widths 1 / sqrt(2).
static double ellipse(uint32_t variables, const double *design, size_t stride)
{
    (void)variables;
    const double along = (design[0] + design[stride]) / sqrt(2);
    const double across = (design[stride] - design[0]) / sqrt(2);
    return along * along / 4 + across * across - 1;
}

static double corner(uint32_t variables, const double *design, size_t stride)
{
    double least = 1;
    for (uint32_t v = 0; v < variables; v++)
        least = fmin(least, design[v * stride] - 0.7);
    return least;
}

static double nowhere_good(uint32_t variables, const double *design, size_t stride)
{
    return 1 + hypersphere(variables, design, stride) / 10;
}

static double everywhere_good(uint32_t variables, const double *design, size_t stride)
{
    (void)variables;
    (void)design;
    (void)stride;
    return -1;
}

// A cube of side 0.01: a share of 1e-20 of the design space in ten variables.
static double tiny_cube(uint32_t variables, const double *design, size_t stride)
{
    double worst = -1;
    for (uint32_t v = 0; v < variables; v++)
        worst = fmax(worst, fabs(design[v * stride] - 0.3) / 0.005 - 1);
    return worst;
}

// Two good balls; the second is smaller. Fails numerically far away from both.
static double two_regions(uint32_t variables, const double *design, size_t stride)
{
    double one = 0;
    double two = 0;
    for (uint32_t v = 0; v < variables; v++) {
        one += pow(design[v * stride] - 0.5, 2);
        two += pow(design[v * stride] + 0.5, 2);
    }
    if (one > 6 && two > 6)
        return NAN;
    return fmin(sqrt(one) - 0.5, sqrt(two) - 0.3);
}

// Good on both sides of a ridge, which holds the middle of all good designs.
static double beside_a_ridge(uint32_t variables, const double *design, size_t stride)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v * stride];
    return 0.4 - fabs(sum) / sqrt(variables);
}

struct setting {
    problem_function *problem;
    uint32_t variables;
    double lower;
    double upper;
    uint32_t fixed; // of the variables, in front
    uint32_t samples;
    uint32_t steps; // of exploration, and of consolidation
    uint32_t certificate;
    double target;
    int threads;
    bool replay;                  // start anew half-way, from the verdicts given so far
    uint32_t replay_at;           // or after so many steps
    struct scenario_search asked; // what engineers ask for; everything else is filled in
};

static const struct setting standard = {
    .variables = 2,
    .lower = -1,
    .upper = 1,
    .samples = 200,
    .steps = 100,
    .certificate = 10000,
    .target = 0.99,
    .threads = 1,
};

struct outcome_of_search {
    struct search_result result;
    struct box box;
    uint32_t steps[SEARCH_PHASE_DONE];
};

static struct scenario scenario_of(const struct setting *setting)
{
    struct scenario scenario;
    memset(&scenario, 0, sizeof scenario);
    box_init(&scenario.design_space, setting->variables);
    curve_map_init(&scenario.curves, setting->variables);
    for (uint32_t v = 0; v < setting->variables; v++) {
        scenario.design_space.lower[v] = v < setting->fixed ? 0.25 : setting->lower;
        scenario.design_space.upper[v] = v < setting->fixed ? 0.25 : setting->upper;
    }
    static struct scenario_constraint constraints[2] = {{.max = 0, .scale = 1},
                                                        {.max = 0, .scale = 1}};
    scenario.constraints = constraints;
    scenario.constraint_count = G_N_ELEMENTS(constraints);
    scenario.search = setting->asked;
    scenario.search.samples = setting->samples;
    scenario.search.exploration_steps = setting->steps;
    scenario.search.consolidation_steps = setting->steps;
    scenario.search.certificate_samples = setting->certificate;
    scenario.search.target_purity = setting->target;
    scenario.search.sampling = SAMPLING_METHOD_UNIFORM;
    scenario.constraint_count = 2; // see evaluate()
    return scenario;
}

// What workers do.
static void evaluate(const struct setting *setting, const struct search_request *request,
                     struct verdict *verdicts)
{
    const uint32_t samples = request->sampling.samples;
    double *values = g_new(double, (size_t)samples * setting->variables);
    sampling_fill(&request->sampling, request->box, 0, samples, values, samples);
    for (uint32_t i = 0; i < samples; i++) {
        const double relative = setting->problem(setting->variables, values + i, samples);
        verdicts[i] = (struct verdict){.violation = verdict_violation(relative)};
        verdicts[i].constraint = verdicts[i].violation != 0 && relative > 0.5 ? 1 : 0;
        if (request->detail == VERDICT_DETAIL_SHARE && verdicts[i].violation != 0)
            verdicts[i] = (struct verdict){.violation = 1};
        if (request->detail == VERDICT_DETAIL_MARGIN)
            verdicts[i].margin = isnan(relative) ? -INFINITY : (float)-relative;
    }
    g_free(values);
}

// Runs a search to its end; the caller releases outcome.box.
static struct outcome_of_search run(const struct setting *setting, uint64_t seed)
{
    struct scenario scenario = scenario_of(setting);
    struct outcome_of_search outcome = {0};
    struct search *search = search_create(&scenario, seed, setting->threads);
    GPtrArray *journal = g_ptr_array_new_with_free_func(g_free);
    struct search_request request;
    while (search_request(search, &request)) {
        struct verdict *verdicts = g_new(struct verdict, request.sampling.samples);
        evaluate(setting, &request, verdicts);
        g_ptr_array_add(journal, verdicts);
        outcome.steps[request.phase]++;
        search_complete(search, verdicts);
        assert_int_equal(search_last_step(search)->step, request.sampling.step);
        if (setting->replay &&
            journal->len == (setting->replay_at > 0 ? setting->replay_at : setting->steps)) {
            search_free(search);
            search = search_create(&scenario, seed, setting->threads);
            for (guint i = 0; i < journal->len; i++) {
                assert_true(search_request(search, &request));
                search_complete(search, g_ptr_array_index(journal, i));
            }
        }
    }
    search_result(search, &outcome.result);
    box_init(&outcome.box, setting->variables);
    box_assign(&outcome.box, outcome.result.box);
    outcome.result.box = NULL;
    assert_true(box_inside(&outcome.box, &scenario.design_space));
    search_free(search);
    g_ptr_array_free(journal, TRUE);
    box_fini(&scenario.design_space);
    curve_map_fini(&scenario.curves);
    return outcome;
}

// The share of good designs in a box, from fresh points that the search has not seen.
static double true_purity(const struct setting *setting, const struct box *box)
{
    struct search_request request = {
        .sampling = {.seed = 987654321, .samples = 50000, .method = SAMPLING_METHOD_UNIFORM},
        .detail = VERDICT_DETAIL_SHARE,
        .box = box,
    };
    struct verdict *verdicts = g_new(struct verdict, request.sampling.samples);
    evaluate(setting, &request, verdicts);
    const double good = verdict_good_count(verdicts, request.sampling.samples);
    g_free(verdicts);
    return good / request.sampling.samples;
}

static double volume(const struct box *box)
{
    double volume = 1;
    for (uint32_t v = 0; v < box->count; v++)
        volume *= box->upper[v] - box->lower[v];
    return volume;
}

// A certified box of at least `least` of the exact volume, over several seeds.
static void assert_finds(const struct setting *setting, double exact, double least, double most)
{
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct outcome_of_search outcome = run(setting, seed);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        assert_true(outcome.result.purity.lower95 >= setting->target);
        assert_true(outcome.result.purity.estimate > outcome.result.purity.lower95);
        const double purity = true_purity(setting, &outcome.box);
        const double ratio = volume(&outcome.box) / exact;
        if (!(purity >= setting->target && ratio >= least && ratio <= most))
            fail_msg("seed %d: volume ratio %.4f, purity %.5f", (int)seed, ratio, purity);
        box_fini(&outcome.box);
    }
}

// In two dimensions a box of purity 0.99 is hardly larger than the exact one.
static void finds_the_square_in_the_circle(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    assert_finds(&setting, 1, 0.95, 1.15);
}

// Bounds that touch each other and two constraints; the search may not stop at the first corner.
static void finds_the_crash_corridors(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = two_section_crash;
    setting.lower = 1e5;
    setting.upper = 1e6;
    assert_finds(&setting, crash_area, 0.95, 1.2);
}

// A box in a tilted ellipse touches it with two corners only.
static void finds_the_box_in_the_ellipse(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = ellipse;
    setting.lower = -3;
    setting.upper = 3;
    assert_finds(&setting, 2, 0.95, 1.2);
}

// Where only one corner is bad, one side moves in and all others stay on the design space.
static void removes_a_corner_with_one_side(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = corner;
    setting.lower = 0;
    setting.variables = 2;
    assert_finds(&setting, 0.7, 0.97, 1.06);
}

// In ten dimensions a box of purity 0.99 is several times the exact one, whose corners alone touch
// the sphere.
static void finds_a_large_box_in_ten_dimensions(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 10;
    assert_finds(&setting, 1, 5, 40);
}

// A fixed variable keeps its value and must not make every volume zero; one free variable is
// enough.
static void searches_one_variable_among_fixed_ones(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 3;
    setting.fixed = 2;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    const double half = sqrt(0.75 - 2 * 0.0625);
    assert_true(fabs(outcome.box.upper[2] - half) < 0.03);
    assert_true(fabs(outcome.box.lower[2] + half) < 0.03);
    assert_true(outcome.box.lower[0] == 0.25 && outcome.box.upper[0] == 0.25);
    assert_true(fabs(outcome.result.log_volume - log(half)) < 0.05);
    box_fini(&outcome.box);
}

// Nothing to search for: the whole design space, after one step, its certificates and an attack.
static void takes_the_whole_space_when_all_is_good(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = everywhere_good;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(outcome.steps[SEARCH_PHASE_SEEK], 1);
    assert_int_equal(outcome.steps[SEARCH_PHASE_EXPLORE] + outcome.steps[SEARCH_PHASE_CONSOLIDATE],
                     0);
    assert_true(outcome.result.log_volume == 0);
    box_fini(&outcome.box);
}

// No good design is a result: it says so, names the constraint in the way, and shows the design
// that violates least.
static void says_when_there_is_no_good_design(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = nowhere_good;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_NO_GOOD_DESIGN);
    assert_int_equal(outcome.result.blocking_constraint, 1);
    assert_true(outcome.result.purity.samples == 0);
    assert_true(outcome.result.log_volume == -INFINITY);
    for (uint32_t v = 0; v < 2; v++)
        assert_true(fabs(outcome.box.lower[v]) < 0.2);
    box_fini(&outcome.box);
}

// Nobody draws a good sample of so small a region by chance: the violation must lead there.
static void finds_a_tiny_region_by_its_violation(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = tiny_cube;
    setting.variables = 10;
    struct outcome_of_search outcome = run(&setting, 2);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    for (uint32_t v = 0; v < 10; v++)
        assert_true(outcome.box.upper[v] - outcome.box.lower[v] > 0.009);
    box_fini(&outcome.box);
}

// Of two good regions the larger one is to be found, and a NaN is a bad sample that is counted.
static void chooses_the_larger_of_two_regions(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = two_regions;
    setting.variables = 3;
    setting.lower = -2;
    setting.upper = 2;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        struct outcome_of_search outcome = run(&setting, seed);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        assert_true(outcome.result.non_finite > 0);
        for (uint32_t v = 0; v < 3; v++)
            assert_true(outcome.box.lower[v] > 0);
        box_fini(&outcome.box);
    }
}

// 100 samples without a bad one prove 0.97 and no more: a target above that is missed, openly.
static void admits_that_a_certificate_is_too_small(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.certificate = 100;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_PURITY_MISSED);
    assert_true(outcome.result.purity.lower95 < 0.99);
    assert_int_equal(outcome.result.purity.samples, 100);
    box_fini(&outcome.box);
}

// After few steps the box is not pure enough yet. The search goes back to consolidating, and if the
// looks are used up it says so: a certified box is always as pure as claimed.
static void short_searches_never_claim_too_much(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 6;
    setting.samples = 50;
    setting.steps = 8;
    uint32_t looked_again = 0;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        struct outcome_of_search outcome = run(&setting, seed);
        looked_again += outcome.steps[SEARCH_PHASE_CERTIFY] > 1;
        if (outcome.result.status == SEARCH_STATUS_DONE)
            assert_true(true_purity(&setting, &outcome.box) >= 0.988);
        else
            assert_int_equal(outcome.result.status, SEARCH_STATUS_PURITY_MISSED);
        box_fini(&outcome.box);
    }
    assert_true(looked_again > 0);
}

// The same verdicts give the same bits whatever number of threads trims, and another seed others.
static void threads_do_not_change_the_result(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 7;
    struct outcome_of_search first = run(&setting, 5);
    static const int threads[] = {4, 16};
    for (int i = 0; i < 2; i++) {
        setting.threads = threads[i];
        struct outcome_of_search other = run(&setting, 5);
        assert_true(box_equal(&first.box, &other.box));
        assert_true(digest_equal(&first.result.digest, &other.result.digest));
        box_fini(&other.box);
    }
    struct outcome_of_search other = run(&setting, 6);
    assert_false(digest_equal(&first.result.digest, &other.result.digest));
    box_fini(&other.box);
    box_fini(&first.box);
}

// A search that is killed is resumed by giving it the journalled verdicts again.
static void replayed_search_ends_with_the_same_digest(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = two_section_crash;
    setting.lower = 1e5;
    setting.upper = 1e6;
    struct outcome_of_search whole = run(&setting, 9);
    setting.replay = true;
    struct outcome_of_search resumed = run(&setting, 9);
    assert_true(digest_equal(&whole.result.digest, &resumed.result.digest));
    box_fini(&whole.box);
    box_fini(&resumed.box);
}

// What is asked is said after the box is final, so that it may be left out: box, purity and digest
// are the same, and only evaluations and steps show it.
static void explanation_changes_nothing(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 5;
    setting.steps = 20;
    setting.target = 0.997; // some seeds look twice
    for (uint64_t seed = 1; seed <= 3; seed++) {
        setting.asked.explain_samples = 0;
        struct outcome_of_search plain = run(&setting, seed);
        setting.asked.explain_samples = 50;
        setting.replay = seed == 2;
        struct outcome_of_search explained = run(&setting, seed);
        setting.replay = false;
        assert_int_equal(plain.steps[SEARCH_PHASE_EXPLAIN], 0);
        assert_int_equal(explained.steps[SEARCH_PHASE_EXPLAIN], 10);
        assert_true(box_equal(&plain.box, &explained.box));
        assert_true(digest_equal(&plain.result.digest, &explained.result.digest));
        assert_int_equal(plain.result.status, explained.result.status);
        assert_int_equal(plain.result.purity.bad, explained.result.purity.bad);
        assert_int_equal(explained.result.evaluations, plain.result.evaluations + 500);
        assert_int_equal(explained.result.steps, plain.result.steps + 10);
        box_fini(&plain.box);
        box_fini(&explained.box);
    }
}

// Killed while it samples outside the box, a search goes on there.
static void explanation_is_resumed(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.steps = 20;
    setting.asked.explain_samples = 50;
    struct outcome_of_search whole = run(&setting, 1);
    setting.replay = true;
    setting.replay_at = whole.result.steps - 2;
    struct outcome_of_search resumed = run(&setting, 1);
    assert_int_equal(resumed.steps[SEARCH_PHASE_EXPLAIN], 4);
    assert_true(box_equal(&whole.box, &resumed.box));
    assert_true(digest_equal(&whole.result.digest, &resumed.result.digest));
    assert_int_equal(whole.result.evaluations, resumed.result.evaluations);
    box_fini(&whole.box);
    box_fini(&resumed.box);
}

// There is nothing to explain without a box, and no bound to look at where all is good.
static void nothing_is_explained_without_a_bound(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.asked.explain_samples = 50;
    setting.problem = nowhere_good;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_NO_GOOD_DESIGN);
    assert_int_equal(outcome.steps[SEARCH_PHASE_EXPLAIN], 0);
    box_fini(&outcome.box);
    setting.problem = everywhere_good;
    outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(outcome.steps[SEARCH_PHASE_EXPLAIN], 0);
    box_fini(&outcome.box);
}

// The explanation is part of the budget: it is set aside, and what others left is not exceeded.
static void explanation_stays_in_the_budget(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 5;
    setting.asked.explain_samples = 100;
    for (uint64_t budget = 12000; budget <= 30000; budget += 6000) {
        setting.asked.evaluations = budget;
        struct outcome_of_search outcome = run(&setting, 1);
        assert_true(outcome.result.evaluations <= budget);
        assert_int_equal(outcome.steps[SEARCH_PHASE_EXPLAIN], 10);
        box_fini(&outcome.box);
    }
}

// With far more steps than it takes, a search that stops when nothing is gained costs a fraction,
// and finds as large a box.
static void stagnation_ends_a_search_early(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 5;
    setting.samples = 100;
    setting.steps = 300;
    struct outcome_of_search whole = run(&setting, 1);
    setting.asked.stagnation = 15;
    struct outcome_of_search early = run(&setting, 1);
    assert_int_equal(early.result.status, SEARCH_STATUS_DONE);
    assert_true(early.steps[SEARCH_PHASE_EXPLORE] < 200);
    assert_true(early.steps[SEARCH_PHASE_CONSOLIDATE] < 290);
    assert_int_equal(whole.steps[SEARCH_PHASE_EXPLORE], 300);
    assert_true(fabs(early.result.log_volume - whole.result.log_volume) < 0.1);
    setting.replay = true;
    setting.replay_at = early.result.steps - 5;
    struct outcome_of_search again = run(&setting, 1);
    assert_true(digest_equal(&again.result.digest, &early.result.digest));
    box_fini(&whole.box);
    box_fini(&early.box);
    box_fini(&again.box);
}

// One variable: bounds where the problem changes, and hardly anything lost.
static void one_variable_is_enough(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 1;
    setting.asked.explain_samples = 20;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(outcome.steps[SEARCH_PHASE_EXPLAIN], 2);
    assert_true(fabs(outcome.box.lower[0] + 0.5) < 0.01);
    assert_true(fabs(outcome.box.upper[0] - 0.5) < 0.01);
    box_fini(&outcome.box);
}

// As many variables as forty springs with nine points have: volumes multiply 720 widths, and each
// bound gets its samples.
static void hundreds_of_variables_are_searched(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.variables = 720;
    setting.lower = -0.87; // two in five are good
    setting.upper = 0.87;
    setting.steps = 10;
    setting.target = 0.5;
    setting.certificate = 100;
    setting.asked.explain_samples = 2;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_true(isfinite(outcome.result.log_volume));
    assert_in_range(outcome.steps[SEARCH_PHASE_EXPLAIN], 1, 1440);
    box_fini(&outcome.box);
}

// Too few steps to get anywhere from the start that was chosen are no reason to say that there is
// no good design when a quarter of those looked at are good.
static void few_steps_still_find_a_box(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = beside_a_ridge;
    setting.variables = 10;
    setting.samples = 100;
    setting.target = 0.6;
    setting.certificate = 1000;
    for (uint32_t steps = 1; steps <= 8; steps++) {
        setting.steps = steps;
        for (uint64_t seed = 1; seed <= 10; seed++) {
            struct outcome_of_search outcome = run(&setting, seed);
            assert_int_not_equal(outcome.result.status, SEARCH_STATUS_NO_GOOD_DESIGN);
            assert_true(isfinite(outcome.result.log_volume));
            box_fini(&outcome.box);
        }
    }
}

// A request stays the same until it is answered, and the phases come in their order.
static void asking_twice_changes_nothing(void **state)
{
    (void)state;
    struct setting setting = standard;
    setting.problem = hypersphere;
    setting.steps = 10;
    struct scenario scenario = scenario_of(&setting);
    struct search *search = search_create(&scenario, 1, 1);
    struct search_request request;
    enum search_phase phase = SEARCH_PHASE_SEEK;
    struct verdict *verdicts = g_new(struct verdict, 10000);
    while (search_request(search, &request)) {
        struct search_request again;
        assert_true(search_request(search, &again));
        assert_memory_equal(&request, &again, sizeof request);
        assert_true(request.phase >= phase || phase == SEARCH_PHASE_CERTIFY);
        phase = request.phase;
        struct search_progress progress;
        search_progress(search, &progress);
        assert_int_equal(progress.phase, phase);
        assert_true(progress.step_count > progress.step);
        evaluate(&setting, &request, verdicts);
        search_complete(search, verdicts);
    }
    struct search_progress progress;
    search_progress(search, &progress);
    assert_int_equal(progress.phase, SEARCH_PHASE_DONE);
    assert_int_equal(progress.step, progress.step_count);
    g_free(verdicts);
    search_free(search);
    box_fini(&scenario.design_space);
    curve_map_fini(&scenario.curves);
}

// A problem and what is asked of its box.
static struct setting asking(problem_function *problem, uint32_t variables)
{
    struct setting setting = standard;
    setting.problem = problem;
    setting.variables = variables;
    return setting;
}

static double width(const struct box *box, uint32_t variable)
{
    return box->upper[variable] - box->lower[variable];
}

// The budget holds for everything, the certificate and second looks included, and shortens the
// steps evenly: the box is certified nevertheless. One that is hardly enough still gives a box and
// an honest purity.
static void budget_is_kept(void **state)
{
    (void)state;
    static const uint64_t budgets[] = {10200, 10500, 14000, 20000, 30000};
    for (int i = 0; i < 5; i++) {
        struct setting setting = asking(hypersphere, 4);
        setting.asked.evaluations = budgets[i];
        struct outcome_of_search outcome = run(&setting, 3);
        assert_true(outcome.result.evaluations <= budgets[i]);
        assert_true(outcome.result.purity.samples == 10000);
        assert_true(outcome.result.log_volume > -6);
        if (budgets[i] >= 20000)
            assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        box_fini(&outcome.box);
    }
}

// As many boxes grow as were asked for; one alone grows from a good design.
static void starts_are_as_many_as_asked_for(void **state)
{
    (void)state;
    static const uint32_t starts[] = {1, 2, 12};
    uint32_t last = 0;
    for (int i = 0; i < 3; i++) {
        struct setting setting = asking(two_regions, 3);
        setting.lower = -2;
        setting.upper = 2;
        setting.asked.starts = starts[i];
        struct outcome_of_search outcome = run(&setting, 4);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        // More starts are sought for longer where good designs are few.
        assert_true(outcome.steps[SEARCH_PHASE_SEEK] >= last);
        last = outcome.steps[SEARCH_PHASE_SEEK];
        box_fini(&outcome.box);
    }
    assert_true(last > 1);
}

// From a given design the search goes to the region around it, though another is larger, and
// finds in one sample what no Latin hypercube would: a cube of side 0.01 in ten variables.
static void search_begins_at_the_given_design(void **state)
{
    (void)state;
    double start[10];
    struct setting setting = asking(two_regions, 3);
    setting.lower = -2;
    setting.upper = 2;
    setting.asked.start = start;
    for (uint32_t v = 0; v < 10; v++)
        start[v] = -0.5;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(outcome.steps[SEARCH_PHASE_SEEK], 1);
    assert_true(outcome.box.upper[0] < 0);
    box_fini(&outcome.box);
    setting = asking(tiny_cube, 10);
    setting.asked.start = start;
    for (uint32_t v = 0; v < 10; v++)
        start[v] = 0.301;
    outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_int_equal(outcome.steps[SEARCH_PHASE_SEEK], 1);
    box_fini(&outcome.box);
}

// A bad start is no reason to give up: the search looks for others.
static void bad_start_is_passed_over(void **state)
{
    (void)state;
    double start[2] = {0.99, 0.99};
    struct setting setting = asking(hypersphere, 2);
    setting.asked.start = start;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_true(volume(&outcome.box) > 0.9);
    box_fini(&outcome.box);
}

// From a given box too.
static void search_begins_at_the_given_box(void **state)
{
    (void)state;
    struct setting setting = asking(two_regions, 3);
    setting.lower = -2;
    setting.upper = 2;
    double lower[3] = {-0.6, -0.6, -0.6};
    double upper[3] = {-0.3, -0.3, -0.3};
    setting.asked.start_box = (struct box){.count = 3, .lower = lower, .upper = upper};
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_true(outcome.box.upper[0] < 0);
    box_fini(&outcome.box);
}

// A reference near the corner of the circle bends the whole box towards it, and stays inside.
static void reference_stays_inside(void **state)
{
    (void)state;
    double reference[2] = {0.65, -0.2};
    struct setting setting = asking(hypersphere, 2);
    setting.asked.reference = reference;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct outcome_of_search outcome = run(&setting, seed);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        assert_true(box_contains(&outcome.box, reference));
        assert_true(volume(&outcome.box) > 0.4);
        box_fini(&outcome.box);
    }
}

// No good box contains a bad design: one sample says so, and which constraint it is.
static void bad_reference_is_refused(void **state)
{
    (void)state;
    double reference[2] = {0.9, 0.9};
    struct setting setting = asking(hypersphere, 2);
    setting.asked.reference = reference;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_NO_GOOD_DESIGN);
    assert_int_equal(outcome.result.blocking_constraint, 1);
    assert_int_equal(outcome.result.evaluations, 1);
    assert_true(outcome.box.lower[0] == 0.9 && outcome.box.upper[1] == 0.9);
    box_fini(&outcome.box);
}

// Held bounds stay where they are, to the bit, the others make the best of it, and a variable held
// to a value does not make the volume vanish.
static void held_bounds_stay(void **state)
{
    (void)state;
    double lower[3] = {-0.1, 0.2, NAN};
    double upper[3] = {NAN, 0.2, NAN};
    struct setting setting = asking(hypersphere, 3);
    setting.asked.hold.lower = lower;
    setting.asked.hold.upper = upper;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_true(outcome.box.lower[0] == -0.1);
    assert_true(outcome.box.lower[1] == 0.2 && outcome.box.upper[1] == 0.2);
    assert_true(outcome.box.upper[0] > 0.4 && width(&outcome.box, 2) > 0.8);
    assert_true(isfinite(outcome.result.log_volume));
    box_fini(&outcome.box);
}

// A box of which every bound is held is certified as it is: nothing is sought, and one look
// decides, whatever is found. With the promise of every design one bad corner is found, which a
// thousandth of the points hits.
static void given_box_is_certified_as_it_is(void **state)
{
    (void)state;
    static const struct {
        double half; // width
        enum promise promise;
        enum search_status status;
    } cases[] = {
        {0.49, PROMISE_POINTS, SEARCH_STATUS_DONE},
        {0.9, PROMISE_POINTS, SEARCH_STATUS_PURITY_MISSED},
        {0.52, PROMISE_POINTS, SEARCH_STATUS_DONE}, // with bad corners
        {0.49, PROMISE_EVERY, SEARCH_STATUS_DONE},
        {0.52, PROMISE_EVERY, SEARCH_STATUS_PURITY_MISSED},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        double lower[3], upper[3];
        for (int v = 0; v < 3; v++) {
            lower[v] = -cases[i].half;
            upper[v] = cases[i].half;
        }
        struct setting setting = asking(hypersphere, 3);
        setting.asked.hold.lower = lower;
        setting.asked.hold.upper = upper;
        setting.asked.promise = cases[i].promise;
        struct outcome_of_search outcome = run(&setting, 1);
        assert_int_equal(outcome.result.status, cases[i].status);
        assert_memory_equal(outcome.box.lower, lower, sizeof lower);
        assert_memory_equal(outcome.box.upper, upper, sizeof upper);
        assert_int_equal(outcome.steps[SEARCH_PHASE_SEEK] + outcome.steps[SEARCH_PHASE_EXPLORE] +
                             outcome.steps[SEARCH_PHASE_CONSOLIDATE],
                         0);
        assert_int_equal(outcome.result.purity.samples, setting.certificate);
        setting.replay = true;
        setting.replay_at = 2;
        struct outcome_of_search resumed = run(&setting, 1);
        assert_true(digest_equal(&resumed.result.digest, &outcome.result.digest));
        box_fini(&resumed.box);
        box_fini(&outcome.box);
    }
}

// What is certified, and comes out, is the rounded box, with either promise, resumed or not.
static void rounded_box_is_certified(void **state)
{
    (void)state;
    for (int promise = PROMISE_POINTS; promise < PROMISE_COUNT; promise++) {
        struct setting setting = asking(hypersphere, 3);
        setting.asked.round = 0.125;
        setting.asked.promise = (enum promise)promise;
        struct outcome_of_search outcome = run(&setting, 1);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        for (uint32_t v = 0; v < 3; v++) {
            assert_true(fmod(outcome.box.lower[v], 0.125) == 0);
            assert_true(fmod(outcome.box.upper[v], 0.125) == 0);
            assert_true(width(&outcome.box, v) >= 0.5);
        }
        assert_true(true_purity(&setting, &outcome.box) >= 0.99);
        setting.replay = true;
        struct outcome_of_search resumed = run(&setting, 1);
        assert_true(digest_equal(&resumed.result.digest, &outcome.result.digest));
        box_fini(&resumed.box);
        box_fini(&outcome.box);
    }
}

// Corridors are as wide as asked for, at the cost of the others; where that cannot be had the
// search says that the purity was missed.
static void minimum_widths_are_kept(void **state)
{
    (void)state;
    double widths[3] = {1.4, 0, 0.1};
    struct setting setting = asking(hypersphere, 3);
    setting.asked.minimum_widths = widths;
    struct outcome_of_search outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
    assert_true(width(&outcome.box, 0) >= 1.4 && width(&outcome.box, 1) < 1.1);
    assert_true(volume(&outcome.box) > 0.8);
    box_fini(&outcome.box);
    widths[1] = widths[2] = 1.4;
    outcome = run(&setting, 1);
    assert_int_equal(outcome.result.status, SEARCH_STATUS_PURITY_MISSED);
    assert_true(width(&outcome.box, 2) >= 1.4);
    box_fini(&outcome.box);
}

// In the circle the best box with weights w has half-widths in proportion to their roots: the wide
// one is 1.7 times the other where one variable counts three times.
static void weights_make_corridors_wide(void **state)
{
    (void)state;
    double weights[2] = {3, 1};
    struct setting setting = asking(hypersphere, 2);
    setting.asked.weights = weights;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct outcome_of_search outcome = run(&setting, seed);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        const double ratio = width(&outcome.box, 0) / width(&outcome.box, 1);
        if (!(ratio > 1.45 && ratio < 2.1))
            fail_msg("seed %d: ratio %.3f", (int)seed, ratio);
        box_fini(&outcome.box);
    }
}

// Good where one variable is small and another, tied to it, is not: they share what both allow.
static double apart(uint32_t variables, const double *design, size_t stride)
{
    (void)variables;
    const double one = fabs(design[0] - 0.2) - 0.4;
    const double two = fabs(design[stride] + 0.2) - 0.4;
    const double three = fabs(design[2 * stride]) - 0.5;
    return fmax(fmax(one, two), three);
}

// Two springs share one corridor: equal to the bit, and as wide as both allow.
static void tied_variables_share_a_corridor(void **state)
{
    (void)state;
    uint32_t tie[3] = {0, 0, 2};
    struct setting setting = asking(apart, 3);
    setting.asked.tie = tie;
    for (uint64_t seed = 1; seed <= 4; seed++) {
        struct outcome_of_search outcome = run(&setting, seed);
        assert_int_equal(outcome.result.status, SEARCH_STATUS_DONE);
        assert_true(outcome.box.lower[0] == outcome.box.lower[1]);
        assert_true(outcome.box.upper[0] == outcome.box.upper[1]);
        const double shared = width(&outcome.box, 0);
        if (!(shared > 0.37 && shared < 0.42))
            fail_msg("seed %d: width %.3f", (int)seed, shared);
        box_fini(&outcome.box);
    }
}

// What was asked for does not come between a search and its journal: it is resumed to the bit, on
// any number of threads.
static void search_with_demands_is_resumed(void **state)
{
    (void)state;
    double weights[5] = {2, 1, 1, 1, 0.5};
    double widths[5] = {0, 0.9, 0.9, 0, 0};
    double reference[5] = {0.1, 0.3, -0.2, 0, 0};
    uint32_t tie[5] = {0, 1, 1, 3, 4};
    struct setting setting = asking(hypersphere, 5);
    setting.asked = (struct scenario_search){.evaluations = 40000,
                                             .starts = 3,
                                             .weights = weights,
                                             .minimum_widths = widths,
                                             .reference = reference,
                                             .tie = tie};
    struct outcome_of_search whole = run(&setting, 9);
    assert_int_equal(whole.result.status, SEARCH_STATUS_DONE);
    setting.replay = true;
    setting.threads = 4;
    struct outcome_of_search resumed = run(&setting, 9);
    assert_true(digest_equal(&whole.result.digest, &resumed.result.digest));
    box_fini(&whole.box);
    box_fini(&resumed.box);
}

// Every phase and status has the name that files and messages use.
static void phases_and_statuses_have_names(void **state)
{
    (void)state;
    assert_string_equal(protocol_phase_name(SEARCH_PHASE_CONSOLIDATE), "consolidate");
    assert_string_equal(protocol_status_name(SEARCH_STATUS_NO_GOOD_DESIGN), "no_good_design");
    for (int i = 0; i <= SEARCH_PHASE_DONE; i++)
        assert_non_null(protocol_phase_name((enum search_phase)i));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_the_square_in_the_circle),
        cmocka_unit_test(finds_the_crash_corridors),
        cmocka_unit_test(finds_the_box_in_the_ellipse),
        cmocka_unit_test(removes_a_corner_with_one_side),
        cmocka_unit_test(finds_a_large_box_in_ten_dimensions),
        cmocka_unit_test(searches_one_variable_among_fixed_ones),
        cmocka_unit_test(takes_the_whole_space_when_all_is_good),
        cmocka_unit_test(says_when_there_is_no_good_design),
        cmocka_unit_test(finds_a_tiny_region_by_its_violation),
        cmocka_unit_test(chooses_the_larger_of_two_regions),
        cmocka_unit_test(admits_that_a_certificate_is_too_small),
        cmocka_unit_test(short_searches_never_claim_too_much),
        cmocka_unit_test(threads_do_not_change_the_result),
        cmocka_unit_test(replayed_search_ends_with_the_same_digest),
        cmocka_unit_test(explanation_changes_nothing),
        cmocka_unit_test(explanation_is_resumed),
        cmocka_unit_test(nothing_is_explained_without_a_bound),
        cmocka_unit_test(explanation_stays_in_the_budget),
        cmocka_unit_test(stagnation_ends_a_search_early),
        cmocka_unit_test(one_variable_is_enough),
        cmocka_unit_test(hundreds_of_variables_are_searched),
        cmocka_unit_test(few_steps_still_find_a_box),
        cmocka_unit_test(asking_twice_changes_nothing),
        cmocka_unit_test(budget_is_kept),
        cmocka_unit_test(starts_are_as_many_as_asked_for),
        cmocka_unit_test(search_begins_at_the_given_design),
        cmocka_unit_test(bad_start_is_passed_over),
        cmocka_unit_test(search_begins_at_the_given_box),
        cmocka_unit_test(reference_stays_inside),
        cmocka_unit_test(bad_reference_is_refused),
        cmocka_unit_test(held_bounds_stay),
        cmocka_unit_test(given_box_is_certified_as_it_is),
        cmocka_unit_test(rounded_box_is_certified),
        cmocka_unit_test(minimum_widths_are_kept),
        cmocka_unit_test(weights_make_corridors_wide),
        cmocka_unit_test(tied_variables_share_a_corridor),
        cmocka_unit_test(search_with_demands_is_resumed),
        cmocka_unit_test(phases_and_statuses_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
