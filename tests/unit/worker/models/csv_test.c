#include "worker/models/csv.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void start(struct csv *csv, const char *text)
{
    csv_start(csv, "t.csv", text, strlen(text));
}

// The place of a field is what an editor jumps to: it counts from the line's first character,
// blanks included, and lines that are skipped count.
static void fields_know_their_place(void **state)
{
    (void)state;
    struct csv csv;
    struct error error;
    start(&csv, "# note\n\n a , bc\r\n,\n");
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.line, 3);
    assert_int_equal(csv.field_count, 2);
    assert_true(csv_is(&csv.fields[0], "a"));
    assert_true(csv_is(&csv.fields[1], "bc"));
    assert_int_equal(csv.fields[0].column, 2);
    assert_int_equal(csv.fields[1].column, 6);
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, 2);
    assert_true(csv_is(&csv.fields[1], ""));
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, 0);
}

// A last line without a newline is a line; an empty text has none.
static void last_line_needs_no_newline(void **state)
{
    (void)state;
    struct csv csv;
    struct error error;
    start(&csv, "x");
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, 1);
    start(&csv, "");
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, 0);
}

// strtod alone would take "12abc", "nan", "0x" and a number cut off at a buffer's end.
static void only_whole_finite_numbers_are_numbers(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "12abc", "nan",
        "inf",   "-inf",
        "1e999", "",
        "1 2",   "1.00000000000000000000000000000000000000000000000000000000000000000000000000",
    };
    struct csv csv;
    struct error error;
    double number = -1.0;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[128] = "a,";
        strcat(text, wrong[i]);
        start(&csv, text);
        assert_int_equal(csv_row(&csv, &error), STATUS_OK);
        assert_int_equal(csv_number(&csv, 1, "mass", "kg", &number, &error), STATUS_INVALID);
        assert_true(number == -1.0);
        assert_int_equal(strncmp(error.text, "t.csv:1:3: mass: ", 17), 0);
    }
    start(&csv, "450e3,-0.5");
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv_number(&csv, 0, "f", "N", &number, &error), STATUS_OK);
    assert_true(number == 450e3);
    assert_int_equal(csv_number(&csv, 1, "f", "N", &number, &error), STATUS_OK);
    assert_true(number == -0.5);
}

// A NUL inside a file must not end a field early: "1\0junk" is not the number 1.
static void nul_inside_a_field_is_no_end(void **state)
{
    (void)state;
    struct csv csv;
    struct error error;
    double number;
    csv_start(&csv, "t.csv", "1\0junk", 6);
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv_number(&csv, 0, "f", "N", &number, &error), STATUS_INVALID);
}

static void too_many_fields_are_refused(void **state)
{
    (void)state;
    char text[CSV_FIELD_MAX + 1];
    memset(text, ',', CSV_FIELD_MAX);
    text[CSV_FIELD_MAX] = '\0';
    struct csv csv;
    struct error error;
    start(&csv, text);
    assert_int_equal(csv_row(&csv, &error), STATUS_INVALID);
    text[CSV_FIELD_MAX - 1] = '\0';
    start(&csv, text);
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, CSV_FIELD_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_know_their_place),
        cmocka_unit_test(last_line_needs_no_newline),
        cmocka_unit_test(only_whole_finite_numbers_are_numbers),
        cmocka_unit_test(nul_inside_a_field_is_no_end),
        cmocka_unit_test(too_many_fields_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
