#include "common/scenario/formula_read.h"

#include "common/scenario/constraint.h"
#include "common/scenario/field.h"
#include "common/scenario/formula.h"

#include <assert.h>
#include <glib.h>
#include <stdio.h>
#include <string.h>

#define AT(structure, member) .offset = offsetof(struct structure, member)

// ------------------------------------------------------------------------------------------------
// Variables

struct variable_document {
    char name[SCENARIO_NAME_SIZE];
    double lower;
    double upper;
};

static const struct field variable_fields[] = {
    {"name", FIELD_IDENTIFIER, AT(variable_document, name)},
    {"lower", FIELD_NUMBER, AT(variable_document, lower), .range = FIELD_ANY},
    {"upper", FIELD_NUMBER, AT(variable_document, upper), .range = FIELD_ANY},
};

// `names` gives the index + 1 of each variable so far.
static bool read_variable(const struct tree_node *node, uint32_t index, GHashTable *names,
                          struct scenario *scenario, struct error *error)
{
    struct variable_document document = {0};
    if (!field_read(node, variable_fields, G_N_ELEMENTS(variable_fields), &document, error))
        return false;
    if (document.lower > document.upper) {
        tree_error(tree_child(node, "upper"), error,
                   "expected at least the lower bound of %.15g, found %.15g", document.lower,
                   document.upper);
        return false;
    }
    struct scenario_variable *variable = &scenario->variables[index];
    *variable = (struct scenario_variable){.spring = SCENARIO_NO_SPRING};
    g_strlcpy(variable->name, document.name, sizeof variable->name);
    scenario->design_space.lower[index] = document.lower;
    scenario->design_space.upper[index] = document.upper;
    if (g_hash_table_insert(names, variable->name, GUINT_TO_POINTER(index + 1)))
        return true;
    tree_error(tree_child(node, "name"), error,
               "expected a name that no other variable has, found %s a second time", document.name);
    return false;
}

static bool read_variables(const struct tree_node *node, GHashTable *names,
                           struct scenario *scenario, struct error *error)
{
    if (node->kind != TREE_SEQUENCE || node->count < 1 || node->count > SCENARIO_VARIABLE_MAX) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(node, error,
                   "expected a list of 1 to %d variables with name, lower and upper, found %s",
                   SCENARIO_VARIABLE_MAX, tree_shown(node, shown));
        return false;
    }
    box_init(&scenario->design_space, node->count);
    scenario->variables = g_new0(struct scenario_variable, node->count);
    curve_map_init(&scenario->curves, node->count);
    for (uint32_t i = 0; i < node->count; i++) {
        if (!read_variable(node->items[i], i, names, scenario, error))
            return false;
    }
    if (box_free_count(&scenario->design_space) > 0)
        return true;
    tree_error(node, error,
               "every variable is fixed: expected at least one with its lower bound below its "
               "upper");
    return false;
}

// ------------------------------------------------------------------------------------------------
// Parameters

// What a formula is read from.
struct reader {
    struct scenario *scenario;
    const struct tree_node *variables;
    const struct tree_node *parameters; // a mapping, or NULL
    const struct tree_node *spot;       // to point at when a parameter is missing
    GHashTable *names;                  // variable -> index + 1
    struct error *error;
};

static uint32_t variable_index(const struct reader *reader, const char *name)
{
    uint32_t index = GPOINTER_TO_UINT(g_hash_table_lookup(reader->names, name));
    return index > 0 ? index - 1 : SCENARIO_CONSTANT;
}

// The parameter of that key; NULL when it is not given.
static const struct tree_node *parameter(const struct reader *reader, const char *key)
{
    return reader->parameters != NULL ? tree_child(reader->parameters, key) : NULL;
}

static bool missing(const struct reader *reader, const char *key, const char *expected)
{
    tree_error(reader->spot, reader->error, "missing %s '%s': expected %s",
               reader->parameters != NULL ? "key" : "parameter", key, expected);
    return false;
}

static const struct tree_node *required(const struct reader *reader, const char *key,
                                        const char *expected)
{
    const struct tree_node *node = parameter(reader, key);
    if (node == NULL)
        missing(reader, key, expected);
    return node;
}

static bool read_number(const struct reader *reader, const struct tree_node *node,
                        struct field_range range, const char *unit, double *number)
{
    const struct field field = {.kind = FIELD_NUMBER, .range = range, .unit = unit};
    return field_read_value(node, &field, number, reader->error);
}

// A scalar that a formula takes from a variable or from a parameter.
struct input {
    const char *name;
    struct field_range range; // of the parameter; a variable may take what its bounds allow
    const char *unit;         // NULL where it has none
};

// Adds an input to the formula.
static bool read_input(struct reader *reader, const struct input *input)
{
    struct scenario_formula *formula = &reader->scenario->formula;
    struct scenario_input *to = &formula->inputs[formula->input_count++];
    const struct tree_node *node = parameter(reader, input->name);
    to->variable = variable_index(reader, input->name);
    if (to->variable != SCENARIO_CONSTANT && node != NULL) {
        tree_error(node, reader->error,
                   "expected a variable or a parameter: there is a variable %s too", input->name);
        return false;
    }
    if (to->variable != SCENARIO_CONSTANT)
        return true;
    if (node != NULL)
        return read_number(reader, node, input->range, input->unit, &to->value);
    char expected[128];
    snprintf(expected, sizeof expected, "a number%s%s, or a variable of that name",
             input->unit != NULL ? " in " : "", input->unit != NULL ? input->unit : "");
    return missing(reader, input->name, expected);
}

// Adds inputs to the formula, which gets room for `count_max`.
static bool read_inputs(struct reader *reader, const struct input *inputs, uint32_t count,
                        uint32_t count_max)
{
    reader->scenario->formula.inputs = g_new0(struct scenario_input, count_max);
    for (uint32_t i = 0; i < count; i++) {
        if (!read_input(reader, &inputs[i]))
            return false;
    }
    return true;
}

// Adds every variable that is not an input of another name yet, in the order of the file. Returns
// how many.
static uint32_t add_other_variables(struct reader *reader)
{
    struct scenario_formula *formula = &reader->scenario->formula;
    const uint32_t named = formula->input_count;
    for (uint32_t i = 0; i < reader->scenario->design_space.count; i++) {
        uint32_t at = 0;
        while (at < named && formula->inputs[at].variable != i)
            at++;
        if (at == named)
            formula->inputs[formula->input_count++] = (struct scenario_input){.variable = i};
    }
    return formula->input_count - named;
}

// Every variable must be an input that the formula knows by name.
static bool refuse_unknown_variables(const struct reader *reader, const struct input *inputs,
                                     uint32_t count)
{
    const char **known = g_new0(const char *, count + 1);
    for (uint32_t i = 0; i < count; i++)
        known[i] = inputs[i].name;
    bool accepted = true;
    for (uint32_t i = 0; i < reader->scenario->design_space.count && accepted; i++) {
        if (!g_strv_contains(known, reader->scenario->variables[i].name))
            accepted = field_unknown_key(tree_child(reader->variables->items[i], "name"),
                                         "variable", known, reader->error);
    }
    g_free(known);
    return accepted;
}

// Every parameter must be an input or one of `others` (ends with NULL).
static bool refuse_unknown_parameters(const struct reader *reader, const struct input *inputs,
                                      uint32_t count, const char *const *others)
{
    GPtrArray *known = g_ptr_array_new();
    for (uint32_t i = 0; i < count; i++)
        g_ptr_array_add(known, (gpointer)inputs[i].name);
    for (; *others != NULL; others++)
        g_ptr_array_add(known, (gpointer)*others);
    g_ptr_array_add(known, NULL);
    const char *const *keys = (const char *const *)known->pdata;
    bool accepted = true;
    for (uint32_t i = 0; reader->parameters != NULL && i < reader->parameters->count; i++) {
        const struct tree_node *key = reader->parameters->keys[i];
        if (g_strv_contains(keys, key->text))
            continue;
        if (keys[0] != NULL)
            field_unknown_key(key, "parameter", keys, reader->error);
        else
            tree_error(key, reader->error, "unknown parameter '%s': model %s has none", key->text,
                       scenario_model_name(reader->scenario->model));
        accepted = false;
        break;
    }
    g_ptr_array_unref(known);
    return accepted;
}

// Adds a list of `count_min` to `count_max` numbers to the formula's constants.
static bool read_list(struct reader *reader, const char *key, uint32_t count_min,
                      uint32_t count_max, struct field_range range, const char *unit)
{
    char expected[128], shown[TREE_SHOWN_SIZE];
    struct scenario_formula *formula = &reader->scenario->formula;
    if (count_min == count_max)
        snprintf(expected, sizeof expected, "a list of %u numbers", count_min);
    else
        snprintf(expected, sizeof expected, "a list of %u to %u numbers", count_min, count_max);
    const struct tree_node *node = required(reader, key, expected);
    if (node == NULL)
        return false;
    if (node->kind != TREE_SEQUENCE || node->count < count_min || node->count > count_max) {
        tree_error(node, reader->error, "expected %s, found %s", expected, tree_shown(node, shown));
        return false;
    }
    formula->constants = g_renew(double, formula->constants, formula->constant_count + node->count);
    double *numbers = formula->constants + formula->constant_count;
    formula->constant_count += node->count;
    return field_read_numbers(node, &range, unit, numbers, node->count, reader->error);
}

// ------------------------------------------------------------------------------------------------
// Formulas

static const struct field_range any_number = FIELD_ANY;
static const struct field_range positive = FIELD_POSITIVE;
static const struct field_range not_negative = FIELD_NOT_NEGATIVE;

static const char *const no_parameters[] = {NULL};

static bool read_hypersphere(struct reader *reader)
{
    if (!refuse_unknown_parameters(reader, NULL, 0, no_parameters) ||
        !read_inputs(reader, NULL, 0, reader->scenario->design_space.count))
        return false;
    add_other_variables(reader);
    return true;
}

static bool read_rosenbrock(struct reader *reader)
{
    if (!read_hypersphere(reader))
        return false;
    if (reader->scenario->formula.input_count >= 2)
        return true;
    tree_error(reader->variables, reader->error, "expected at least 2 variables, found 1");
    return false;
}

static bool read_angle(struct reader *reader)
{
    static const struct field_range turn = FIELD_FROM_TO(-360, 360);
    struct scenario_formula *formula = &reader->scenario->formula;
    const struct tree_node *node = required(reader, "angle", "a number in degrees");
    formula->constants = g_renew(double, formula->constants, formula->constant_count + 1);
    return node != NULL && read_number(reader, node, turn, "degrees",
                                       &formula->constants[formula->constant_count++]);
}

static bool read_ellipse(struct reader *reader)
{
    static const struct input inputs[FORMULA_ELLIPSE_INPUT_COUNT] = {
        [FORMULA_ELLIPSE_X] = {"x", FIELD_ANY, NULL},
        [FORMULA_ELLIPSE_Y] = {"y", FIELD_ANY, NULL},
    };
    static const char *const others[] = {"center", "semi_axes", "angle", NULL};
    const uint32_t count = FORMULA_ELLIPSE_INPUT_COUNT;
    return refuse_unknown_variables(reader, inputs, count) &&
           refuse_unknown_parameters(reader, inputs, count, others) &&
           read_inputs(reader, inputs, count, count) &&
           read_list(reader, "center", 2, 2, any_number, NULL) &&
           read_list(reader, "semi_axes", 2, 2, positive, NULL) && read_angle(reader);
}

static bool read_row(struct reader *reader, const struct tree_node *node, double *row,
                     uint32_t columns)
{
    char shown[TREE_SHOWN_SIZE];
    if (node->kind == TREE_SEQUENCE && node->count == columns)
        return field_read_numbers(node, &any_number, NULL, row, columns, reader->error);
    tree_error(node, reader->error, "expected a list of %u numbers, one a variable, found %s",
               columns, tree_shown(node, shown));
    return false;
}

static bool read_matrix(struct reader *reader)
{
    char expected[128], shown[TREE_SHOWN_SIZE];
    struct scenario_formula *formula = &reader->scenario->formula;
    const uint32_t columns = formula->input_count;
    snprintf(expected, sizeof expected, "a list of 1 to %d rows, each a list of %u numbers",
             SCENARIO_ROW_MAX, columns);
    const struct tree_node *node = required(reader, "matrix", expected);
    if (node == NULL)
        return false;
    if (node->kind != TREE_SEQUENCE || node->count < 1 || node->count > SCENARIO_ROW_MAX) {
        tree_error(node, reader->error, "expected %s, found %s", expected, tree_shown(node, shown));
        return false;
    }
    formula->rows = node->count;
    formula->constant_count = node->count * columns;
    formula->constants = g_new0(double, formula->constant_count);
    for (uint32_t row = 0; row < node->count; row++) {
        if (!read_row(reader, node->items[row], formula->constants + row * columns, columns))
            return false;
    }
    return true;
}

static bool read_linear(struct reader *reader)
{
    static const char *const others[] = {"matrix", NULL};
    if (!refuse_unknown_parameters(reader, NULL, 0, others) ||
        !read_inputs(reader, NULL, 0, reader->scenario->design_space.count))
        return false;
    add_other_variables(reader);
    return read_matrix(reader);
}

static bool read_two_section_crash(struct reader *reader)
{
    static const struct input inputs[FORMULA_TWO_SECTION_INPUT_COUNT] = {
        [FORMULA_TWO_SECTION_F1] = {"F1", FIELD_ANY, "N"},
        [FORMULA_TWO_SECTION_F2] = {"F2", FIELD_ANY, "N"},
        [FORMULA_TWO_SECTION_MASS] = {"mass", FIELD_POSITIVE, "kg"},
        [FORMULA_TWO_SECTION_D1] = {"d1", FIELD_NOT_NEGATIVE, "m"},
        [FORMULA_TWO_SECTION_D2] = {"d2", FIELD_NOT_NEGATIVE, "m"},
        [FORMULA_TWO_SECTION_SPEED] = {"speed", FIELD_NOT_NEGATIVE, "m/s"},
    };
    const uint32_t count = FORMULA_TWO_SECTION_INPUT_COUNT;
    return refuse_unknown_variables(reader, inputs, count) &&
           refuse_unknown_parameters(reader, inputs, count, no_parameters) &&
           read_inputs(reader, inputs, count, count);
}

// A limit among the parameters is a constraint on an outcome.
static bool read_limit(struct reader *reader, const char *key, const char *unit, uint32_t outcome)
{
    const struct tree_node *node = parameter(reader, key);
    double limit;
    if (node == NULL)
        return true;
    if (!read_number(reader, node, positive, unit, &limit))
        return false;
    constraint_add(reader->scenario, outcome, -INFINITY, limit);
    return true;
}

// The inputs of an ordered crash with `sections`. The caller frees them and their names.
static struct input *ordered_inputs(uint32_t sections, char (**names)[16])
{
    struct input *inputs = g_new0(struct input, FORMULA_ORDERED_FORCE + sections);
    *names = g_malloc_n(sections, sizeof **names);
    inputs[FORMULA_ORDERED_MASS] = (struct input){"mass", positive, "kg"};
    inputs[FORMULA_ORDERED_SPEED] = (struct input){"speed", not_negative, "m/s"};
    for (uint32_t i = 0; i < sections; i++) {
        snprintf((*names)[i], sizeof **names, "F_%u", i + 1);
        inputs[FORMULA_ORDERED_FORCE + i] = (struct input){(*names)[i], any_number, "N"};
    }
    return inputs;
}

static bool read_ordered_crash(struct reader *reader)
{
    static const char *const others[] = {"lengths", "decel_limit", NULL};
    if (!read_list(reader, "lengths", 2, SCENARIO_VARIABLE_MAX, positive, "m"))
        return false;
    const uint32_t count = FORMULA_ORDERED_FORCE + reader->scenario->formula.constant_count;
    char(*names)[16];
    struct input *inputs = ordered_inputs(count - FORMULA_ORDERED_FORCE, &names);
    bool read = refuse_unknown_variables(reader, inputs, count) &&
                refuse_unknown_parameters(reader, inputs, count, others) &&
                read_inputs(reader, inputs, count, count) &&
                read_limit(reader, "decel_limit", "m/s2", FORMULA_ORDERED_DECEL_MAX);
    g_free(inputs);
    g_free(names);
    return read;
}

// The points of a path, and the forces: all variables that are no other input.
static bool read_paths(struct reader *reader)
{
    static const struct field points = {.kind = FIELD_COUNT,
                                        .range = FIELD_FROM_TO(2, SCENARIO_VARIABLE_MAX)};
    struct scenario_formula *formula = &reader->scenario->formula;
    const struct tree_node *node = required(reader, "points", "the points of a path's curve");
    if (node == NULL || !field_read_value(node, &points, &formula->rows, reader->error))
        return false;
    const uint32_t forces = add_other_variables(reader);
    if (forces > 0 && forces % formula->rows == 0)
        return true;
    tree_error(reader->variables, reader->error,
               "expected a force for each of %u points of each path, path by path, found %u forces",
               formula->rows, forces);
    return false;
}

static bool read_corridor_crash(struct reader *reader)
{
    static const struct input inputs[FORMULA_CORRIDOR_FORCE] = {
        [FORMULA_CORRIDOR_LENGTH] = {"length", FIELD_POSITIVE, "m"},
        [FORMULA_CORRIDOR_ENERGY] = {"energy", FIELD_NOT_NEGATIVE, "J"},
    };
    static const char *const others[] = {"points", "force_limit", NULL};
    const uint32_t count = FORMULA_CORRIDOR_FORCE;
    return refuse_unknown_parameters(reader, inputs, count, others) &&
           read_inputs(reader, inputs, count, count + reader->scenario->design_space.count) &&
           read_paths(reader) && read_limit(reader, "force_limit", "N", FORMULA_CORRIDOR_FORCE_MAX);
}

static bool read_model(struct reader *reader)
{
    switch (reader->scenario->model) {
    case SCENARIO_MODEL_HYPERSPHERE:
        return read_hypersphere(reader);
    case SCENARIO_MODEL_ELLIPSE:
        return read_ellipse(reader);
    case SCENARIO_MODEL_LINEAR:
        return read_linear(reader);
    case SCENARIO_MODEL_ROSENBROCK:
        return read_rosenbrock(reader);
    case SCENARIO_MODEL_TWO_SECTION_CRASH:
        return read_two_section_crash(reader);
    case SCENARIO_MODEL_ORDERED_CRASH:
        return read_ordered_crash(reader);
    case SCENARIO_MODEL_CORRIDOR_CRASH:
        return read_corridor_crash(reader);
    case SCENARIO_MODEL_SMALL_OVERLAP:
    case SCENARIO_MODEL_COUNT:
        break;
    }
    assert(!"a model in closed form");
    return false;
}

bool formula_read(const struct formula_document *document, struct scenario *scenario,
                  struct error *error)
{
    const struct tree_node *parameters = document->parameters;
    if (parameters != NULL && parameters->kind != TREE_MAPPING) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(parameters, error,
                   "expected a mapping with the parameters of model %s, found %s",
                   scenario_model_name(scenario->model), tree_shown(parameters, shown));
        return false;
    }
    struct reader reader = {
        .scenario = scenario,
        .variables = document->variables,
        .parameters = parameters,
        .spot = parameters != NULL ? parameters : document->root,
        .names = g_hash_table_new(g_str_hash, g_str_equal),
        .error = error,
    };
    bool read =
        read_variables(document->variables, reader.names, scenario, error) && read_model(&reader);
    g_hash_table_unref(reader.names);
    return read;
}
