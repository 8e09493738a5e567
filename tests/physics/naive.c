#include "tests/physics/naive.h"

#include <math.h>
#include <stdbool.h>

enum { X, Y, YAW, FREEDOM };

struct naive_spring {
    double length;      // [m] l
    double deformation; // [m] s
    double p2[2];       // [m] where forces act
    double projection;  // [m] y on the barrier, or on the plane of the face
    double normal[2];   // of the barrier at P2
    bool contact;
    double force[2];      // [N] in vehicle axes
    double work[2];       // [J] done on the vehicle by its x force, its y force
    double deepest;       // [m] greatest deformation in contact
    double before;        // [m] deformation that loading is told from
    double margin;        // [m] to the nearer end of the face
    double slip;          // [m] length with which it slips off there
    bool slipped;         // off a rounded edge within the step,
    double slip_length;   // [m] at this length
    bool touched;         // at the time before
    double slip_before;   // [m] slip at the time before
    double margin_before; // [m]
};

struct naive {
    const struct kinematics_setup *setup;
    const double *values;
    struct naive_spring springs[KINEMATICS_SPRING_MAX];
    double force[2]; // [N] sums in road axes
    double moment;   // [Nm]
    double work_rate[KINEMATICS_SPRING_MAX];
    bool slipped;       // spring 0 slipped off a rounded edge within the step,
    double slip_length; // [m] at this length
    // Gathered for the results.
    double length_last, length_min, yaw_max, ax_max, ax_sum;
    double contacts;
};

static double interpolate(const struct kinematics_curve *curve, const double *force, double s)
{
    const uint32_t last = curve->point_count - 1;
    if (s < curve->deformation[0]) {
        return 0.0;
    }
    if (s >= curve->deformation[last]) {
        return force[last];
    }
    uint32_t i = 0;
    while (s >= curve->deformation[i + 1]) {
        i++;
    }
    const double share =
        (s - curve->deformation[i]) / (curve->deformation[i + 1] - curve->deformation[i]);
    return force[i] + share * (force[i + 1] - force[i]);
}

// Where the line from P1 along -(cos, sin) meets the barrier.
static void project(const struct kinematics_setup *setup, const double q[FREEDOM],
                    const struct kinematics_spring *at, struct naive_spring *spring)
{
    const double c = cos(q[YAW]);
    const double sn = sin(q[YAW]);
    const double p1[2] = {setup->cog[0] + q[X] + at->position[0] * c - at->position[1] * sn,
                          setup->cog[1] + q[Y] + at->position[0] * sn + at->position[1] * c};
    // Eq. 6.11 and 6.12, the length with its sign.
    spring->p2[0] = setup->face_x;
    spring->p2[1] = tan(q[YAW]) * (setup->face_x - p1[0]) + p1[1];
    spring->length = (p1[0] - setup->face_x) / c;
    spring->normal[0] = 1.0;
    spring->normal[1] = 0.0;
    const double flat_y = spring->p2[1];
    bool meets = spring->p2[1] >= setup->edge_y - setup->width && spring->p2[1] <= setup->edge_y;
    if (setup->profile == KINEMATICS_PROFILE_ROUNDED &&
        spring->p2[1] > setup->edge_y - setup->edge_radius) {
        const double r = setup->edge_radius;
        const double centre[2] = {setup->face_x - r, setup->edge_y - r};
        const double w[2] = {p1[0] - centre[0], p1[1] - centre[1]};
        const double along = w[0] * c + w[1] * sn;
        const double root = along * along - (w[0] * w[0] + w[1] * w[1] - r * r);
        meets = false;
        if (root >= 0.0) {
            const double length = along - sqrt(root);
            const double p2[2] = {p1[0] - length * c, p1[1] - length * sn};
            if (p2[0] >= centre[0]) {
                meets = true;
                spring->length = length;
                spring->p2[0] = p2[0];
                spring->p2[1] = p2[1];
                spring->normal[0] = (p2[0] - centre[0]) / r;
                spring->normal[1] = (p2[1] - centre[1]) / r;
            }
        }
    }
    spring->margin = fmin(setup->edge_y - flat_y, flat_y - (setup->edge_y - setup->width));
    spring->slip = spring->length;
    spring->projection = spring->p2[1];
    if (setup->profile == KINEMATICS_PROFILE_ROUNDED) {
        // Distance of the line from the circle's centre, towards the vehicle's left. The line is
        // tangent at r, or leaves the quarter at its end, whose height over the centre is r.
        const double r = setup->edge_radius;
        const double w[2] = {p1[0] - (setup->face_x - r), p1[1] - (setup->edge_y - r)};
        const double left = w[0] * sn - w[1] * c;
        const double foot = w[0] * c + w[1] * sn;
        const double inner = left + (sn > 0.0 ? r * c : r);
        const double outer = flat_y - (setup->edge_y - setup->width);
        const double slip = foot - (sn > 0.0 ? r * sn : 0.0);
        spring->margin = fmin(inner, outer);
        spring->slip = outer < inner ? (p1[0] - setup->face_x) / c : slip;
        if (!meets && flat_y > setup->edge_y - r) {
            spring->length = slip;
            spring->p2[0] = p1[0] - slip * c;
            spring->p2[1] = p1[1] - slip * sn;
        }
    }
    spring->deformation = at->length - spring->length;
    spring->contact = meets && spring->deformation > 0.0 && c > 0.0;
}

// Where a straight line from a to b is 0, from 0 at a to 1 at b.
static double crossing(double a, double b)
{
    return a / (a - b);
}

// Whether a spring slipped off the rounded edge since the time before, and with which length.
static void slip_off(struct naive *naive, uint32_t index)
{
    struct naive_spring *spring = &naive->springs[index];
    spring->slipped = spring->touched && !spring->contact && spring->margin < 0.0;
    spring->slip_length = spring->slip_before + crossing(spring->margin_before, spring->margin) *
                                                    (spring->slip - spring->slip_before);
    spring->slip_before = spring->slip;
    spring->margin_before = spring->margin;
    spring->touched = spring->contact;
    if (index == 0) {
        naive->slipped = spring->slipped;
        naive->slip_length = spring->slip_length;
    }
}

// Forces at a place; v is NULL where loading is told from the deformation before.
static void forces(struct naive *naive, const double q[FREEDOM], const double *v, bool settled)
{
    const struct kinematics_setup *setup = naive->setup;
    const double c = cos(q[YAW]);
    const double sn = sin(q[YAW]);
    const double cog[2] = {setup->cog[0] + q[X], setup->cog[1] + q[Y]};
    const double *values = naive->values;
    naive->force[0] = naive->force[1] = naive->moment = 0.0;
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        const struct kinematics_spring *at = &setup->springs[i];
        struct naive_spring *spring = &naive->springs[i];
        project(setup, q, at, spring);
        bool grows = spring->deformation > spring->before;
        if (v != NULL && setup->reloading == KINEMATICS_RELOADING_THESIS) {
            const double arm[2] = {spring->p2[0] - cog[0], spring->p2[1] - cog[1]};
            const double vp[2] = {v[X] - v[YAW] * arm[1], v[Y] + v[YAW] * arm[0]};
            grows = vp[0] * spring->normal[0] + vp[1] * spring->normal[1] < 0.0;
        }
        if (settled && setup->reloading == KINEMATICS_RELOADING_THESIS) {
            spring->before = spring->deformation;
        } else if (settled && spring->contact) {
            spring->before = fmax(spring->before, spring->deformation);
        }
        for (int direction = 0; direction < 2; direction++) {
            const double *load = values + direction * at->load.point_count;
            const double *unload =
                values + 2 * at->load.point_count + direction * at->unload.point_count;
            double force = 0.0;
            if (spring->contact && grows) {
                force = interpolate(&at->load, load, spring->deformation);
            } else if (spring->contact && at->unload.point_count > 0) {
                force = interpolate(&at->unload, unload, spring->deformation);
            }
            spring->force[direction] = force;
        }
        if (settled && setup->profile == KINEMATICS_PROFILE_ROUNDED) {
            slip_off(naive, i);
        }
        values += 2 * (at->load.point_count + at->unload.point_count);
        // Eq. 6.39 and 6.40.
        const double global[2] = {c * spring->force[0] - sn * spring->force[1],
                                  sn * spring->force[0] + c * spring->force[1]};
        naive->force[0] += global[0];
        naive->force[1] += global[1];
        naive->moment +=
            global[0] * (cog[1] - spring->p2[1]) - global[1] * (cog[0] - spring->p2[0]);
    }
}

// Adds each spring's work along a way of the COG, forces held.
static void work(struct naive *naive, const double q[FREEDOM], const double way[FREEDOM])
{
    const struct kinematics_setup *setup = naive->setup;
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        struct naive_spring *spring = &naive->springs[i];
        const double c = cos(q[YAW]);
        const double sn = sin(q[YAW]);
        const double arm[2] = {spring->p2[0] - setup->cog[0] - q[X],
                               spring->p2[1] - setup->cog[1] - q[Y]};
        const double moved[2] = {way[X] - way[YAW] * arm[1], way[Y] + way[YAW] * arm[0]};
        spring->work[0] += spring->force[0] * (c * moved[0] + sn * moved[1]);
        spring->work[1] += spring->force[1] * (c * moved[1] - sn * moved[0]);
    }
}

static void observe(struct naive *naive, const double q[FREEDOM])
{
    const struct naive_spring *first = &naive->springs[0];
    bool contact = false;
    for (uint32_t i = 0; i < naive->setup->spring_count; i++) {
        contact |= naive->springs[i].contact;
        struct naive_spring *spring = &naive->springs[i];
        if (spring->contact) {
            spring->deepest = fmax(spring->deepest, spring->deformation);
        } else if (spring->slipped) {
            spring->deepest =
                fmax(spring->deepest, naive->setup->springs[i].length - spring->slip_length);
        }
    }
    const double ax = naive->force[0] / naive->setup->mass;
    naive->yaw_max = fmax(naive->yaw_max, fabs(q[YAW]));
    naive->ax_max = fmax(naive->ax_max, fabs(ax));
    naive->ax_sum += ax;
    naive->contacts += contact;
    if (first->contact) {
        naive->length_last = first->length;
        naive->length_min = fmin(naive->length_min, first->length);
    } else if (naive->slipped) {
        naive->length_last = naive->slip_length;
        naive->length_min = fmin(naive->length_min, naive->slip_length);
    }
}

static void accelerate(const struct naive *naive, double a[FREEDOM])
{
    a[X] = naive->force[0] / naive->setup->mass;
    a[Y] = naive->force[1] / naive->setup->mass;
    a[YAW] = naive->moment / naive->setup->yaw_inertia;
}

// Eq. 6.41 to 6.44 with three places in memory; the velocity at the end from the last two places
// and half a step of the acceleration there. Velocity Verlet in its usual form: x += v dt + a dt^2
// / 2, v += (a_before + a_after) dt / 2, which has the work F (v_before dt + a dt^2/4 ...) spelled
// out.
static void step_differences(struct naive *naive, uint32_t n, double q[FREEDOM], double v[FREEDOM])
{
    const struct kinematics_setup *setup = naive->setup;
    const double dt = setup->time_step;
    const bool verlet = setup->integrator != KINEMATICS_CENTRAL_DIFFERENCE;
    double before[FREEDOM] = {0.0};
    double a[FREEDOM];
    forces(naive, before, NULL, true);
    accelerate(naive, a);
    if (verlet) {
        observe(naive, before);
    }
    const double kick = verlet ? 0.5 * dt * dt : 0.0;
    const double start[FREEDOM] = {-setup->speed * dt, 0.0, 0.0};
    double way[FREEDOM];
    for (int i = 0; i < FREEDOM; i++) {
        q[i] = start[i] + a[i] * kick;
        way[i] = verlet ? 0.25 * (start[i] + q[i]) : 0.0;
    }
    work(naive, before, way);
    for (uint32_t k = 1; k < n; k++) {
        forces(naive, q, NULL, true);
        observe(naive, q);
        accelerate(naive, a);
        double next[FREEDOM];
        for (int i = 0; i < FREEDOM; i++) {
            next[i] = a[i] * dt * dt + 2.0 * q[i] - before[i];
            way[i] = 0.5 * (next[i] - before[i]);
        }
        work(naive, q, way);
        for (int i = 0; i < FREEDOM; i++) {
            before[i] = q[i];
            q[i] = next[i];
        }
    }
    forces(naive, q, NULL, true);
    observe(naive, q);
    accelerate(naive, a);
    for (int i = 0; i < FREEDOM; i++) {
        const double half = (q[i] - before[i]) / dt;
        v[i] = half + 0.5 * a[i] * dt;
        way[i] = 0.25 * dt * (half + v[i]);
    }
    work(naive, q, way);
}

static void step_runge_kutta(struct naive *naive, uint32_t n, double q[FREEDOM], double v[FREEDOM])
{
    const struct kinematics_setup *setup = naive->setup;
    const double dt = setup->time_step;
    static const double to[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0, 2.0, 2.0, 1.0};
    for (uint32_t k = 0; k < n; k++) {
        double rate[FREEDOM] = {0.0};
        double a[FREEDOM] = {0.0};
        double q_sum[FREEDOM] = {0.0};
        double v_sum[FREEDOM] = {0.0};
        for (int stage = 0; stage < 4; stage++) {
            double place[FREEDOM];
            double there[FREEDOM];
            double way[FREEDOM];
            for (int i = 0; i < FREEDOM; i++) {
                place[i] = q[i] + to[stage] * dt * rate[i];
                there[i] = v[i] + to[stage] * dt * a[i];
                way[i] = weight[stage] * dt / 6.0 * there[i];
            }
            forces(naive, place, there, stage == 0);
            if (stage == 0) {
                observe(naive, place);
            }
            work(naive, place, way);
            accelerate(naive, a);
            for (int i = 0; i < FREEDOM; i++) {
                rate[i] = there[i];
                q_sum[i] += way[i];
                v_sum[i] += weight[stage] * dt / 6.0 * a[i];
            }
        }
        for (int i = 0; i < FREEDOM; i++) {
            q[i] += q_sum[i];
            v[i] += v_sum[i];
        }
    }
    forces(naive, q, v, true);
    observe(naive, q);
}

void naive_evaluate(const struct kinematics_setup *setup, const double *values, double *results)
{
    struct naive naive = {.setup = setup, .values = values};
    const struct kinematics_spring *first = &setup->springs[0];
    naive.length_last = naive.length_min = first->length;
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        naive.springs[i].before = -INFINITY;
    }
    double q[FREEDOM] = {0.0};
    double v[FREEDOM] = {-setup->speed, 0.0, 0.0};
    const uint32_t n = (uint32_t)lround(setup->duration / setup->time_step);
    if (setup->integrator == KINEMATICS_RUNGE_KUTTA_4) {
        step_runge_kutta(&naive, n, q, v);
    } else {
        step_differences(&naive, n, q, v);
    }
    results[KINEMATICS_LENGTH_LAST] = naive.length_last;
    results[KINEMATICS_LENGTH_MIN] = naive.length_min;
    results[KINEMATICS_PILLAR_TRAVEL] = q[Y] + first->position[0] * sin(q[YAW]) +
                                        first->position[1] * cos(q[YAW]) - first->position[1];
    results[KINEMATICS_PROJECTION_TRAVEL] =
        naive.springs[0].projection - setup->cog[1] - first->position[1];
    results[KINEMATICS_YAW] = q[YAW];
    results[KINEMATICS_YAW_MAX] = naive.yaw_max;
    results[KINEMATICS_TRAVEL_X] = q[X];
    results[KINEMATICS_TRAVEL_Y] = q[Y];
    results[KINEMATICS_DELTA_VX] = v[X] + setup->speed;
    results[KINEMATICS_DELTA_VY] = v[Y];
    results[KINEMATICS_ACCELERATION_MAX] = naive.ax_max;
    results[KINEMATICS_ACCELERATION_MEAN] = naive.contacts > 0 ? naive.ax_sum / naive.contacts : 0;
    results[KINEMATICS_KINETIC_ENERGY] = 0.5 * setup->mass * (v[X] * v[X] + v[Y] * v[Y]) +
                                         0.5 * setup->yaw_inertia * v[YAW] * v[YAW];
    results[KINEMATICS_LATERAL_WORK] = 0.0;
    results[KINEMATICS_ENERGY_BALANCE] =
        0.5 * setup->mass * setup->speed * setup->speed - results[KINEMATICS_KINETIC_ENERGY];
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        const struct naive_spring *spring = &naive.springs[i];
        results[KINEMATICS_LATERAL_WORK] += spring->work[1];
        results[KINEMATICS_WORK + i] = -spring->work[0] - spring->work[1];
        results[KINEMATICS_ENERGY_BALANCE] -= results[KINEMATICS_WORK + i];
        results[KINEMATICS_WORK + setup->spring_count + i] = spring->deepest;
    }
}
