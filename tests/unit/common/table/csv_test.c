#include "common/table/csv.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
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
    assert_int_equal(csv_column(&csv, csv.fields[0].text), 2);
    assert_int_equal(csv_column(&csv, csv.fields[1].text), 6);
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
        "12abc", "nan", "inf", "-inf", "1e999", "", "1 2", "0x10",
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

// What spreadsheets write: a field in quotes may hold commas and, doubled, quotes. Characters
// count, not bytes, in the places of messages.
static void quotes_hold_commas_and_quotes(void **state)
{
    (void)state;
    struct csv csv;
    struct error error;
    start(&csv, "\xc3\xa9, \"a, \"\"b\"\"\" ,\"\",1\"2\n");
    assert_int_equal(csv_row(&csv, &error), STATUS_OK);
    assert_int_equal(csv.field_count, 4);
    static const char *const texts[] = {"\xc3\xa9", "a, \"b\"", "", "1\"2"};
    for (size_t i = 0; i < 4; i++) {
        char *text = csv_text(&csv.fields[i]);
        assert_string_equal(text, texts[i]);
        free(text);
    }
    assert_int_equal(csv_column(&csv, csv.fields[1].text), 5);
    static const char *const wrong[][2] = {
        {"1,\"a\n\"", "t.csv:1:3: expected a closing quote"},
        {"\"a\"\"", "t.csv:1:1: expected a closing quote"},
        {"\"a\" b,1", "t.csv:1:5: expected a comma or the line's end"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        start(&csv, wrong[i][0]);
        assert_int_equal(csv_row(&csv, &error), STATUS_INVALID);
        assert_int_equal(strncmp(error.text, wrong[i][1], strlen(wrong[i][1])), 0);
    }
}

// A row may have more fields than csv_row() takes, and a text may be a piece of a table.
static void fields_are_read_one_by_one(void **state)
{
    (void)state;
    char text[2 * CSV_FIELD_MAX];
    memset(text, ',', sizeof text);
    struct csv csv;
    struct csv_field field;
    struct error error;
    csv_start(&csv, "t.csv", text, sizeof text);
    csv.line = 6;
    assert_true(csv_line(&csv));
    int count = 0;
    for (; csv.at != NULL; count++)
        assert_int_equal(csv_next(&csv, &field, &error), STATUS_OK);
    assert_int_equal(count, sizeof text + 1);
    csv_error_at(&csv, csv.line_end, &error, "wrong");
    assert_string_equal(error.text, "t.csv:7:1025: wrong");
    assert_false(csv_line(&csv));
}

// A message shows what stands in the file, but nothing that could steer a terminal.
static void shown_fields_are_short_and_plain(void **state)
{
    (void)state;
    char shown[CSV_SHOWN_SIZE];
    const struct csv_field escape = {"\x1b[2J\0x", 6, false};
    assert_string_equal(csv_shown(&escape, shown), "?[2J?x");
    char text[100];
    memset(text, 'a', sizeof text);
    const struct csv_field longer = {text, sizeof text, false};
    assert_int_equal(strlen(csv_shown(&longer, shown)), CSV_SHOWN_SIZE - 1);
    assert_string_equal(shown + CSV_SHOWN_SIZE - 4, "...");
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
        cmocka_unit_test(quotes_hold_commas_and_quotes),
        cmocka_unit_test(fields_are_read_one_by_one),
        cmocka_unit_test(shown_fields_are_short_and_plain),
        cmocka_unit_test(too_many_fields_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
