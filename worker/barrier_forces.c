// sobox-barrier-forces: from the forces on a barrier's nodes and the motion of the vehicle to each
// spring's force-deformation curve, as a design for sobox-simulate. The thinking is done in
// worker/reduction; here are options and files.
#include "common/base/arithmetic.h"
#include "common/base/error.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/base/whole_file.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/scenario_read.h"
#include "common/table/csv.h"
#include "worker/components/component.h"
#include "worker/components/group.h"
#include "worker/reduction/doubts.h"
#include "worker/reduction/reduction.h"

#include <errno.h>
#include <glib.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// Text that is read at once; no line may be longer. [bytes]
enum { PIECE_SIZE = 1 << 20 };

// A gap so many times the usual one between two times is worth a note.
static const double gap_noted = 3.0;

static const char program_summary[] =
    "Turns the forces on a barrier's nodes into the force-deformation curves of a scenario's\n"
    "springs: a design for sobox-simulate. Prints what was made of them as one JSON object.";

static const char program_description[] =
    "Forces have the columns time_s,node,y_m,z_m,normal_x_N,normal_y_N,shear_x_N,shear_y_N, "
    "sorted\n"
    "by time; the motion has time_s,x_m,y_m,yaw_rad of the centre of gravity. Both are in the\n"
    "scenario's axes: forwards is -x. Springs that share y need their height (m above the road) "
    "in\n"
    "the scenario.\n"
    "\n"
    "Forces and motion are held against each other (\"balance\", \"doubts\"); what contradicts\n"
    "the mass and the motion beyond all meaning is an error.\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input.";

struct options {
    char *forces; // "-": standard input
    char *motion;
    char *output;
    char *components; // NULL: patches end half-way between springs
    char **set;
    gboolean version;
    char *scenario;
};

// ---- Options ----

static enum status options_check(const struct options *options, struct error *error)
{
    if (options->version) {
        return STATUS_OK;
    }
    if (options->scenario == NULL) {
        return error_set(error, STATUS_INVALID,
                         "no scenario: expected sobox-barrier-forces SCENARIO.yaml (see --help)");
    }
    const char *missing = options->forces == NULL   ? "--forces FORCES.csv"
                          : options->motion == NULL ? "--motion MOTION.csv"
                          : options->output == NULL ? "--output DESIGN.csv"
                                                    : NULL;
    if (missing != NULL) {
        return error_set(error, STATUS_INVALID, "expected %s (see --help)", missing);
    }
    return STATUS_OK;
}

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    const GOptionEntry entries[] = {
        {"forces", 'f', 0, G_OPTION_ARG_FILENAME, &options->forces,
         "The nodes' forces over time; - reads standard input", "FORCES.csv"},
        {"motion", 'm', 0, G_OPTION_ARG_FILENAME, &options->motion,
         "The motion of the centre of gravity", "MOTION.csv"},
        {"output", 'o', 0, G_OPTION_ARG_FILENAME, &options->output, "Where to write the design",
         "DESIGN.csv"},
        {"components", 'c', 0, G_OPTION_ARG_FILENAME, &options->components,
         "The boxes of the springs' components, as sobox-springs takes them", "COMPONENTS.csv"},
        {"set", 's', 0, G_OPTION_ARG_FILENAME_ARRAY, &options->set,
         "Override a key of the scenario, for instance springs.0.height=0.4; may be repeated",
         "KEY.PATH=VALUE"},
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
    return status == STATUS_OK ? options_check(options, error) : status;
}

static void options_fini(struct options *options)
{
    g_free(options->forces);
    g_free(options->motion);
    g_free(options->output);
    g_free(options->components);
    g_strfreev(options->set);
    g_free(options->scenario);
}

// ---- Input ----

static enum status read_scenario(const struct options *options, struct scenario *scenario,
                                 struct error *error)
{
    const size_t set_count = options->set != NULL ? g_strv_length(options->set) : 0;
    const enum status status = scenario_read_file(
        scenario, options->scenario, (const char *const *)options->set, set_count, error);
    if (status != STATUS_OK) {
        return status;
    }
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP || scenario->case_count > 0) {
        return error_set(error, STATUS_INVALID,
                         "%s: expected a scenario of model small_overlap without cases: one crash "
                         "was measured",
                         options->scenario);
    }
    plausibility_tell(scenario);
    return STATUS_OK;
}

static enum status read_motion(const char *path, struct motion *motion, struct error *error)
{
    g_autofree char *text = NULL;
    size_t size;
    g_autoptr(GError) reason = NULL;
    if (!g_file_get_contents(path, &text, &size, &reason)) {
        return error_set(error, STATUS_INVALID, "%s: %s", path, reason->message);
    }
    if (motion_parse(motion, INFINITY, path, text, size, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        if (motion->value[i] == NULL) {
            return error_set(error, STATUS_INVALID,
                             "%s:1:1: expected the columns time_s, x_m, y_m and yaw_rad, found no "
                             "%s",
                             path, motion_quantity_name((enum motion_quantity)i));
        }
    }
    return STATUS_OK;
}

// Leaves NULL where no components are given.
static enum status read_groups(const char *path, struct group_list **groups, struct error *error)
{
    if (path == NULL) {
        return STATUS_OK;
    }
    size_t size;
    g_autofree char *text = csv_load(path, &size, error);
    g_autofree struct component_list *components = g_new0(struct component_list, 1);
    *groups = g_new0(struct group_list, 1);
    if (text == NULL || component_parse(components, path, text, size, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    return group_make(*groups, components, error);
}

// Hands on the whole lines of `piece`, which holds `size` bytes; all of them at the end of the
// file. Returns in `size` how many bytes are left over.
static enum status hand_on(struct reduction *reduction, const char *path, char *piece, size_t *size,
                           bool ended, struct error *error)
{
    const char *last = memrchr(piece, '\n', *size);
    const size_t whole = ended ? *size : last != NULL ? (size_t)(last - piece) + 1 : 0;
    if (whole == 0 && *size == PIECE_SIZE) {
        return error_set(error, STATUS_INVALID, "%s: expected lines of less than %d bytes", path,
                         PIECE_SIZE);
    }
    if (reduction_read(reduction, piece, whole, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    memmove(piece, piece + whole, *size - whole);
    *size -= whole;
    return STATUS_OK;
}

static enum status read_forces(FILE *file, const char *path, struct reduction *reduction,
                               struct error *error)
{
    g_autofree char *piece = g_malloc(PIECE_SIZE);
    size_t size = 0;
    bool ended = false;
    while (!ended) {
        const size_t added = fread(piece + size, 1, PIECE_SIZE - size, file);
        if (added == 0 && ferror(file)) {
            return error_set(error, STATUS_INVALID, "%s: %s", path, g_strerror(errno));
        }
        ended = added == 0;
        size += added;
        if (hand_on(reduction, path, piece, &size, ended, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    return STATUS_OK;
}

static enum status open_and_read_forces(const char *path, struct reduction *reduction,
                                        struct error *error)
{
    if (strcmp(path, "-") == 0) {
        return read_forces(stdin, path, reduction, error);
    }
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return error_set(error, STATUS_INVALID, "%s: %s", path, g_strerror(errno));
    }
    const enum status status = read_forces(file, path, reduction, error);
    fclose(file);
    return status;
}

// ---- Output ----

static enum status write_design(const char *path, const struct design *design,
                                const struct scenario *scenario, struct error *error)
{
    g_autofree char *text = design_text(design, scenario);
    return whole_file_write(path, text, strlen(text), error);
}

// What a person should look at before trusting the curves.
static void note_doubts(const struct options *options, const struct reduction_summary *summary)
{
    const double usual = (summary->time_last - summary->time_first) / (summary->times - 1);
    if (summary->gap > gap_noted * usual) {
        log_note("%s: nothing between %g and %g s, %.0f times the usual gap", options->forces,
                 summary->gap_start, summary->gap_start + summary->gap, summary->gap / usual);
    }
    if (summary->outside_share > 0.0) {
        log_note("%s: %llu node forces, %.2f %% of the total, lie outside all patches",
                 options->forces, (unsigned long long)summary->outside_count,
                 100.0 * summary->outside_share);
    }
    if (summary->undeformed_share > 0.0) {
        log_note("%s: %.2f %% of the forces lie before springs that the barrier had not reached: "
                 "they are left out",
                 options->forces, 100.0 * summary->undeformed_share);
    }
    if (summary->yaw_max >= G_PI / 2.0) {
        log_note("%s: the yaw passes 90 degrees, where no spring has a projection",
                 options->motion);
    }
}

// Notes what contradicts what. What cannot be meant is an error: the curves would be worth nothing.
static enum status judge_balance(const struct options *options, const struct doubts *doubts,
                                 struct error *error)
{
    for (uint32_t i = 0; i + doubts->impossible < doubts->count; i++) {
        log_note("%s: %s", options->forces, doubts->text[i]);
    }
    if (!doubts->impossible) {
        return STATUS_OK;
    }
    return error_set(error, STATUS_INVALID, "%s and %s: %s", options->forces, options->motion,
                     doubts->text[doubts->count - 1]);
}

// A number as JSON; what is not finite has no number there.
static json_t *json_number(double number)
{
    return isfinite(number) ? json_real(number) : json_null();
}

static json_t *balance_lines(const struct balance *balance)
{
    json_t *object = json_object();
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        const struct balance_line *line = &balance->lines[k];
        json_object_set_new(object, motion_quantity_name((enum motion_quantity)k),
                            json_pack("{s:f, s:f, s:o, s:f, s:f}", "impulse", line->impulse,
                                      "momentum_change", line->change, "ratio",
                                      json_number(line->ratio), "motion_error", line->error,
                                      "moved", line->moved));
    }
    return object;
}

static json_t *doubt_texts(const struct doubts *doubts)
{
    json_t *array = json_array();
    for (uint32_t i = 0; i < doubts->count; i++) {
        json_array_append_new(array, json_string(doubts->text[i]));
    }
    return array;
}

static json_t *spring_points(const struct design *design, const struct scenario *scenario)
{
    json_t *object = json_object();
    for (uint32_t i = 0; i < design->spring_count; i++) {
        const struct design_spring *spring = &design->springs[i];
        json_object_set_new(object, scenario->springs[i].name,
                            json_pack("{s:I, s:I, s:f}", "load_points",
                                      (json_int_t)spring->load.point_count, "unload_points",
                                      (json_int_t)spring->unload.point_count, "deformation_max",
                                      spring->load.deformation[spring->load.point_count - 1]));
    }
    return object;
}

static enum status print_summary(const struct reduction_summary *summary,
                                 const struct doubts *doubts, const struct design *design,
                                 const struct scenario *scenario, struct error *error)
{
    json_t *object = json_pack(
        "{s:I, s:I, s:f, s:f, s:f, s:s, s:[f,f], s:o, s:o, s:{s:I, s:f}, s:f, s:f, s:o}",
        "node_forces", (json_int_t)summary->node_forces, "times", (json_int_t)summary->times,
        "time_first", summary->time_first, "time_last", summary->time_last, "gap_max", summary->gap,
        "forces_on", summary->turned ? "barrier" : "vehicle", "impulse", summary->impulse[0],
        summary->impulse[1], "balance", balance_lines(&summary->balance), "doubts",
        doubt_texts(doubts), "outside", "count", (json_int_t)summary->outside_count, "share",
        summary->outside_share, "undeformed_share", summary->undeformed_share, "repeated_share",
        summary->repeated_share, "springs", spring_points(design, scenario));
    const bool printed = json_dumpf(object, stdout, JSON_INDENT(2)) == 0 && putchar('\n') != EOF &&
                         fflush(stdout) == 0;
    json_decref(object);
    if (!printed) {
        return error_set(error, STATUS_IO, "standard output: writing failed");
    }
    return STATUS_OK;
}

// ---- The program ----

static enum status reduce(const struct options *options, const struct scenario *scenario,
                          const struct group_list *groups, const struct motion *motion,
                          struct error *error)
{
    struct reduction *reduction =
        reduction_create(scenario, groups, motion, options->forces, error);
    if (reduction == NULL) {
        return STATUS_INVALID;
    }
    struct design design = {0};
    struct reduction_summary summary;
    struct doubts doubts;
    enum status status = open_and_read_forces(options->forces, reduction, error);
    if (status == STATUS_OK) {
        status = reduction_finish(reduction, &design, &summary, error);
    }
    if (status == STATUS_OK) {
        note_doubts(options, &summary);
        doubts_find(&doubts, &summary.balance, scenario);
        status = judge_balance(options, &doubts, error);
    }
    if (status == STATUS_OK) {
        status = write_design(options->output, &design, scenario, error);
    }
    if (status == STATUS_OK) {
        status = print_summary(&summary, &doubts, &design, scenario, error);
    }
    design_fini(&design);
    reduction_free(reduction);
    return status;
}

static enum status barrier_forces(const struct options *options, struct error *error)
{
    struct scenario scenario = {0};
    struct motion motion = {0};
    g_autofree struct group_list *groups = NULL;
    enum status status = read_scenario(options, &scenario, error);
    if (status == STATUS_OK) {
        status = read_motion(options->motion, &motion, error);
    }
    if (status == STATUS_OK) {
        status = read_groups(options->components, &groups, error);
    }
    if (status == STATUS_OK) {
        status = reduce(options, &scenario, groups, &motion, error);
    }
    motion_fini(&motion);
    scenario_fini(&scenario);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
    arithmetic_start();
    struct options options = {0};
    struct error error = {0};
    log_start("sobox-barrier-forces", LOG_NORMAL);
    enum status status = options_parse(&options, argc, argv, &error);
    if (status != STATUS_OK) {
        log_error("%s", error.text);
    } else if (options.version) {
        printf("sobox-barrier-forces %s\n", SOBOX_VERSION);
    } else if ((status = barrier_forces(&options, &error)) != STATUS_OK) {
        log_failure(&error);
    }
    options_fini(&options);
    return (int)status_exit(status);
}
