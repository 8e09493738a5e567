#include "worker/reduction/doubts.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <stdarg.h>

// The limits of the table in doubts.h.
static const double speed_share_min = 0.7;
static const double speed_share_max = 1.1;
static const double place_max[MOTION_QUANTITY_COUNT] = {0.05, 0.05, 0.05}; // [m, m, rad]
static const double closure_max = 0.10;
static const double closure_yaw_max = 0.25;
static const double lateral_share = 0.05; // of the change in x
static const double lever = 0.05;         // [m]
static const double moved_share_max = 0.10;
static const double end_share_max = 0.20;
static const double span_max = 5.0;    // [s]
static const double travel_max = 50.0; // [m]
static const double ratio_min = 0.02;
static const double ratio_max = 10.0;

// Slips that a ratio of impulse to change of momentum gives away.
static const struct {
    double from, to;
    const char *slip;
} slips[] = {
    {0.0, 0.0005, "both sides of the contact in one table, or units"},
    {0.0005, 0.002, "forces in kN"},
    {0.09, 0.115, "forces in kgf"},
    {0.20, 0.25, "forces in lbf"},
    {0.4, 0.6, "half of the cells, or one half of the car, is missing"},
    {0.0, 1.0, "cells, parts or times without their forces, or too large a vehicle.mass"},
    {1.8, 2.2, "forces counted twice"},
    {500.0, 2000.0, "vehicle.mass in t, forces in mN, or the forces' times in ms"},
    {1.0, INFINITY, "forces counted more than once, or too small a vehicle.mass"},
};

static const char *slip_of(double ratio)
{
    size_t i = 0;
    while (i + 1 < G_N_ELEMENTS(slips) && !(ratio >= slips[i].from && ratio < slips[i].to)) {
        i++;
    }
    return slips[i].slip;
}

static bool within(double value, double from, double to)
{
    return value >= from && value <= to;
}

// Adds a text. After one of the impossible there is nothing more to say.
__attribute__((format(printf, 3, 4))) static void note(struct doubts *doubts, bool impossible,
                                                       const char *format, ...)
{
    assert(doubts->count < DOUBTS_MAX);
    assert(!doubts->impossible);
    va_list arguments;
    va_start(arguments, format);
    g_vsnprintf(doubts->text[doubts->count++], DOUBTS_TEXT_SIZE, format, arguments);
    va_end(arguments);
    doubts->impossible = impossible;
}

// ---- The motion alone ----

static void judge_units(struct doubts *doubts, const struct balance *balance)
{
    const double *travel = balance->travel;
    if (balance->span > span_max) {
        note(doubts, true,
             "the forces last %g s: expected the times of a crash in s, at most %g s (in ms?)",
             balance->span, span_max);
    } else if (fmax(travel[MOTION_X], travel[MOTION_Y]) > travel_max) {
        note(doubts, true,
             "the motion travels %g m: expected the travel of a crash in m, at most %g m (in mm?)",
             fmax(travel[MOTION_X], travel[MOTION_Y]), travel_max);
    } else if (travel[MOTION_YAW] > 2.0 * G_PI) {
        note(doubts, true,
             "the motion yaws by %g rad, more than a full turn: expected yaw_rad in radians "
             "(in degrees?)",
             travel[MOTION_YAW]);
    } else if (!balance->known) {
        note(doubts, true,
             "fewer than three times of the motion lie within those of the forces: expected "
             "the same crash from the same instant on");
    }
}

static void judge_speed(struct doubts *doubts, const struct balance *balance, double speed)
{
    const double share = balance->speed / speed;
    if (within(share, speed_share_min, speed_share_max)) {
        return;
    }
    const bool impossible = share < -speed_share_min || !within(fabs(share), ratio_min, ratio_max);
    const char *slip = share < -speed_share_min ? "x_m of opposite sign: forwards is -x"
                       : share > ratio_max      ? "the motion in mm"
                       : share < ratio_min      ? "the motion's times in ms, or x_m in km or of "
                                                  "another direction"
                                                : "vehicle.speed, or the motion's units or start";
    note(doubts, impossible,
         "the motion begins at %.4g m/s towards the barrier, the scenario at %.4g m/s: expected "
         "%.2g to %.2g of it in the first tenth of the time (%s?)",
         balance->speed, speed, speed_share_min, speed_share_max, slip);
}

static void judge_place(struct doubts *doubts, const struct balance *balance, const double cog[2])
{
    const double expected[MOTION_QUANTITY_COUNT] = {cog[0], cog[1], 0.0};
    for (int k = 0; k < MOTION_QUANTITY_COUNT; k++) {
        if (balance->time_first == 0.0 && fabs(balance->place[k] - expected[k]) > place_max[k]) {
            note(doubts, false,
                 "the motion's %s begins with %.4g, the scenario's vehicle with %.4g: expected the "
                 "centre of gravity at first contact in the scenario's axes",
                 motion_quantity_name((enum motion_quantity)k), balance->place[k], expected[k]);
        }
    }
}

// ---- Forces and motion ----

static void judge_x(struct doubts *doubts, const struct balance *balance)
{
    const struct balance_line *x = &balance->lines[MOTION_X];
    // A cumulated impulse ends with the change of momentum; a force ends with none.
    const bool impulses = x->ratio < 1.0 - closure_max &&
                          balance->force_last >= 0.8 * balance->force_max &&
                          within(balance->force_last, 0.7 * x->change, 1.3 * x->change);
    if (fabs(x->ratio - 1.0) <= closure_max) {
        return;
    }
    // A ratio that is not a number means a vehicle that nothing slows.
    const bool impossible = impulses || !within(x->ratio, ratio_min, ratio_max);
    note(doubts, impossible,
         "the forces' impulse in x is %.4g N s, the motion's change of momentum %.4g N s, ratio "
         "%.3g: expected 1 within %g (%s?)",
         x->impulse, x->change, x->ratio, closure_max,
         impulses             ? "impulses in N s in place of forces"
         : isnan(x->ratio)    ? "a motion that ends before the crash, or of another vehicle"
         : !(x->ratio >= 0.0) ? "forces or x_m of opposite sign"
                              : slip_of(x->ratio));
}

// What explains x explains the other directions too: half of the cells have half of every impulse.
static double share_of_all(const struct balance *balance)
{
    const double ratio = balance->lines[MOTION_X].ratio;
    return fabs(ratio - 1.0) > closure_max ? ratio : 1.0;
}

static void judge_aside(struct doubts *doubts, const struct balance *balance)
{
    const struct balance_line *line = &balance->lines[MOTION_Y];
    const double base = fabs(balance->lines[MOTION_X].change);
    const double impulse = line->impulse / share_of_all(balance);
    const double most = fmax(fabs(impulse), fabs(line->change));
    if (fabs(impulse - line->change) > closure_max * most + lateral_share * base) {
        note(
            doubts, false,
            "the forces' impulse in y is %.4g N s, the motion's change of momentum %.4g N s, ratio "
            "%.3g: expected 1 within %g (%s?)",
            line->impulse, line->change, line->ratio, closure_max,
            line->impulse == 0.0                ? "no lateral forces measured"
            : within(line->ratio, -1.25, -0.75) ? "y of forces or motion of opposite sign: y is "
                                                  "to the vehicle's right"
                                                : "lateral forces missing, or axes that differ");
    }
}

static void judge_yaw(struct doubts *doubts, const struct balance *balance)
{
    const struct balance_line *line = &balance->lines[MOTION_YAW];
    const double base = lever * fabs(balance->lines[MOTION_X].change);
    const double impulse = line->impulse / share_of_all(balance);
    const double most = fmax(fabs(impulse), fabs(line->change));
    const double ratio = line->ratio;
    if (fabs(impulse - line->change) > closure_yaw_max * most + base) {
        note(doubts, false,
             "the impulse of the forces' moment is %.4g N m s, the motion's change of angular "
             "momentum %.4g N m s, ratio %.3g: expected 1 within %g (%s?)",
             line->impulse, line->change, ratio, closure_yaw_max,
             within(ratio, -1.3, -0.7)     ? "yaw_rad or the nodes' y_m of opposite sign"
             : within(ratio, 0.012, 0.025) ? "yaw_rad in degrees"
                                           : "nodes' y_m, lateral forces, vehicle.yaw_inertia");
    }
}

// Forces that close but act at other times give another motion.
static void judge_times(struct doubts *doubts, const struct balance *balance)
{
    const struct balance_line *x = &balance->lines[MOTION_X];
    const bool closed = fabs(x->ratio - 1.0) <= closure_max;
    if (closed && x->error > moved_share_max * x->moved) {
        note(doubts, false,
             "the motion differs from what the forces alone give by %.3g m on average, where they "
             "move the vehicle by %.3g m: expected at most %g of it (forces about %.2g ms too %s?)",
             x->error, x->moved, moved_share_max, 1e3 * fabs(balance->late),
             balance->late > 0.0 ? "late" : "early");
    }
    if (balance->force_last > end_share_max * balance->force_max) {
        note(
            doubts, false,
            "the forces end with %.4g N in x, %.2g of their greatest: expected at most %g (a table "
            "that is cut off before the crash ends?)",
            balance->force_last, balance->force_last / balance->force_max, end_share_max);
    }
}

void doubts_find(struct doubts *doubts, const struct balance *balance,
                 const struct scenario *scenario)
{
    *doubts = (struct doubts){0};
    judge_units(doubts, balance);
    if (!doubts->impossible) {
        judge_speed(doubts, balance, scenario->vehicle.speed);
    }
    if (!doubts->impossible) {
        judge_place(doubts, balance, scenario->vehicle.cog);
        judge_x(doubts, balance);
    }
    if (!doubts->impossible) {
        judge_aside(doubts, balance);
        judge_yaw(doubts, balance);
        judge_times(doubts, balance);
    }
}
