// sobox-simulate: one design through the scenario's model. Prints its outcomes as JSON; of the
// crash model it writes the trajectory and compares it with a measured or finite-element motion.
#include "common/base/arithmetic.h"
#include "common/base/error.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/base/whole_file.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/scenario_read.h"
#include "common/table/decimal.h"
#include "worker/batch/batch.h"
#include "worker/kinematics/kinematics.h"
#include "worker/models/design.h"
#include "worker/models/model.h"
#include "worker/models/motion.h"
#include "worker/models/point.h"
#include "worker/models/small_overlap.h"

#include <glib.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char program_summary[] =
    "Simulates one design of a scenario and prints its outcomes as one JSON object, with\n"
    "\"good\", whether it meets all constraints, and \"violated\", those that it does not.";

static const char program_description[] =
    "A design file has the columns spring,branch,deformation_m,force_x_N,force_y_N; branch is "
    "load\n"
    "or unload. For models in closed form it has variable,value. A reference has time_s and any of "
    "x_m, y_m (place of the centre of gravity in the\n"
    "scenario's axes: forwards is -x) and yaw_rad; what is printed of it is the mean absolute "
    "error.\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input.";

struct options {
    char *design; // a file or a place of the design space
    char **set;
    char *trajectory;
    char *compare;
    char *load_case;
    gboolean version;
    char *scenario;
};

// What a simulated design left behind.
struct simulation {
    struct kinematics_problem *problem;
    double *outcomes; // (outcome)
    double *rows;     // (row x column) the trajectory
};

// ---- Options ----

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    // FILENAME takes the bytes as they come. STRING would convert them from the alphabet of the
    // locale, and programs that write the same numbers everywhere set none.
    const GOptionEntry entries[] = {
        {"design", 'd', 0, G_OPTION_ARG_FILENAME, &options->design,
         "Forces of a CSV file, or of the design space: centre, lower, upper (default: centre)",
         "FILE.csv|centre|lower|upper"},
        {"set", 's', 0, G_OPTION_ARG_FILENAME_ARRAY, &options->set,
         "Override a key of the scenario, for instance vehicle.mass=1800; may be repeated",
         "KEY.PATH=VALUE"},
        {"trajectory", 't', 0, G_OPTION_ARG_FILENAME, &options->trajectory,
         "Write the motion and the springs of every time step", "FILE.csv"},
        {"compare", 'c', 0, G_OPTION_ARG_FILENAME, &options->compare,
         "Print the mean absolute errors from this motion", "REF.csv"},
        {"case", 'l', 0, G_OPTION_ARG_FILENAME, &options->load_case,
         "Simulate this one of the scenario's cases (default: all of them)", "NAME"},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .argument = "SCENARIO.yaml",
        .summary = program_summary,
        .description = program_description,
        .entries = entries,
    };
    struct options_common common;
    const enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    options->scenario = common.argument;
    if (status == STATUS_OK && !options->version && options->scenario == NULL) {
        return error_set(error, STATUS_INVALID,
                         "no scenario: expected sobox-simulate SCENARIO.yaml (see --help)");
    }
    return status;
}

static void options_fini(struct options *options)
{
    g_free(options->design);
    g_strfreev(options->set);
    g_free(options->trajectory);
    g_free(options->compare);
    g_free(options->load_case);
    g_free(options->scenario);
}

// ---- Input ----

// Reads a whole file. A file that the user named and that cannot be read is invalid input.
static enum status read_text(const char *path, char **text, size_t *size, struct error *error)
{
    g_autoptr(GError) reason = NULL;
    if (!g_file_get_contents(path, text, size, &reason)) {
        return error_set(error, STATUS_INVALID, "%s: %s", path, reason->message);
    }
    return STATUS_OK;
}

static enum status read_scenario(const struct options *options, struct scenario *scenario,
                                 struct error *error)
{
    const size_t set_count = options->set != NULL ? g_strv_length(options->set) : 0;
    enum status status = scenario_read_file(scenario, options->scenario,
                                            (const char *const *)options->set, set_count, error);
    if (status == STATUS_IO) {
        error->status = status = STATUS_INVALID;
    }
    if (status == STATUS_OK) {
        plausibility_tell(scenario);
    }
    return status;
}

// Finds the case that was asked for, or the whole scenario.
static enum status choose_case(const struct options *options, const struct scenario *scenario,
                               const struct scenario **chosen, struct error *error)
{
    *chosen = scenario;
    if (options->load_case == NULL) {
        return STATUS_OK;
    }
    GString *names = g_string_new(NULL);
    for (uint32_t i = 0; i < scenario->case_count; i++) {
        if (strcmp(scenario->cases[i].name, options->load_case) == 0) {
            *chosen = &scenario->cases[i];
        }
        g_string_append_printf(names, "%s%s", i > 0 ? ", " : "", scenario->cases[i].name);
    }
    enum status status = STATUS_OK;
    if (scenario->case_count == 0) {
        status = error_set(error, STATUS_INVALID, "--case %s: %s has no cases", options->load_case,
                           options->scenario);
    } else if (*chosen == scenario) {
        status = error_set(error, STATUS_INVALID, "--case %s: expected one of %s",
                           options->load_case, names->str);
    }
    g_string_free(names, TRUE);
    return status;
}

// A motion is that of one crash.
static enum status check_motion(const struct options *options, const struct scenario *scenario,
                                struct error *error)
{
    const char *option = options->trajectory != NULL ? "--trajectory"
                         : options->compare != NULL  ? "--compare"
                                                     : NULL;
    if (option == NULL) {
        return STATUS_OK;
    }
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP) {
        return error_set(error, STATUS_INVALID,
                         "%s: model %s has no motion: expected a scenario of model small_overlap",
                         option, scenario_model_name(scenario->model));
    }
    if (scenario->case_count > 0) {
        return error_set(error, STATUS_INVALID,
                         "%s: the scenario has %u cases, each with its own motion: expected --case "
                         "NAME beside it",
                         option, scenario->case_count);
    }
    return STATUS_OK;
}

// Whether --design names a place of the design space; else it names a file.
static bool design_is_place(const char *wanted, enum design_place *place)
{
    static const char *const places[] = {
        [DESIGN_CENTRE] = "centre",
        [DESIGN_LOWER] = "lower",
        [DESIGN_UPPER] = "upper",
    };
    *place = DESIGN_CENTRE;
    for (size_t i = 0; wanted != NULL && i < G_N_ELEMENTS(places); i++) {
        if (strcmp(wanted, places[i]) == 0) {
            *place = (enum design_place)i;
            return true;
        }
    }
    return wanted == NULL;
}

static enum status read_design(const char *wanted, const struct scenario *scenario,
                               struct design *design, struct error *error)
{
    enum design_place place;
    if (design_is_place(wanted, &place)) {
        design_init_place(design, scenario, place);
        return STATUS_OK;
    }
    g_autofree char *text = NULL;
    size_t size;
    if (read_text(wanted, &text, &size, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    return design_parse(design, scenario, wanted, text, size, error);
}

static enum status read_point(const char *wanted, const struct scenario *scenario, double *values,
                              struct error *error)
{
    enum design_place place;
    if (design_is_place(wanted, &place)) {
        point_place(values, scenario, place);
        return STATUS_OK;
    }
    g_autofree char *text = NULL;
    size_t size;
    if (read_text(wanted, &text, &size, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    return point_parse(values, scenario, wanted, text, size, error);
}

// ---- The simulation ----

static void simulation_run(struct simulation *simulation, const struct scenario *scenario,
                           const struct design *design)
{
    struct kinematics_problem *problem =
        small_overlap_problem(scenario, design, (struct kinematics_omitted){0});
    const size_t columns = kinematics_column_count(problem);
    simulation->problem = problem;
    simulation->outcomes = g_new(double, kinematics_result_count(problem));
    simulation->rows = g_new(double, kinematics_row_count(problem) * columns);
    g_autofree double *values = g_new(double, kinematics_value_count(problem));
    small_overlap_values(design, values);
    kinematics_record(problem, values, simulation->outcomes, simulation->rows);
    small_overlap_outcomes(scenario->barrier.overlap, 1, simulation->outcomes, 1);
}

static void simulation_fini(struct simulation *simulation)
{
    kinematics_free(simulation->problem);
    g_free(simulation->outcomes);
    g_free(simulation->rows);
}

// ---- Output ----

static void append_number(GString *text, char separator, double number)
{
    char digits[DECIMAL_SIZE];
    g_string_append_c(text, separator);
    g_string_append(text, decimal_text(number, digits));
}

static GString *trajectory_text(const struct simulation *simulation,
                                const struct scenario *scenario)
{
    GString *text = g_string_new("time_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps");
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const char *name = scenario->springs[i].name;
        g_string_append_printf(text,
                               ",%s.length_m,%s.deformation_m,%s.force_x_N,%s.force_y_N,%s.contact",
                               name, name, name, name, name);
    }
    g_string_append_c(text, '\n');
    const uint32_t columns = kinematics_column_count(simulation->problem);
    const double *row = simulation->rows;
    for (uint32_t i = 0; i < kinematics_row_count(simulation->problem); i++, row += columns) {
        char digits[DECIMAL_SIZE];
        g_string_append(text, decimal_text(row[KINEMATICS_COLUMN_TIME], digits));
        for (uint32_t column = 1; column < columns; column++) {
            append_number(text, ',', row[column]);
        }
        g_string_append_c(text, '\n');
    }
    return text;
}

static enum status write_trajectory(const char *path, const struct simulation *simulation,
                                    const struct scenario *scenario, struct error *error)
{
    GString *text = trajectory_text(simulation, scenario);
    const enum status status = whole_file_write(path, text->str, text->len, error);
    g_string_free(text, TRUE);
    return status;
}

// A number as JSON; what is not finite has no number there.
static json_t *json_number(double number)
{
    return isfinite(number) ? json_real(number) : json_null();
}

// The names of the outcomes whose constraints are not met, each once.
static json_t *violated_names(const struct scenario *scenario, const double *outcomes)
{
    json_t *names = json_array();
    uint32_t violated[SCENARIO_CONSTRAINT_MAX];
    const uint32_t count = batch_violated(scenario, outcomes, violated);
    for (uint32_t i = 0; i < count; i++) {
        char name[SCENARIO_OUTCOME_NAME_SIZE];
        json_array_append_new(names,
                              json_string(scenario_outcome_name(scenario, violated[i], name)));
    }
    return names;
}

static json_t *motion_errors(const struct motion *motion, const struct simulation *simulation)
{
    static const enum kinematics_column columns[MOTION_QUANTITY_COUNT] = {
        [MOTION_X] = KINEMATICS_COLUMN_X,
        [MOTION_Y] = KINEMATICS_COLUMN_Y,
        [MOTION_YAW] = KINEMATICS_COLUMN_YAW,
    };
    json_t *errors = json_object();
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        const enum motion_quantity quantity = (enum motion_quantity)i;
        if (motion->value[quantity] == NULL) {
            continue;
        }
        const double error = motion_error(
            motion, quantity, simulation->rows + KINEMATICS_COLUMN_TIME,
            simulation->rows + columns[quantity], kinematics_row_count(simulation->problem),
            kinematics_column_count(simulation->problem));
        json_object_set_new(errors, motion_quantity_name(quantity), json_number(error));
    }
    return errors;
}

// Says of a crash whether the car turned so far that its springs had no projection on the barrier:
// from then on they gave no force, and what the model says of it is worth little.
static void set_turned(json_t *object, const struct scenario *crash, const char *prefix,
                       const double *outcomes)
{
    g_autofree char *name = g_strconcat(prefix, "yaw_beyond_90_deg", NULL);
    if (crash->model == SCENARIO_MODEL_SMALL_OVERLAP) {
        json_object_set_new(object, name,
                            json_boolean(small_overlap_turned(outcomes[OUTCOME_YAW_MAX_DEG])));
    }
}

static void set_all_turned(json_t *object, const struct scenario *scenario, const double *outcomes)
{
    if (scenario->case_count == 0) {
        set_turned(object, scenario, "", outcomes);
    }
    for (uint32_t i = 0; i < scenario->case_count; i++) {
        g_autofree char *prefix = g_strconcat(scenario->cases[i].name, ".", NULL);
        set_turned(object, &scenario->cases[i], prefix, outcomes);
        outcomes += scenario_outcome_count(&scenario->cases[i]);
    }
}

// What is not plausible about the scenario.
static json_t *warnings(const struct scenario *scenario)
{
    json_t *texts = json_array();
    for (uint32_t i = 0; i < scenario->finding_count; i++) {
        json_array_append_new(texts, json_string(scenario->findings[i].text));
    }
    return texts;
}

// Prints everything as one object. `errors`, which is taken, may be NULL.
static enum status print_outcomes(const struct scenario *scenario, const double *outcomes,
                                  json_t *errors, struct error *error)
{
    json_t *object = json_object();
    for (uint32_t i = 0; i < scenario_outcome_count(scenario); i++) {
        char name[SCENARIO_OUTCOME_NAME_SIZE];
        json_object_set_new(object, scenario_outcome_name(scenario, i, name),
                            json_number(outcomes[i]));
    }
    set_all_turned(object, scenario, outcomes);
    const struct verdict verdict = batch_verdict(scenario, outcomes, 1);
    json_object_set_new(object, "good", json_boolean(verdict.violation == VERDICT_GOOD));
    json_object_set_new(object, "violated", violated_names(scenario, outcomes));
    json_object_set_new(object, "warnings", warnings(scenario));
    if (errors != NULL) {
        json_object_set_new(object, "mean_absolute_error", errors);
    }
    const bool printed = json_dumpf(object, stdout, JSON_INDENT(2)) == 0 && putchar('\n') != EOF &&
                         fflush(stdout) == 0;
    json_decref(object);
    if (!printed) {
        return error_set(error, STATUS_IO, "standard output: writing failed");
    }
    return STATUS_OK;
}

// ---- One crash ----

// `motion` has count 0 where there is nothing to compare with.
static enum status report(const struct options *options, const struct scenario *scenario,
                          const struct design *design, const struct motion *motion,
                          struct error *error)
{
    struct simulation simulation = {0};
    simulation_run(&simulation, scenario, design);
    enum status status = STATUS_OK;
    if (options->trajectory != NULL) {
        status = write_trajectory(options->trajectory, &simulation, scenario, error);
    }
    if (status == STATUS_OK) {
        json_t *errors = motion->count > 0 ? motion_errors(motion, &simulation) : NULL;
        status = print_outcomes(scenario, simulation.outcomes, errors, error);
    }
    simulation_fini(&simulation);
    return status;
}

static enum status simulate_crash(const struct options *options, const struct scenario *scenario,
                                  const struct design *design, struct error *error)
{
    struct motion motion = {0};
    enum status status = STATUS_OK;
    if (options->compare != NULL) {
        g_autofree char *text = NULL;
        size_t size;
        status = read_text(options->compare, &text, &size, error);
        if (status == STATUS_OK) {
            status = motion_parse(&motion, scenario->simulation.duration, options->compare, text,
                                  size, error);
        }
    }
    if (status == STATUS_OK) {
        status = report(options, scenario, design, &motion, error);
    }
    motion_fini(&motion);
    return status;
}

// ---- Several crashes, formulas ----

// The same curves in every case.
static enum status simulate_cases(const struct scenario *scenario, const struct design *design,
                                  struct error *error)
{
    g_autofree double *outcomes = g_new(double, scenario_outcome_count(scenario));
    double *outcome = outcomes;
    for (uint32_t i = 0; i < scenario->case_count; i++) {
        const uint32_t count = scenario_outcome_count(&scenario->cases[i]);
        struct simulation simulation = {0};
        simulation_run(&simulation, &scenario->cases[i], design);
        memcpy(outcome, simulation.outcomes, count * sizeof *outcome);
        outcome += count;
        simulation_fini(&simulation);
    }
    return print_outcomes(scenario, outcomes, NULL, error);
}

static enum status simulate_formula(const struct options *options, const struct scenario *scenario,
                                    struct error *error)
{
    struct model *model = model_create(scenario);
    g_autofree double *point = g_new(double, model_variable_count(model));
    g_autofree double *values = g_new(double, (size_t)model_variable_count(model) * MODEL_BLOCK);
    g_autofree double *rows = g_new(double, (size_t)model_outcome_count(model) * MODEL_BLOCK);
    g_autofree double *outcomes = g_new(double, model_outcome_count(model));
    enum status status = read_point(options->design, scenario, point, error);
    if (status == STATUS_OK) {
        for (uint32_t i = 0; i < model_variable_count(model); i++) {
            values[(size_t)i * MODEL_BLOCK] = point[i];
        }
        model_evaluate(model, 1, values, rows);
        for (uint32_t i = 0; i < model_outcome_count(model); i++) {
            outcomes[i] = rows[(size_t)i * MODEL_BLOCK];
        }
        status = print_outcomes(scenario, outcomes, NULL, error);
    }
    model_free(model);
    return status;
}

// ---- The program ----

static enum status simulate_scenario(const struct options *options, const struct scenario *scenario,
                                     struct error *error)
{
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP) {
        return simulate_formula(options, scenario, error);
    }
    struct design design = {0};
    enum status status = read_design(options->design, scenario, &design, error);
    if (status == STATUS_OK) {
        status = scenario->case_count > 0 ? simulate_cases(scenario, &design, error)
                                          : simulate_crash(options, scenario, &design, error);
    }
    design_fini(&design);
    return status;
}

static enum status simulate(const struct options *options, struct error *error)
{
    struct scenario scenario = {0};
    const struct scenario *chosen = NULL;
    enum status status = read_scenario(options, &scenario, error);
    if (status == STATUS_OK) {
        status = choose_case(options, &scenario, &chosen, error);
    }
    if (status == STATUS_OK) {
        status = check_motion(options, chosen, error);
    }
    if (status == STATUS_OK) {
        status = simulate_scenario(options, chosen, error);
    }
    scenario_fini(&scenario);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
    arithmetic_start();
    struct options options = {0};
    struct error error = {0};
    log_start("sobox-simulate", LOG_NORMAL);
    enum status status = options_parse(&options, argc, argv, &error);
    if (status != STATUS_OK) {
        log_error("%s", error.text);
    } else if (options.version) {
        printf("sobox-simulate %s\n", SOBOX_VERSION);
    } else if ((status = simulate(&options, &error)) != STATUS_OK) {
        log_failure(&error);
    }
    options_fini(&options);
    return (int)status_exit(status);
}
