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
        cmocka_unit_test(a_script_begins_with_what_it_draws_and_where),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
