// A measured or finite-element motion of the COG to compare a simulated one with: a CSV file with a
// header, the column time_s and any of x_m, y_m, yaw_rad; other columns are passed over.
#ifndef SOBOX_WORKER_MODELS_MOTION_H
#define SOBOX_WORKER_MODELS_MOTION_H

#include "common/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum motion_quantity { MOTION_X, MOTION_Y, MOTION_YAW, MOTION_QUANTITY_COUNT };

struct motion {
    uint32_t count;                       // times, at least 2
    double *time;                         // [s] strictly ascending (count)
    double *value[MOTION_QUANTITY_COUNT]; // [m, m, rad] (count), or NULL where there is no column
};

// The column's name: "x_m", "y_m", "yaw_rad".
const char *motion_quantity_name(enum motion_quantity quantity);

// Reads a motion from the text of a CSV file; `source` stands for the file in messages. Times lie
// within 0 .. duration. On success the caller releases it with motion_fini(); else it is left
// zeroed. Errors: STATUS_INVALID.
enum status motion_parse(struct motion *motion, double duration, const char *source,
                         const char *text, size_t size, struct error *error) MUST_USE;

// Releases a motion. A zeroed struct is fine.
void motion_fini(struct motion *motion);

// Mean absolute error of a simulated quantity (thesis eq. 7.1): the mean of |P_i - O_i| over the
// reference's times, P linear between simulated times. time[i * stride], value[i * stride] (count)
// are the simulation's, times ascending from 0. The motion has that quantity.
double motion_error(const struct motion *motion, enum motion_quantity quantity, const double *time,
                    const double *value, uint32_t count, size_t stride);

#endif
