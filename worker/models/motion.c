#include "worker/models/motion.h"

#include "common/table/csv.h"

#include <assert.h>
#include <glib.h>
#include <math.h>

static const struct {
    const char *name;
    const char *unit;
} quantities[MOTION_QUANTITY_COUNT] = {
    [MOTION_X] = {"x_m", "m"},
    [MOTION_Y] = {"y_m", "m"},
    [MOTION_YAW] = {"yaw_rad", "rad"},
};

// Where each column stands in the file.
struct motion_columns {
    uint32_t count;
    uint32_t time;
    uint32_t quantity[MOTION_QUANTITY_COUNT];
};

const char *motion_quantity_name(enum motion_quantity quantity)
{
    return quantities[quantity].name;
}

void motion_fini(struct motion *motion)
{
    g_free(motion->time);
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        g_free(motion->value[i]);
    }
    *motion = (struct motion){0};
}

// The field with that name, or field_count.
static uint32_t find_column(const struct csv *csv, const char *name)
{
    uint32_t field = 0;
    while (field < csv->field_count && !csv_is(&csv->fields[field], name)) {
        field++;
    }
    return field;
}

static enum status parse_header(struct csv *csv, struct motion_columns *columns,
                                struct error *error)
{
    if (csv_row(csv, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    bool any = false;
    columns->count = csv->field_count;
    columns->time = find_column(csv, "time_s");
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        columns->quantity[i] = find_column(csv, quantities[i].name);
        any |= columns->quantity[i] < columns->count;
    }
    if (columns->time == columns->count || !any) {
        return csv_error(csv, 0, error,
                         "expected a header with time_s and at least one of x_m, y_m, yaw_rad");
    }
    return STATUS_OK;
}

static enum status parse_time(const struct motion *motion, const struct csv *csv, uint32_t field,
                              double duration, double *time, struct error *error)
{
    // A simulated time is a whole number of steps, so it may miss the duration by a rounding error.
    const double slack = 1e-9 * duration;
    if (csv_number(csv, field, "time_s", "s", time, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    if (*time < 0.0 || *time > duration + slack) {
        return csv_error(csv, field, error,
                         "time_s: expected 0 to %g s, the simulated time, found %g", duration,
                         *time);
    }
    if (motion->count > 0 && !(*time > motion->time[motion->count - 1])) {
        return csv_error(csv, field, error,
                         "time_s: expected more than %g s, the time before, "
                         "found %g",
                         motion->time[motion->count - 1], *time);
    }
    return STATUS_OK;
}

static enum status parse_row(struct motion *motion, const struct csv *csv,
                             const struct motion_columns *columns, double duration,
                             struct error *error)
{
    if (csv->field_count != columns->count) {
        return csv_error(csv, MIN(csv->field_count, columns->count), error,
                         "expected %u fields as in the header, found %u", columns->count,
                         csv->field_count);
    }
    double time;
    if (parse_time(motion, csv, columns->time, duration, &time, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    const uint32_t last = motion->count;
    for (int i = 0; i < MOTION_QUANTITY_COUNT; i++) {
        const uint32_t field = columns->quantity[i];
        if (field == columns->count) {
            continue;
        }
        motion->value[i] = g_renew(double, motion->value[i], last + 1);
        if (csv_number(csv, field, quantities[i].name, quantities[i].unit, &motion->value[i][last],
                       error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    motion->time = g_renew(double, motion->time, last + 1);
    motion->time[last] = time;
    motion->count++;
    return STATUS_OK;
}

static enum status parse_rows(struct motion *motion, struct csv *csv,
                              const struct motion_columns *columns, double duration,
                              struct error *error)
{
    for (;;) {
        if (csv_row(csv, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
        if (csv->field_count == 0) {
            break;
        }
        if (parse_row(motion, csv, columns, duration, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    if (motion->count < 2) {
        return csv_error(csv, 0, error, "expected at least 2 times, found %u", motion->count);
    }
    return STATUS_OK;
}

enum status motion_parse(struct motion *motion, double duration, const char *source,
                         const char *text, size_t size, struct error *error)
{
    *motion = (struct motion){0};
    struct csv csv;
    struct motion_columns columns;
    csv_start(&csv, source, text, size);
    if (parse_header(&csv, &columns, error) != STATUS_OK ||
        parse_rows(motion, &csv, &columns, duration, error) != STATUS_OK) {
        motion_fini(motion);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

double motion_error(const struct motion *motion, enum motion_quantity quantity, const double *time,
                    const double *value, uint32_t count, size_t stride)
{
    assert(motion->value[quantity] != NULL);
    assert(count >= 2);
    double sum = 0.0;
    uint32_t after = 1; // the first simulated time not before the reference's
    for (uint32_t i = 0; i < motion->count; i++) {
        while (after + 1 < count && time[after * stride] < motion->time[i]) {
            after++;
        }
        const double start = time[(after - 1) * stride];
        const double share = fmin((motion->time[i] - start) / (time[after * stride] - start), 1.0);
        const double from = value[(after - 1) * stride];
        const double simulated = from + share * (value[after * stride] - from);
        sum += fabs(simulated - motion->value[quantity][i]);
    }
    return sum / motion->count;
}
