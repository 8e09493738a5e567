#include "coordinator/evaluation/designs.h"
#include "sample_scenario.h"

#include <glib.h>

static struct scenario scenario;

static int set_up(void **state)
{
    (void)state;
    sample_scenario(&scenario);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    scenario_fini(&scenario);
    return 0;
}

static struct designs_layout layout_of(const char *header)
{
    struct designs_layout layout;
    struct error error = {0};
    if (designs_layout_read(&layout, &scenario, "d.csv", 1, header, strlen(header), &error) !=
        STATUS_OK)
        fail_msg("%s", error.text);
    return layout;
}

static void assert_header_refused(const char *header, const char *complaint)
{
    struct designs_layout layout;
    struct error error = {0};
    assert_int_equal(
        designs_layout_read(&layout, &scenario, "d.csv", 1, header, strlen(header), &error),
        STATUS_INVALID);
    assert_complaint(&error, complaint);
}

static void assert_rows_refused(const char *header, const char *rows, const char *complaint)
{
    struct designs_layout layout = layout_of(header);
    struct designs designs;
    struct error error = {0};
    assert_int_equal(designs_read(&designs, &layout, "d.csv", 2, rows, strlen(rows), &error),
                     STATUS_INVALID);
    assert_complaint(&error, complaint);
    assert_null(designs.values);
    designs_layout_fini(&layout);
}

// Columns in any order, ids, and the value of a fixed variable that has no column.
static void rows_become_designs(void **state)
{
    (void)state;
    static const char rows[] = "0.5,first,-1\n1e-3,second one, 7 \n";
    struct designs_layout layout = layout_of("b,id,a\n");
    struct designs designs;
    struct error error = {0};
    assert_int_equal(designs_read(&designs, &layout, "d.csv", 2, rows, strlen(rows), &error),
                     STATUS_OK);
    assert_int_equal(designs.count, 2);
    static const double expected[] = {-1, 0.5, 0.25, 7, 1e-3, 0.25}; // 7: outside the design space
    assert_memory_equal(designs.values, expected, sizeof expected);
    assert_int_equal(designs.id_sizes[1], strlen("second one"));
    assert_memory_equal(designs.ids[1], "second one", strlen("second one"));
    designs_fini(&designs);
    designs_layout_fini(&layout);
}

// Files come from spreadsheets, from Windows, by hand: line ends, blanks, comments, quotes, no last
// newline.
static void line_ends_blanks_comments_and_quotes_do_not_matter(void **state)
{
    (void)state;
    static const char rows[] = "# by hand\r\n1,2,3\r\n\r\n  \t\n  4 ,\t\"5\",6";
    struct designs_layout layout = layout_of(" a , \"b\",c \r\n");
    struct designs designs;
    struct error error = {0};
    assert_int_equal(designs_read(&designs, &layout, "d.csv", 2, rows, strlen(rows), &error),
                     STATUS_OK);
    assert_int_equal(designs.count, 2);
    static const double expected[] = {1, 2, 3, 4, 5, 6};
    assert_memory_equal(designs.values, expected, sizeof expected);
    assert_null(designs.ids);
    designs_fini(&designs);
    designs_layout_fini(&layout);
}

// Each complaint says where and what would be right.
static void wrong_header_is_explained(void **state)
{
    (void)state;
    assert_header_refused("a", "d.csv:1:2: expected a column for every variable that is not "
                               "fixed: b is missing");
    assert_header_refused("a,b,d", "d.csv:1:5: expected the name of a variable of the scenario, "
                                   "as a, or id; found \"d\"");
    assert_header_refused("a,b,", "d.csv:1:5: expected the name of a variable");
    assert_header_refused("a,b,a", "d.csv:1:5: expected one column a, found a second");
    assert_header_refused("id,id,a,b", "d.csv:1:4: expected one column id, found a second");
    assert_header_refused("\"a,b\"", "d.csv:1:2: expected the name of a variable of the "
                                     "scenario, as a, or id; found \"a,b\"");
    assert_header_refused("0.5,0.25", "d.csv:1:1: expected the name of a variable");
    assert_header_refused("a;b", "d.csv:1:1: expected the name of a variable");
    assert_header_refused("\x1b[2Ja,b", "d.csv:1:1: expected the name of a variable of the "
                                        "scenario, as a, or id; found \"?[2Ja\"");
}

// The place is that of the value, in lines and bytes of the file, comments counted.
static void wrong_row_is_explained(void **state)
{
    (void)state;
    assert_rows_refused("a,b", "1,2\n3,x\n", "d.csv:3:3: b: expected a finite number, found \"x\"");
    assert_rows_refused("a,b", "# c\n\nnan,2\n", "d.csv:4:1: a: expected a finite number");
    assert_rows_refused("a,b", "inf,2\n", "d.csv:2:1: a: expected a finite number");
    assert_rows_refused("a,b", "1,\n", "d.csv:2:3: b: expected a finite number, found \"\"");
    assert_rows_refused("a,b", ",2\n", "d.csv:2:1: a: expected a finite number, found \"\"");
    assert_rows_refused("a,b", "1,\"2\n", "d.csv:2:3: expected a closing quote");
    assert_rows_refused("a,b", "1,2\n3",
                        "d.csv:3:2: expected 2 fields, as in the header, found 1: "
                        "the line is cut off, or a value is missing");
    assert_rows_refused("a,b", "1,2,3,4\n",
                        "d.csv:2:8: expected 2 fields, as in the header, "
                        "found 4");
    assert_rows_refused("id,a,b", "\"x,y\",1,2\n", "d.csv:2:2: id: expected a text without quotes");
    assert_rows_refused("a,b", "1,5,2,5\n", "d.csv:2:8: expected 2 fields");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_become_designs),
        cmocka_unit_test(line_ends_blanks_comments_and_quotes_do_not_matter),
        cmocka_unit_test(wrong_header_is_explained),
        cmocka_unit_test(wrong_row_is_explained),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
