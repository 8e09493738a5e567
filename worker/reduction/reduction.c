#include "worker/reduction/reduction.h"

#include "common/table/csv.h"
#include "worker/reduction/branches.h"
#include "worker/reduction/patches.h"

#include <glib.h>
#include <math.h>

enum column {
    COLUMN_TIME,
    COLUMN_NODE,
    COLUMN_Y,
    COLUMN_Z,
    COLUMN_NORMAL_X,
    COLUMN_NORMAL_Y,
    COLUMN_SHEAR_X,
    COLUMN_SHEAR_Y,
    COLUMN_COUNT
};

static const struct {
    const char *name;
    const char *unit;
} columns[COLUMN_COUNT] = {
    [COLUMN_TIME] = {"time_s", "s"},
    [COLUMN_NODE] = {"node", "a whole number"},
    [COLUMN_Y] = {"y_m", "m"},
    [COLUMN_Z] = {"z_m", "m"},
    [COLUMN_NORMAL_X] = {"normal_x_N", "N"},
    [COLUMN_NORMAL_Y] = {"normal_y_N", "N"},
    [COLUMN_SHEAR_X] = {"shear_x_N", "N"},
    [COLUMN_SHEAR_Y] = {"shear_y_N", "N"},
};

static const char header_text[] = "time_s,node,y_m,z_m,normal_x_N,normal_y_N,shear_x_N,shear_y_N";

struct reduction {
    const struct scenario *scenario;
    const struct motion *motion;
    struct patches patches;
    struct csv csv;
    bool started;
    bool headed;

    // The time that is being read.
    double time;                          // [s]
    double yaw;                           // [rad]
    double force[SCENARIO_SPRING_MAX][2]; // [N] of each spring, in road axes
    GHashTable *nodes;                    // seen at this time
    uint32_t motion_at;                   // the motion's first time after this one, or its last

    // All times.
    GArray *samples[SCENARIO_SPRING_MAX]; // of struct branches_sample
    struct reduction_summary summary;
    double total;              // [N] sum of |force|
    double outside;            // [N]
    double undeformed;         // [N]
    double cog[2];             // [m] at the time being read
    struct balance_sample all; // of the time being read
    GArray *sums;              // of struct balance_sample
};

struct reduction *reduction_create(const struct scenario *scenario, const struct group_list *groups,
                                   const struct motion *motion, const char *source,
                                   struct error *error)
{
    struct reduction *reduction = g_new0(struct reduction, 1);
    reduction->scenario = scenario;
    reduction->motion = motion;
    reduction->nodes = g_hash_table_new(g_direct_hash, g_direct_equal);
    reduction->csv.source = source;
    reduction->sums = g_array_new(FALSE, FALSE, sizeof(struct balance_sample));
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        reduction->samples[i] = g_array_new(FALSE, FALSE, sizeof(struct branches_sample));
    }
    if (patches_init(&reduction->patches, scenario, groups, error) != STATUS_OK) {
        reduction_free(reduction);
        return NULL;
    }
    return reduction;
}

void reduction_free(struct reduction *reduction)
{
    if (reduction == NULL) {
        return;
    }
    for (uint32_t i = 0; i < reduction->scenario->spring_count; i++) {
        g_array_free(reduction->samples[i], TRUE);
    }
    g_array_free(reduction->sums, TRUE);
    g_hash_table_destroy(reduction->nodes);
    g_free(reduction);
}

// ---- One time ----

// Puts the vehicle where the motion has it at `time`, which lies within the motion's times and not
// before the last one asked for.
static void move_vehicle(struct reduction *reduction, double time)
{
    const struct motion *motion = reduction->motion;
    uint32_t after = MAX(reduction->motion_at, 1);
    while (after + 1 < motion->count && motion->time[after] < time) {
        after++;
    }
    reduction->motion_at = after;
    const double span = motion->time[after] - motion->time[after - 1];
    const double share = (time - motion->time[after - 1]) / span;
    double now[MOTION_QUANTITY_COUNT];
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        const double from = motion->value[i][after - 1];
        const double to = motion->value[i][after];
        now[i] = share < 1.0 ? from + share * (to - from) : to;
    }
    reduction->cog[0] = now[MOTION_X];
    reduction->cog[1] = now[MOTION_Y];
    reduction->yaw = now[MOTION_YAW];
    reduction->summary.yaw_max = fmax(reduction->summary.yaw_max, fabs(reduction->yaw));
    patches_move(&reduction->patches, now[MOTION_X], now[MOTION_Y], now[MOTION_YAW]);
}

static void begin_time(struct reduction *reduction, double time)
{
    struct reduction_summary *summary = &reduction->summary;
    if (summary->times == 0) {
        summary->time_first = time;
    } else if (time - reduction->time > summary->gap) {
        summary->gap = time - reduction->time;
        summary->gap_start = reduction->time;
    }
    summary->times++;
    summary->time_last = time;
    reduction->time = time;
    reduction->all = (struct balance_sample){.time = time};
    g_hash_table_remove_all(reduction->nodes);
    for (uint32_t i = 0; i < reduction->scenario->spring_count; i++) {
        reduction->force[i][0] = reduction->force[i][1] = 0.0;
    }
    move_vehicle(reduction, time);
}

// Notes what the springs did at the time that was read, in vehicle axes.
static void end_time(struct reduction *reduction)
{
    const double sine = sin(reduction->yaw);
    const double cosine = cos(reduction->yaw);
    for (uint32_t i = 0; i < reduction->scenario->spring_count; i++) {
        const struct patches_spring *spring = &reduction->patches.springs[i];
        const double *force = reduction->force[i];
        if (!spring->projected || spring->deformation < 0.0) {
            reduction->undeformed += hypot(force[0], force[1]);
            continue;
        }
        const struct branches_sample sample = {
            .deformation = spring->deformation,
            .force = {cosine * force[0] + sine * force[1], cosine * force[1] - sine * force[0]},
        };
        g_array_append_val(reduction->samples[i], sample);
    }
    g_array_append_val(reduction->sums, reduction->all);
}

// ---- The table ----

static enum status read_header(struct csv *csv, struct error *error)
{
    for (uint32_t i = 0; i < COLUMN_COUNT; i++) {
        if (i >= csv->field_count || !csv_is(&csv->fields[i], columns[i].name)) {
            return csv_error(csv, i, error, "expected the header %s", header_text);
        }
    }
    if (csv->field_count > COLUMN_COUNT) {
        return csv_error(csv, COLUMN_COUNT, error, "expected the header %s", header_text);
    }
    return STATUS_OK;
}

static enum status check_time(const struct reduction *reduction, double time, struct error *error)
{
    const struct csv *csv = &reduction->csv;
    const struct motion *motion = reduction->motion;
    const double first = motion->time[0];
    const double last = motion->time[motion->count - 1];
    if (time < first || time > last) {
        return csv_error(csv, COLUMN_TIME, error,
                         "time_s: expected %g to %g s, the times of the motion, found %g", first,
                         last, time);
    }
    if (reduction->summary.times > 0 && time < reduction->time) {
        return csv_error(csv, COLUMN_TIME, error,
                         "time_s: expected %.15g s, the time before, or later, found %.15g",
                         reduction->time, time);
    }
    if (reduction->summary.times == REDUCTION_TIME_MAX && time > reduction->time) {
        return csv_error(csv, COLUMN_TIME, error, "expected at most %d different times",
                         REDUCTION_TIME_MAX);
    }
    return STATUS_OK;
}

static enum status check_node(struct reduction *reduction, double node, struct error *error)
{
    const double node_max = 9007199254740991.0; // the greatest whole number that is exact
    if (node != floor(node) || node < 0.0 || node > node_max) {
        return csv_error(&reduction->csv, COLUMN_NODE, error,
                         "node: expected a whole number from 0 on, found %.15g", node);
    }
    if (!g_hash_table_add(reduction->nodes, GSIZE_TO_POINTER((gsize)node))) {
        return csv_error(&reduction->csv, COLUMN_NODE, error,
                         "node: expected each node once a time, found %.15g again at %.15g s", node,
                         reduction->time);
    }
    return STATUS_OK;
}

// Nodes lie on the plane of the face; the arc of a rounded edge is taken for a part of it.
static void add_to_all(struct reduction *reduction, const double force[2], double y)
{
    const double lever_x = reduction->scenario->barrier.face_x - reduction->cog[0];
    const double lever_y = y - reduction->cog[1];
    double *all = reduction->all.force;
    all[MOTION_X] += force[0];
    all[MOTION_Y] += force[1];
    all[MOTION_YAW] += lever_x * force[1] - lever_y * force[0];
}

static void take_force(struct reduction *reduction, const double number[COLUMN_COUNT])
{
    const double force[2] = {number[COLUMN_NORMAL_X] + number[COLUMN_SHEAR_X],
                             number[COLUMN_NORMAL_Y] + number[COLUMN_SHEAR_Y]};
    const double size = hypot(force[0], force[1]);
    const uint32_t spring = patches_find(&reduction->patches, number[COLUMN_Y], number[COLUMN_Z]);
    reduction->summary.node_forces++;
    reduction->total += size;
    add_to_all(reduction, force, number[COLUMN_Y]);
    if (spring == PATCHES_NONE) {
        reduction->summary.outside_count += size > 0.0;
        reduction->outside += size;
        return;
    }
    for (int k = 0; k < 2; k++) {
        reduction->force[spring][k] += force[k];
    }
}

static enum status read_row(struct reduction *reduction, struct error *error)
{
    const struct csv *csv = &reduction->csv;
    if (csv->field_count != COLUMN_COUNT) {
        return csv_error(csv, MIN(csv->field_count, COLUMN_COUNT), error,
                         "expected %d fields (%s), found %u", COLUMN_COUNT, header_text,
                         csv->field_count);
    }
    double number[COLUMN_COUNT];
    for (uint32_t i = 0; i < COLUMN_COUNT; i++) {
        if (csv_number(csv, i, columns[i].name, columns[i].unit, &number[i], error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    const double time = number[COLUMN_TIME];
    if (check_time(reduction, time, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (reduction->summary.times == 0 || time > reduction->time) {
        if (reduction->summary.times > 0) {
            end_time(reduction);
        }
        begin_time(reduction, time);
    }
    if (check_node(reduction, number[COLUMN_NODE], error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    take_force(reduction, number);
    return STATUS_OK;
}

enum status reduction_read(struct reduction *reduction, const char *text, size_t size,
                           struct error *error)
{
    struct csv *csv = &reduction->csv;
    if (reduction->started) {
        csv_continue(csv, text, size);
    } else {
        csv_start(csv, csv->source, text, size);
        reduction->started = true;
    }
    for (;;) {
        if (csv_row(csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        if (csv->field_count == 0) {
            return STATUS_OK;
        }
        const enum status status =
            reduction->headed ? read_row(reduction, error) : read_header(csv, error);
        if (status != STATUS_OK) {
            return status;
        }
        reduction->headed = true;
    }
}

// ---- The curves ----

// Impulse of all times in x and y, as the table states the forces.
static void add_impulse(struct reduction *reduction)
{
    const struct balance_sample *sums = (const struct balance_sample *)reduction->sums->data;
    for (uint32_t i = 1; i < reduction->sums->len; i++) {
        const double span = sums[i].time - sums[i - 1].time;
        for (int k = 0; k < 2; k++) {
            reduction->summary.impulse[k] += 0.5 * span * (sums[i - 1].force[k] + sums[i].force[k]);
        }
    }
}

// Forces as they act on the vehicle. Tables state either side of the contact; over a crash the
// barrier can only slow the vehicle, which tells the two apart.
static void face_vehicle(struct reduction *reduction)
{
    struct reduction_summary *summary = &reduction->summary;
    summary->turned = summary->impulse[0] < 0.0;
    if (!summary->turned) {
        return;
    }
    summary->impulse[0] = -summary->impulse[0];
    summary->impulse[1] = -summary->impulse[1];
    for (uint32_t i = 0; i < reduction->scenario->spring_count; i++) {
        struct branches_sample *samples = (struct branches_sample *)reduction->samples[i]->data;
        for (uint32_t k = 0; k < reduction->samples[i]->len; k++) {
            samples[k].force[0] = -samples[k].force[0];
            samples[k].force[1] = -samples[k].force[1];
        }
    }
}

static double force_share(const struct reduction *reduction, double part)
{
    return reduction->total > 0.0 ? part / reduction->total : 0.0;
}

static enum status check_table(const struct reduction *reduction, struct error *error)
{
    const struct csv *csv = &reduction->csv;
    if (!reduction->headed) {
        return csv_error(csv, 0, error, "expected the header %s", header_text);
    }
    if (reduction->summary.times < 2) {
        return csv_error(csv, 0, error, "expected at least 2 times, found %u",
                         reduction->summary.times);
    }
    if (!(reduction->total > reduction->outside + reduction->undeformed)) {
        return csv_error(csv, 0, error,
                         "no force lies on any spring's patch: expected the nodes' y_m and the "
                         "motion in the scenario's axes");
    }
    return STATUS_OK;
}

enum status reduction_finish(struct reduction *reduction, struct design *design,
                             struct reduction_summary *summary, struct error *error)
{
    *design = (struct design){0};
    if (!reduction->started && reduction_read(reduction, "", 0, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (reduction->summary.times > 0) {
        end_time(reduction);
    }
    if (check_table(reduction, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    add_impulse(reduction);
    face_vehicle(reduction);
    balance_make(&reduction->summary.balance, (const struct balance_sample *)reduction->sums->data,
                 reduction->sums->len, reduction->summary.turned ? -1.0 : 1.0, reduction->motion,
                 reduction->scenario);
    const uint32_t point_max = DESIGN_POINT_MAX / (2 * reduction->scenario->spring_count);
    double repeated = 0.0;
    design_init(design, reduction->scenario);
    for (uint32_t i = 0; i < reduction->scenario->spring_count; i++) {
        const GArray *samples = reduction->samples[i];
        repeated += branches_make((const struct branches_sample *)samples->data, samples->len,
                                  point_max, &design->springs[i]);
    }
    reduction->summary.outside_share = force_share(reduction, reduction->outside);
    reduction->summary.undeformed_share = force_share(reduction, reduction->undeformed);
    reduction->summary.repeated_share = force_share(reduction, repeated);
    *summary = reduction->summary;
    return STATUS_OK;
}
