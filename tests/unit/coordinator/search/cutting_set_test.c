#include "coordinator/search/cutting_set.h"

#include "tests/unit/coordinator/search/attacked.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { STEPS = 200 };

// sum of x <= 1: upper bounds of 1 / n, where the adversary's worst corner is all upper bounds.
static void sum_below_one(uint32_t variables, const double *design, double *margins)
{
    margins[0] = 1;
    for (uint32_t v = 0; v < variables; v++)
        margins[0] -= design[v];
}

static void sphere(uint32_t variables, const double *design, double *margins)
{
    double sum = 0;
    for (uint32_t v = 0; v < variables; v++)
        sum += design[v] * design[v];
    margins[0] = sqrt(variables) / 2 - sqrt(sum);
}

static void all_good(uint32_t variables, const double *design, double *margins)
{
    (void)variables;
    (void)design;
    margins[0] = 1;
}

struct grown {
    struct cutting_set set;
    struct demands demands;
    struct adversary_report report;
    uint32_t step;
};

static void begin(struct grown *grown, const struct attacked *problem, const double *start)
{
    *grown = (struct grown){0};
    demands_init(&grown->demands, &problem->scenario.search, problem->frame.variables,
                 &problem->frame.space);
    attacked_set(problem, &grown->demands, start, &grown->set);
}

static void end(struct grown *grown)
{
    cutting_set_fini(&grown->set);
    demands_fini(&grown->demands);
}

static void take_steps(struct grown *grown, const struct attacked *problem, uint32_t steps)
{
    for (uint32_t i = 0; i < steps; i++) {
        struct cutting_set *set = &grown->set;
        const struct moves *moves = adversary_moves(&set->adversary);
        const struct box *box = cutting_set_box(set);
        const struct sampling sampling = {.step = grown->step++,
                                          .samples = moves->attacks *
                                                     moves_count(&problem->scenario.curves, box),
                                          .method = SAMPLING_METHOD_MOVES,
                                          .curves = &problem->scenario.curves,
                                          .moves = moves};
        struct verdict *verdicts = g_new(struct verdict, sampling.samples);
        attacked_evaluate(problem, &sampling, box, verdicts);
        cutting_set_complete(set, &sampling, verdicts, &grown->report);
        g_free(verdicts);
    }
}

static struct box centre_of(const struct grown *grown, uint32_t variables)
{
    struct box box;
    box_init(&box, variables);
    cutting_set_centre(&grown->set, &box);
    return box;
}

// Grown from a small box to one whose limits are all that there is.
static void a_set_grows_to_its_limit(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, sum_below_one, 1, 4, 0, 1);
    static const double start[] = {0.1, 0.1, 0.2, 0.05};
    struct grown grown;
    begin(&grown, &problem, start);
    take_steps(&grown, &problem, STEPS / 2);
    cutting_set_refine(&grown.set);
    take_steps(&grown, &problem, STEPS / 2);
    assert_true(cutting_set_resting(&grown.set));
    struct box box = centre_of(&grown, 4);
    for (uint32_t v = 0; v < 4; v++) {
        assert_true(box.lower[v] == 0);
        assert_true(fabs(box.upper[v] - 0.25) < 0.004);
    }
    assert_true(grown.report.margin >= 0);
    assert_true(fabs(cutting_set_merit(&grown.set) - 4 * log(0.25)) < 0.02);
    box_fini(&box);
    end(&grown);
    attacked_fini(&problem);
}

// A start in a corner where everything is bad still finds the way to a good box: the excess of
// limits is paid off first.
static void a_bad_start_moves_to_good_designs(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, sphere, 1, 3, -1, 1);
    static const double start[] = {0.9, -0.9, 0.95};
    struct grown grown;
    begin(&grown, &problem, start);
    take_steps(&grown, &problem, STEPS);
    struct box box = centre_of(&grown, 3);
    uint32_t corner;
    assert_true(attacked_worst_corner(&problem, &box, &corner) > -1e-3);
    double volume = 1;
    for (uint32_t v = 0; v < 3; v++)
        volume *= box.upper[v] - box.lower[v];
    assert_true(volume > 0.97 && volume < 1.001);
    box_fini(&box);
    end(&grown);
    attacked_fini(&problem);
}

// Where nothing is in the way the box is the design space, exactly: sides are put on its edges.
static void nothing_in_the_way_gives_the_design_space(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, all_good, 1, 3, -2, 5);
    static const double start[] = {0, 1, -1};
    struct grown grown;
    begin(&grown, &problem, start);
    take_steps(&grown, &problem, STEPS);
    struct box box = centre_of(&grown, 3);
    for (uint32_t v = 0; v < 3; v++)
        assert_true(box.lower[v] == -2 && box.upper[v] == 5);
    box_fini(&box);
    end(&grown);
    attacked_fini(&problem);
}

// Held bounds and a design that must stay inside are kept at every step, not only at the last.
static void demands_are_kept_at_every_step(void **state)
{
    (void)state;
    static bool hold[] = {true, false, false, false, false, false};
    static double reference[] = {0.3, 0.9, 0.05};
    struct attacked problem;
    attacked_init(&problem, sum_below_one, 1, 3, 0, 2);
    struct grown grown;
    begin(&grown, &problem, (const double[]){0.3, 0.1, 0.05});
    grown.demands.held = hold;
    grown.demands.reference = reference;
    grown.demands.any = true;
    box_init(&grown.demands.around, 3);
    for (uint32_t v = 0; v < 3; v++)
        grown.demands.around.lower[v] = grown.demands.around.upper[v] = reference[v];
    take_steps(&grown, &problem, 1); // the start itself was laid out without them
    for (uint32_t i = 0; i < 60; i++) {
        take_steps(&grown, &problem, 1);
        const struct box *box = cutting_set_box(&grown.set);
        assert_true(box->lower[0] == 0);
        for (uint32_t v = 0; v < 3; v++)
            assert_true(box->lower[v] <= reference[v] && box->upper[v] >= reference[v]);
    }
    grown.demands.held = NULL;
    grown.demands.reference = NULL;
    end(&grown);
    attacked_fini(&problem);
}

// A box that is attacked before it is certified stays as it is; mended, it moves and keeps more.
static void a_standing_set_moves_only_when_mended(void **state)
{
    (void)state;
    struct attacked problem;
    attacked_init(&problem, sphere, 1, 4, -1, 1);
    struct grown grown;
    begin(&grown, &problem, (const double[]){0, 0, 0, 0});
    take_steps(&grown, &problem, STEPS);
    cutting_set_stand(&grown.set);
    struct box before = centre_of(&grown, 4);
    take_steps(&grown, &problem, 5);
    struct box after = centre_of(&grown, 4);
    assert_true(box_equal(&before, &after));
    uint32_t corner;
    const double margin = attacked_worst_corner(&problem, &after, &corner);
    cutting_set_mend(&grown.set);
    take_steps(&grown, &problem, 12);
    box_fini(&after);
    after = centre_of(&grown, 4);
    assert_false(box_equal(&before, &after));
    assert_true(attacked_worst_corner(&problem, &after, &corner) > margin);
    box_fini(&before);
    box_fini(&after);
    end(&grown);
    attacked_fini(&problem);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_set_grows_to_its_limit),
        cmocka_unit_test(a_bad_start_moves_to_good_designs),
        cmocka_unit_test(nothing_in_the_way_gives_the_design_space),
        cmocka_unit_test(demands_are_kept_at_every_step),
        cmocka_unit_test(a_standing_set_moves_only_when_mended),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
