#include "worker/reduction/balance.h"

#include <glib.h>
#include <math.h>

// The integrals of the forces of one direction, from the first time on.
struct integrals {
    const struct balance_sample *samples;
    uint32_t count;
    double *impulse; // [N s] (count)
    double *twice;   // [N s2] (count) integral of the impulse
};

// ---- Integrals ----

static void integrals_init(struct integrals *integrals, const struct balance_sample *samples,
                           uint32_t count, int direction, double sign)
{
    *integrals = (struct integrals){
        .samples = samples,
        .count = count,
        .impulse = g_new0(double, count),
        .twice = g_new0(double, count),
    };
    double *impulse = integrals->impulse;
    for (uint32_t i = 1; i < count; i++) {
        const double span = samples[i].time - samples[i - 1].time;
        const double sum = samples[i].force[direction] + samples[i - 1].force[direction];
        impulse[i] = impulse[i - 1] + 0.5 * sign * span * sum;
        integrals->twice[i] = integrals->twice[i - 1] + 0.5 * span * (impulse[i] + impulse[i - 1]);
    }
}

static void integrals_fini(struct integrals *integrals)
{
    g_free(integrals->impulse);
    g_free(integrals->twice);
}

// The integral of the impulse from the first time to `time`, which lies within all times.
static double twice_at(const struct integrals *integrals, double time)
{
    const struct balance_sample *samples = integrals->samples;
    uint32_t low = 0;
    uint32_t high = integrals->count - 1;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (samples[middle].time <= time) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const double span = time - samples[low].time;
    const double share = span / (samples[high].time - samples[low].time);
    const double from = integrals->impulse[low];
    const double here = from + share * (integrals->impulse[high] - from);
    return integrals->twice[low] + 0.5 * span * (from + here);
}

// ---- The two tenths ----

// Indices of the motion's times that begin and end the first and the last tenth.
struct tenths {
    uint32_t first, first_end, last_start, last;
};

static bool find_tenths(const struct motion *motion, double from, double to, struct tenths *tenths)
{
    uint32_t first = 0;
    uint32_t last = motion->count - 1;
    while (first < last && motion->time[first] < from) {
        first++;
    }
    while (last > first && motion->time[last] > to) {
        last--;
    }
    if (last - first < 2) {
        return false;
    }
    const double tenth = 0.1 * (motion->time[last] - motion->time[first]);
    *tenths = (struct tenths){first, first + 1, last - 1, last};
    while (motion->time[tenths->first_end] < motion->time[first] + tenth) {
        tenths->first_end++;
    }
    while (motion->time[tenths->last_start] > motion->time[last] - tenth) {
        tenths->last_start--;
    }
    return true;
}

static double mean_velocity(const struct motion *motion, int quantity, uint32_t from, uint32_t to)
{
    return (motion->value[quantity][to] - motion->value[quantity][from]) /
           (motion->time[to] - motion->time[from]);
}

static double mean_impulse(const struct integrals *integrals, const struct motion *motion,
                           uint32_t from, uint32_t to)
{
    return (twice_at(integrals, motion->time[to]) - twice_at(integrals, motion->time[from])) /
           (motion->time[to] - motion->time[from]);
}

// ---- One direction ----

// How far the forces have moved a body of `inertia` from free motion.
static double moved_at(const struct integrals *integrals, const struct motion *motion,
                       const struct tenths *tenths, double inertia, uint32_t index)
{
    return (twice_at(integrals, motion->time[index]) -
            twice_at(integrals, motion->time[tenths->first])) /
           inertia;
}

// How far the motion misses at the time with that index what the forces give a body of `inertia`
// that begins as the motion does.
static double miss_at(const struct integrals *integrals, const struct motion *motion, int quantity,
                      const struct tenths *tenths, double inertia, uint32_t index)
{
    const double start = motion->time[tenths->first];
    const double velocity =
        mean_velocity(motion, quantity, tenths->first, tenths->first_end) -
        mean_impulse(integrals, motion, tenths->first, tenths->first_end) / inertia;
    return motion->value[quantity][index] - motion->value[quantity][tenths->first] -
           velocity * (motion->time[index] - start) -
           moved_at(integrals, motion, tenths, inertia, index);
}

static void make_line(struct balance *balance, const struct integrals *integrals,
                      const struct motion *motion, int quantity, const struct tenths *tenths,
                      double inertia, double speed)
{
    const double none = 0.01; // of the momentum before the crash: no change to compare with
    struct balance_line *line = &balance->lines[quantity];
    line->change = inertia * (mean_velocity(motion, quantity, tenths->last_start, tenths->last) -
                              mean_velocity(motion, quantity, tenths->first, tenths->first_end));
    line->impulse = mean_impulse(integrals, motion, tenths->last_start, tenths->last) -
                    mean_impulse(integrals, motion, tenths->first, tenths->first_end);
    line->ratio = fabs(line->change) > none * inertia * speed ? line->impulse / line->change : NAN;
    for (uint32_t i = tenths->first; i <= tenths->last; i++) {
        line->error += fabs(miss_at(integrals, motion, quantity, tenths, inertia, i));
        line->moved += fabs(moved_at(integrals, motion, tenths, inertia, i));
    }
    line->error /= tenths->last - tenths->first + 1;
    line->moved /= tenths->last - tenths->first + 1;
    if (quantity == MOTION_X && line->change != 0.0) {
        balance->late = miss_at(integrals, motion, quantity, tenths, inertia, tenths->last) *
                        inertia / line->change;
    }
}

static void take_ends(struct balance *balance, const struct balance_sample *samples, uint32_t count,
                      const struct motion *motion)
{
    balance->span = samples[count - 1].time - samples[0].time;
    balance->force_last = fabs(samples[count - 1].force[MOTION_X]);
    for (uint32_t i = 0; i < count; i++) {
        balance->force_max = fmax(balance->force_max, fabs(samples[i].force[MOTION_X]));
    }
    balance->time_first = motion->time[0];
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        balance->place[k] = motion->value[k][0];
        for (uint32_t i = 0; i < motion->count; i++) {
            const double travel = fabs(motion->value[k][i] - balance->place[k]);
            balance->travel[k] = fmax(balance->travel[k], travel);
        }
    }
}

void balance_make(struct balance *balance, const struct balance_sample *samples, uint32_t count,
                  double sign, const struct motion *motion, const struct scenario *scenario)
{
    const struct scenario_vehicle *vehicle = &scenario->vehicle;
    const double inertia[MOTION_QUANTITY_COUNT] = {
        [MOTION_X] = vehicle->mass,
        [MOTION_Y] = vehicle->mass,
        [MOTION_YAW] = vehicle->yaw_inertia,
    };
    struct tenths tenths;
    *balance = (struct balance){0};
    take_ends(balance, samples, count, motion);
    balance->known = find_tenths(motion, samples[0].time, samples[count - 1].time, &tenths);
    if (!balance->known) {
        return;
    }
    balance->speed = -mean_velocity(motion, MOTION_X, tenths.first, tenths.first_end);
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        struct integrals integrals;
        integrals_init(&integrals, samples, count, k, sign);
        // A yaw of one radian a second counts as a speed of one metre a second would.
        make_line(balance, &integrals, motion, k, &tenths, inertia[k],
                  k == MOTION_YAW ? 1.0 : vehicle->speed);
        integrals_fini(&integrals);
    }
}
