#include "common/scenario/sweep.h"

#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const char base[] = "name: plane\n"
                           "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                           "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                           "springs:\n"
                           "  - name: front\n"
                           "    position: [-0.83, -0.75]\n"
                           "    deformation: [0.0, 1.2]\n"
                           "    force_x: {lower: 0, upper: 450e3}\n"
                           "    force_y: {lower: 0, upper: 250e3}\n"
                           "response: any\n"
                           "firewall_distance: 0.25\n"
                           "search: {seed: 7}\n";

struct folder {
    char *path;
};

static void write_file(const struct folder *folder, const char *name, const char *text)
{
    char *path = g_build_filename(folder->path, name, NULL);
    assert_true(g_file_set_contents(path, text, -1, NULL));
    g_free(path);
}

static int setup(void **state)
{
    struct folder *folder = g_new0(struct folder, 1);
    folder->path = g_dir_make_tmp("sobox-sweep-XXXXXX", NULL);
    write_file(folder, "base.yaml", base);
    *state = folder;
    return 0;
}

static int teardown(void **state)
{
    struct folder *folder = *state;
    GDir *dir = g_dir_open(folder->path, 0, NULL);
    for (const char *name; (name = g_dir_read_name(dir)) != NULL;) {
        char *path = g_build_filename(folder->path, name, NULL);
        g_remove(path);
        g_free(path);
    }
    g_dir_close(dir);
    g_rmdir(folder->path);
    g_free(folder->path);
    g_free(folder);
    return 0;
}

// Writes and reads a sweep, with one override or none.
static enum status read_sweep(const struct folder *folder, const char *text, const char *override,
                              struct sweep **sweep, struct error *error)
{
    write_file(folder, "sweep.yaml", text);
    char *path = g_build_filename(folder->path, "sweep.yaml", NULL);
    enum status status = sweep_read_file(sweep, path, &override, override != NULL ? 1 : 0, error);
    g_free(path);
    return status;
}

static struct sweep *sweep_of(const struct folder *folder, const char *text)
{
    struct sweep *sweep;
    struct error error = {0};
    if (read_sweep(folder, text, NULL, &sweep, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    return sweep;
}

static void assert_names(const struct sweep *sweep, const char *const *names)
{
    char name[SWEEP_CASE_NAME_SIZE];
    uint32_t count = 0;
    for (; names[count] != NULL; count++) {
        assert_true(count < sweep_case_count(sweep));
        assert_string_equal(sweep_case_name(sweep, count, name), names[count]);
    }
    assert_int_equal(sweep_case_count(sweep), count);
}

#define HEAD "sweep: s\nbase: base.yaml\n"

// What each way of giving values expands to, in which order, and by which names.
static void axes_expand_to_cases_in_order(void **state)
{
    static const struct {
        const char *text;
        const char *names[8];
    } cases[] = {
        {HEAD "axes: [{path: vehicle.mass, values: [1500, 16e2]}]", {"mass=1500", "mass=16e2"}},
        {HEAD "axes: [{path: search.samples, range: [3, 5]}]",
         {"samples=3", "samples=4", "samples=5"}},
        {HEAD "axes: [{path: search.samples, range: [10, 35, 10]}]",
         {"samples=10", "samples=20", "samples=30"}},
        {HEAD "axes: [{path: firewall_distance, linspace: [0.1, 0.3, 3]}]",
         {"firewall_distance=0.1", "firewall_distance=0.2", "firewall_distance=0.3"}},
        {HEAD "axes:\n- {path: vehicle.mass, values: [1, 2]}\n"
              "- {path: response, values: [any, rotating]}",
         {"mass=1,response=any", "mass=1,response=rotating", "mass=2,response=any",
          "mass=2,response=rotating"}},
        {HEAD "axes:\n- zip:\n  - {path: vehicle.mass, values: [1, 2, 3]}\n"
              "  - {path: vehicle.yaw_inertia, linspace: [10, 20, 3]}",
         {"mass=1,yaw_inertia=10", "mass=2,yaw_inertia=15", "mass=3,yaw_inertia=20"}},
        {HEAD "replicates: 3", {"seed=7", "seed=8", "seed=9"}},
        {HEAD "axes: [{path: vehicle.mass, values: [1, 2]}]\nreplicates: 2",
         {"mass=1,seed=7", "mass=1,seed=8", "mass=2,seed=7", "mass=2,seed=8"}},
        // Two paths that end alike need all of their names, and a list its place.
        {HEAD "axes:\n- {path: springs.0.force_x.upper, values: [1e5]}\n"
              "- {path: springs.0.force_y.upper, values: [[1, 2], 3]}",
         {"springs.0.force_x.upper=1e5,springs.0.force_y.upper=#1",
          "springs.0.force_x.upper=1e5,springs.0.force_y.upper=3"}},
        {HEAD "axes: [{csv: table.csv}]",
         {"mass=1500,response=any", "mass=1600,response=rotating"}},
        {HEAD "axes: [{csv: named.csv}, {path: search.samples, range: [1, 2]}]",
         {"light,samples=1", "light,samples=2", "the heavy one,samples=1",
          "the heavy one,samples=2"}},
    };
    const struct folder *folder = *state;
    write_file(folder, "table.csv",
               "vehicle.mass, response\n1500, any\n# a comment\n\n1600,\"rotating\"\r\n");
    write_file(folder, "named.csv",
               "\xef\xbb\xbf"
               "case,vehicle.mass\nlight,1500\nthe heavy one,2000");
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct sweep *sweep = sweep_of(folder, cases[i].text);
        assert_names(sweep, cases[i].names);
        sweep_free(sweep);
    }
}

// The values of a case are those that --set would give, so the scenario, its text and its digest
// are too: a case can be run alone. The last value is the end of the linspace exactly.
static void case_is_its_base_with_its_values_set(void **state)
{
    const struct folder *folder = *state;
    struct sweep *sweep =
        sweep_of(folder, HEAD "axes:\n- {path: vehicle.mass, linspace: [1500, 1500.1, 4]}\n"
                              "- {path: springs.front.force_x.upper, values: [[1e5, 2e5], 3e5]}\n"
                              "replicates: 2\n");
    const char *const *columns = sweep_columns(sweep);
    assert_int_equal(sweep_column_count(sweep), 3);
    assert_string_equal(columns[2], "search.seed");
    assert_null(columns[3]);
    for (uint32_t i = 0; i < sweep_case_count(sweep); i++) {
        struct scenario scenario, alone;
        struct error error = {0};
        char *sets[3], *path = g_build_filename(folder->path, "base.yaml", NULL);
        for (uint32_t c = 0; c < 3; c++)
            sets[c] = g_strdup_printf("%s=%s", columns[c], sweep_value(sweep, i, c));
        if (sweep_scenario(sweep, i, &scenario, &error) != STATUS_OK)
            fail_msg("%s", error.text);
        assert_int_equal(scenario_read_file(&alone, path, (const char *const *)sets, 3, &error),
                         STATUS_OK);
        assert_string_equal(scenario.text, alone.text);
        assert_true(digest_equal(&scenario.digest, &alone.digest));
        if (i >= 12)
            assert_true(scenario.vehicle.mass == 1500.1);
        assert_true(scenario.springs[0].force_upper[0][0] == (i / 2 % 2 == 0 ? 1e5 : 3e5));
        assert_int_equal(scenario.search.seed, 7 + i % 2);
        scenario_fini(&alone);
        scenario_fini(&scenario);
        for (uint32_t c = 0; c < 3; c++)
            g_free(sets[c]);
        g_free(path);
    }
    sweep_free(sweep);
}

// Whatever is wrong is said at its place, with what would be right.
static void wrong_sweeps_are_refused_at_their_place(void **state)
{
    static const struct {
        const char *text, *said;
    } cases[] = {
        {"sweep: s\naxes: []\n", "sweep.yaml:1:1: missing key 'base'"},
        {HEAD, "missing key 'axes'"},
        {"sweep: a/b\nbase: base.yaml\nreplicates: 2\n", "sweep.yaml:1:8: sweep: expected a name"},
        {HEAD "axis: []\n", "sweep.yaml:3:1: unknown key 'axis'; did you mean 'axes'?"},
        {HEAD "axes: []\n", "sweep.yaml:3:7: axes: expected a list of at least one axis"},
        {HEAD "axes: {}\n", "axes: expected a list of at least one axis, found a mapping"},
        {HEAD "axes: [3]\n", "axes.0: expected a mapping"},
        {HEAD "axes: [{path: a}]\n", "expected `path` with one of"},
        {HEAD "axes: [{values: [1]}]\n", "expected `path` with one of"},
        {HEAD "axes: [{path: a, values: [1], range: [1, 2]}]\n", "expected `path` with one of"},
        {HEAD "axes: [{path: a, csv: b.csv}]\n", "expected `path` with one of"},
        {HEAD "axes: [{path: a, values: []}]\n", "sweep.yaml:3:26: axes.0.values: expected a list"},
        {HEAD "axes: [{path: a, values: [1, 2, 1]}]\n", "3:33: axes.0.values.2: 1 is given twice"},
        {HEAD "axes: [{path: a, values: 4}]\n", "expected a list of at least one value, found 4"},
        {HEAD "axes: [{path: [a], values: [1]}]\n", "expected the path of a key, found a list"},
        {HEAD "axes: [{path: '', values: [1]}]\n", "expected the path of a key"},
        {HEAD "axes: [{path: a..b, values: [1]}]\n", "expected the path of a key"},
        {HEAD "axes: [{path: a=b, values: [1]}]\n", "expected the path of a key"},
        {HEAD "axes: [{path: a, range: [1]}]\n", "expected whole numbers [from, to]"},
        {HEAD "axes: [{path: a, range: [2, 1]}]\n", "expected whole numbers [from, to]"},
        {HEAD "axes: [{path: a, range: [1, 2.5]}]\n", "expected whole numbers [from, to]"},
        {HEAD "axes: [{path: a, range: [1, 3, 0]}]\n", "expected whole numbers [from, to]"},
        {HEAD "axes: [{path: a, range: [1, 1e7]}]\n", "expected at most 100000 values"},
        {HEAD "axes: [{path: a, linspace: [1, 2]}]\n", "expected [from, to, how many]"},
        {HEAD "axes: [{path: a, linspace: [1, 1, 3]}]\n", "expected [from, to, how many]"},
        {HEAD "axes: [{path: a, linspace: [1, 2, 1]}]\n", "expected [from, to, how many]"},
        {HEAD "axes: [{path: a, linspace: [1, 2, .inf]}]\n", "expected a finite number"},
        {HEAD "axes: [{path: a, values: [1]}, {path: a, values: [2]}]\n", "a is changed twice"},
        {HEAD "axes: [{path: springs.0.length, values: [1]}, {path: springs.front.length, values: "
              "[2]}]\n",
         "springs.front.length is changed twice"},
        {HEAD "axes: [{csv: broken.csv}]\n", "broken.csv:2:9: key 'a' is given twice"},
        {HEAD "axes: [{path: search.seed, range: [1, 2]}]\nreplicates: 2\n",
         "sweep.yaml:4:13: replicates: search.seed is changed twice"},
        {HEAD "replicates: 0\n", "sweep.yaml:3:13: replicates: expected a whole number"},
        {HEAD "axes: [{zip: 3}]\n", "expected a list of axes that go together"},
        {HEAD "axes: [{zip: [{path: a, values: [1, 2]}, {path: b, values: [1]}]}]\n",
         "axes.0.zip.1: expected 2 values as in the first axis of the zip, found 1"},
        {HEAD "axes: [{zip: [{csv: b.csv}]}]\n", "expected `path` with one of"},
        {HEAD "axes: [{path: a, range: [1, 1000]}, {path: b, range: [1, 1000]}]\n",
         "expected at most 100000 cases in a sweep, found 1000000 with this axis"},
        {HEAD "axes: [{csv: absent.csv}]\n", "absent.csv:1:1: expected a file that can be read"},
        {HEAD "axes: [{csv: empty.csv}]\n", "empty.csv:1:1: expected a header and rows"},
        {HEAD "axes: [{csv: header.csv}]\n", "header.csv:2:1: expected rows below the header"},
        {HEAD "axes: [{csv: short.csv}]\n",
         "short.csv:3:1: expected 2 cells as in the header, found 1"},
        {HEAD "axes: [{csv: hole.csv}]\n",
         "hole.csv:2:4: expected a value for b, found an empty cell"},
        {HEAD "axes: [{csv: open.csv}]\n", "open.csv:2:1: expected a closing quote"},
        {HEAD "axes: [{csv: twice.csv}]\n", "twice.csv:4:1: two cases would have the name"},
        {HEAD "axes: [{csv: labels.csv}]\n",
         "labels.csv:3:3: two cases would have the name 'x': expected a name of its own"},
        {HEAD "axes: [{csv: names.csv}]\n", "expected a column headed by the path of a key"},
        {HEAD "axes: [{csv: control.csv}]\n", "control.csv:2:2: expected text, found the control"},
        {"sweep: s\nbase: absent.yaml\nreplicates: 2\n", "absent.yaml:1:1: expected a file"},
        {"sweep: s\nbase: sweep.yaml\nreplicates: 2\n", "expected a scenario, found a sweep"},
        {"sweep: s\nbase: [a]\nreplicates: 2\n", "expected the name of a scenario file"},
        {"sweep: s\nbase: bad.yaml\nreplicates: 2\n", "bad.yaml:1:1: missing key"},
        {HEAD "axes: [{path: a, values: [&x 1]}]\n", "anchors and aliases"},
    };
    const struct folder *folder = *state;
    write_file(folder, "empty.csv", "# nothing\n\n");
    write_file(folder, "header.csv", "a, b");
    write_file(folder, "short.csv", "a,b\n1,2\n3\n");
    write_file(folder, "hole.csv", "a,b\n1, \n");
    write_file(folder, "open.csv", "a\n\"1\n");
    write_file(folder, "twice.csv", "a,b\n1,2\n2,2\n1,2\n");
    write_file(folder, "labels.csv", "case,a\nx,1\nx,2\n");
    write_file(folder, "names.csv", "case\nx\n");
    write_file(folder, "control.csv", "a\n1\x1b[2J\n");
    write_file(folder, "broken.csv", "a\n\"{a: 1, a: 2}\"\n");
    write_file(folder, "bad.yaml", "name: x\n");
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct sweep *sweep = NULL;
        struct error error = {0};
        if (read_sweep(folder, cases[i].text, NULL, &sweep, &error) != STATUS_INVALID)
            fail_msg("accepted:\n%s", cases[i].text);
        assert_null(sweep);
        if (strstr(error.text, cases[i].said) == NULL)
            fail_msg("expected \"%s\", found \"%s\" of\n%s", cases[i].said, error.text,
                     cases[i].text);
    }
}

// A value that makes its case invalid is pointed at in the sweep file, a line of the base that does
// not go with it in the base; both name the case.
static void invalid_case_is_named_with_the_place_of_its_value(void **state)
{
    static const struct {
        const char *text;
        uint32_t index;
        const char *said[2];
    } cases[] = {
        {HEAD "axes: [{path: vehicle.mass, values: [1500, -3]}]",
         1,
         {"sweep.yaml:3:44: vehicle.mass: expected more than 0 kg, found -3",
          "in the case mass=-3 of "}},
        {HEAD "axes: [{path: vehicle.masss, values: [1500]}]",
         0,
         {"sweep.yaml:3:15: vehicle: unknown key 'masss'; did you mean 'mass'?",
          "in the case masss=1500 of "}},
        {HEAD "axes: [{path: springs.3.length, values: [1.2]}]",
         0,
         {"sweep.yaml:3:15: springs: expected the name of an item or an index from 0 to 0",
          "in the case length=1.2"}},
        // Within a list the item is pointed at, within a cell too.
        {HEAD "axes: [{path: springs.front.force_x.lower, values: [[0, x]]}]",
         0,
         {"sweep.yaml:3:57: springs.0.force_x.lower.1: expected", "in the case lower=#1"}},
        {HEAD "axes: [{csv: cells.csv}]",
         0,
         {"cells.csv:2:6: springs.0.position.1: expected", "in the case position=#1"}},
        {HEAD "axes: [{path: response, values: ['ro:1:1: x']}]",
         0,
         {"sweep.yaml:3:34", "in the case response="}},
        {HEAD "axes: [{path: springs.0.deformation, values: [[0, 1, 2]]}, {path: "
              "springs.0.force_x.upper, values: [[1, 2]]}]",
         0,
         {"expected a number or a list of 3", "deformation=#1,upper=#1"}},
    };
    const struct folder *folder = *state;
    write_file(folder, "cells.csv", "springs.front.position\n\"[1, x]\"\n");
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct sweep *sweep = sweep_of(folder, cases[i].text);
        struct scenario scenario;
        struct error error = {0};
        assert_int_equal(sweep_scenario(sweep, cases[i].index, &scenario, &error), STATUS_INVALID);
        assert_null(scenario.text);
        for (size_t k = 0; k < 2; k++)
            if (strstr(error.text, cases[i].said[k]) == NULL)
                fail_msg("expected \"%s\", found \"%s\"", cases[i].said[k], error.text);
        sweep_free(sweep);
    }
}

// An option changes the base of all cases, and the seeds of the replicates follow it; one that an
// axis would overrule is refused rather than ignored.
static void options_change_the_base_but_no_axis(void **state)
{
    const struct folder *folder = *state;
    static const char text[] = HEAD "axes: [{path: vehicle.mass, values: [1500]}]\nreplicates: 2\n";
    struct sweep *sweep;
    struct error error = {0};
    assert_int_equal(read_sweep(folder, text, "vehicle.mass=3", &sweep, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "vehicle.mass is changed by the sweep"));
    static const char into[] = HEAD "axes: [{path: springs.0, values: [{}]}]\n";
    assert_int_equal(read_sweep(folder, into, "springs.front.length=1", &sweep, &error),
                     STATUS_INVALID);
    assert_non_null(strstr(error.text, "springs.0 is changed by the sweep"));
    assert_int_equal(read_sweep(folder, text, "firewall_distance=0.2", &sweep, &error), STATUS_OK);
    struct scenario scenario;
    assert_int_equal(sweep_scenario(sweep, 1, &scenario, &error), STATUS_OK);
    assert_true(scenario.firewall_distance == 0.2);
    assert_int_equal(scenario.search.seed, 8);
    scenario_fini(&scenario);
    sweep_free(sweep);
}

static void sweep_is_told_from_scenario_by_its_key(void **state)
{
    const struct folder *folder = *state;
    write_file(folder, "sweep.yaml", HEAD);
    write_file(folder, "list.yaml", "- sweep\n");
    static const struct {
        const char *name;
        bool sweep;
    } files[] = {{"sweep.yaml", true}, {"base.yaml", false}, {"list.yaml", false}, {"none", false}};
    for (size_t i = 0; i < G_N_ELEMENTS(files); i++) {
        char *path = g_build_filename(folder->path, files[i].name, NULL);
        assert_int_equal(sweep_detect(path), files[i].sweep);
        g_free(path);
    }
}

// A hundred thousand cases are the limit and cost neither time nor memory worth mentioning.
static void greatest_sweep_is_read(void **state)
{
    const struct folder *folder = *state;
    struct sweep *sweep = sweep_of(folder, HEAD "axes: [{path: search.samples, range: [1, 1000]}]\n"
                                                "replicates: 100\n");
    assert_int_equal(sweep_case_count(sweep), SWEEP_CASE_MAX);
    char name[SWEEP_CASE_NAME_SIZE];
    assert_string_equal(sweep_case_name(sweep, SWEEP_CASE_MAX - 1, name), "samples=1000,seed=106");
    sweep_free(sweep);
}

// Whatever bytes stand in a sweep file or its table, the answer is a sweep or a message; the cases
// of what is accepted can be named and read.
static void random_damage_is_refused_or_harmless(void **state)
{
    static const char yaml[] = HEAD "axes:\n  - {path: vehicle.mass, values: [1, [2, {a: 'b'}]]}\n"
                                    "  - zip:\n      - {path: search.samples, range: [1, 9, 4]}\n"
                                    "      - {path: firewall_distance, linspace: [0.1, 0.3, 3]}\n"
                                    "  - csv: table.csv\nreplicates: 3\n";
    static const char csv[] =
        "case, response,\"vehicle.speed\"\nfirst,any,17\n\"a \"\"b\"\"\",x,3\n";
    static const char odd[] = "\"',:[]{}\n #-=.09";
    const struct folder *folder = *state;
    GRand *random = g_rand_new_with_seed(20161);
    for (int round = 0; round < 400; round++) {
        char *texts[] = {g_strdup(yaml), g_strdup(csv)};
        char *damaged = texts[round % 2];
        for (int i = 0; i <= round % 7; i++)
            damaged[g_rand_int_range(random, 0, (gint32)strlen(damaged))] =
                round % 3 == 0 ? (char)g_rand_int_range(random, 1, 256)
                               : odd[g_rand_int_range(random, 0, sizeof odd - 1)];
        write_file(folder, "table.csv", texts[1]);
        struct sweep *sweep = NULL;
        struct error error = {0};
        if (read_sweep(folder, texts[0], NULL, &sweep, &error) == STATUS_OK) {
            char name[SWEEP_CASE_NAME_SIZE];
            struct scenario scenario;
            const uint32_t last = sweep_case_count(sweep) - 1;
            assert_true(strlen(sweep_case_name(sweep, last, name)) > 0);
            if (sweep_scenario(sweep, last, &scenario, &error) == STATUS_OK)
                scenario_fini(&scenario);
            sweep_free(sweep);
        } else {
            assert_true(strlen(error.text) > 0);
        }
        g_free(texts[0]);
        g_free(texts[1]);
    }
    g_rand_free(random);
}

// Seeds alone need no file: the scenario's own and those that follow it, under its name. A path may
// hold what means something in YAML.
static void seeds_make_a_sweep(void **state)
{
    const struct folder *folder = *state;
    write_file(folder, "the engineer's: base.yaml", base);
    char *path = g_build_filename(folder->path, "the engineer's: base.yaml", NULL);
    const char *override = "vehicle.mass=1500";
    struct sweep *sweep;
    struct scenario scenario;
    struct error error = {0};
    if (sweep_of_seeds(&sweep, path, &override, 1, 3, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_string_equal(sweep_name(sweep), "plane");
    assert_names(sweep, (const char *const[8]){"seed=7", "seed=8", "seed=9"});
    assert_int_equal(sweep_scenario(sweep, 2, &scenario, &error), STATUS_OK);
    assert_int_equal(scenario.search.seed, 9);
    assert_true(scenario.vehicle.mass == 1500);
    scenario_fini(&scenario);
    sweep_free(sweep);
    assert_int_equal(sweep_of_seeds(&sweep, "/nowhere.yaml", NULL, 0, 3, &error), STATUS_INVALID);
    assert_null(sweep);
    g_free(path);
}

int main(void)
{
#define RUN_TEST(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        RUN_TEST(seeds_make_a_sweep),
        RUN_TEST(axes_expand_to_cases_in_order),
        RUN_TEST(case_is_its_base_with_its_values_set),
        RUN_TEST(wrong_sweeps_are_refused_at_their_place),
        RUN_TEST(invalid_case_is_named_with_the_place_of_its_value),
        RUN_TEST(options_change_the_base_but_no_axis),
        RUN_TEST(sweep_is_told_from_scenario_by_its_key),
        RUN_TEST(greatest_sweep_is_read),
        RUN_TEST(random_damage_is_refused_or_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
