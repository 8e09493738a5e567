#include "common/scenario/scenario_read.h"

#include "tests/unit/common/scenario/example.h"

#include <glib.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static enum status read_text(struct scenario *scenario, const char *text, struct error *error)
{
    return scenario_read_text(scenario, "t.yaml", text, strlen(text), NULL, 0, error);
}

static struct scenario read_valid(const char *text, const char *override)
{
    struct scenario scenario;
    struct error error = {0};
    enum status status = scenario_read_text(&scenario, "t.yaml", text, strlen(text), &override,
                                            override != NULL, &error);
    if (status != STATUS_OK)
        fail_msg("%s", error.text);
    return scenario;
}

static char *replaced(const char *text, const char *find, const char *with)
{
    const char *at = strstr(text, find);
    if (at == NULL)
        fail_msg("the example does not contain: %s", find);
    return g_strdup_printf("%.*s%s%s", (int)(at - text), text, with, at + strlen(find));
}

static void assert_scenario_empty(const struct scenario *scenario)
{
    struct scenario empty;
    memset(&empty, 0, sizeof empty);
    assert_memory_equal(scenario, &empty, sizeof empty);
}

// ------------------------------------------------------------------------------------------------
// What a valid file means

// Every key of the file arrives in its place, in the unit the header names.
static void every_key_arrives(void **state)
{
    (void)state;
    struct scenario s = read_valid(example, NULL);
    assert_string_equal(s.name, "example");
    assert_true(s.vehicle.mass == 1650 && s.vehicle.yaw_inertia == 3000);
    assert_true(s.vehicle.speed == 17.889 && s.vehicle.cog[0] == 0.1 && s.vehicle.cog[1] == 0);
    assert_true(s.barrier.face_x == -2.08 && s.barrier.edge_y == -0.455);
    assert_true(s.barrier.width == 1.2 && s.barrier.overlap == 0.455);
    assert_int_equal(s.barrier.profile, SCENARIO_PROFILE_ROUNDED);
    assert_true(s.barrier.edge_radius == 0.2);
    assert_int_equal(s.spring_count, 2);
    assert_string_equal(s.springs[1].name, "rail-2");
    assert_true(s.springs[1].position[0] == -1.0 && s.springs[1].position[1] == -0.5);
    assert_true(s.springs[1].length == 1.5);
    assert_int_equal(s.springs[0].point_count, 3);
    assert_true(s.springs[0].deformation[1] == 0.5);
    assert_true(s.springs[0].force_upper[SCENARIO_DIRECTION_X][1] == 80e3);
    assert_true(s.springs[0].force_upper[SCENARIO_DIRECTION_Y][2] == 250e3);
    assert_true(s.springs[0].force_lower[SCENARIO_DIRECTION_Y][2] == 2);
    assert_true(s.simulation.duration == 0.12 && s.simulation.time_step == 5e-4);
    assert_int_equal(s.simulation.integrator, SCENARIO_INTEGRATOR_VELOCITY_VERLET);
    assert_int_equal(s.response, SCENARIO_RESPONSE_GLANCING_OFF);
    assert_true(s.firewall_distance == 0.25);
    assert_int_equal(s.search.samples, 200);
    assert_int_equal(s.search.exploration_steps, 10);
    assert_int_equal(s.search.consolidation_steps, 20);
    assert_int_equal(s.search.sampling, SAMPLING_METHOD_LATIN_HYPERCUBE);
    assert_true(s.search.target_purity == 0.95);
    assert_int_equal(s.search.certificate_samples, 5000);
    assert_true(s.search.seed == UINT64_C(9007199254740991));
    scenario_fini(&s);
}

// A file with the required keys only gets the defaults that scenario_init() promises.
static void absent_keys_keep_their_defaults(void **state)
{
    (void)state;
    struct scenario s = read_valid("name: short\n"
                                   "vehicle: {mass: 1, yaw_inertia: 1, speed: 1}\n"
                                   "barrier: {face_x: -2, edge_y: -0.4}\n"
                                   "springs:\n"
                                   "- name: a\n"
                                   "  position: [-1, -0.7]\n"
                                   "  deformation: [0, 1]\n"
                                   "  force_x: {lower: 0, upper: 1}\n"
                                   "  force_y: {lower: 0, upper: 0}\n"
                                   "response: any\n"
                                   "firewall_distance: 0\n",
                                   NULL);
    struct scenario initial;
    scenario_init(&initial);
    assert_memory_equal(&s.simulation, &initial.simulation, sizeof s.simulation);
    assert_memory_equal(&s.search, &initial.search, sizeof s.search);
    assert_true(s.barrier.width == 1.15 && s.barrier.edge_radius == 0.15);
    assert_int_equal(s.barrier.profile, SCENARIO_PROFILE_FLAT);
    assert_true(fabs(s.barrier.overlap - 0.3) < 1e-12);
    assert_true(s.vehicle.cog[0] == 0 && s.vehicle.cog[1] == 0);
    // A firewall at the A-pillar gives no length to measure violations by.
    assert_int_equal(s.constraint_count, 1);
    assert_true(s.constraints[0].min == 0 && s.constraints[0].scale == 1);
    scenario_fini(&initial);
    scenario_fini(&s);
}

// Without a length the structure reaches from the spring's place to the face; the place is
// relative to the COG, which may itself be off the origin.
static void default_length_reaches_the_face(void **state)
{
    (void)state;
    struct scenario s = read_valid(example, NULL);
    assert_true(fabs(s.springs[0].length - (-0.83 + 0.1 + 2.08)) < 1e-12);
    scenario_fini(&s);
}

// Without an overlap the lateral travel is judged by the way that the A-pillar has to the end of
// the face, wherever the COG is; one that is given holds.
static void default_overlap_ends_with_the_face(void **state)
{
    (void)state;
    char *text = replaced(example, "  overlap: 0.455\n", "");
    static const struct {
        const char *override;
        double overlap; // [m]
    } cases[] = {
        {NULL, 0.295},
        {"vehicle.cog=[0.1, 0.05]", 0.245},
        {"barrier.edge_y=-0.5", 0.25},
        {"barrier.overlap=0.4", 0.4},
        {"springs.0.position=[-0.83, 0.1]", -1}, // beside the barrier
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct scenario s;
        struct error error = {0};
        enum status status =
            scenario_read_text(&s, "t.yaml", text, strlen(text), &cases[i].override,
                               cases[i].override != NULL ? 1 : 0, &error);
        assert_int_equal(status, cases[i].overlap > 0 ? STATUS_OK : STATUS_INVALID);
        if (status == STATUS_OK)
            assert_true(fabs(s.barrier.overlap - cases[i].overlap) < 1e-12);
        else
            assert_string_equal(error.text,
                                "--set springs.0.position=[-0.83, 0.1]:1:1: springs.0.position: "
                                "the first spring starts 0.555 m beside the barrier's end: "
                                "expected a y of less than -0.455 m, or a barrier.overlap by "
                                "which lateral travel is judged, found 0.1");
        scenario_fini(&s);
    }
    g_free(text);
}

// The order of variables is part of every result file: spring by spring, x points, y points.
static void variables_stand_spring_by_spring(void **state)
{
    (void)state;
    struct scenario s = read_valid(example, NULL);
    static const char *const names[] = {
        "front.force_x[0]",  "front.force_x[1]",  "front.force_x[2]",  "front.force_y[0]",
        "front.force_y[1]",  "front.force_y[2]",  "rail-2.force_x[0]", "rail-2.force_x[1]",
        "rail-2.force_y[0]", "rail-2.force_y[1]",
    };
    assert_int_equal(s.design_space.count, G_N_ELEMENTS(names));
    for (uint32_t i = 0; i < s.design_space.count; i++)
        assert_string_equal(s.variables[i].name, names[i]);
    assert_int_equal(s.variables[9].spring, 1);
    assert_int_equal(s.variables[9].point, 1);
    assert_int_equal(s.variables[9].direction, SCENARIO_DIRECTION_Y);
    assert_true(s.design_space.upper[2] == 450e3 && s.design_space.lower[4] == 1);
    assert_true(s.design_space.lower[6] == 7 && s.design_space.upper[6] == 7);
    scenario_fini(&s);
}

static void assert_constraint(const struct scenario_constraint *constraint, uint32_t outcome,
                              double min, double max, double scale)
{
    assert_int_equal(constraint->outcome, outcome);
    assert_true(constraint->min == min);
    assert_true(constraint->max == max);
    assert_true(constraint->scale == scale);
}

// The response's constraints come first and the user's follow in file order, even where both bound
// the same outcome; each is measured in units of its greatest bound.
static void constraints_follow_the_response(void **state)
{
    (void)state;
    struct scenario s = read_valid(example, NULL);
    assert_int_equal(s.constraint_count, 6);
    assert_constraint(&s.constraints[0], OUTCOME_S_L_MIN, 0.25, INFINITY, 0.25);
    assert_constraint(&s.constraints[1], OUTCOME_ABWAP, 1, INFINITY, 1);
    assert_constraint(&s.constraints[2], OUTCOME_ABWP, 1, INFINITY, 1);
    assert_constraint(&s.constraints[3], OUTCOME_YAW_DEG, -20, 10, 20);
    assert_constraint(&s.constraints[4], OUTCOME_ENERGY_ABSORBED + 1, -INFINITY, 9e4, 9e4);
    assert_constraint(&s.constraints[5], OUTCOME_S_L, -INFINITY, 1, 1);
    scenario_fini(&s);

    s = read_valid(example, "response=rotating");
    assert_constraint(&s.constraints[0], OUTCOME_S_L_MIN, 0.25, INFINITY, 0.25);
    assert_constraint(&s.constraints[1], OUTCOME_ABWP, -INFINITY, 1, 1);
    const double below_90 = nextafter(90, 0);
    assert_constraint(&s.constraints[2], OUTCOME_YAW_MAX_DEG, -INFINITY, below_90, below_90);
    assert_int_equal(s.constraint_count, 6);
    scenario_fini(&s);

    s = read_valid(example, "response=any");
    assert_int_equal(s.constraint_count, 4);
    scenario_fini(&s);
}

// ------------------------------------------------------------------------------------------------
// What an invalid file is told

struct mistake {
    const char *find;    // in the example
    const char *with;    // what stands there instead
    const char *message; // how the error begins
};

static void assert_mistakes(const struct mistake *mistakes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        char *text = replaced(example, mistakes[i].find, mistakes[i].with);
        struct scenario scenario;
        struct error error = {0};
        enum status status = read_text(&scenario, text, &error);
        if (status != STATUS_INVALID ||
            strncmp(error.text, mistakes[i].message, strlen(mistakes[i].message)) != 0)
            fail_msg("'%s': expected: %s\n found: %s", mistakes[i].with, mistakes[i].message,
                     error.text);
        assert_scenario_empty(&scenario);
        g_free(text);
    }
}

// Keys: a slip of the pen is told from a word out of place, and what is missing is named.
static void wrong_keys_are_named(void **state)
{
    (void)state;
    static const struct mistake mistakes[] = {
        {"  mass: 1650", "  mas: 1650",
         "t.yaml:4:3: vehicle: unknown key 'mas'; did you mean 'mass'?"},
        {"  mass: 1650", "  wheels: 4\n  mass: 1650",
         "t.yaml:4:3: vehicle: unknown key 'wheels'; expected one of mass, yaw_inertia, speed, "
         "cog"},
        {"  mass: 1650\n", "", "t.yaml:4:3: vehicle: missing key 'mass': expected more than 0 kg"},
        {"name: example\n", "", "t.yaml:1:1: missing key 'name': expected a name"},
        {"response: glancing_off\n", "",
         "t.yaml:1:1: missing key 'response': expected any, rotating or glancing_off"},
        {"firewall_distance: 0.25\n", "",
         "t.yaml:1:1: missing key 'firewall_distance': expected at least 0 m"},
        {"    position: [-0.83, -0.75]\n", "", "t.yaml:16:5: springs.0: missing key 'position'"},
        {"{lower: 0, upper: [60e3, 80e3, 450e3]}", "{upper: 0}",
         "t.yaml:19:14: springs.0.force_x: missing key 'lower': expected a number or a list in N"},
        {"  speed", "  mass: 1\n  speed", "t.yaml:6:3: key 'mass' is given twice"},
        {"  yaw_deg:", "  yaw:",
         "t.yaml:34:3: constraints: unknown outcome 'yaw'; expected one of "
         "s_L, s_L_min, AbWAP"},
        {"  yaw_deg:", "  yaw_deq:",
         "t.yaml:34:3: constraints: unknown outcome 'yaw_deq'; did you mean 'yaw_deg'?"},
        {"absorbed.rail-2", "absorbed.rail",
         "t.yaml:35:3: constraints: unknown outcome 'energy_absorbed.rail'"},
        {"  seed:", "  step: 3\n  seed:", "t.yaml:44:3: search: unknown key 'step'"},
        {"{min: -20", "{nim: -20",
         "t.yaml:34:13: constraints.yaw_deg: unknown key 'nim'; expected one of min, max"},
    };
    assert_mistakes(mistakes, G_N_ELEMENTS(mistakes));
}

// Types: what is a number, a list or a mapping is decided by what is asked for.
static void wrong_types_are_pointed_at(void **state)
{
    (void)state;
    static const struct mistake mistakes[] = {
        {"1650", "heavy", "t.yaml:4:9: vehicle.mass: expected a number (in kg), found heavy"},
        {"1650", "\"1650\"", "t.yaml:4:9: vehicle.mass: expected a number (in kg), found '1650'"},
        {"1650", "1650 kg", "t.yaml:4:9: vehicle.mass: expected a number (in kg), found 1650 kg"},
        {"1650", "0x10", "t.yaml:4:9: vehicle.mass: expected a number (in kg), found 0x10"},
        {"1650", "1,650", "t.yaml:4:9: vehicle.mass: expected a number"},
        {"1650", "1e", "t.yaml:4:9: vehicle.mass: expected a number"},
        {"1650", "e3", "t.yaml:4:9: vehicle.mass: expected a number"},
        {"1650", ".", "t.yaml:4:9: vehicle.mass: expected a number"},
        {"1650", "[1]", "t.yaml:4:9: vehicle.mass: expected a number (in kg), found a list of 1"},
        {" 1650", "", "t.yaml:4:8: vehicle.mass: expected a number (in kg), found nothing"},
        {"1650", ".nan", "t.yaml:4:9: vehicle.mass: expected a finite number, found .nan"},
        {"1650", "-.INF", "t.yaml:4:9: vehicle.mass: expected a finite number, found -.INF"},
        {"1650", "1e999", "t.yaml:4:9: vehicle.mass: expected a number of at most 1e15"},
        {"cog: [0.1, 0.0]", "cog: 0.1",
         "t.yaml:7:8: vehicle.cog: expected a list of 2 numbers, found 0.1"},
        {"cog: [0.1, 0.0]", "cog: [0.1, 0.0, 0.0]",
         "t.yaml:7:8: vehicle.cog: expected a list of 2 numbers, found a list of 3"},
        {"[0.0, 0.5, 1.0]", "0.5",
         "t.yaml:18:18: springs.0.deformation: expected a list of 2 to 32 deformations in m, "
         "found 0.5"},
        {"{lower: 0, upper: [60e3, 80e3, 450e3]}", "450e3",
         "t.yaml:19:14: springs.0.force_x: expected a mapping, found 450e3"},
        {"[60e3, 80e3, 450e3]", "[60e3, 80e3]",
         "t.yaml:19:32: springs.0.force_x.upper: expected a number or a list of 3, found a list "
         "of 2"},
        {"[60e3, 80e3, 450e3]", "[60e3, high, 450e3]",
         "t.yaml:19:39: springs.0.force_x.upper.1: expected a number (in N), found high"},
        {"[60e3, 80e3, 450e3]", "{a: 1}",
         "t.yaml:19:32: springs.0.force_x.upper: expected a number or a list of numbers, found a "
         "mapping"},
        {"{min: -20, max: 10}", "-20",
         "t.yaml:34:12: constraints.yaw_deg: expected a mapping, found -20"},
        {"profile: rounded", "profile: round",
         "t.yaml:13:12: barrier.profile: expected flat or rounded, found round"},
        {"model: small_overlap", "model: full_overlap",
         "t.yaml:2:8: model: expected small_overlap, hypersphere, ellipse, linear, rosenbrock, "},
        {"latin_hypercube", "halton",
         "t.yaml:41:13: search.sampling: expected uniform, latin_hypercube or sobol, found "
         "halton"},
        {"velocity_verlet", "euler",
         "t.yaml:30:15: simulation.integrator: expected central_difference, velocity_verlet, "
         "runge_kutta_4 or event_verlet, found euler"},
        {"20e1", "2.5", "t.yaml:38:12: search.samples: expected a whole number, 1 to 1000000"},
        {"20e1", "many", "t.yaml:38:12: search.samples: expected a whole number"},
    };
    assert_mistakes(mistakes, G_N_ELEMENTS(mistakes));
}

// Ranges: values of the right type that no crash can have.
static void values_out_of_range_are_refused(void **state)
{
    (void)state;
    static const struct mistake mistakes[] = {
        {"1650", "-3", "t.yaml:4:9: vehicle.mass: expected more than 0 kg, found -3"},
        {"1650", "0", "t.yaml:4:9: vehicle.mass: expected more than 0 kg, found 0"},
        {"3000", "-1", "t.yaml:5:16: vehicle.yaw_inertia: expected more than 0 kg m2, found -1"},
        {"overlap: 0.455", "overlap: 0",
         "t.yaml:12:12: barrier.overlap: expected more than 0 m, found 0"},
        {"edge_radius: 0.2", "edge_radius: 0", "t.yaml:14:16: barrier.edge_radius: expected more"},
        {"edge_radius: 0.2", "edge_radius: 1.3",
         "t.yaml:14:16: barrier.edge_radius: expected an edge_radius of at most the barrier's "
         "width of 1.2 m, found 1.3"},
        {"time_step: 5.0e-4", "time_step: 0", "t.yaml:29:14: simulation.time_step: expected more"},
        {"time_step: 5.0e-4", "time_step: 0.13",
         "t.yaml:29:14: simulation.time_step: expected a time_step of at most the duration of "
         "0.12 s, found 0.13"},
        {"  time_step: 5.0e-4\n", "  time_step: 1e-9\n",
         "t.yaml:29:14: simulation.time_step: expected a time_step of at least 1.2e-07 s"},
        {"  duration: 0.12\n  time_step: 5.0e-4\n", "  duration: 0.5e-3\n",
         "t.yaml:28:3: simulation: expected a time_step of at most the duration"},
        {"firewall_distance: 0.25", "firewall_distance: -0.1",
         "t.yaml:32:20: firewall_distance: expected at least 0 m, found -0.1"},
        {"20e1", "0",
         "t.yaml:38:12: search.samples: expected a whole number, 1 to 1000000, found "
         "0"},
        {"20e1", "-5", "t.yaml:38:12: search.samples: expected a whole number"},
        {"20e1", "5000000000", "t.yaml:38:12: search.samples: expected a whole number"},
        {"exploration_steps: 10", "exploration_steps: -1",
         "t.yaml:39:22: search.exploration_steps: expected a whole number, 0 to 1000000"},
        {"certificate_samples: 5000", "certificate_samples: 0",
         "t.yaml:43:24: search.certificate_samples: expected a whole number, 1 to"},
        {"0.95", "1", "t.yaml:42:18: search.target_purity: expected more than 0 and less than 1"},
        {"0.95", "0", "t.yaml:42:18: search.target_purity: expected more than 0 and less than 1"},
        {"9007199254740991", "9007199254740993", "t.yaml:44:9: search.seed: expected a whole"},
        {"9007199254740991", "-1",
         "t.yaml:44:9: search.seed: expected a whole number, 0 to "
         "9007199254740991, found -1"},
        {"name: example", "name: a/b", "t.yaml:1:7: name: expected a name of 1 to 63 printable"},
        {"name: example", "name: ..", "t.yaml:1:7: name: expected a name"},
        {"name: example", "name: \"a\\tb\"", "t.yaml:1:7: name: expected a name"},
        {"name: example", "name: ''", "t.yaml:1:7: name: expected a name"},
        {"name: example", "name: aaaaaaaaaabbbbbbbbbbccccccccccddddddddddeeeeeeeeeeffffffffffgggg",
         "t.yaml:1:7: name: expected a name of 1 to 63 printable"},
        {"name: rail-2", "name: front end",
         "t.yaml:21:11: springs.1.name: expected a name of 1 to 63 letters, digits, '_' or '-', "
         "found front end"},
        {"name: rail-2", "name: ''", "t.yaml:21:11: springs.1.name: expected a name of 1 to 63"},
    };
    assert_mistakes(mistakes, G_N_ELEMENTS(mistakes));
}

// Values that are fine alone and wrong together.
static void contradictions_are_pointed_at(void **state)
{
    (void)state;
    static const struct mistake mistakes[] = {
        {"[0.0, 0.5, 1.0]", "[0.0, 0.5, 0.5]",
         "t.yaml:18:29: springs.0.deformation.2: expected ascending deformations, here more than "
         "0.5 m, found 0.5"},
        {"[0.0, 0.5, 1.0]", "[0.0, 0.5, 0.4]", "t.yaml:18:29: springs.0.deformation.2: expected"},
        {"[0.0, 0.5, 1.0]", "[-0.1, 0.5, 0.6]",
         "t.yaml:18:19: springs.0.deformation.0: expected at least 0 m, found -0.1"},
        {"[0.0, 0.5, 1.0]", "[0.0]",
         "t.yaml:18:18: springs.0.deformation: expected a list of 2 to 32 deformations in m, "
         "found a list of 1"},
        {"{lower: 0, upper: [60e3, 80e3, 450e3]}", "{lower: 70e3, upper: [80e3, 60e3, 450e3]}",
         "t.yaml:19:42: springs.0.force_x.upper.1: expected at least the lower bound of 70000 N, "
         "found 60000"},
        {"{lower: 7, upper: 7}", "{lower: 7, upper: 6}",
         "t.yaml:25:32: springs.1.force_x.upper: expected at least the lower bound of 7 N, found "
         "6"},
        {"[-0.83, -0.75]", "[-2.3, -0.75]",
         "t.yaml:17:15: springs.0.position: the spring is 0.12 m behind the barrier's face: "
         "expected an x of more than -2.18 m, found -2.3"},
        // A length of its own does not bring a spring out of the barrier.
        {"[-1.0, -0.5]", "[-2.18, -0.5]", "t.yaml:22:15: springs.1.position: the spring is"},
        {"length: 1.5", "length: 0", "t.yaml:23:13: springs.1.length: expected more than 0 m"},
        {"name: rail-2", "name: front",
         "t.yaml:21:11: springs.1.name: expected a name that no other spring has, found front, "
         "the name of springs.0"},
        {"{min: -20, max: 10}", "{min: 20, max: 10}",
         "t.yaml:34:27: constraints.yaw_deg.max: expected at least the min of 20, found 10"},
        {"{min: -20, max: 10}", "{}",
         "t.yaml:34:12: constraints.yaw_deg: expected min, max or both, found neither"},
    };
    assert_mistakes(mistakes, G_N_ELEMENTS(mistakes));
}

// A search without a free variable has nothing to search.
static void a_design_space_needs_a_free_variable(void **state)
{
    (void)state;
    const char *overrides[] = {
        "springs.0.force_x={lower: 1, upper: 1}",
        "springs.0.force_y={lower: [1, 2, 3], upper: [1, 2, 3]}",
        "springs.1.force_y={lower: -0, upper: 0}",
    };
    struct scenario scenario;
    struct error error = {0};
    assert_int_equal(
        scenario_read_text(&scenario, "t.yaml", example, strlen(example), overrides, 3, &error),
        STATUS_INVALID);
    assert_string_equal(error.text, "t.yaml:16:3: springs: every force is fixed: expected at least "
                                    "one with its lower bound below its upper");
}

// More constraints than fit the byte that names one on the wire. Only a model with as many outcomes
// can have them.
static void too_many_constraints_are_refused(void **state)
{
    (void)state;
    GString *text = g_string_new("name: wide\nmodel: linear\n"
                                 "variables: [{name: x, lower: 0, upper: 1}]\n"
                                 "parameters:\n  matrix:\n");
    for (int i = 0; i < SCENARIO_ROW_MAX; i++)
        g_string_append(text, "  - [1]\n");
    g_string_append(text, "constraints:\n");
    for (int i = 0; i < SCENARIO_ROW_MAX; i++)
        g_string_append_printf(text, "  row_%d: {max: 1}\n", i + 1);
    struct scenario scenario;
    struct error error = {0};
    assert_int_equal(read_text(&scenario, text->str, &error), STATUS_INVALID);
    assert_string_equal(error.text, "t.yaml:263:3: constraints: expected at most 255 constraints "
                                    "beside those of the model, found 256");
    g_string_free(text, TRUE);
}

// Both rules of reloading can be asked for; a third is refused.
static void reloading_can_be_chosen(void **state)
{
    (void)state;
    struct scenario s = read_valid(example, "simulation.reloading=crushed");
    assert_int_equal(s.simulation.reloading, SCENARIO_RELOADING_CRUSHED);
    scenario_fini(&s);
    s = read_valid(example, "simulation.reloading=thesis");
    assert_int_equal(s.simulation.reloading, SCENARIO_RELOADING_THESIS);
    scenario_fini(&s);
    const char *override = "simulation.reloading=elastic";
    struct error error = {0};
    assert_int_equal(
        scenario_read_text(&s, "t.yaml", example, strlen(example), &override, 1, &error),
        STATUS_INVALID);
    assert_non_null(strstr(error.text, "expected thesis or crushed, found elastic"));
}

// Overrides are checked like the file and named as they were given.
static void wrong_overrides_name_themselves(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"vehicle.mass=-3",
         "--set vehicle.mass=-3:1:1: vehicle.mass: expected more than 0 kg, found -3"},
        {"vehicle.mas=3",
         "--set vehicle.mas=3:1:1: vehicle: unknown key 'mas'; did you mean 'mass'?"},
        {"springs.2.length=1", "--set springs.2.length=1:1:1: springs: expected the name of an "
                               "item or an index from 0 to "
                               "1, found '2'"},
        {"springs.back.length=1",
         "--set springs.back.length=1:1:1: springs: expected the name of an item or an index from "
         "0 to 1, found 'back'"},
        {"springs.front.length=-1",
         "--set springs.front.length=-1:1:1: springs.0.length: expected more than 0 m, found -1"},
        {"vehicle.mass.kg=1", "--set vehicle.mass.kg=1:1:1: vehicle.mass: expected a mapping to "
                              "set 'kg' in, found 1650"},
        {"vehicle..mass=1", "--set vehicle..mass=1:1:1: expected keys with single dots in between, "
                            "found 'vehicle..mass'"},
        {"vehicle.mass", "--set vehicle.mass:1:1: expected KEY.PATH=VALUE"},
        {"=3", "--set =3:1:1: expected KEY.PATH=VALUE"},
        {"vehicle.mass=", "--set vehicle.mass=:1:1: expected KEY.PATH=VALUE"},
        {"vehicle.mass=[1", "--set vehicle.mass=[1:2:1: broken YAML: "},
        {"vehicle.mass=1\n---\n2",
         "--set vehicle.mass=1?---?2:2:1: expected one YAML document, found a second"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct scenario scenario;
        struct error error = {0};
        assert_int_equal(scenario_read_text(&scenario, "t.yaml", example, strlen(example),
                                            &cases[i][0], 1, &error),
                         STATUS_INVALID);
        if (strncmp(error.text, cases[i][1], strlen(cases[i][1])) != 0)
            fail_msg("expected: %s\n found: %s", cases[i][1], error.text);
        assert_scenario_empty(&scenario);
    }
}

// A wrong file name is wrong input: exit status 2 and the same form of message.
static void a_missing_file_is_invalid_input(void **state)
{
    (void)state;
    struct scenario scenario;
    struct error error = {0};
    assert_int_equal(scenario_read_file(&scenario, "/nonexistent/car.yaml", NULL, 0, &error),
                     STATUS_INVALID);
    assert_string_equal(error.text, "/nonexistent/car.yaml:1:1: expected a file that can be read: "
                                    "No such file or directory");
    assert_scenario_empty(&scenario);

    assert_int_equal(scenario_read_file(&scenario, "/", NULL, 0, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "/:1:1: expected a file that can be read: "));
}

// ------------------------------------------------------------------------------------------------
// The canonical text

// A worker reads the text it is sent, so the text must mean the same scenario and, since its hash
// is its name, must not change when it is written again.
static void canonical_text_is_the_same_scenario(void **state)
{
    (void)state;
    struct scenario first = read_valid(example, "springs.0.force_x.upper.1=81e3");
    struct scenario second = read_valid(first.text, NULL);
    assert_int_equal(first.text_size, strlen(first.text));
    assert_string_equal(second.text, first.text);
    assert_true(digest_equal(&second.digest, &first.digest));
    assert_true(box_equal(&second.design_space, &first.design_space));
    assert_true(second.design_space.upper[1] == 81e3);
    assert_memory_equal(&second.vehicle, &first.vehicle, sizeof first.vehicle);
    assert_memory_equal(&second.barrier, &first.barrier, sizeof first.barrier);
    assert_memory_equal(&second.simulation, &first.simulation, sizeof first.simulation);
    assert_memory_equal(&second.search, &first.search, sizeof first.search);
    assert_int_equal(second.spring_count, first.spring_count);
    assert_memory_equal(second.springs, first.springs, first.spring_count * sizeof *first.springs);
    assert_int_equal(second.constraint_count, first.constraint_count);
    assert_memory_equal(second.constraints, first.constraints,
                        first.constraint_count * sizeof *first.constraints);
    assert_memory_equal(second.variables, first.variables,
                        first.design_space.count * sizeof *first.variables);
    scenario_fini(&second);
    scenario_fini(&first);
}

// Comments and layout are not part of a scenario's identity, values are.
static void digest_follows_the_values(void **state)
{
    (void)state;
    char *text = replaced(example, "  cog: [0.1, 0.0]   # m", "  cog:\n  - 0.1\n  - 0.0\n# end");
    struct scenario plain = read_valid(example, NULL);
    struct scenario relaid = read_valid(text, NULL);
    struct scenario heavier = read_valid(example, "vehicle.mass=1651");
    assert_true(digest_equal(&plain.digest, &relaid.digest));
    assert_false(digest_equal(&plain.digest, &heavier.digest));
    scenario_fini(&plain);
    scenario_fini(&relaid);
    scenario_fini(&heavier);
    g_free(text);
}

// ------------------------------------------------------------------------------------------------
// Damaged texts

// Whatever a damaged text means, it is read or refused with one line that names the place; what is
// read survives being written and read again. The copy has no NUL and no spare byte behind it, so
// that the address sanitizer sees any look beyond its end.
static void assert_read_or_refused(const char *text, size_t size)
{
    char *copy = g_memdup2(text, size == 0 ? 1 : size);
    struct scenario scenario;
    struct error error = {0};
    enum status status = scenario_read_text(&scenario, "t.yaml", copy, size, NULL, 0, &error);
    if (status == STATUS_OK) {
        struct scenario again = read_valid(scenario.text, NULL);
        assert_string_equal(again.text, scenario.text);
        scenario_fini(&again);
    } else {
        assert_int_equal(status, STATUS_INVALID);
        assert_memory_equal(error.text, "t.yaml:", 7);
        assert_null(strchr(error.text, '\n'));
        assert_scenario_empty(&scenario);
    }
    scenario_fini(&scenario);
    g_free(copy);
}

// A file that is still being written, or a message that was cut.
static void every_prefix_is_read_or_refused(void **state)
{
    (void)state;
    for (size_t size = 0; size <= strlen(example); size++)
        assert_read_or_refused(example, size);
}

// A slip of the finger.
static void every_missing_byte_is_read_or_refused(void **state)
{
    (void)state;
    size_t size = strlen(example);
    char *text = g_malloc(size);
    for (size_t at = 0; at < size; at++) {
        memcpy(text, example, at);
        memcpy(text + at, example + at + 1, size - at - 1);
        assert_read_or_refused(text, size - 1);
    }
    g_free(text);
}

// Bytes that YAML gives a meaning to, UTF-8 forbids, or nobody expects, at every place.
static void every_odd_byte_is_read_or_refused(void **state)
{
    (void)state;
    static const char odd[] = {'\0', '\n', '\t', ' ', ':', '-', '[', '}',    '"',    '|',   '&',
                               '*',  '!',  '#',  '%', ',', '?', '9', '\x01', '\x80', '\xff'};
    char *text = g_strdup(example);
    size_t size = strlen(example);
    for (size_t at = 0; at < size; at++) {
        text[at] = odd[(at * 7) % sizeof odd];
        assert_read_or_refused(text, size);
        text[at] = odd[(at * 11 + 5) % sizeof odd];
        assert_read_or_refused(text, size);
        text[at] = example[at];
    }
    g_free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_arrives),
        cmocka_unit_test(absent_keys_keep_their_defaults),
        cmocka_unit_test(default_length_reaches_the_face),
        cmocka_unit_test(default_overlap_ends_with_the_face),
        cmocka_unit_test(variables_stand_spring_by_spring),
        cmocka_unit_test(constraints_follow_the_response),
        cmocka_unit_test(wrong_keys_are_named),
        cmocka_unit_test(wrong_types_are_pointed_at),
        cmocka_unit_test(values_out_of_range_are_refused),
        cmocka_unit_test(contradictions_are_pointed_at),
        cmocka_unit_test(a_design_space_needs_a_free_variable),
        cmocka_unit_test(too_many_constraints_are_refused),
        cmocka_unit_test(reloading_can_be_chosen),
        cmocka_unit_test(wrong_overrides_name_themselves),
        cmocka_unit_test(a_missing_file_is_invalid_input),
        cmocka_unit_test(canonical_text_is_the_same_scenario),
        cmocka_unit_test(digest_follows_the_values),
        cmocka_unit_test(every_prefix_is_read_or_refused),
        cmocka_unit_test(every_missing_byte_is_read_or_refused),
        cmocka_unit_test(every_odd_byte_is_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
