// Design notes. The state is (x, y, yaw) and its rate. Between two events every spring has a fixed
// mode, so the right side is smooth and Runge-Kutta is of its order; a trial step after which some
// spring no longer fits its mode is halved until the event lies between two times that are 1e-13 s
// apart. What a switch does then is decided by the acceleration of the deformation on either side.
#include "tests/physics/reference.h"

#include <math.h>
#include <string.h>

enum mode {
    AWAY, // the line misses the barrier, or the spring is longer than undeformed
    OFF,  // in contact and without force
    ON,   // loading
    HELD, // its deformation rests at the switch; some share of its force acts
};

enum { FREEDOM = 3, HELD_SWEEPS = 60, CUTS = 60 };

static const double event_width = 1e-13; // [s] to which an event's time is found
static const double rate_zero = 1e-7;    // [m/s] below which a deformation rests
static const double held_time = 1e-4;    // [s] in which a held spring loses what rate it has left

struct state {
    double q[FREEDOM]; // [m, m, rad] from time 0
    double v[FREEDOM];
};

struct touch {
    bool contact;
    double deformation;  // [m]
    double p2[2];        // [m]
    double row[FREEDOM]; // rate of deformation = row . v
};

struct run {
    const struct reference_crash *crash;
    enum mode mode[REFERENCE_SPRING_MAX];
    double deepest[REFERENCE_SPRING_MAX]; // [m] in contact so far
    struct state now;
    struct reference_outcome outcome;
};

static double dot(const double *a, const double *b, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

// Where the line p1 - t axis meets the barrier first, seen from the vehicle. Returns false where it
// misses; t, p2 and the normal are then those of the plane of the face.
static bool meet(const struct reference_crash *crash, const double p1[2], const double axis[2],
                 double *t, double p2[2], double normal[2])
{
    const double flat_top = crash->edge_y - crash->radius;
    *t = (p1[0] - crash->face_x) / axis[0];
    p2[0] = crash->face_x;
    p2[1] = p1[1] - *t * axis[1];
    normal[0] = 1.0;
    normal[1] = 0.0;
    if (p2[1] <= flat_top || crash->radius == 0.0) {
        return p2[1] >= crash->edge_y - crash->width && p2[1] <= crash->edge_y;
    }
    // |p1 - t axis - centre| = radius, the nearer of two solutions, on the quarter that the
    // barrier has.
    const double centre[2] = {crash->face_x - crash->radius, flat_top};
    const double from[2] = {p1[0] - centre[0], p1[1] - centre[1]};
    const double half = dot(from, axis, 2);
    const double inside = half * half - dot(from, from, 2) + crash->radius * crash->radius;
    if (inside < 0.0) {
        return false;
    }
    const double nearer = half - sqrt(inside);
    const double arm[2] = {from[0] - nearer * axis[0], from[1] - nearer * axis[1]};
    if (arm[0] < 0.0 || arm[1] < 0.0) {
        return false;
    }
    *t = nearer;
    for (int i = 0; i < 2; i++) {
        p2[i] = centre[i] + arm[i];
        normal[i] = arm[i] / crash->radius;
    }
    return true;
}

static struct touch touch(const struct reference_crash *crash, uint32_t index, const double *q)
{
    const struct reference_spring *spring = &crash->springs[index];
    const double axis[2] = {cos(q[2]), sin(q[2])};
    const double across[2] = {-axis[1], axis[0]};
    double arm[2]; // of P1 from the COG, in road axes
    double p1[2];
    for (int i = 0; i < 2; i++) {
        arm[i] = spring->place[0] * axis[i] + spring->place[1] * across[i];
        p1[i] = crash->cog[i] + q[i] + arm[i];
    }
    struct touch found;
    double t;
    double normal[2];
    const bool meets = meet(crash, p1, axis, &t, found.p2, normal);
    found.deformation = spring->length - t;
    found.contact = meets && found.deformation > 0.0 && axis[0] > 0.0;
    // P2 stays on the barrier: normal . (rate of p1 - t axis) = 0 gives the rate of t.
    const double turning[2] = {-arm[1] - t * across[0], arm[0] - t * across[1]};
    const double slope = dot(normal, axis, 2);
    found.row[0] = -normal[0] / slope;
    found.row[1] = -normal[1] / slope;
    found.row[2] = -dot(normal, turning, 2) / slope;
    return found;
}

static double force(const struct reference_spring *spring, int direction, double s)
{
    const double *at = spring->deformation;
    const double *of = spring->force[direction];
    const uint32_t last = spring->point_count - 1;
    if (s < at[0]) {
        return 0.0;
    }
    for (uint32_t i = 0; i < last; i++) {
        if (s < at[i + 1]) {
            return of[i] + (of[i + 1] - of[i]) * (s - at[i]) / (at[i + 1] - at[i]);
        }
    }
    return of[last];
}

// The accelerations that the whole force of a spring gives the vehicle.
static void push(const struct reference_crash *crash, uint32_t index, const double *q,
                 const struct touch *at, double a[FREEDOM])
{
    const double local[2] = {force(&crash->springs[index], 0, at->deformation),
                             force(&crash->springs[index], 1, at->deformation)};
    const double road[2] = {cos(q[2]) * local[0] - sin(q[2]) * local[1],
                            sin(q[2]) * local[0] + cos(q[2]) * local[1]};
    const double lever[2] = {at->p2[0] - crash->cog[0] - q[0], at->p2[1] - crash->cog[1] - q[1]};
    a[0] = road[0] / crash->mass;
    a[1] = road[1] / crash->mass;
    a[2] = (lever[0] * road[1] - lever[1] * road[0]) / crash->yaw_inertia;
}

// What the deformation's rate gains in a second while nothing pushes: the row changes on the way.
static double drift(const struct reference_crash *crash, uint32_t index, const struct state *state)
{
    const double e = 1e-7; // [s]
    double there[2][FREEDOM];
    for (int i = 0; i < FREEDOM; i++) {
        there[0][i] = state->q[i] - e * state->v[i];
        there[1][i] = state->q[i] + e * state->v[i];
    }
    const struct touch before = touch(crash, index, there[0]);
    const struct touch after = touch(crash, index, there[1]);
    if (before.contact != after.contact) {
        return 0.0;
    }
    return (dot(after.row, state->v, FREEDOM) - dot(before.row, state->v, FREEDOM)) / (2.0 * e);
}

// Accelerations of the vehicle; `share` receives the part of its force that each spring has.
static void accelerate(const struct run *run, const struct state *state, double total[FREEDOM],
                       double share[REFERENCE_SPRING_MAX])
{
    const struct reference_crash *crash = run->crash;
    struct touch at[REFERENCE_SPRING_MAX];
    double own[REFERENCE_SPRING_MAX][FREEDOM];
    bool held = false;
    memset(total, 0, FREEDOM * sizeof *total);
    for (uint32_t i = 0; i < crash->spring_count; i++) {
        share[i] = run->mode[i] == ON ? 1.0 : 0.0;
        held |= run->mode[i] == HELD;
        if (run->mode[i] != ON && run->mode[i] != HELD) {
            continue;
        }
        at[i] = touch(crash, i, state->q);
        push(crash, i, state->q, &at[i], own[i]);
        for (int k = 0; k < FREEDOM; k++) {
            total[k] += share[i] * own[i][k];
        }
    }
    for (int sweep = 0; held && sweep < HELD_SWEEPS; sweep++) {
        for (uint32_t i = 0; i < crash->spring_count; i++) {
            if (run->mode[i] != HELD) {
                continue;
            }
            const double by_own = dot(at[i].row, own[i], FREEDOM);
            const double others = dot(at[i].row, total, FREEDOM) - share[i] * by_own;
            const double wanted =
                others + drift(crash, i, state) + dot(at[i].row, state->v, FREEDOM) / held_time;
            const double part = by_own < 0.0 ? fmin(fmax(-wanted / by_own, 0.0), 1.0) : 0.0;
            for (int k = 0; k < FREEDOM; k++) {
                total[k] += (part - share[i]) * own[i][k];
            }
            share[i] = part;
        }
    }
}

static struct state advance(const struct run *run, double h)
{
    static const double reach[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const struct state *from = &run->now;
    struct state to = *from;
    double rate[FREEDOM] = {0.0};
    double a[FREEDOM] = {0.0};
    double share[REFERENCE_SPRING_MAX];
    for (int stage = 0; stage < 4; stage++) {
        struct state there;
        for (int i = 0; i < FREEDOM; i++) {
            there.q[i] = from->q[i] + reach[stage] * h * rate[i];
            there.v[i] = from->v[i] + reach[stage] * h * a[i];
        }
        accelerate(run, &there, a, share);
        for (int i = 0; i < FREEDOM; i++) {
            rate[i] = there.v[i];
            to.q[i] += weight[stage] * h * rate[i];
            to.v[i] += weight[stage] * h * a[i];
        }
    }
    return to;
}

// Whether a spring's mode no longer fits what it does.
static bool outgrown(const struct run *run, uint32_t index, const struct state *state)
{
    const struct touch at = touch(run->crash, index, state->q);
    const double rate = dot(at.row, state->v, FREEDOM);
    double total[FREEDOM];
    double share[REFERENCE_SPRING_MAX];
    if (at.contact != (run->mode[index] != AWAY)) {
        return true;
    }
    switch (run->mode[index]) {
    case ON:
        return rate < 0.0;
    case OFF:
        return run->crash->crushed ? at.deformation > run->deepest[index] : rate > 0.0;
    case HELD:
        accelerate(run, state, total, share);
        return (share[index] >= 1.0 && rate > rate_zero) ||
               (share[index] <= 0.0 && rate < -rate_zero);
    case AWAY:
        break;
    }
    return false;
}

static bool any_outgrown(const struct run *run, const struct state *state)
{
    for (uint32_t i = 0; i < run->crash->spring_count; i++) {
        if (outgrown(run, i, state)) {
            return true;
        }
    }
    return false;
}

// The acceleration of a spring's deformation with none and with all of its own force.
static void either_side(struct run *run, uint32_t index, double *without, double *with)
{
    double total[FREEDOM];
    double share[REFERENCE_SPRING_MAX];
    const struct touch at = touch(run->crash, index, run->now.q);
    const enum mode mode = run->mode[index];
    run->mode[index] = OFF;
    accelerate(run, &run->now, total, share);
    *without = dot(at.row, total, FREEDOM) + drift(run->crash, index, &run->now);
    double own[FREEDOM];
    push(run->crash, index, run->now.q, &at, own);
    *with = *without + dot(at.row, own, FREEDOM);
    run->mode[index] = mode;
}

static enum mode next_mode(struct run *run, uint32_t index)
{
    const struct touch at = touch(run->crash, index, run->now.q);
    const double rate = dot(at.row, run->now.v, FREEDOM);
    const enum mode mode = run->mode[index];
    const bool beyond = !run->crash->crushed || at.deformation > run->deepest[index];
    double without, with;
    if (!at.contact) {
        return AWAY;
    }
    if (mode == AWAY) {
        return rate > 0.0 && beyond ? ON : OFF;
    }
    either_side(run, index, &without, &with);
    if (mode == HELD) {
        return rate > 0.0 ? ON : OFF;
    }
    if (mode == ON) {
        return without > 0.0 ? HELD : OFF;
    }
    return with < 0.0 && rate < rate_zero ? HELD : ON;
}

static void observe(struct run *run, const struct state *state)
{
    struct reference_outcome *outcome = &run->outcome;
    outcome->yaw_max = fmax(outcome->yaw_max, fabs(state->q[2]));
    for (uint32_t i = 0; i < run->crash->spring_count; i++) {
        const struct touch at = touch(run->crash, i, state->q);
        if (!at.contact) {
            continue;
        }
        run->deepest[i] = fmax(run->deepest[i], at.deformation);
        if (i == 0) {
            outcome->length_last = run->crash->springs[0].length - at.deformation;
            outcome->length_min = fmin(outcome->length_min, outcome->length_last);
        }
    }
}

// One step of h, or up to the first event in it. Returns what it took.
static double step(struct run *run, double h)
{
    struct state to = advance(run, h);
    if (!any_outgrown(run, &to)) {
        run->now = to;
        observe(run, &to);
        return h;
    }
    double before = 0.0;
    double after = h;
    for (int cut = 0; cut < CUTS && after - before > event_width; cut++) {
        const double middle = 0.5 * (before + after);
        const struct state there = advance(run, middle);
        *(any_outgrown(run, &there) ? &after : &before) = middle;
    }
    const struct state last = advance(run, before);
    observe(run, &last);
    run->now = advance(run, after);
    enum mode modes[REFERENCE_SPRING_MAX];
    for (uint32_t i = 0; i < run->crash->spring_count; i++) {
        modes[i] = outgrown(run, i, &run->now) ? next_mode(run, i) : run->mode[i];
    }
    memcpy(run->mode, modes, sizeof modes);
    observe(run, &run->now);
    run->outcome.events++;
    return after;
}

struct reference_outcome reference_evaluate(const struct reference_crash *crash)
{
    struct run run = {.crash = crash, .now.v = {-crash->speed}};
    const struct reference_spring *first = &crash->springs[0];
    run.outcome.length_last = run.outcome.length_min = first->length;
    for (uint32_t i = 0; i < crash->spring_count; i++) {
        run.deepest[i] = -INFINITY;
        run.mode[i] = touch(crash, i, run.now.q).contact ? ON : AWAY;
    }
    for (double time = 0.0; time < crash->duration - event_width;) {
        bool contact = false;
        for (uint32_t i = 0; i < crash->spring_count; i++) {
            contact |= run.mode[i] != AWAY;
        }
        const double taken = step(&run, fmin(crash->step, crash->duration - time));
        time += taken;
        run.outcome.contact_time += contact ? taken : 0.0;
    }
    const double *q = run.now.q;
    const double y = first->place[0] * sin(q[2]) + first->place[1] * cos(q[2]);
    run.outcome.pillar_travel = q[1] + y - first->place[1];
    run.outcome.projection_travel = touch(crash, 0, q).p2[1] - crash->cog[1] - first->place[1];
    run.outcome.yaw = q[2];
    memcpy(run.outcome.travel, q, sizeof run.outcome.travel);
    memcpy(run.outcome.velocity, run.now.v, sizeof run.outcome.velocity);
    return run.outcome;
}
