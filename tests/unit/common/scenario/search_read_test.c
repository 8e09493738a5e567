// How to search: what each key means, and what its mistakes are told.
#include "common/scenario/search_read.h"

#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// Variables 0..3 of left, 4..7 of right (x, x, y, y each), 8..13 of rail.
static const char crash[] =
    "name: s\n"
    "vehicle: {mass: 1, yaw_inertia: 1, speed: 1}\n"
    "barrier: {face_x: -2, edge_y: -0.4, overlap: 0.4}\n"
    "springs:\n"
    "- {name: left, position: [-1, -0.7], deformation: [0, 1], force_x: {lower: 0, upper: 10}, "
    "force_y: {lower: 0, upper: 5}}\n"
    "- {name: right, position: [-1, -0.5], deformation: [0, 1], force_x: {lower: 0, upper: 10}, "
    "force_y: {lower: 0, upper: 5}}\n"
    "- {name: rail, position: [-1, -0.6], deformation: [0, 0.5, 1], force_x: {lower: 0, upper: "
    "10}, force_y: {lower: 2, upper: 2}}\n"
    "response: any\n"
    "firewall_distance: 0\n";

static const char plane[] = "name: s\nmodel: linear\n"
                            "variables:\n"
                            "- {name: a, lower: 0, upper: 10}\n"
                            "- {name: b, lower: 0, upper: 10}\n"
                            "- {name: c, lower: 4, upper: 4}\n"
                            "parameters: {matrix: [[1, 1, 1]]}\n"
                            "constraints: {row_1: {max: 9}}\n";

// Reads a scenario, then a search section into it. Releases the scenario when that fails.
static bool read_search(struct scenario *scenario, const char *text, const char *search,
                        struct error *error)
{
    *error = (struct error){0};
    if (scenario_read_text(scenario, "s.yaml", text, strlen(text), NULL, 0, error) != STATUS_OK)
        fail_msg("%s", error->text);
    struct tree *tree = tree_parse("t.yaml", search, strlen(search), error);
    assert_non_null(tree);
    bool read = search_read(tree_root(tree), scenario, error);
    tree_free(tree);
    if (!read)
        scenario_fini(scenario);
    return read;
}

static struct scenario read_valid(const char *text, const char *search)
{
    struct scenario scenario;
    struct error error;
    if (!read_search(&scenario, text, search, &error))
        fail_msg("%s", error.text);
    return scenario;
}

static void assert_numbers(const double *numbers, const double *expected, size_t count)
{
    assert_non_null(numbers);
    for (size_t i = 0; i < count; i++) {
        if (numbers[i] != expected[i] && !(isnan(numbers[i]) && isnan(expected[i])))
            fail_msg("number %zu: expected %g, found %g", i, expected[i], numbers[i]);
    }
}

// A list that the file does not give is no list: the search must not find zeros for weights.
static void absent_lists_are_null(void **state)
{
    (void)state;
    struct scenario s = read_valid(plane, "{}");
    assert_null(s.search.start);
    assert_null(s.search.weights);
    assert_null(s.search.minimum_widths);
    assert_null(s.search.reference);
    assert_null(s.search.hold.lower);
    assert_null(s.search.hold.upper);
    assert_null(s.search.tie);
    assert_int_equal(s.search.start_box.count, 0);
    assert_int_equal(s.search.starts, 0);
    assert_true(s.search.evaluations == 0);
    scenario_fini(&s);
}

static void counts_arrive(void **state)
{
    (void)state;
    struct scenario s = read_valid(plane, "{starts: 7, evaluations: 40e3, sampling: sobol}");
    assert_int_equal(s.search.starts, 7);
    assert_true(s.search.evaluations == 40000);
    assert_int_equal(s.search.sampling, SAMPLING_METHOD_SOBOL);
    scenario_fini(&s);
}

// One number for all, a list, a mapping that leaves the fixed variable out, and a word: four ways
// to the same design.
static void a_start_is_written_in_four_ways(void **state)
{
    (void)state;
    static const char *const ways[] = {"start: [5, 5, 4]", "start: {b: 5, a: 5}",
                                       "start: {a: 5, b: 5, c: 4}", "start: centre"};
    for (size_t i = 0; i < G_N_ELEMENTS(ways); i++) {
        struct scenario s = read_valid(plane, ways[i]);
        assert_numbers(s.search.start, (const double[]){5, 5, 4}, 3);
        scenario_fini(&s);
    }
    struct scenario s = read_valid(plane, "start: 4");
    assert_numbers(s.search.start, (const double[]){4, 4, 4}, 3);
    scenario_fini(&s);
}

// Forces are named by spring, by direction with a number for each point, or one by one.
static void forces_are_named_by_spring_direction_and_point(void **state)
{
    (void)state;
    struct scenario s = read_valid(crash, "weights:\n"
                                          "  left: 2\n"
                                          "  right.force_y: [3, 4]\n"
                                          "  rail.force_x: 5\n"
                                          "  rail.force_y[1]: 6\n");
    assert_numbers(s.search.weights, (const double[]){2, 2, 2, 2, 1, 1, 3, 4, 5, 5, 5, 1, 6, 1},
                   14);
    scenario_fini(&s);
}

static void boxes_and_held_bounds_arrive(void **state)
{
    (void)state;
    struct scenario s = read_valid(plane, "start_box: {lower: {a: 1, b: 2}, upper: [8, 9, 4]}\n"
                                          "hold: {lower: {a: 1}, upper: {b: 9}}\n"
                                          "minimum_widths: {b: 3}\n"
                                          "reference: {a: 2, b: 2}\n");
    assert_int_equal(s.search.start_box.count, 3);
    assert_numbers(s.search.start_box.lower, (const double[]){1, 2, 4}, 3);
    assert_numbers(s.search.start_box.upper, (const double[]){8, 9, 4}, 3);
    assert_numbers(s.search.hold.lower, (const double[]){1, NAN, NAN}, 3);
    assert_numbers(s.search.hold.upper, (const double[]){NAN, 9, NAN}, 3);
    assert_numbers(s.search.minimum_widths, (const double[]){0, 3, 0}, 3);
    assert_numbers(s.search.reference, (const double[]){2, 2, 4}, 3);
    scenario_fini(&s);
}

// A box leaves nothing to search: all bounds are held, and what would shape a box is not looked at.
static void a_box_holds_every_bound(void **state)
{
    (void)state;
    struct scenario s = read_valid(plane, "box: {lower: {a: 1, b: 2}, upper: [8, 9, 4]}\n"
                                          "start_box: {lower: 0, upper: 3}\n"
                                          "hold: {upper: {b: 7}}\n"
                                          "reference: {a: 9, b: 2}\n"
                                          "weights: 2\n");
    assert_numbers(s.search.hold.lower, (const double[]){1, 2, 4}, 3);
    assert_numbers(s.search.hold.upper, (const double[]){8, 9, 4}, 3);
    assert_int_equal(s.search.start_box.count, 0);
    assert_null(s.search.reference);
    assert_null(s.search.weights);
    assert_true(scenario_is_box(&s));
    scenario_fini(&s);
    s = read_valid(plane, "hold: {lower: {a: 1, b: 2}, upper: {a: 8, b: 9}}");
    assert_true(scenario_is_box(&s)); // c is fixed
    scenario_fini(&s);
    s = read_valid(plane, "hold: {lower: {a: 1, b: 2}, upper: {a: 8}}");
    assert_false(scenario_is_box(&s));
    scenario_fini(&s);
    s = read_valid(plane, "samples: 10");
    assert_false(scenario_is_box(&s));
    scenario_fini(&s);
}

// A box to certify is rounded inwards where it is read; what is a value stays one.
static void a_box_is_rounded(void **state)
{
    (void)state;
    struct scenario s =
        read_valid(plane, "{round: 2, box: {lower: [1, 3, 4], upper: [8.5, 3, 4]}}");
    assert_numbers(s.search.hold.lower, (const double[]){2, 3, 4}, 3);
    assert_numbers(s.search.hold.upper, (const double[]){8, 3, 4}, 3);
    scenario_fini(&s);
}

// Bounds that are held and values are as they were asked for; all others are to be multiples.
static void what_may_move_is_to_be_rounded(void **state)
{
    (void)state;
    struct scenario s = read_valid(plane, "{round: 2, hold: {lower: {a: 1}}}");
    double lower[3] = {1, 4, 4}, upper[3] = {8, 6, 4};
    const struct box box = {.count = 3, .lower = lower, .upper = upper};
    for (uint32_t v = 0; v < 3; v++)
        assert_true(scenario_is_rounded(&s, &box, v));
    upper[0] = 9;
    lower[1] = 3;
    assert_false(scenario_is_rounded(&s, &box, 0));
    assert_false(scenario_is_rounded(&s, &box, 1));
    scenario_fini(&s);
    s = read_valid(plane, "samples: 10");
    assert_true(scenario_is_rounded(&s, &box, 1));
    scenario_fini(&s);
}

// A tie points at its first variable whatever the order in which the names are given.
static void ties_point_at_the_first(void **state)
{
    (void)state;
    struct scenario s =
        read_valid(crash, "tie: [[right, left], ['rail.force_x[2]', 'rail.force_x[0]']]\n");
    static const uint32_t expected[] = {0, 1, 2, 3, 0, 1, 2, 3, 8, 9, 8, 11, 12, 13};
    assert_memory_equal(s.search.tie, expected, sizeof expected);
    scenario_fini(&s);

    s = read_valid(crash, "tie: [[left.force_x, right.force_x]]\n");
    static const uint32_t axial[] = {0, 1, 2, 3, 0, 1, 6, 7, 8, 9, 10, 11, 12, 13};
    assert_memory_equal(s.search.tie, axial, sizeof axial);
    scenario_fini(&s);
}

static void mistakes_are_pointed_at(void **state)
{
    (void)state;
    static const struct {
        const char *text, *search, *message;
    } mistakes[] = {
        {plane, "starts: 0", "t.yaml:1:9: starts: expected a whole number, 1 to 1024, found 0"},
        {plane, "evaluations: 5000",
         "t.yaml:1:14: evaluations: expected at least 10200, the samples of a step and of the "
         "certificate, found 5000"},
        {plane, "start: [5, 5]",
         "t.yaml:1:8: start: expected a number or a list of 3, found a list of 2"},
        {plane, "start: middle", "t.yaml:1:8: start: expected a number, found middle"},
        {plane, "start: [5, 11, 4]",
         "t.yaml:1:12: start.1: expected b inside the design space, 0 to 10, found 11"},
        {plane, "start: {a: 5}",
         "t.yaml:1:8: start: b is missing: expected a number for every free variable"},
        {plane, "start: {a: 5, d: 5}",
         "t.yaml:1:15: start: unknown variable 'd'; did you mean 'a'?"},
        {plane, "{start: 4, start_box: {lower: 4, upper: 4}}",
         "t.yaml:1:23: start_box: expected start or start_box, found both"},
        {plane, "start_box: {lower: 4, upper: [9, 3, 4]}",
         "t.yaml:1:30: start_box.upper: expected b at least at its lower bound of 4, found 3"},
        {plane, "start_box: {lower: 4}",
         "t.yaml:1:12: start_box: missing key 'upper': expected a number for every variable"},
        {crash, "weights: {front: 2}",
         "t.yaml:1:11: weights: unknown variable 'front': expected a spring, SPRING.force_x, "
         "SPRING.force_y, or one force as left.force_x[0]"},
        {crash, "weights: {left.force_z: 2}",
         "t.yaml:1:11: weights: unknown variable 'left.force_z': expected a spring, "
         "SPRING.force_x, SPRING.force_y, or one force as left.force_x[0]"},
        {crash, "weights: {left: 2, left.force_x: 3}",
         "t.yaml:1:20: weights: left.force_x[0] is given twice: expected it once"},
        {crash, "weights: {left: 0}", "t.yaml:1:17: weights.left: expected more than 0, found 0"},
        {crash, "minimum_widths: {left.force_x: -1}",
         "t.yaml:1:32: minimum_widths.left.force_x: expected at least 0 N, found -1"},
        {crash, "minimum_widths: {left: 6}",
         "t.yaml:1:17: minimum_widths: expected at most 5 for left.force_y[0], all there is, found "
         "6"},
        {plane, "{minimum_widths: {a: 3}, hold: {lower: {a: 4}, upper: {a: 6}}}",
         "t.yaml:1:18: minimum_widths: expected at most 2 for a, all there is, found 3"},
        {plane, "hold: {}", "t.yaml:1:7: hold: expected lower, upper or both, found neither"},
        {plane, "hold: {lower: {a: 6}, upper: {a: 5}}",
         "t.yaml:1:30: hold.upper: expected the upper bound of a at least at the lower one of 6, "
         "found 5"},
        {plane, "hold: {lower: [1, 2, 4], upper: [1, 2, 4]}",
         "t.yaml:1:7: hold: every variable has one value: expected a lower bound below its upper "
         "one "
         "(sobox-simulate looks at one design)"},
        {plane, "box: {lower: [1, 1, 4], upper: [1, 1, 4]}",
         "t.yaml:1:6: box: every variable has one value: expected a lower bound below its upper "
         "one "
         "(sobox-simulate looks at one design)"},
        {plane, "box: {lower: [1, 3, 4], upper: [2, 2, 4]}",
         "t.yaml:1:32: box.upper: expected b at least at its lower bound of 3, found 2"},
        {plane, "box: {lower: [1, 1, 4], upper: [2, 12, 4]}",
         "t.yaml:1:36: box.upper.1: expected b inside the design space, 0 to 10, found 12"},
        {plane, "round: 0", "t.yaml:1:8: round: expected more than 0, found 0"},
        {plane, "round: 11",
         "t.yaml:1:8: round: a, 0 to 10, has no width between multiples of 11: expected a smaller "
         "step"},
        {plane, "{round: 2, box: {lower: [3, 1, 4], upper: [5, 5, 4]}}",
         "t.yaml:1:9: round: a, 3 to 5, has no width between multiples of 2: expected a smaller "
         "step"},
        {plane, "box: {lower: {a: 1}, upper: {a: 2, b: 2}}",
         "t.yaml:1:14: box.lower: b is missing: expected a number for every free variable"},
        {plane, "hold: {lower: {a: -1}}",
         "t.yaml:1:19: hold.lower.a: expected a inside the design space, 0 to 10, found -1"},
        {plane, "{hold: {lower: {a: 3}}, start: {a: 2, b: 2}}",
         "t.yaml:1:32: start: expected a inside the bounds that are held, 3 to 10, found 2"},
        {plane, "{hold: {lower: {a: 3}}, start_box: {lower: 4, upper: [5, 5, 4]}}",
         "t.yaml:1:36: start_box: expected the held bound of a, 3, found 4"},
        {plane, "{reference: [9, 4, 4], start_box: {lower: 4, upper: [5, 5, 4]}}",
         "t.yaml:1:13: reference: expected a inside the start_box, 4 to 5, found 9"},
        {crash, "tie: left",
         "t.yaml:1:6: tie: expected a list of lists of names that share a corridor, found left"},
        {crash, "tie: [[left]]",
         "t.yaml:1:7: tie.0: expected a list of at least 2 names, found a list of 1"},
        {crash, "tie: [[left, rail]]",
         "t.yaml:1:14: tie.0.1: expected the discretization points of left for rail too"},
        {crash, "tie: [[left.force_x, left.force_y]]",
         "t.yaml:1:22: tie.0.1: expected the design space of left.force_x[0] for left.force_y[0] "
         "too, 0 to 10, found 0 to 5"},
        {crash, "tie: [[left, right], [left.force_x, right.force_x]]",
         "t.yaml:1:23: tie.1.0: left.force_x[0] is tied twice: expected it once"},
        {crash, "tie: [[left, left]]",
         "t.yaml:1:14: tie.0.1: left.force_x[0] is tied twice: expected it once"},
        {crash, "{tie: [[left, right]], weights: {right: 2}}",
         "t.yaml:1:33: weights: expected the same for left.force_x[0] and right.force_x[0], which "
         "are tied"},
        {crash, "{tie: [[left, right]], hold: {lower: {right: 2}}}",
         "t.yaml:1:30: hold: expected the same for left.force_x[0] and right.force_x[0], which are "
         "tied"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(mistakes); i++) {
        struct scenario scenario;
        struct error error;
        if (read_search(&scenario, mistakes[i].text, mistakes[i].search, &error) ||
            strcmp(error.text, mistakes[i].message) != 0)
            fail_msg("'%s': expected: %s\n found: %s", mistakes[i].search, mistakes[i].message,
                     error.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(absent_lists_are_null),
        cmocka_unit_test(counts_arrive),
        cmocka_unit_test(a_start_is_written_in_four_ways),
        cmocka_unit_test(forces_are_named_by_spring_direction_and_point),
        cmocka_unit_test(boxes_and_held_bounds_arrive),
        cmocka_unit_test(a_box_holds_every_bound),
        cmocka_unit_test(a_box_is_rounded),
        cmocka_unit_test(what_may_move_is_to_be_rounded),
        cmocka_unit_test(ties_point_at_the_first),
        cmocka_unit_test(mistakes_are_pointed_at),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
