#include "common/scenario/field.h"

#include "common/scenario/scenario.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

// A table as a reader writes it, with one field of each kind.
struct car {
    char name[SCENARIO_NAME_SIZE];
    char plate[SCENARIO_NAME_SIZE];
    double mass;
    double size[2];
    uint32_t doors;
    uint64_t mileage;
    int colour;
    const struct tree_node *radio;
};

static const char *const colours[] = {"red", "green", "blue", NULL};

#define AT(member) .offset = offsetof(struct car, member)
static const struct field car_fields[] = {
    {"name", FIELD_NAME, .optional = true, AT(name)},
    {"plate", FIELD_IDENTIFIER, .optional = true, AT(plate)},
    {"mass", FIELD_NUMBER, AT(mass), .range = FIELD_POSITIVE, .unit = "kg"},
    {"size", FIELD_NUMBER_PAIR, .optional = true, AT(size), .range = FIELD_NOT_NEGATIVE},
    {"doors", FIELD_COUNT, .optional = true, AT(doors), .range = FIELD_FROM_TO(2, 5)},
    {"mileage", FIELD_COUNT_64, .optional = true, AT(mileage),
     .range = FIELD_FROM_TO(0, FIELD_COUNT_MAX)},
    {"colour", FIELD_WORD, .optional = true, AT(colour), .words = colours},
    {"radio", FIELD_NODE, .optional = true, AT(radio)},
};

// Reads the text into `car`; returns the message, or "" when there was none. The radio's node goes
// with the tree, so only its presence is of use.
static const char *read_car(const char *text, struct car *car)
{
    static struct error error;
    error = (struct error){0};
    struct tree *tree = tree_parse("t", text, strlen(text), &error);
    if (tree == NULL)
        fail_msg("%s", error.text);
    bool read = field_read(tree_root(tree), car_fields, G_N_ELEMENTS(car_fields), car, &error);
    assert_int_equal(read, error.status == STATUS_OK);
    tree_free(tree);
    return error.text;
}

static void assert_told(const char *text, const char *message)
{
    struct car car = {0};
    assert_string_equal(read_car(text, &car), message);
}

// Each kind lands at its offset in its type; what is absent is left alone.
static void fields_fill_the_struct(void **state)
{
    (void)state;
    struct car car = {.doors = 4, .colour = 1};
    assert_string_equal(read_car("{name: my car, plate: AB-12_3, mass: 1.2e3, size: [4, 1.8], "
                                 "mileage: 9007199254740991, colour: blue, radio: [1]}",
                                 &car),
                        "");
    assert_string_equal(car.name, "my car");
    assert_string_equal(car.plate, "AB-12_3");
    assert_true(car.mass == 1200 && car.size[0] == 4 && car.size[1] == 1.8);
    assert_true(car.mileage == UINT64_C(9007199254740991));
    assert_int_equal(car.colour, 2);
    assert_non_null(car.radio);

    struct car other = {.doors = 4, .colour = 1};
    assert_string_equal(read_car("{mass: 1}", &other), "");
    assert_int_equal(other.doors, 4);
    assert_int_equal(other.colour, 1);
    assert_null(other.radio);
}

// The grammar of numbers is ours, not strtod's, and does not depend on the locale.
static void numbers_follow_one_grammar(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } numbers[] = {{"1", 1},     {"+1", 1},      {"01", 1},       {"1.", 1},     {".5", 0.5},
                   {"1e3", 1e3}, {"1E+3", 1000}, {"2.5e-1", .25}, {"1e15", 1e15}};
    for (size_t i = 0; i < G_N_ELEMENTS(numbers); i++) {
        char text[64];
        struct car car = {0};
        g_snprintf(text, sizeof text, "{mass: %s}", numbers[i].text);
        assert_string_equal(read_car(text, &car), "");
        assert_true(car.mass == numbers[i].value);
    }
    static const char *const others[] = {"0x1p3", "1_000", "1e",       "e1",  "--1", "1e+",
                                         ".",     "1.2.3", "infinity", "1d3", "'1'"};
    for (size_t i = 0; i < G_N_ELEMENTS(others); i++) {
        char text[64], message[128];
        g_snprintf(text, sizeof text, "{mass: %s}", others[i]);
        g_snprintf(message, sizeof message, "t:1:8: mass: expected a number (in kg), found %s",
                   others[i]);
        assert_told(text, message);
    }
}

// Counts may be written as numbers, but are whole, and exact to the last unit.
static void counts_are_whole(void **state)
{
    (void)state;
    struct car car = {0};
    assert_string_equal(read_car("{mass: 1, mileage: 20e3, doors: 5.0}", &car), "");
    assert_true(car.mileage == 20000 && car.doors == 5);
    assert_told("{mass: 1, doors: 2.5}",
                "t:1:18: doors: expected a whole number, 2 to 5, found 2.5");
    assert_told("{mass: 1, doors: 6}", "t:1:18: doors: expected a whole number, 2 to 5, found 6");
    assert_told("{mass: 1, doors: 1e400}",
                "t:1:18: doors: expected a whole number, 2 to 5, found 1e400");
    assert_told("{mass: 1, mileage: 9007199254740992}",
                "t:1:20: mileage: expected a whole number, 0 to 9007199254740991, found "
                "9007199254740992");
}

// The nearest key is suggested when it is near, else all are listed; a wrong key is told before a
// missing one, since it is usually its cause.
static void unknown_keys_come_with_help(void **state)
{
    (void)state;
    assert_told("{mas: 1}", "t:1:2: unknown key 'mas'; did you mean 'mass'?");
    assert_told("{mass: 1, color: red}", "t:1:11: unknown key 'color'; did you mean 'colour'?");
    assert_told("{mass: 1, 'm': 2}",
                "t:1:11: unknown key 'm'; expected one of name, plate, mass, size, doors, "
                "mileage, colour, radio");
    assert_told("{doors: 3}", "t:1:1: missing key 'mass': expected more than 0 kg");
    assert_told("[1]", "t:1:1: expected a mapping, found a list of 1");
}

// A number may stand for a whole list; a list has the right length or is refused.
static void a_number_stands_for_all(void **state)
{
    (void)state;
    static const struct field_range any = FIELD_ANY;
    double numbers[3] = {0};
    struct error error = {0};
    struct tree *tree = tree_parse("t", "[7, [1, 2, 3], [1, 2], {a: 1}]", 30, &error);
    struct tree_node **items = tree_root(tree)->items;
    assert_true(field_read_numbers(items[0], &any, "N", numbers, 3, &error));
    assert_true(numbers[0] == 7 && numbers[1] == 7 && numbers[2] == 7);
    assert_true(field_read_numbers(items[1], &any, "N", numbers, 3, &error));
    assert_true(numbers[0] == 1 && numbers[1] == 2 && numbers[2] == 3);
    assert_false(field_read_numbers(items[2], &any, "N", numbers, 3, &error));
    assert_string_equal(error.text,
                        "t:1:16: 2: expected a number or a list of 3, found a list of 2");
    assert_false(field_read_numbers(items[3], &any, NULL, numbers, 3, &error));
    assert_string_equal(error.text,
                        "t:1:24: 3: expected a number or a list of numbers, found a mapping");
    tree_free(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_fill_the_struct),  cmocka_unit_test(numbers_follow_one_grammar),
        cmocka_unit_test(counts_are_whole),        cmocka_unit_test(unknown_keys_come_with_help),
        cmocka_unit_test(a_number_stands_for_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
