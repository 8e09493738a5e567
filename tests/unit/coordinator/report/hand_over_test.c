// Curves for other programs and curves from them, on the run folder of sample_run.h: the spring
// `front` has corridors from 15 to 45 kN at 0 m and 112.5 to 337.5 kN at 1.2 m along the car.
#include "sample_run.h"

#include "coordinator/report/report.h"

static char *exported(const char *folder, const char *format, const char *units)
{
    const struct report_export settings = {
        .format = format, .units = units, .folder = folder, .first_id = 100};
    struct error error = {0};
    char *path, *text;
    if (report_export(folder, &settings, &path, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    assert_true(g_file_get_contents(path, &text, NULL, NULL));
    g_free(path);
    return text;
}

// Cards as the solvers' manuals have them: fields of 10 and of 20 characters, comments that say the
// units and what the curves are worth.
static void solvers_get_curves_in_their_own_cards(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *text = exported(*state, "ls-dyna", "kN-mm-ms");
    assert_true(g_str_has_prefix(text, "*KEYWORD\n$ "));
    assert_true(g_str_has_suffix(text, "*END\n"));
    assert_contains(text, "$ between lower and upper at least 0.9970 of all designs are good\n");
    assert_contains(text, "$ units kN-mm-ms: deformation in mm, force in kN\n");
    assert_contains(text, "*DEFINE_CURVE_TITLE\nfront F_x lower\n"
                          "$#    lcid      sidr       sfa       sfo      offa      offo    dattyp\n"
                          "       100         0       1.0       1.0       0.0       0.0         0\n"
                          "$#                a1                  o1\n"
                          "                   0                  15\n"
                          "                1200               112.5\n"
                          "*DEFINE_CURVE_TITLE\nfront F_x middle\n");
    assert_contains(text, "rail F_y upper\n");
    assert_contains(text, "\n       111  ");
    g_free(text);
    text = exported(*state, "openradioss", "N-mm-s");
    assert_contains(text, "/FUNCT/102\nfront F_x upper\n"
                          "#                  X                   Y\n"
                          "                   0               45000\n"
                          "                1200              337500\n");
    g_free(text);
}

static void tables_name_their_units(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *text = exported(*state, "csv", "kN-m-s");
    assert_true(g_str_has_prefix(text, "spring,direction,bound,deformation_m,force_kN,reached\n"
                                       "front,x,lower,0,15,yes\nfront,x,lower,1.2,112.5,yes\n"
                                       "front,x,middle,0,30,yes\nfront,x,middle,1.2,225,yes\n"));
    g_free(text);
    text = exported(*state, "json", "N-m-s");
    assert_contains(text, "\"force_unit\": \"N\"");
    assert_contains(text, "\"bound\": \"upper\"");
    assert_contains(text, "337500.0");
    g_free(text);
}

// Whoever takes the curves over learns from where on they mean nothing, in the units of the curves.
static void curves_tell_what_no_design_reaches(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_DONE);
    char *text = exported(*state, "ls-dyna", "kN-mm-ms");
    assert_contains(text,
                    "$ from 1000 mm on: reached by none of 2,048 designs that were simulated\n"
                    "                   0                 500\n");
    assert_contains(text, "$ from 0 mm on: reached by none of 2,048 designs that were simulated\n"
                          "                   0                  20\n");
    g_free(text);
    text = exported(*state, "openradioss", "N-m-s");
    assert_contains(text, "# from 1 m on: reached by none of 2,048 designs that were simulated\n"
                          "                   0              500000\n");
    g_free(text);
    text = exported(*state, "csv", "kN-m-s");
    assert_contains(text, "front,x,upper,0.75,700,yes\nfront,x,upper,1,700,no\n");
    g_free(text);
    text = exported(*state, "json", "N-m-s");
    assert_contains(text, "\"points_reached\": 4");
    g_free(text);
}

static void wrong_exports_are_refused(void **state)
{
    static const struct {
        const char *format, *units;
        uint32_t search;
        const char *said;
    } cases[] = {
        {"nastran", "N-m-s", 0, "--export nastran: expected ls-dyna, openradioss, csv or json"},
        {"csv", "lbf-in-s", 0, "--units lbf-in-s: expected one of N-m-s, N-mm-s"},
        {"csv", "N-m-s", 7, "there is no search 7"},
        {"csv", "N-m-s", 1, "search 1 has no corridors"},
    };
    sample_sweep(*state);
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        const struct report_export settings = {.format = cases[i].format,
                                               .units = cases[i].units,
                                               .search = cases[i].search,
                                               .folder = *state,
                                               .first_id = 1};
        struct error error = {0};
        char *path;
        assert_int_equal(report_export(*state, &settings, &path, &error), STATUS_INVALID);
        assert_null(path);
        assert_contains(error.text, cases[i].said);
    }
}

// Writes a file of measured curves and says what is found of it; NULL when it is refused, with the
// message in `error`.
static char *checked(const char *folder, const char *csv, const char *units, bool *inside,
                     struct error *error)
{
    char *path = g_build_filename(folder, "measured.csv", NULL), *text = NULL;
    assert_true(g_file_set_contents(path, csv, -1, NULL));
    size_t size;
    FILE *out = open_memstream(&text, &size);
    const struct report_check settings = {.path = path, .units = units};
    enum status status = report_check(folder, &settings, out, inside, error);
    fclose(out);
    g_free(path);
    if (status == STATUS_OK)
        return text;
    assert_int_equal(status, STATUS_INVALID);
    free(text);
    return NULL;
}

static void measured_curve_is_held_against_its_corridor(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    struct error error = {0};
    bool inside;
    char *said = checked(*state,
                         "spring,direction,deformation,force\n"
                         "front,x,0,30\nfront,x,600,150\nfront,x,1200,225\n",
                         "kN-mm-ms", &inside, &error);
    assert_true(inside);
    assert_string_equal(said, "front F_x: inside its corridor from 0 to 1200 mm\n");
    free(said);
    // In kN and m: above the upper bound from the start, below the lower one at the end.
    said = checked(*state,
                   "spring,direction,deformation,force\n"
                   "front,x,0,55\nfront,x,0.6,100\nfront,x,1.2,100\n"
                   "front,y,0.3,100\nfront,y,0.9,100\n",
                   "kN-m-s", &inside, &error);
    assert_false(inside);
    assert_contains(said, "front F_x: leaves its corridor (looked at from 0 to 1.2 m)\n");
    assert_contains(said, "above the upper bound from 0 to ");
    assert_contains(said, "most at 0 m: by 10 kN\n");
    assert_contains(said, "below the lower bound from ");
    assert_contains(said, " to 1.2 m, most at 1.2 m: by 12.5 kN\n");
    assert_contains(said, "front F_y: inside its corridor from 0.3 to 0.9 m\n");
    assert_contains(said, "    the corridor reaches from 0 to 1.2 m\n");
    free(said);
}

// A part that is too weak only where no crash presses it to is outside its corridor, and told to be
// so there alone; one that is too weak earlier is not.
static void curve_that_leaves_where_no_design_comes_is_told_apart(void **state)
{
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_DONE);
    struct error error = {0};
    bool inside;
    char *said = checked(*state,
                         "spring,direction,deformation,force\n"
                         "front,x,0,600\nfront,x,800,500\nfront,x,1000,100\n",
                         "kN-mm-ms", &inside, &error);
    assert_false(inside);
    assert_contains(said, "from 800 to 1000 mm");
    assert_contains(said, "    all of it beyond 750 mm, where none of 2,048 simulated designs of "
                          "the corridors comes\n");
    free(said);
    said = checked(*state,
                   "spring,direction,deformation,force\n"
                   "front,x,0,600\nfront,x,700,500\nfront,x,1000,100\n",
                   "kN-mm-ms", &inside, &error);
    assert_false(inside);
    assert_null(strstr(said, "all of it"));
    free(said);
    said = checked(*state, "spring,direction,deformation,force\nidle,y,0,100\nidle,y,0.4,100\n",
                   "kN-m-s", &inside, &error);
    assert_false(inside);
    assert_contains(said, "all of it beyond 0 m,");
    free(said);
}

static void wrong_measured_curves_are_refused_at_their_place(void **state)
{
    static const struct {
        const char *csv, *said;
    } cases[] = {
        {"spring,direction,deformation\nfront,x,0\n", "measured.csv:1:29: expected the columns"},
        {"spring,direction,x,force\nfront,x,0,1\n", "measured.csv:1:18: expected deformation"},
        {"spring,direction,deformation,force,mass\nfront,x,0,1,2\n", "expected four columns"},
        {"spring,direction,deformation,force\nrear,x,0,1\n",
         "measured.csv:2:1: expected the name of a spring, one of front, rail, found 'rear'"},
        {"spring,direction,deformation,force\nfront,z,0,1\n", ":2:7: expected x or y, found 'z'"},
        {"spring,direction,deformation,force\nfront,x,0,1\n", ":2:1: expected at least 2 points"},
        {"spring,direction,deformation,force\nfront,x,0,one\n",
         ":2:11: force: expected a finite number [N]"},
        {"spring,direction,deformation,force\nfront,x,0,nan\n",
         ":2:11: force: expected a finite number [N]"},
        {"spring,direction,deformation,force\nfront,x,0\n",
         ":2:10: expected 4 fields as in the header, found 3"},
        {"spring,direction,deformation,force\n", "expected rows below the header"},
        {"spring,direction,deformation,force\nfront,x,1,1\nfront,x,1,2\n",
         ":3:9: expected a deformation greater than the one above"},
    };
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct error error = {0};
        bool inside = true;
        assert_null(checked(*state, cases[i].csv, "N-m-s", &inside, &error));
        assert_false(inside);
        assert_contains(error.text, cases[i].said);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(solvers_get_curves_in_their_own_cards),
        IN_FOLDER(tables_name_their_units),
        IN_FOLDER(curves_tell_what_no_design_reaches),
        IN_FOLDER(wrong_exports_are_refused),
        IN_FOLDER(measured_curve_is_held_against_its_corridor),
        IN_FOLDER(curve_that_leaves_where_no_design_comes_is_told_apart),
        IN_FOLDER(wrong_measured_curves_are_refused_at_their_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
