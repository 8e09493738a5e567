// Scenarios that no car could have are pointed at, with the likely slip, and real ones are not.
#include "common/scenario/plausibility.h"

#include "common/scenario/scenario_read.h"
#include "common/scenario/sweep.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// A car that says everything that can be checked.
static const char sedan[] = "name: sedan\n"
                            "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                            "barrier: {face_x: -2.08, edge_y: -0.455, width: 1.15}\n"
                            "springs:\n"
                            "- name: front\n"
                            "  position: [-0.83, -0.75]\n"
                            "  deformation: [0.0, 0.3, 0.6, 0.9, 1.2]\n"
                            "  force_x: {lower: 0, upper: [80e3, 450e3, 450e3, 450e3, 450e3]}\n"
                            "  force_y: {lower: 0, upper: 250e3}\n"
                            "- name: rail\n"
                            "  position: [-0.98, -0.5]\n"
                            "  deformation: [0.1, 0.8]\n"
                            "  force_x: {lower: 0, upper: 120e3}\n"
                            "  force_y: {lower: 0, upper: 70e3}\n"
                            "response: any\n"
                            "firewall_distance: 0.25\n";

// A hired kart against the end of a concrete wall, at 45 km/h.
static const char kart[] = "name: kart\n"
                           "vehicle: {mass: 150, yaw_inertia: 30, speed: 12.5}\n"
                           "barrier: {face_x: -0.95, edge_y: -0.2, width: 2}\n"
                           "springs:\n"
                           "- name: bumper\n"
                           "  position: [-0.45, -0.45]\n"
                           "  deformation: [0.0, 0.1, 0.45]\n"
                           "  force_x: {lower: 0, upper: [20e3, 60e3, 60e3]}\n"
                           "  force_y: {lower: 0, upper: 20e3}\n"
                           "simulation: {duration: 0.12}\n"
                           "response: any\n"
                           "firewall_distance: 0.1\n";

// A lorry of 12 t, its cab behind a long bonnet, at 50 km/h.
static const char lorry[] = "name: lorry\n"
                            "vehicle: {mass: 12000, yaw_inertia: 80e3, speed: 13.9}\n"
                            "barrier: {face_x: -3.6, edge_y: -0.5, width: 1.5}\n"
                            "springs:\n"
                            "- name: bonnet\n"
                            "  position: [-2.1, -1.1]\n"
                            "  length: 1.5\n"
                            "  deformation: [0.0, 0.3, 1.4]\n"
                            "  force_x: {lower: 0, upper: [300e3, 1200e3, 1500e3]}\n"
                            "  force_y: {lower: 0, upper: 800e3}\n"
                            "simulation: {duration: 0.25}\n"
                            "response: any\n"
                            "firewall_distance: 0.3\n";

// A pickup against a wall of its whole width, with a heavy lorry's overlap of all of it.
static const char wall[] = "name: wall\n"
                           "vehicle: {mass: 2400, yaw_inertia: 6200, speed: 15.6, cog: [0, 0]}\n"
                           "barrier: {face_x: -2.3, edge_y: 2, width: 4, overlap: 2}\n"
                           "springs:\n"
                           "- name: left\n"
                           "  position: [-0.9, -0.6]\n"
                           "  deformation: [0, 0.5, 1.1]\n"
                           "  force_x: {lower: 0, upper: 500e3}\n"
                           "  force_y: {lower: 0, upper: 0}\n"
                           "- name: right\n"
                           "  position: [-0.9, 0.6]\n"
                           "  deformation: [0, 0.5, 1.1]\n"
                           "  force_x: {lower: 0, upper: 500e3}\n"
                           "  force_y: {lower: 0, upper: 0}\n"
                           "response: any\n"
                           "constraints: {decel_max_g: {max: 60}, travel_x: {max: 0.9}}\n"
                           "firewall_distance: 0\n";

// Writes the text as a file, reads it with overrides (a list with '\n' between them) as a user
// would, and removes it.
static enum status read_as_file(const char *text, const char *overrides, struct scenario *scenario,
                                struct error *error)
{
    GError *reason = NULL;
    char *folder = g_dir_make_tmp("plausibility-XXXXXX", &reason);
    assert_non_null(folder);
    char *path = g_build_filename(folder, "t.yaml", NULL);
    assert_true(g_file_set_contents(path, text, -1, NULL));
    char **set = g_strsplit(overrides, "\n", -1);
    enum status status =
        scenario_read_file(scenario, path, (const char *const *)set, g_strv_length(set), error);
    g_strfreev(set);
    g_remove(path);
    g_rmdir(folder);
    g_free(path);
    g_free(folder);
    return status;
}

static void assert_without_findings(const char *text, const char *overrides)
{
    struct scenario scenario;
    struct error error = {0};
    if (read_as_file(text, overrides, &scenario, &error) != STATUS_OK)
        fail_msg("%s: %s", overrides, error.text);
    if (scenario.finding_count > 0)
        fail_msg("%s: %s", overrides, scenario.findings[0].text);
    scenario_fini(&scenario);
}

struct implausible {
    enum plausibility_check check; // that must find it
    bool error;
    const char *overrides;
    const char *says; // part of its message
};

// Every row of the table, and each of the slips that were seen to pass.
static const struct implausible slips[] = {
    {PLAUSIBILITY_MASS, true, "vehicle.mass=1.65", "likely slip: 1.65 t, which is 1650 kg"},
    {PLAUSIBILITY_MASS, true, "vehicle.mass=1.65e6", "likely slip: 1.65e+06 g, which is 1650 kg"},
    {PLAUSIBILITY_MASS, false, "vehicle.mass=90\nvehicle.yaw_inertia=150", "vehicle.mass"},
    {PLAUSIBILITY_GYRATION, true, "vehicle.yaw_inertia=2.99e9",
     "2.99e+09 kg mm2, which is 2990 kg m2"},
    {PLAUSIBILITY_GYRATION, true, "vehicle.yaw_inertia=3", "3 t m2, which is 3000 kg m2"},
    {PLAUSIBILITY_GYRATION, true, "vehicle.yaw_inertia=3e6", "3e+06 t mm2, which is 3000 kg m2"},
    {PLAUSIBILITY_SLENDERNESS, false, "vehicle.yaw_inertia=500", "inertia of roll"},
    {PLAUSIBILITY_SPEED, false, "vehicle.speed=64.4", "64.4 km/h, which is 17.89 m/s"},
    {PLAUSIBILITY_SPEED, true, "vehicle.speed=17889", "17889 mm/s, which is 17.89 m/s"},
    {PLAUSIBILITY_COG, false, "vehicle.cog=[1.2, 0]", "cog from the front axle"},
    {PLAUSIBILITY_COG, true, "vehicle.cog=[-1.2, 0]", "cog from the front axle"},
    {PLAUSIBILITY_FACE, true, "barrier.face_x=-2070", "-2070 mm, which is -2.07 m"},
    {PLAUSIBILITY_FACE, true, "barrier.face_x=2.08", "x counted positive forwards"},
    {PLAUSIBILITY_FACE, true, "barrier.face_x=-208", "-208 cm, which is -2.08 m"},
    {PLAUSIBILITY_EDGE, true, "barrier.edge_y=-455", "-455 mm, which is -0.455 m"},
    {PLAUSIBILITY_WIDTH, true, "barrier.width=1150", "1150 mm, which is 1.15 m"},
    {PLAUSIBILITY_WIDTH, false, "barrier.width=115", "115 cm, which is 1.15 m"},
    {PLAUSIBILITY_RADIUS, true, "barrier.profile=rounded\nbarrier.edge_radius=150",
     "150 mm, which is 0.15 m"},
    {PLAUSIBILITY_RADIUS, false, "barrier.edge_radius=0.6", "barrier.edge_radius"},
    {PLAUSIBILITY_OVERLAP, true, "barrier.overlap=455", "455 mm, which is 0.455 m"},
    {PLAUSIBILITY_OVERLAP, true, "barrier.overlap=25", "per cent of the car's width"},
    {PLAUSIBILITY_OVERLAP_SPARE, false, "barrier.overlap=0.25", "(0.25 for 25 %)"},
    {PLAUSIBILITY_AHEAD, true, "springs.0.position=[0.83, -0.75]", "x counted positive forwards"},
    {PLAUSIBILITY_AHEAD, true, "springs.0.position=[-830, -0.75]", "-830 mm, which is -0.83 m"},
    {PLAUSIBILITY_AHEAD, false, "springs.1.position=[0.1, -0.5]\nsprings.1.length=2.18",
     "springs.1.position.0"},
    {PLAUSIBILITY_BESIDE, true, "springs.0.position=[-0.83, -750]", "-750 mm, which is -0.75 m"},
    {PLAUSIBILITY_MISS, true,
     "springs.0.position=[-0.83, 0.75]\nsprings.1.position=[-0.98, 0.5]\nbarrier.overlap=0.455",
     "y with the wrong sign"},
    {PLAUSIBILITY_MISS, true,
     "springs.0.position=[-0.83, 0.75]\nsprings.1.position=[-0.98, 0.5]\nbarrier.edge_y=0.455",
     "springs and edge_y"},
    {PLAUSIBILITY_MISS, false, "springs.1.position=[-0.98, 0.5]", "springs.1.position.1"},
    {PLAUSIBILITY_MISS, true, "barrier.width=0.01\nbarrier.overlap=0.3", "sideways"},
    {PLAUSIBILITY_LENGTH, true, "springs.0.length=1250", "1250 mm, which is 1.25 m"},
    {PLAUSIBILITY_PRESSED, false, "springs.0.length=1.4", "springs.0.length"},
    {PLAUSIBILITY_PRESSED, true, "springs.0.length=2.4\nsprings.0.deformation=[0,1,1.2,1.5,2.2]",
     "springs.0.length"},
    {PLAUSIBILITY_GAP, false, "springs.0.length=1.19\nsprings.1.length=1.0", "springs.0.length"},
    {PLAUSIBILITY_GAP, true,
     "springs.0.length=1.2\nsprings.1.length=1.0\nbarrier.face_x=-6\nvehicle.yaw_inertia=9000",
     "springs.0.length"},
    {PLAUSIBILITY_HEIGHT, true, "springs.0.height=500", "500 mm, which is 0.5 m"},
    {PLAUSIBILITY_DEFORMATION, true, "springs.0.deformation=[0, 0.3, 0.6, 0.9, 5]",
     "springs.0.deformation.4"},
    {PLAUSIBILITY_DEFORMATION, true, "springs.0.deformation=[0, 300, 600, 900, 1200]",
     "1200 mm, which is 1.2 m"},
    {PLAUSIBILITY_DEFORMATION, false, "springs.0.deformation=[0, 0.3, 0.6, 0.9, 1.5]",
     "springs.0.deformation.4"},
    {PLAUSIBILITY_FORCE_SIGN, true, "springs.0.force_x={lower: -450e3, upper: 0}",
     "a force on the barrier"},
    {PLAUSIBILITY_FORCE_SIGN, false, "springs.1.force_x.lower=-1e3", "springs.1.force_x"},
    {PLAUSIBILITY_FORCE_SIGN, false, "springs.1.force_y={lower: -70e3, upper: -1}",
     "springs.1.force_y"},
    {PLAUSIBILITY_FORCE_POINT, false, "springs.0.force_x.upper=[80e3, 450e3, 450, 450e3, 450e3]",
     "springs.0.force_x.upper.2"},
    {PLAUSIBILITY_FORCE_RATIO, false, "springs.0.force_y.upper=250\nsprings.1.force_y.upper=70",
     "force_y in kN"},
    {PLAUSIBILITY_SPRING_SHARE, false, "springs.1.force_x.upper=120", "springs.1.force_x"},
    {PLAUSIBILITY_ENERGY, true,
     "springs.0.force_x.upper=[80, 450, 450, 450, 450]\nsprings.1.force_x.upper=120\n"
     "springs.0.force_y.upper=250\nsprings.1.force_y.upper=70",
     "the car has 264.0 kJ; likely slip: forces in kN in place of N"},
    {PLAUSIBILITY_ENERGY, false, "springs.0.force_x.upper=100e3\nsprings.0.force_y.upper=50e3",
     "below 1 the structure cannot stop the car"},
    {PLAUSIBILITY_ENERGY, true, "springs.0.force_x.upper=450e6\nsprings.0.force_y.upper=250e6",
     "forces in mN in place of N"},
    {PLAUSIBILITY_FIREWALL, true, "firewall_distance=250", "250 mm, which is 0.25 m"},
    {PLAUSIBILITY_FIREWALL, true, "firewall_distance=1.3", "firewall_distance"},
    {PLAUSIBILITY_FIREWALL, false, "firewall_distance=1.1", "firewall_distance"},
    {PLAUSIBILITY_DURATION, true, "simulation={duration: 150, time_step: 1}",
     "150 ms, which is 0.15 s"},
    {PLAUSIBILITY_DURATION, false, "simulation={duration: 0.02}", "simulation.duration"},
    {PLAUSIBILITY_TIME_STEP, true, "simulation={time_step: 1}", "1 ms, which is 0.001 s"},
    {PLAUSIBILITY_TIME_STEP, false, "simulation={time_step: 0.01}", "simulation.time_step"},
    {PLAUSIBILITY_CONSTRAINT_YAW, false, "constraints={yaw_deg: {max: 0.35}}",
     "0.35 rad, which is 20.05 deg"},
    {PLAUSIBILITY_CONSTRAINT_LENGTH, true, "constraints={deformation_max.rail: {max: 500}}",
     "500 mm, which is 0.5 m"},
    {PLAUSIBILITY_CONSTRAINT_LENGTH, true, "constraints={s_L: {min: 250}}",
     "250 mm, which is 0.25 m"},
    {PLAUSIBILITY_CONSTRAINT_SHARE, false, "constraints={AbWAP: {max: 100}}", "100 %, which is 1"},
    {PLAUSIBILITY_CONSTRAINT_SPEED, false, "constraints={delta_vx: {min: 45}}",
     "45 km/h, which is 12.5 m/s"},
    {PLAUSIBILITY_CONSTRAINT_DECELERATION, false, "constraints={decel_max_g: {max: 400}}",
     "400 m/s2, which is 40.77 g"},
    {PLAUSIBILITY_CONSTRAINT_ENERGY, false, "constraints={energy_absorbed.rail: {min: 60}}",
     "60 kJ, which is 6e+04 J"},
};

static void assert_found(const struct scenario *scenario, const struct implausible *slip)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++) {
        const struct scenario_finding *finding = &scenario->findings[i];
        if (finding->check == (int)slip->check && finding->error == slip->error &&
            strstr(finding->text, slip->says) != NULL && g_str_has_prefix(finding->place, "--set "))
            return;
    }
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        print_error("%s: %s\n", scenario->findings[i].place, scenario->findings[i].text);
    fail_msg("%s: expected %s of row %d with '%s'", slip->overrides,
             slip->error ? "an error" : "a warning", (int)slip->check, slip->says);
}

static struct scenario read_leniently(const char *text, const char *overrides)
{
    struct scenario scenario;
    struct error error = {0};
    char **set = g_strsplit(overrides, "\n", -1);
    enum status status = scenario_read_text(&scenario, "t.yaml", text, strlen(text),
                                            (const char *const *)set, g_strv_length(set), &error);
    g_strfreev(set);
    if (status != STATUS_OK)
        fail_msg("%s: %s", overrides, error.text);
    return scenario;
}

// Each slip is found by its row, at the option it came from; a warning lets the file pass. Where
// the file cannot even be completed, the slip is what is pointed at.
static void slips_are_found(void **state)
{
    (void)state;
    for (size_t i = 0; i < G_N_ELEMENTS(slips); i++) {
        const struct implausible *slip = &slips[i];
        struct scenario scenario;
        struct error error = {0};
        enum status status = read_as_file(sedan, slip->overrides, &scenario, &error);
        if (slip->error) {
            assert_int_equal(status, STATUS_INVALID);
            if (strstr(error.text, slip->says) == NULL)
                fail_msg("%s: expected '%s', found %s", slip->overrides, slip->says, error.text);
        } else if (status != STATUS_OK) {
            fail_msg("%s: expected a warning, found %s", slip->overrides, error.text);
        } else {
            assert_found(&scenario, slip);
            assert_false(plausibility_refused(&scenario, NULL));
        }
        scenario_fini(&scenario);
    }
}

// No row of the table is without a slip that it finds.
static void every_row_is_tried(void **state)
{
    (void)state;
    for (int check = 0; check < PLAUSIBILITY_CHECK_COUNT; check++) {
        bool tried = false;
        for (size_t i = 0; i < G_N_ELEMENTS(slips); i++)
            tried |= (int)slips[i].check == check;
        if (!tried)
            fail_msg("nothing tries row %d, %s", check, plausibility_rows[check].what);
    }
}

// Unusual vehicles are still vehicles.
static void real_vehicles_are_not_suspected(void **state)
{
    (void)state;
    static const char *const vehicles[] = {sedan, kart, lorry, wall};
    static const char *const responses[] = {"response=any", "response=rotating",
                                            "response=glancing_off"};
    for (size_t i = 0; i < G_N_ELEMENTS(vehicles); i++)
        for (size_t k = 0; k < G_N_ELEMENTS(responses); k++)
            assert_without_findings(vehicles[i], responses[k]);
    assert_without_findings(sedan, "vehicle.speed=4.2"); // a test at 15 km/h
    assert_without_findings(sedan, "barrier.overlap=0.455");
    assert_without_findings(sedan, "barrier.edge_y=-0.2"); // an overlap of 40 %
    assert_without_findings(sedan,
                            "constraints={yaw_deg: {min: -20, max: 20}, delta_vx: {min: 10}, "
                            "kinetic_energy: {max: 50e3}, s_L: {max: 0.6}}");
    assert_without_findings(lorry, "vehicle.mass=40e3\nvehicle.yaw_inertia=500e3\nvehicle.speed=8");
}

static void assert_file_without_findings(const char *path)
{
    struct scenario scenario;
    struct error error = {0};
    if (scenario_read_file(&scenario, path, NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    if (scenario.finding_count > 0)
        fail_msg("%s: %s", path, scenario.findings[0].text);
    scenario_fini(&scenario);
}

static void assert_sweep_without_findings(const char *path)
{
    struct sweep *sweep;
    struct error error = {0};
    if (sweep_read_file(&sweep, path, NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    for (uint32_t i = 0; i < sweep_case_count(sweep); i++) {
        struct scenario scenario;
        if (sweep_scenario(sweep, i, &scenario, &error) != STATUS_OK)
            fail_msg("%s", error.text);
        if (scenario.finding_count > 0)
            fail_msg("%s: %s", path, scenario.findings[0].text);
        scenario_fini(&scenario);
    }
    sweep_free(sweep);
}

// Nor is any file that comes with the program, sweeps in all their cases, or that its tests use as
// real cars.
static void shipped_files_are_not_suspected(void **state)
{
    (void)state;
    static const char *const folders[] = {"deploy/scenarios", "deploy/scenarios/benchmarks",
                                          "tests/data"};
    uint32_t count = 0;
    for (size_t i = 0; i < G_N_ELEMENTS(folders); i++) {
        char *folder = g_build_filename(SOBOX_SOURCE_DIR, folders[i], NULL);
        GDir *names = g_dir_open(folder, 0, NULL);
        assert_non_null(names);
        for (const char *name; (name = g_dir_read_name(names)) != NULL;) {
            char *path = g_build_filename(folder, name, NULL);
            if (g_str_has_suffix(name, ".yaml") && sweep_detect(path))
                assert_sweep_without_findings(path);
            else if (g_str_has_suffix(name, ".yaml"))
                assert_file_without_findings(path);
            count += g_str_has_suffix(name, ".yaml");
            g_free(path);
        }
        g_dir_close(names);
        g_free(folder);
    }
    assert_true(count >= 9 + 13 + 1);
}

// A file that was written for another program is told so as a whole.
static void systems_of_units_are_recognised(void **state)
{
    (void)state;
    static const struct {
        const char *overrides, *says;
    } systems[] = {
        {"vehicle={mass: 1.65, yaw_inertia: 3e6, speed: 17889}\n"
         "barrier={face_x: -2080, edge_y: -455, width: 1150}\n"
         "springs.0.position=[-830, -750]\nsprings.1.position=[-980, -500]\n"
         "springs.0.deformation=[0, 300, 600, 900, 1200]\nsprings.1.deformation=[100, 800]\n"
         "firewall_distance=250",
         "the whole file seems to be in t, mm, s, N, expected kg, m, s, N"},
        {"vehicle={mass: 1650, yaw_inertia: 3e9, speed: 17.889}\n"
         "barrier={face_x: -2080, edge_y: -455, width: 1150}\n"
         "springs.0.position=[-830, -750]\nsprings.1.position=[-980, -500]\n"
         "springs.0.deformation=[0, 300, 600, 900, 1200]\nsprings.1.deformation=[100, 800]\n"
         "simulation={duration: 150, time_step: 1}\nfirewall_distance=250",
         "the whole file seems to be in kg, mm, ms, kN, expected kg, m, s, N"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(systems); i++) {
        struct scenario scenario;
        struct error error = {0};
        assert_int_equal(read_as_file(sedan, systems[i].overrides, &scenario, &error),
                         STATUS_INVALID);
        if (strstr(error.text, systems[i].says) == NULL)
            fail_msg("%s", error.text);
    }
}

// Text that is read again, from a journal or the network, is never refused for what it means: its
// findings are there to be shown.
static void text_read_again_is_not_refused(void **state)
{
    (void)state;
    struct scenario scenario = read_leniently(sedan, "vehicle.mass=1.65");
    assert_true(scenario.finding_count > 0 && scenario.findings[0].error);
    assert_int_equal(scenario.findings[0].check, PLAUSIBILITY_MASS);
    struct error error = {0};
    assert_true(plausibility_refused(&scenario, &error));
    assert_int_equal(error.status, STATUS_INVALID);
    scenario_fini(&scenario);
}

// A scenario with cases is judged by them, and the case is named; what all share is said once.
static void cases_are_judged_by_themselves(void **state)
{
    (void)state;
    char *text =
        g_strconcat(sedan, "cases:\n- {name: slow}\n- {name: fast, vehicle.speed: 64.4}\n", NULL);
    struct scenario scenario = read_leniently(text, "barrier.overlap=0.25");
    uint32_t overlap = 0, speed = 0;
    for (uint32_t i = 0; i < scenario.finding_count; i++) {
        const struct scenario_finding *finding = &scenario.findings[i];
        overlap += finding->check == PLAUSIBILITY_OVERLAP_SPARE;
        speed += finding->check == PLAUSIBILITY_SPEED &&
                 g_str_has_suffix(finding->text, "(in case fast)") &&
                 g_str_has_prefix(finding->place, "t.yaml:19:");
    }
    assert_int_equal(overlap, 1);
    assert_int_equal(speed, 1);
    scenario_fini(&scenario);
    // What the cases began from is simulated by nobody.
    g_free(text);
    text = g_strconcat(sedan, "cases:\n- {name: slow, vehicle.speed: 10}\n", NULL);
    scenario = read_leniently(text, "vehicle.speed=64.4");
    assert_int_equal(scenario.finding_count, 0);
    scenario_fini(&scenario);
    g_free(text);
}

// A case of a sweep that cannot be meant is refused by its name, at its value in the sweep; one
// that is unlikely is pointed at there.
static void cases_of_sweeps_are_judged(void **state)
{
    (void)state;
    char *folder = g_dir_make_tmp("plausibility-XXXXXX", NULL);
    char *base = g_build_filename(folder, "sedan.yaml", NULL);
    char *path = g_build_filename(folder, "sweep.yaml", NULL);
    assert_true(g_file_set_contents(base, sedan, -1, NULL));
    assert_true(g_file_set_contents(path,
                                    "sweep: speeds\nbase: sedan.yaml\naxes:\n"
                                    "- {path: vehicle.speed, values: [17.889, 64.4, 17889]}\n",
                                    -1, NULL));
    struct sweep *sweep;
    struct error error = {0};
    assert_int_equal(sweep_read_file(&sweep, path, NULL, 0, &error), STATUS_OK);
    struct scenario scenario;
    assert_int_equal(sweep_scenario(sweep, 0, &scenario, &error), STATUS_OK);
    assert_int_equal(scenario.finding_count, 0);
    scenario_fini(&scenario);
    assert_int_equal(sweep_scenario(sweep, 1, &scenario, &error), STATUS_OK);
    char *place = g_strconcat(path, ":4:42", NULL);
    assert_string_equal(scenario.findings[0].place, place);
    scenario_fini(&scenario);
    assert_int_equal(sweep_scenario(sweep, 2, &scenario, &error), STATUS_INVALID);
    assert_true(g_str_has_prefix(error.text, path));
    assert_non_null(strstr(error.text, ":4:48: vehicle.speed: speed is 17889 m/s"));
    assert_non_null(strstr(error.text, "in the case speed=17889 of"));
    sweep_free(sweep);
    g_remove(base);
    g_remove(path);
    g_rmdir(folder);
    g_free(place);
    g_free(base);
    g_free(path);
    g_free(folder);
}

// ------------------------------------------------------------------------------------------------
// The table as people read it

// "below 50, above 500000", or "none" where there is no such limit.
static char *limits(double low, double high)
{
    char *below = isfinite(low) ? g_strdup_printf("below %.6g", low) : g_strdup("");
    char *above = isfinite(high) ? g_strdup_printf("above %.6g", high) : g_strdup("");
    char *text =
        g_strdup_printf("%s%s%s", below, below[0] != '\0' && above[0] != '\0' ? ", " : "", above);
    g_free(below);
    g_free(above);
    if (text[0] == '\0') {
        g_free(text);
        return g_strdup("none");
    }
    return text;
}

static char *quantity(const struct plausibility_row *row)
{
    char *text = g_strdup_printf("%s%s%s%s%s%s", row->what, row->unit[0] != '\0' ? " [" : "",
                                 row->unit, row->unit[0] != '\0' ? "]" : "",
                                 row->only != NULL ? "; " : "", row->only != NULL ? row->only : "");
    return text;
}

static char *read_source(const char *path)
{
    char *text = NULL;
    char *whole = g_build_filename(SOBOX_SOURCE_DIR, path, NULL);
    assert_true(g_file_get_contents(whole, &text, NULL, NULL));
    g_free(whole);
    return text;
}

// The README has the table row by row, and the manual an entry for each: what is checked is what is
// written there.
static void the_table_is_documented(void **state)
{
    (void)state;
    char *readme = read_source("common/scenario/README.md");
    char *manual = read_source("deploy/man/sobox-scenario.5");
    bool missing = false;
    for (int i = 0; i < PLAUSIBILITY_CHECK_COUNT; i++) {
        const struct plausibility_row *row = &plausibility_rows[i];
        char *what = quantity(row), *errors = limits(row->error_min, row->error_max);
        char *warnings = limits(row->min, row->max);
        char *line = g_strdup_printf("| `%s` | %s | %s | %s | %s |\n", row->key, what, errors,
                                     warnings, row->reason);
        char *entry = g_strdup_printf(".TP\n.B %s\n%s:\nwarning %s; error %s; %s.\n", row->key,
                                      what, warnings, errors, row->reason);
        char *escaped = g_strjoinv("\\-", g_strsplit(entry, "-", -1));
        if (strstr(readme, line) == NULL)
            missing = true, print_error("README.md: expected %s", line);
        if (strstr(manual, escaped) == NULL)
            missing = true, print_error("sobox-scenario.5: expected %s", escaped);
        g_free(escaped);
        g_free(entry);
        g_free(line);
        g_free(warnings);
        g_free(errors);
        g_free(what);
    }
    g_free(readme);
    g_free(manual);
    assert_false(missing);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slips_are_found),
        cmocka_unit_test(every_row_is_tried),
        cmocka_unit_test(real_vehicles_are_not_suspected),
        cmocka_unit_test(shipped_files_are_not_suspected),
        cmocka_unit_test(systems_of_units_are_recognised),
        cmocka_unit_test(text_read_again_is_not_refused),
        cmocka_unit_test(cases_are_judged_by_themselves),
        cmocka_unit_test(cases_of_sweeps_are_judged),
        cmocka_unit_test(the_table_is_documented),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
