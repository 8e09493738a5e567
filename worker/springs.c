// sobox-springs: from the boxes of a car's components, from reference curves, or from both to the
// springs of a scenario. The thinking is
// done in worker/components; here are options and files.
#include "common/base/arithmetic.h"
#include "common/base/error.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/base/whole_file.h"
#include "worker/components/component.h"
#include "worker/components/face.h"
#include "worker/components/group.h"
#include "worker/components/points.h"
#include "worker/components/reference.h"
#include "worker/components/spring.h"
#include "worker/components/springs_text.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PLACES_TOLD = 5 }; // overlaps, and gaps, that are told one by one

static const char program_summary[] =
    "Makes the springs of a scenario from the boxes of a car's components: places, lengths,\n"
    "heights, discretization points and, where the table has forces, the design space. Or chooses\n"
    "the points alone, on reference curves.";

static const char program_description[] =
    "The table has the columns name,group,x_min_m,x_max_m,y_min_m,y_max_m,z_min_m,z_max_m and, if\n"
    "known, force_x_N,force_y_N. x and y are those of the scenario at first contact (forwards is "
    "-x,\n"
    "the struck side is at negative y), z is the height above the road. Components of one group\n"
    "share a spring; those without a group are grouped by standing in line. Overlaps of the\n"
    "groups' patches and unused places of the face are told on standard error.\n"
    "\n"
    "Curves have the columns spring,deformation_m,force_x_N,force_y_N, as sobox-barrier-forces\n"
    "writes them: on each as few points are chosen as follow it within the tolerance.\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input.";

struct options {
    double face_x; // [m] NAN: not given
    double edge_y;
    double width;
    char *curves;     // NULL: none
    double tolerance; // [%]
    long points;      // of a spring, at most
    char *output;     // NULL: standard output
    gboolean version;
    char *table;
};

// What the program works on.
struct work {
    struct component_list components;
    struct group_list groups;
    struct reference_list curves;
    struct spring springs[GROUP_MAX];
    uint32_t spring_count;
};

// ---- Options ----

static enum status options_check(const struct options *options, struct error *error)
{
    if (options->version) {
        return STATUS_OK;
    }
    if (options->table == NULL && options->curves == NULL) {
        return error_set(error, STATUS_INVALID,
                         "no components: expected sobox-springs COMPONENTS.csv, or --curves "
                         "CURVES.csv (see --help)");
    }
    if (!(options->tolerance > 0.0 && options->tolerance < 100.0)) {
        return error_set(error, STATUS_INVALID,
                         "--tolerance: expected more than 0 and less than 100 %%");
    }
    if (isinf(options->face_x) || isinf(options->edge_y)) {
        return error_set(error, STATUS_INVALID, "expected a finite --face-x and --edge-y [m]");
    }
    if (!isnan(options->width) && (!(options->width > 0.0) || isnan(options->edge_y))) {
        return error_set(error, STATUS_INVALID,
                         "expected a --width of more than 0 m beside an --edge-y");
    }
    return STATUS_OK;
}

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    const GOptionEntry entries[] = {
        {"face-x", 'x', 0, G_OPTION_ARG_DOUBLE, &options->face_x,
         "x of the barrier's face at first contact; by default that of the foremost component",
         "METRES"},
        {"edge-y", 'y', 0, G_OPTION_ARG_DOUBLE, &options->edge_y,
         "y of the inner end of the barrier's face; by default no end is looked at", "METRES"},
        {"width", 'w', 0, G_OPTION_ARG_DOUBLE, &options->width,
         "Width of the face, from its inner end towards -y", "METRES"},
        {"curves", 'c', 0, G_OPTION_ARG_FILENAME, &options->curves,
         "Reference curves on which to choose points", "CURVES.csv"},
        {"tolerance", 't', 0, G_OPTION_ARG_DOUBLE, &options->tolerance,
         "By how much the points may miss a curve, in % of its greatest force; by default 5",
         "PERCENT"},
        {"points", 'n', 0, G_OPTION_ARG_CALLBACK, (gpointer)options_number,
         "Points of a spring, at most; by default 32", "COUNT"},
        {"output", 'o', 0, G_OPTION_ARG_FILENAME, &options->output,
         "Where to write the springs; by default standard output", "SPRINGS.yaml"},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_number numbers[] = {
        {"--points", offsetof(struct options, points), 2, SCENARIO_POINT_MAX},
        {0},
    };
    const struct options_program program = {
        .argument = "COMPONENTS.csv",
        .summary = program_summary,
        .description = program_description,
        .entries = entries,
        .numbers = numbers,
        .options = options,
    };
    struct options_common common;
    const enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    options->table = common.argument;
    return status == STATUS_OK ? options_check(options, error) : status;
}

static void options_fini(struct options *options)
{
    g_free(options->curves);
    g_free(options->output);
    g_free(options->table);
}

// ---- Input ----

static enum status read_text(const char *path, char **text, size_t *size, struct error *error)
{
    g_autoptr(GError) reason = NULL;
    if (!g_file_get_contents(path, text, size, &reason)) {
        return error_set(error, STATUS_INVALID, "%s: %s", path, reason->message);
    }
    return STATUS_OK;
}

static enum status read_components(const char *path, struct component_list *components,
                                   struct error *error)
{
    g_autofree char *text = NULL;
    size_t size;
    const enum status status = read_text(path, &text, &size, error);
    return status == STATUS_OK ? component_parse(components, path, text, size, error) : status;
}

static enum status read_curves(const char *path, struct reference_list *curves, struct error *error)
{
    g_autofree char *text = NULL;
    size_t size;
    const enum status status = read_text(path, &text, &size, error);
    return status == STATUS_OK ? reference_parse(curves, path, text, size, error) : status;
}

// ---- What a person should look at ----

static const char *group_name(const struct work *work, uint32_t group)
{
    return work->groups.items[group].name;
}

static void tell_overlaps(const struct options *options, const struct work *work,
                          const struct face_check *check)
{
    for (uint32_t i = 0; i < check->overlap_count && i < PLACES_TOLD; i++) {
        const struct face_place *place = &check->overlaps[i];
        log_note("%s: groups %s and %s overlap: y %g .. %g, z %g .. %g m (%.0f cm2)",
                 options->table, group_name(work, place->one), group_name(work, place->other),
                 place->y[0], place->y[1], place->z[0], place->z[1], 1e4 * face_area(place));
    }
    if (check->overlap_count > PLACES_TOLD) {
        log_note("%s: %u smaller overlaps", options->table, check->overlap_count - PLACES_TOLD);
    }
}

static void tell_gaps(const struct options *options, const struct face_check *check)
{
    for (uint32_t i = 0; i < check->gap_count && i < PLACES_TOLD; i++) {
        const struct face_place *place = &check->gaps[i];
        log_note("%s: no component stands at y %g .. %g, z %g .. %g m (%.0f cm2)", options->table,
                 place->y[0], place->y[1], place->z[0], place->z[1], 1e4 * face_area(place));
    }
    if (check->gap_count > 0) {
        log_note("%s: %.0f %% of the front, y %g .. %g, z %g .. %g m, is unused", options->table,
                 100.0 * check->gap_area / face_area(&check->front), check->front.y[0],
                 check->front.y[1], check->front.z[0], check->front.z[1]);
    }
}

static void tell_beside(const struct options *options, const struct work *work,
                        const struct face *face)
{
    for (uint32_t i = 0; i < work->groups.count; i++) {
        const struct component_box *box = &work->groups.items[i].box;
        const double beside = face_beside(&work->groups.items[i], face);
        const double y = work->springs[i].position[1];
        if (beside > 0.0) {
            log_note("%s: group %s: %.0f mm of its %.0f mm in y lie beside the barrier's face%s",
                     options->table, group_name(work, i), 1e3 * beside,
                     1e3 * (box->max[1] - box->min[1]),
                     y > face->edge_y || y < face->far_y
                         ? "; its spring does not meet the barrier at first contact"
                         : "");
        }
    }
}

static void tell_doubts(const struct options *options, const struct work *work)
{
    const struct face face = {
        .edge_y = isnan(options->edge_y) ? INFINITY : options->edge_y,
        .far_y = isnan(options->width) ? -INFINITY : options->edge_y - options->width,
    };
    struct face_check check;
    face_check_make(&check, &work->groups, &face);
    tell_overlaps(options, work, &check);
    tell_gaps(options, &check);
    tell_beside(options, work, &face);
    face_check_fini(&check);
    if (!work->components.forces) {
        log_note("%s: without a force_x_N and force_y_N of every component the springs have no "
                 "force_x and force_y: write them before you search",
                 options->table);
    }
}

// What of the curves is not in the springs.
static void tell_curves(const struct options *options, const struct work *work)
{
    for (uint32_t i = 0; i < work->curves.count; i++) {
        const struct reference *curve = &work->curves.items[i];
        uint32_t at = 0;
        while (at < work->spring_count && strcmp(work->springs[at].name, curve->name) != 0) {
            at++;
        }
        if (at == work->spring_count) {
            log_note("%s: no group is called %s: its curve is left out", options->curves,
                     curve->name);
            continue;
        }
        if (curve->passed > 0) {
            log_note("%s: spring %s: %u rows go back, or on by less than 0.1 mm: they are left out",
                     options->curves, curve->name, curve->passed);
        }
        if (work->springs[at].chosen.miss > options->tolerance / 100.0) {
            log_note("%s: spring %s: %u points miss the curve by %.1f %% of its greatest force",
                     options->curves, curve->name, work->springs[at].point_count,
                     100.0 * work->springs[at].chosen.miss);
        }
    }
}

// ---- The program ----

static struct points_rule points_rule(const struct options *options)
{
    return (struct points_rule){
        .tolerance = options->tolerance / 100.0,
        .point_max = (uint32_t)options->points,
    };
}

// The spring of a group, with the points of its curve where it has one.
static enum status make_spring(const struct options *options, struct work *work, uint32_t group,
                               double face_x, struct error *error)
{
    struct spring *spring = &work->springs[group];
    const struct reference *curve = reference_find(&work->curves, work->groups.items[group].name);
    enum status status =
        spring_make(spring, &work->components, &work->groups, group, face_x, error);
    if (status == STATUS_OK && curve != NULL) {
        const struct points_rule rule = points_rule(options);
        struct points_choice choice;
        status =
            points_choose(&choice, curve, spring->deformation, spring->point_count, &rule, error);
        if (status == STATUS_OK) {
            spring_choose(spring, &work->components, &work->groups, group, face_x, &choice);
        }
    }
    return status;
}

static enum status springs_of_groups(const struct options *options, struct work *work,
                                     struct error *error)
{
    enum status status = read_components(options->table, &work->components, error);
    if (status == STATUS_OK) {
        status = group_make(&work->groups, &work->components, error);
    }
    const double face_x = isnan(options->face_x) ? spring_foremost(&work->groups) : options->face_x;
    for (uint32_t i = 0; status == STATUS_OK && i < work->groups.count; i++) {
        status = make_spring(options, work, i, face_x, error);
    }
    work->spring_count = work->groups.count;
    return status;
}

static enum status springs_of_curves(const struct options *options, struct work *work,
                                     struct error *error)
{
    const struct points_rule rule = points_rule(options);
    for (uint32_t i = 0; i < work->curves.count; i++) {
        const struct reference *curve = &work->curves.items[i];
        struct points_choice choice;
        if (points_choose(&choice, curve, NULL, 0, &rule, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        spring_of_curve(&work->springs[i], curve->name, &choice);
    }
    work->spring_count = work->curves.count;
    return STATUS_OK;
}

static enum status write_springs(const struct options *options, const struct work *work,
                                 struct error *error)
{
    g_autofree char *text = springs_text(work->springs, work->spring_count,
                                         options->table != NULL ? &work->groups : NULL);
    if (options->output != NULL) {
        return whole_file_write(options->output, text, strlen(text), error);
    }
    if (fputs(text, stdout) == EOF || fflush(stdout) != 0) {
        return error_set(error, STATUS_IO, "standard output: writing failed");
    }
    return STATUS_OK;
}

static enum status springs(const struct options *options, struct error *error)
{
    g_autofree struct work *work = g_new0(struct work, 1);
    enum status status = STATUS_OK;
    if (options->curves != NULL) {
        status = read_curves(options->curves, &work->curves, error);
    }
    if (status == STATUS_OK) {
        status = options->table != NULL ? springs_of_groups(options, work, error)
                                        : springs_of_curves(options, work, error);
    }
    if (status == STATUS_OK && options->table != NULL) {
        tell_doubts(options, work);
    }
    if (status == STATUS_OK) {
        tell_curves(options, work);
        status = write_springs(options, work, error);
    }
    reference_fini(&work->curves);
    return status;
}

int main(int argc, char **argv)
{
    streams_start();
    arithmetic_start();
    struct options options = {
        .face_x = NAN,
        .edge_y = NAN,
        .width = NAN,
        .tolerance = 5.0,
        .points = SCENARIO_POINT_MAX,
    };
    struct error error = {0};
    log_start("sobox-springs", LOG_NORMAL);
    enum status status = options_parse(&options, argc, argv, &error);
    if (status != STATUS_OK) {
        log_error("%s", error.text);
    } else if (options.version) {
        printf("sobox-springs %s\n", SOBOX_VERSION);
    } else if ((status = springs(&options, &error)) != STATUS_OK) {
        log_failure(&error);
    }
    options_fini(&options);
    return (int)status_exit(status);
}
