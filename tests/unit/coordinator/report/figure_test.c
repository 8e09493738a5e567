#include "common/plot/picture.h"
#include "sample_run.h"

#include "coordinator/report/report.h"

#include <stdlib.h>

// ---- looking at pictures ----

struct picture {
    char *text;
    char *words; // all that is written in it, each text on a line
};

static void collect_text(GMarkupParseContext *context, const char *text, gsize size, gpointer user,
                         GError **error)
{
    (void)error;
    GString *words = user;
    const char *element = g_markup_parse_context_get_element(context);
    if (g_str_equal(element, "text") || g_str_equal(element, "tspan"))
        g_string_append_len(words, text, (gssize)size);
}

static void end_text(GMarkupParseContext *context, const char *element, gpointer user,
                     GError **error)
{
    (void)context;
    (void)error;
    if (g_str_equal(element, "text"))
        g_string_append_c(user, '\n');
}

// The SVG, which must be well-formed XML.
static struct picture picture_read(const char *folder, const char *name)
{
    static const GMarkupParser parser = {.text = collect_text, .end_element = end_text};
    struct picture picture = {.text = file_text(folder, name)};
    GString *words = g_string_new(NULL);
    GMarkupParseContext *context = g_markup_parse_context_new(&parser, 0, words, NULL);
    GError *failure = NULL;
    if (!g_markup_parse_context_parse(context, picture.text, -1, &failure) ||
        !g_markup_parse_context_end_parse(context, &failure))
        fail_msg("%s: %s", name, failure->message);
    g_markup_parse_context_free(context);
    picture.words = g_string_free(words, FALSE);
    return picture;
}

static void picture_fini(struct picture *picture)
{
    g_free(picture->text);
    g_free(picture->words);
}

static size_t occurrences(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, part)) != NULL; at += strlen(part))
        count++;
    return count;
}

static void draw(const char *folder, const struct report_plot *plot)
{
    struct error error = {0};
    if (report_draw(folder, plot, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

static char *subfolder(const char *folder, const char *name)
{
    char *path = g_build_filename(folder, name, NULL);
    assert_int_equal(mkdir(path, 0777), 0);
    return path;
}

// ---- tests ----

// One panel a spring and direction, axes with their units, and the names where a reader looks.
static void svg_has_a_panel_for_each_spring_and_direction(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    struct picture picture = picture_read(*state, "corridors.svg");
    static const char *const TITLES[] = {"front, axial force\n", "front, lateral force\n",
                                         "rail, axial force\n", "rail, lateral force\n"};
    for (size_t i = 0; i < G_N_ELEMENTS(TITLES); i++)
        assert_int_equal(occurrences(picture.words, TITLES[i]), 1);
    assert_int_equal(occurrences(picture.words, "deformation [m]\n"), 4);
    assert_int_equal(occurrences(picture.words, "Fx [kN]\n"), 2);
    assert_int_equal(occurrences(picture.words, "Fy [kN]\n"), 2);
    assert_contains(picture.words, "sample\n");
    assert_contains(picture.words, "response: any");
    assert_contains(picture.words, "purity at least 0.9970 with 95 % confidence");
    picture_fini(&picture);
}

// The script that stays in the folder draws the same picture when a user runs it there.
static void script_runs_by_hand(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    char *ours = file_text(*state, "corridors.svg");
    char *path = g_build_filename(*state, "corridors.svg", NULL);
    assert_int_equal(unlink(path), 0);
    char *argv[] = {(char[]){"gnuplot"}, (char[]){"corridors.gp"}, NULL};
    int status = -1;
    assert_true(g_spawn_sync(*state, argv, NULL, G_SPAWN_SEARCH_PATH, NULL, NULL, NULL, NULL,
                             &status, NULL));
    assert_int_equal(status, 0);
    char *theirs = file_text(*state, "corridors.svg");
    assert_string_equal(theirs, ours);
    g_free(theirs);
    g_free(path);
    g_free(ours);
}

// The other two formats begin as such files do, and go where they were asked to go.
static void other_formats_are_drawn(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_PDF});
    char *pdf = file_text(*state, "corridors.pdf");
    assert_memory_equal(pdf, "%PDF-", 5);
    g_free(pdf);
    char *elsewhere = subfolder(*state, "else where");
    char *output = g_build_filename(elsewhere, "figure.png", NULL);
    draw(*state, &(struct report_plot){.format = PICTURE_PNG, .output = output});
    char *png = file_text(elsewhere, "figure.png");
    assert_memory_equal(png, "\x89PNG", 4);
    assert_true(file_exists(elsewhere, "figure.gp"));
    g_free(png);
    g_free(output);
    g_free(elsewhere);
}

// A scenario's name may hold anything printable. In a script it could end a string and begin a
// command, in the SVG it could begin an element.
static void hostile_names_stay_names(void **state)
{
    static const char NAME[] = "'\"; system(\"touch pwned\") # `touch pwned` @x <b> & {=x}_2^\\";
    char *yaml = g_strconcat("name: '", "'", NAME, "'\n", strchr(SAMPLE_SCENARIO, '\n') + 1, NULL);
    sample_run(*state, yaml, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    struct picture picture = picture_read(*state, "corridors.svg");
    assert_contains(picture.words, NAME);
    assert_false(file_exists(*state, "pwned"));
    assert_true(access("pwned", F_OK) != 0);
    picture_fini(&picture);
    g_free(yaml);
}

// What is shared without its numbers must not carry them, neither on the axes nor in the script.
static void normalised_figure_holds_no_numbers(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG, .normalise = true});
    struct picture picture = picture_read(*state, "corridors-normalised.svg");
    assert_int_equal(occurrences(picture.words, "deformation, normalised\n"), 4);
    assert_int_equal(occurrences(picture.words, "Fx, normalised\n"), 2);
    assert_null(strstr(picture.words, "[kN]"));
    char *script = file_text(*state, "corridors-normalised.gp");
    // F_x runs from 0 to 450 kN over both springs, the deformation of "rail" from 0.1 to 0.9 m.
    assert_contains(script, "$design_1_x << END\n0 0 0.133333333333333"); // 60 of 450 kN
    assert_contains(script, "$corridor_1_x << END\n0 0.0333333333333333");
    assert_contains(script,
                    "\n1 0.25 0.75\nEND\n"); // 112.5 and 337.5 kN at the greatest deformation
    assert_null(strstr(script, "450"));
    assert_null(strstr(script, "1.2\n"));
    g_free(script);
    picture_fini(&picture);
}

// Two runs in one picture: both in the legend under what tells them apart, in two colours.
static void compared_run_is_drawn_over_the_first(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *other = subfolder(*state, "other");
    char *yaml = g_strdup(SAMPLE_SCENARIO);
    memcpy(strstr(yaml, "name: rail"), "name: hood", 10);
    char **halves = g_strsplit(yaml, "response: any", 2);
    char *rotating = g_strjoinv("response: rotating", halves);
    sample_run(other, rotating, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG, .compare = other});
    struct picture picture = picture_read(*state, "corridors-compared.svg");
    assert_contains(picture.words, "response: any ");
    assert_contains(picture.words, "response: rotating ");
    // Only the spring that both have.
    assert_int_equal(occurrences(picture.words, "front, axial force\n"), 1);
    assert_null(strstr(picture.words, "rail, axial force"));
    char *script = file_text(*state, "corridors-compared.gp");
    assert_int_equal(occurrences(script, "$compared_1_x << END"), 1);
    assert_int_equal(occurrences(script, "$compared_"), 2 + 2 * 3);
    g_free(script);
    picture_fini(&picture);
    g_free(rotating);
    g_strfreev(halves);
    g_free(yaml);
    g_free(other);
}

// What no design reaches is hatched, from the last point that one does reach, and the legend says
// so; where all is reached neither is there.
static void parts_that_no_design_reaches_are_hatched(void **state)
{
    static const char words[] = "hatched: reached by none of 2,048 designs that were simulated\n";
    sample_run(*state, SAMPLE_STOPPED, 1, SAMPLE_DONE);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    struct picture picture = picture_read(*state, "corridors.svg");
    assert_int_equal(occurrences(picture.words, words), 1);
    picture_fini(&picture);
    char *script = file_text(*state, "corridors.gp");
    assert_contains(script, "$corridor_1_x << END\n0 500 700\n0.25 500 700\n0.5 500 700\n"
                            "0.75 500 700\nEND\n"
                            "$corridor_beyond_1_x << END\n0.75 500 700\n1 500 700\nEND\n");
    assert_contains(script, "$corridor_beyond_2_y << END\n0 20 60\n0.4 20 60\nEND\n");
    assert_null(strstr(script, "$corridor_2_y"));
    g_free(script);

    char *other = subfolder(*state, "other");
    sample_run(other, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    draw(other, &(struct report_plot){.format = PICTURE_SVG});
    script = file_text(other, "corridors.gp");
    assert_null(strstr(script, "beyond"));
    assert_null(strstr(script, "hatched"));
    g_free(script);
    // Of two runs only one has such a part.
    draw(other, &(struct report_plot){.format = PICTURE_SVG, .compare = *state});
    script = file_text(other, "corridors-compared.gp");
    assert_contains(script, "$compared_beyond_1_x << END\n0.75 500 700\n1 500 700\nEND\n");
    assert_contains(script, "hatched: reached by none");
    assert_null(strstr(script, "$corridor_beyond"));
    g_free(script);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG, .normalise = true});
    script = file_text(*state, "corridors-normalised.gp");
    assert_contains(script, "$corridor_beyond_1_x << END\n0.75 0.625 0.875\n1 0.625 0.875\nEND\n");
    g_free(script);
    g_free(other);
}

// Nothing in common, nothing to show, no such search: an error that says which.
static void senseless_requests_are_refused(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *strange = subfolder(*state, "strange"), *empty = subfolder(*state, "empty");
    char **parts = g_strsplit(SAMPLE_SCENARIO, "name: front", 2);
    char *renamed = g_strjoinv("name: tail", parts);
    memcpy(strstr(renamed, "name: rail"), "name: hood", 10);
    sample_run(strange, renamed, 1, SAMPLE_DONE);
    sample_run(empty, SAMPLE_SCENARIO, 1, SAMPLE_NO_GOOD_DESIGN);

    struct error error = {0};
    struct report_plot plot = {.compare = strange};
    assert_int_equal(report_draw(*state, &plot, &error), STATUS_INVALID);
    assert_contains(error.text, "none of its springs (tail, ...)");
    plot.compare = empty;
    assert_int_equal(report_draw(*state, &plot, &error), STATUS_INVALID);
    assert_contains(error.text, "no corridors");
    plot = (struct report_plot){.search = 1};
    assert_int_equal(report_draw(*state, &plot, &error), STATUS_INVALID);
    assert_contains(error.text, "there is no search 1");
    assert_int_equal(report_draw("/nowhere", &plot, &error), STATUS_IO);
    assert_false(file_exists(*state, "corridors.svg"));
    g_free(renamed);
    g_strfreev(parts);
    g_free(empty);
    g_free(strange);
}

// A search that found nothing is still drawn: the design space and the reason.
static void empty_result_is_drawn_as_such(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_NO_GOOD_DESIGN);
    draw(*state, &(struct report_plot){.format = PICTURE_SVG});
    struct picture picture = picture_read(*state, "corridors.svg");
    assert_contains(picture.words, "no good design found");
    assert_int_equal(occurrences(picture.words, "front, axial force\n"), 1);
    picture_fini(&picture);
}

// Without gnuplot the error names the package, and no old or half picture is left.
static void missing_gnuplot_names_the_remedy(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *path = g_strdup(g_getenv("PATH"));
    g_setenv("PATH", *state, TRUE);
    struct error error = {0};
    enum status status = report_draw(*state, &(struct report_plot){.format = PICTURE_SVG}, &error);
    g_setenv("PATH", path, TRUE);
    assert_int_equal(status, STATUS_FAILED);
    assert_contains(error.text, "apt-get install gnuplot-nox");
    assert_false(file_exists(*state, "corridors.svg"));
    g_free(path);
}

// When gnuplot fails, what it said reaches the user.
static void failing_gnuplot_is_quoted(void **state)
{
    sample_run(*state, SAMPLE_SCENARIO, 1, SAMPLE_DONE);
    char *bin = subfolder(*state, "bin"), *fake = g_build_filename(bin, "gnuplot", NULL);
    assert_true(g_file_set_contents(fake, "#!/bin/sh\necho 'out of ink' >&2\nexit 3\n", -1, NULL));
    assert_int_equal(chmod(fake, 0755), 0);
    char *path = g_strdup(g_getenv("PATH"));
    g_setenv("PATH", bin, TRUE);
    struct error error = {0};
    enum status status = report_draw(*state, &(struct report_plot){.format = PICTURE_SVG}, &error);
    g_setenv("PATH", path, TRUE);
    assert_int_equal(status, STATUS_FAILED);
    assert_contains(error.text, "out of ink");
    assert_false(file_exists(*state, "corridors.svg"));
    g_free(path);
    g_free(fake);
    g_free(bin);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(svg_has_a_panel_for_each_spring_and_direction),
        IN_FOLDER(script_runs_by_hand),
        IN_FOLDER(other_formats_are_drawn),
        IN_FOLDER(hostile_names_stay_names),
        IN_FOLDER(normalised_figure_holds_no_numbers),
        IN_FOLDER(compared_run_is_drawn_over_the_first),
        IN_FOLDER(parts_that_no_design_reaches_are_hatched),
        IN_FOLDER(senseless_requests_are_refused),
        IN_FOLDER(empty_result_is_drawn_as_such),
        IN_FOLDER(missing_gnuplot_names_the_remedy),
        IN_FOLDER(failing_gnuplot_is_quoted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
