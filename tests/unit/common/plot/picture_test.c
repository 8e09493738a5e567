#include "common/plot/gnuplot.h"
#include "common/plot/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void the_ending_of_a_file_says_its_format(void **state)
{
    (void)state;
    enum picture_format format = PICTURE_SVG;
    assert_true(picture_format_of("some.where/motion.pdf", &format));
    assert_int_equal(format, PICTURE_PDF);
    assert_true(picture_format_of("a.png", &format));
    assert_int_equal(format, PICTURE_PNG);
    assert_false(picture_format_of("motion.gp", &format));
    assert_false(picture_format_of("svg", &format));
}

static void the_stem_has_neither_folder_nor_ending(void **state)
{
    (void)state;
    g_autofree char *stem = picture_stem("some.where/my.motion.svg");
    assert_string_equal(stem, "my.motion");
    g_autofree char *bare = picture_stem("some.where/motion");
    assert_string_equal(bare, "motion");
}

// What gnuplot would run or end the text with is written as octal codes; letters of any language
// stay.
static void a_quoted_text_is_only_ever_text(void **state)
{
    (void)state;
    g_autofree char *quoted = gnuplot_quoted("a\"`b`@c\n\xc3\xa9");
    assert_string_equal(quoted, "\"a\\042\\140b\\140\\100c\\077\xc3\xa9\"");
    g_autofree char *digits = gnuplot_quoted("upper=#29a3");
    assert_string_equal(digits, "\"upper=\\043\\062\\071a3\"");
    g_autofree char *tick = gnuplot_tick("50%");
    assert_string_equal(tick, "\"50%%\"");
}

// A text of the SVG with its entities resolved.
static char *resolved(const char *svg)
{
    static const char *const entities[][2] = {
        {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}};
    char *text = g_strdup(svg);
    for (size_t i = 0; i < G_N_ELEMENTS(entities); i++) {
        char **parts = g_strsplit(text, entities[i][0], -1);
        g_free(text);
        text = g_strjoinv(entities[i][1], parts);
        g_strfreev(parts);
    }
    return text;
}

// Draws texts of every printable character, with digits and letters behind it, as label, title,
// tick and key, and looks for each, whole, in the picture.
static void every_printable_name_arrives_whole(void **state)
{
    (void)state;
    g_autofree char *program = g_find_program_in_path("gnuplot");
    if (program == NULL)
        skip();
    GString *script = g_string_new(NULL);
    picture_begin(script, &(struct picture_page){"Names", "names", "names", 640, 9000});
    GString *keys = g_string_new(NULL), *ticks = g_string_new(NULL);
    enum { FIRST = '!', LAST = '~' };
    for (char c = FIRST; c <= LAST; c++) {
        char text[64];
        g_snprintf(text, sizeof text, "%c1%c8%c%cx,%c", c, c, c, c, c);
        g_autofree char *quoted = gnuplot_quoted(text), *tick = gnuplot_tick(text);
        g_string_append_printf(script, "set label %s at screen 0.5, screen %.3f noenhanced\n",
                               quoted, (c - FIRST) * 0.01);
        g_string_append_printf(ticks, "%s%s %d", ticks->len > 0 ? ", " : "", tick, c);
        g_string_append_printf(keys, "%s0 title %s noenhanced", keys->len > 0 ? ", " : "", quoted);
    }
    g_string_append_printf(script, "set xrange [0:200]\nset ytics noenhanced (%s)\n", ticks->str);
    g_string_append_printf(script, "set yrange [0:200]\nplot %s\n", keys->str);
    char *svg = NULL;
    struct error error = {0};
    if (picture_inline(script->str, &svg, &error) != STATUS_OK)
        fail_msg("%s", error.text);
    g_autofree char *shown = resolved(svg);
    for (char c = FIRST; c <= LAST; c++) {
        char text[64];
        uint32_t found = 0;
        g_snprintf(text, sizeof text, "%c1%c8%c%cx,%c", c, c, c, c, c);
        for (const char *at = shown; (at = strstr(at, text)) != NULL; at++)
            found++;
        if (found < 3) // label, tick and key
            fail_msg("expected %s three times, found it %u times", text, found);
    }
    g_free(svg);
    g_string_free(keys, TRUE);
    g_string_free(ticks, TRUE);
    g_string_free(script, TRUE);
}

static void a_script_begins_with_what_it_draws_and_where(void **state)
{
    (void)state;
    GString *script = g_string_new(NULL);
    const struct picture_page page = {"A thing", "thing", "it's", 640, 480};
    picture_begin(script, &page);
    assert_true(g_str_has_prefix(script->str, "# A thing."));
    assert_non_null(strstr(script->str, "output = \"it\\047s\" . '.' . format"));
    assert_non_null(strstr(script->str, "width = 640.0"));
    assert_non_null(strstr(script->str, "height = 480.0"));
    g_string_free(script, TRUE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_ending_of_a_file_says_its_format),
        cmocka_unit_test(the_stem_has_neither_folder_nor_ending),
        cmocka_unit_test(a_quoted_text_is_only_ever_text),
        cmocka_unit_test(every_printable_name_arrives_whole),
        cmocka_unit_test(a_script_begins_with_what_it_draws_and_where),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
