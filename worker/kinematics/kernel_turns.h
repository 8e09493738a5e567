// Event Verlet: how long each spring loads within the time over which a step's forces act.
//
// The growth of a deformation is s' = (yaw' Y - x') / cos(yaw), Y how far P2 lies beside the COG.
// What a step adds to it is linear in the spring's p_y,
//
//     gain_i = across p_y,i + along
//
// two numbers for all springs of a flat barrier, from the forces and from the way itself, so most
// bundles see in most steps with three operations a spring that no switch is about to turn. Where
// one is, kernel_switch_all() takes the growths from event to event through the step.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_TURNS_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_TURNS_H

#include "worker/kinematics/kernel_events.h"

enum {
    KERNEL_ALL = (1 << LANES) - 1, // bits of all designs
    // Several springs held at once share what moves them; each sweep leaves a small part of it.
    KERNEL_SWITCH_SWEEPS = 4,
    KERNEL_SWITCH_EVENTS = 8, // in a step of one design; what is left then goes on as it was
    KERNEL_ARC_HALVINGS = 12, // to find a turn on the rounded edge to 1/4096 of a step
};

// The time of the forces whose switches are worked out. It is a copy, so that the machine's
// registers may keep the bundle's own.
struct kernel_moment {
    struct kernel_motion at, way; // `way` before the forces
    struct kernel_pose pose;
    struct kernel_load load;
    double weight;
    uint32_t number;  // of the step
    uint32_t turning; // bits of the designs to look at
    bool recording;
};

// What a step's forces and its way add to the growth of the deformations, and what it takes to say
// so of each spring's own force.
struct kernel_gain {
    struct lanes across, along; // gain = across p_y + along [1], [m]
    struct lanes offset;        // [m] Y of a spring at p_y = 0
    struct lanes inverse;       // 1 / cos
    double kick, kick_yaw;      // [m/N], [rad/Nm] of a step's way
    double weight;              // of the step
};

LANES_INLINE struct kernel_gain kernel_gain(const struct kinematics_problem *problem,
                                            const struct kernel_moment *moment)
{
    const struct kernel_motion *at = &moment->at;
    const struct kernel_motion *way = &moment->way;
    const struct kernel_pose *pose = &moment->pose;
    const struct kernel_load *load = &moment->load;
    const double weight = moment->weight;
    const double dt = problem->time_step;
    struct kernel_gain gain;
    gain.kick = weight * dt * dt / problem->mass;
    gain.kick_yaw = weight * dt * dt / problem->yaw_inertia;
    gain.weight = weight;
    gain.inverse = pose->inverse;
    gain.offset = lanes_fnma(at->x, pose->tangent, lanes_set(0.0));
    // Of the forces: (turn Y - backwards) / cos.
    const struct lanes turn = lanes_mul(load->moment, lanes_set(gain.kick_yaw));
    const struct lanes backwards = lanes_mul(load->x, lanes_set(gain.kick));
    // Of the way: yaw' / cos (2 (yaw' p_y / cos - x') tan - X yaw' (tan^2 + 1 / cos^2)).
    const struct lanes tangent = pose->tangent;
    const struct lanes rate = lanes_mul(lanes_set(weight), lanes_mul(way->yaw, pose->inverse));
    const struct lanes twice = lanes_add(tangent, tangent);
    const struct lanes squares =
        lanes_fma(tangent, tangent, lanes_mul(pose->inverse, pose->inverse));
    const struct lanes drift =
        lanes_fma(twice, way->x, lanes_mul(lanes_mul(at->x, way->yaw), squares));
    const struct lanes turn_across = lanes_mul(turn, pose->inverse);
    gain.across =
        lanes_mul(pose->inverse, lanes_fma(lanes_mul(rate, way->yaw), twice, turn_across));
    gain.along =
        lanes_fnma(rate, drift, lanes_mul(pose->inverse, lanes_fms(turn, gain.offset, backwards)));
    return gain;
}

// Which designs, as bits, have a spring whose switch turns in this step, or that is held, or that
// lies on the rounded edge: the growth is told from the way after the step's forces, `next`.
LANES_INLINE uint32_t kernel_turning(const struct kinematics_problem *problem,
                                     struct problem_features features, uint32_t number,
                                     const struct kernel_motion *at,
                                     const struct kernel_motion *next,
                                     const struct kernel_pose *pose,
                                     const struct kernel_bits *switches,
                                     const struct kernel_scratch *scratch)
{
    // (yaw' Y - x') / cos, half a step on: with half of what the way itself adds in a step.
    const struct lanes tangent = pose->tangent;
    const struct lanes turn = lanes_mul(next->yaw, pose->inverse);
    const struct lanes swing = lanes_fma(next->yaw, tangent, lanes_set(1.0));
    const struct lanes across = lanes_mul(lanes_mul(turn, pose->inverse), swing);
    const struct lanes squares = // tan^2 + 1 / cos^2
        lanes_fma(lanes_add(tangent, tangent), tangent, lanes_set(1.0));
    const struct lanes lever = lanes_fma(lanes_mul(lanes_set(0.5), next->yaw), squares, tangent);
    const struct lanes along =
        lanes_fma(lanes_mul(at->x, next->yaw), lever, lanes_mul(next->x, swing));
    const struct lanes least =
        lanes_fma(along, pose->inverse, lanes_set(problem->rest)); // across p_y exceeds
    // Growth is linear in p_y: what all springs do the outermost two do.
    const uint32_t lowest =
        lanes_bits(lanes_less(least, lanes_mul(across, lanes_set(problem->lowest_y))));
    const uint32_t highest =
        lanes_bits(lanes_less(least, lanes_mul(across, lanes_set(problem->highest_y))));
    const uint32_t clear =
        (lowest & highest & ~switches->idle) | ~(lowest | highest | switches->loading);
    if (!features.rounded && __builtin_expect((~clear & KERNEL_ALL) == 0, true)) {
        return 0;
    }
    uint32_t turning = 0;
    uint32_t arc = 0;
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct kernel_event *event = &scratch->springs[i].event;
        const struct lanes position_y = lanes_set(problem->springs[i].position_y);
        const uint32_t grows = lanes_bits(lanes_less(least, lanes_mul(across, position_y)));
        turning |= event->loading ^ (grows & event->contact[number % 2]);
        if (features.rounded) {
            arc |= event->arc;
        }
    }
    return (turning & ~clear) | arc;
}

// How the deformation of a spring on the rounded edge grows at `time` of a step, 0 being the time
// of the forces: towards the tangent it falls at a rate without bound, so nothing is taken as even
// here but the car's accelerations.
struct kernel_arc {
    struct lanes x, y; // [m] COG from the circle's centre, at time 0
    struct lanes sine, cosine;
    struct kernel_motion way, more; // of a step half a step before, and what a step adds to it
    struct lanes position_y;        // [m]
    struct lanes square;            // [m2] of the radius
};

LANES_INLINE struct lanes kernel_arc_growth(const struct kernel_arc *arc, struct lanes time)
{
    const struct lanes half = lanes_set(0.5);
    const struct lanes since = lanes_add(time, half);
    const struct lanes way_x = lanes_fma(since, arc->more.x, arc->way.x);
    const struct lanes way_y = lanes_fma(since, arc->more.y, arc->way.y);
    const struct lanes way_yaw = lanes_fma(since, arc->more.yaw, arc->way.yaw);
    // The mean way between time 0 and `time`, and the turn between them, which is small.
    const struct lanes part = lanes_mul(half, lanes_add(time, lanes_set(1.0)));
    const struct lanes x = lanes_fma(time, lanes_fma(part, arc->more.x, arc->way.x), arc->x);
    const struct lanes y = lanes_fma(time, lanes_fma(part, arc->more.y, arc->way.y), arc->y);
    const struct lanes turn = lanes_mul(time, lanes_fma(part, arc->more.yaw, arc->way.yaw));
    const struct lanes shrunk = lanes_fnma(lanes_mul(half, turn), turn, lanes_set(1.0));
    const struct lanes sine = lanes_fma(shrunk, arc->sine, lanes_mul(turn, arc->cosine));
    const struct lanes cosine = lanes_fms(shrunk, arc->cosine, lanes_mul(turn, arc->sine));
    const struct lanes along = lanes_fma(x, cosine, lanes_mul(y, sine));
    const struct lanes across = lanes_fms(x, sine, lanes_mul(y, cosine));
    const struct lanes height = lanes_sub(across, arc->position_y);
    const struct lanes rise =
        lanes_fma(way_yaw, along, lanes_fms(way_x, sine, lanes_mul(way_y, cosine)));
    const struct lanes advance =
        lanes_fnma(way_yaw, across, lanes_fma(way_x, cosine, lanes_mul(way_y, sine)));
    const double least = 1e-12; // [m2] so that the tangent itself has a rate
    const struct lanes half_chord =
        lanes_sqrt(lanes_max(lanes_fnma(height, height, arc->square), lanes_set(least)));
    return lanes_fnma(lanes_div(height, half_chord), rise, lanes_sub(lanes_set(0.0), advance));
}

// The share of the forces' time after which a spring on the rounded edge ceases to load, 2 where it
// does not.
LANES_INLINE struct lanes kernel_arc_turn(const struct kinematics_problem *problem,
                                          const struct problem_spring *spring,
                                          const struct kernel_moment *moment,
                                          const struct kernel_gain *gain)
{
    const double radius = problem->edge_radius;
    const struct lanes zero = lanes_set(0.0);
    const struct lanes half = lanes_set(0.5);
    const struct lanes kick = lanes_set(gain->kick / gain->weight);
    const struct lanes kick_yaw = lanes_set(gain->kick_yaw / gain->weight);
    const struct kernel_arc arc = {
        .x = lanes_add(moment->at.x, lanes_set(radius)),
        .y = lanes_sub(moment->at.y, lanes_set(problem->edge_y - radius)),
        .sine = moment->pose.sine,
        .cosine = moment->pose.cosine,
        .way = moment->way,
        .more = {lanes_mul(moment->load.x, kick), lanes_mul(moment->load.y, kick),
                 lanes_mul(moment->load.moment, kick_yaw)},
        .position_y = lanes_set(spring->position_y),
        .square = lanes_set(radius * radius),
    };
    struct lanes low = lanes_set(-0.5);
    struct lanes high = lanes_set(gain->weight - 0.5);
    for (int halving = 0; halving < KERNEL_ARC_HALVINGS; halving++) {
        const struct lanes middle = lanes_mul(half, lanes_add(low, high));
        const struct lanes_mask grows = lanes_less(zero, kernel_arc_growth(&arc, middle));
        low = lanes_select(grows, middle, low);
        high = lanes_select(grows, high, middle);
    }
    const struct lanes end = lanes_set(gain->weight - 0.5);
    const struct lanes_mask on = lanes_less(zero, kernel_arc_growth(&arc, end));
    const struct lanes turn = lanes_mul(lanes_set(1.0 / gain->weight), lanes_add(half, low));
    return lanes_select(on, lanes_set(2.0), turn);
}

// What loading adds to the force of spring `index`, and what that does to the growths.
LANES_INLINE void kernel_switch_force(const struct kinematics_problem *problem,
                                      struct problem_features features, uint32_t index,
                                      const struct kernel_moment *moment, struct lanes s,
                                      struct lanes_mask contact, const struct kernel_gain *gain,
                                      struct kernel_scratch *scratch)
{
    const struct problem_spring *spring = &problem->springs[index];
    struct kernel_switch *kept_switch = &scratch->switches[index];
    const double *coefficients = scratch->coefficients;
    const struct kernel_pose *pose = &moment->pose;
    const struct lanes_mask acts = lanes_and_less(contact, lanes_set(spring->load.acts_above), s);
    struct lanes x, y;
    kernel_curve(problem, &spring->load, coefficients, s, acts, &x, &y);
    if (features.unload && spring->unload.point_count > 0) {
        const struct lanes_mask gives =
            lanes_and_less(contact, lanes_set(spring->unload.acts_above), s);
        struct lanes unload_x, unload_y;
        kernel_curve(problem, &spring->unload, coefficients, s, gives, &unload_x, &unload_y);
        x = lanes_sub(x, unload_x);
        y = lanes_sub(y, unload_y);
    }
    const struct lanes position_y = lanes_set(spring->position_y);
    const struct lanes road_x = lanes_fms(pose->cosine, x, lanes_mul(pose->sine, y));
    const struct lanes place = kernel_past_place(problem, features, index, moment->number, scratch);
    const struct lanes torque = lanes_fms(place, y, lanes_mul(position_y, x));
    const struct lanes backwards = lanes_mul(lanes_set(gain->kick), road_x);
    const struct lanes turn = lanes_mul(lanes_set(gain->kick_yaw), torque);
    const struct lanes lever =
        lanes_mul(gain->inverse, lanes_fma(position_y, gain->inverse, gain->offset));
    lanes_store(kept_switch->force[0], x);
    lanes_store(kept_switch->force[1], y);
    lanes_store(kept_switch->backwards, backwards);
    lanes_store(kept_switch->turn, turn);
    lanes_store(kept_switch->lever, lever);
    lanes_store(kept_switch->own, lanes_fms(turn, lever, lanes_mul(gain->inverse, backwards)));
}

// The switch of spring `index` at the beginning of the step.
LANES_INLINE void kernel_switch_start(const struct kinematics_problem *problem,
                                      struct problem_features features, uint32_t index,
                                      const struct kernel_moment *moment,
                                      const struct kernel_gain *gain,
                                      struct kernel_scratch *scratch)
{
    const struct lanes zero = lanes_set(0.0);
    const struct lanes one = lanes_set(1.0);
    const struct lanes none = lanes_set(-INFINITY);
    const uint32_t number = moment->number;
    const struct problem_spring *spring = &problem->springs[index];
    const struct kernel_event *event = &scratch->springs[index].event;
    struct kernel_switch *kept_switch = &scratch->switches[index];
    const struct lanes s = kernel_past_deformation(problem, features, index, number, scratch);
    const struct lanes before =
        kernel_past_deformation(problem, features, index, number + 1, scratch);
    const struct lanes_mask contact = lanes_from_bits(event->contact[number % 2]);
    const struct lanes_mask loading = lanes_from_bits(event->loading);
    // Within `rest` of where the spring last loaded it rests; the reference lies as much higher.
    const struct lanes rest = lanes_set(problem->rest);
    const struct lanes reference = lanes_load(scratch->springs[index].reference[1 - number % 2]);
    const struct lanes beyond = lanes_add(lanes_sub(s, reference), rest);
    const struct lanes_mask rests =
        lanes_and_not(lanes_and_less(contact, lanes_sub(zero, rest), beyond), loading);
    // A crushed spring stays off below its greatest deformation, by the other rule it may begin to
    // load wherever it is.
    struct lanes growth = features.crushed ? none : lanes_select(contact, beyond, none);
    growth = lanes_select(rests, zero, growth);
    growth = lanes_select(loading, lanes_max(lanes_sub(s, before), zero), growth);
    kernel_switch_force(problem, features, index, moment, s, contact, gain, scratch);
    struct lanes more = lanes_fma(gain->across, lanes_set(spring->position_y), gain->along);
    if (features.rounded && event->arc != 0) {
        // What loaded up to now goes on to its turn: a growth of 1 that is 0 then.
        const struct lanes_mask arc = lanes_from_bits(event->arc);
        const struct lanes time = kernel_arc_turn(problem, spring, moment, gain);
        const struct lanes_mask on = lanes_from_bits(event->loading | event->loads[1 - number % 2]);
        const struct lanes fall = lanes_div(lanes_set(-1.0), lanes_max(time, lanes_set(1e-9)));
        growth = lanes_select(arc, lanes_select(on, one, none), growth);
        more = lanes_select(arc, fall, more);
    }
    lanes_store(kept_switch->growth, growth);
    lanes_store(kept_switch->gain, more);
    lanes_store(kept_switch->share, lanes_keep(loading, one));
    lanes_store(kept_switch->mean, zero);
}

// What the changes of all shares add to the way of a step: in x, and to its turn.
struct kernel_shift {
    struct lanes backwards, turn;
};

// The gain of one spring under the shares as they are.
LANES_INLINE struct lanes kernel_switch_gain(const struct kernel_switch *one,
                                             const struct kernel_shift *shift, struct lanes inverse)
{
    const struct lanes gain = lanes_fnma(inverse, shift->backwards, lanes_load(one->gain));
    return lanes_fma(shift->turn, lanes_load(one->lever), gain);
}

// Gives each spring the share that its growth asks for: a spring that rests the share that keeps
// it there, none where nothing presses it, all where its force is too little.
LANES_INLINE void kernel_switch_shares(uint32_t count, struct lanes inverse,
                                       struct kernel_switch *switches, struct kernel_shift *shift)
{
    const struct lanes zero = lanes_set(0.0);
    const struct lanes one = lanes_set(1.0);
    for (uint32_t sweep = 0; sweep < KERNEL_SWITCH_SWEEPS; sweep++) {
        struct lanes_mask resting = lanes_none();
        for (uint32_t i = 0; i < count; i++) {
            struct kernel_switch *kept = &switches[i];
            const struct lanes growth = lanes_load(kept->growth);
            const struct lanes share = lanes_load(kept->share);
            const struct lanes own = lanes_load(kept->own);
            const struct lanes_mask grows = lanes_less(zero, growth);
            const struct lanes_mask falls = lanes_less(growth, zero);
            const struct lanes free =
                lanes_fnma(share, own, kernel_switch_gain(kept, shift, inverse));
            const struct lanes_mask pressed = lanes_less(zero, free);
            const struct lanes_mask resists = lanes_less(own, zero);
            const struct lanes holds = lanes_min(lanes_div(free, lanes_sub(zero, own)), one);
            struct lanes next = lanes_keep(pressed, lanes_select(resists, holds, one));
            next = lanes_select(grows, one, next);
            next = lanes_select(falls, zero, next);
            const struct lanes change = lanes_sub(next, share);
            lanes_store(kept->share, next);
            shift->backwards = lanes_fma(change, lanes_load(kept->backwards), shift->backwards);
            shift->turn = lanes_fma(change, lanes_load(kept->turn), shift->turn);
            resting = lanes_or(resting, lanes_differ(lanes_or(grows, falls), //
                                                     lanes_less(zero, one)));
        }
        if (!lanes_any(resting)) {
            return; // nothing depends on the others' shares
        }
    }
}

// When the first growth becomes 0, at most `left`.
LANES_INLINE struct lanes kernel_switch_next(uint32_t count, struct lanes inverse,
                                             const struct kernel_switch *switches,
                                             const struct kernel_shift *shift, struct lanes left)
{
    const struct lanes zero = lanes_set(0.0);
    for (uint32_t i = 0; i < count; i++) {
        const struct lanes growth = lanes_load(switches[i].growth);
        const struct lanes gain = kernel_switch_gain(&switches[i], shift, inverse);
        const struct lanes_mask turns =
            lanes_or(lanes_and_less(lanes_less(zero, growth), gain, zero),
                     lanes_and_less(lanes_less(growth, zero), zero, gain));
        const struct lanes time = lanes_div(lanes_sub(zero, growth), gain);
        left = lanes_select(turns, lanes_min(time, left), left);
    }
    return left;
}

// Lets `time` go by.
LANES_INLINE void kernel_switch_pass(uint32_t count, struct lanes inverse,
                                     struct kernel_switch *switches,
                                     const struct kernel_shift *shift, struct lanes time)
{
    const struct lanes zero = lanes_set(0.0);
    const struct lanes one = lanes_set(1.0);
    for (uint32_t i = 0; i < count; i++) {
        struct kernel_switch *kept = &switches[i];
        const struct lanes growth = lanes_load(kept->growth);
        const struct lanes share = lanes_load(kept->share);
        const struct lanes gain = kernel_switch_gain(kept, shift, inverse);
        lanes_store(kept->mean, lanes_fma(share, time, lanes_load(kept->mean)));
        // What reaches 0 now is put there; what is held stays.
        const struct lanes_mask grows = lanes_less(zero, growth);
        const struct lanes_mask falls = lanes_less(growth, zero);
        const struct lanes moment = lanes_div(lanes_sub(zero, growth), gain);
        const struct lanes_mask down = lanes_and_less(grows, gain, zero);
        const struct lanes_mask up = lanes_and_less(falls, zero, gain);
        const struct lanes_mask turned = lanes_and_not_above(lanes_or(down, up), moment, time);
        const struct lanes_mask held = lanes_and_not(
            lanes_and_less(lanes_less(zero, share), share, one), lanes_or(grows, falls));
        const struct lanes then = lanes_fma(gain, time, growth);
        lanes_store(kept->growth, lanes_select(lanes_or(turned, held), zero, then));
    }
}

// Takes the switches through the step, from turn to turn.
LANES_INLINE void kernel_switch_run(uint32_t count, struct lanes inverse, struct lanes_mask turning,
                                    struct kernel_switch *switches)
{
    const struct lanes zero = lanes_set(0.0);
    struct kernel_shift shift = {zero, zero};
    struct lanes left = lanes_set(1.0);
    for (uint32_t event = 0; event < KERNEL_SWITCH_EVENTS; event++) {
        kernel_switch_shares(count, inverse, switches, &shift);
        const struct lanes time = event + 1 == KERNEL_SWITCH_EVENTS
                                      ? left
                                      : kernel_switch_next(count, inverse, switches, &shift, left);
        kernel_switch_pass(count, inverse, switches, &shift, time);
        left = lanes_sub(left, time);
        if (!lanes_any(lanes_and_less(turning, zero, left))) {
            break;
        }
    }
}

// Lets springs load for as long as their deformation grows: works out their shares and leaves what
// these change of the forces in `made_good`. Only designs that `turning` names are changed, so no
// bit depends on what a neighbour does.
static __attribute__((noinline)) void kernel_switch_all(const struct kinematics_problem *problem,
                                                        struct problem_features features,
                                                        const struct kernel_moment *moment,
                                                        struct kernel_scratch *scratch)
{
    const struct lanes zero = lanes_set(0.0);
    const struct lanes one = lanes_set(1.0);
    const uint32_t count = problem->spring_count;
    const uint32_t number = moment->number;
    const struct lanes_mask turning = lanes_from_bits(moment->turning);
    const struct kernel_gain gain = kernel_gain(problem, moment);
    for (uint32_t i = 0; i < count; i++) {
        kernel_switch_start(problem, features, i, moment, &gain, scratch);
    }
    kernel_switch_run(count, gain.inverse, turning, scratch->switches);
    struct lanes sum_x = zero;
    struct lanes sum_y = zero;
    struct lanes torque = zero;
    for (uint32_t i = 0; i < count; i++) {
        const struct kernel_switch *kept_switch = &scratch->switches[i];
        const struct problem_spring *spring = &problem->springs[i];
        struct kernel_spring *kept = &scratch->springs[i];
        const struct lanes first = lanes_keep(lanes_from_bits(kept->event.loading), one);
        const struct lanes change =
            lanes_keep(turning, lanes_sub(lanes_load(kept_switch->mean), first));
        const struct lanes x = lanes_mul(change, lanes_load(kept_switch->force[0]));
        const struct lanes y = lanes_mul(change, lanes_load(kept_switch->force[1]));
        sum_x = lanes_add(sum_x, x);
        sum_y = lanes_add(sum_y, y);
        torque = lanes_fma(kernel_past_place(problem, features, i, number, scratch), y, torque);
        torque = lanes_fnma(lanes_set(spring->position_y), x, torque);
        if (features.work || moment->recording) {
            lanes_store(kept->force_x, lanes_add(lanes_load(kept->force_x), x));
            lanes_store(kept->force_y, lanes_add(lanes_load(kept->force_y), y));
        }
        if (moment->recording) {
            lanes_store(kept->event.force_x, lanes_add(lanes_load(kept->event.force_x), x));
            lanes_store(kept->event.force_y, lanes_add(lanes_load(kept->event.force_y), y));
        }
        // What acts at the end of the step is what may end within the next.
        const struct lanes s = kernel_past_deformation(problem, features, i, number, scratch);
        const struct lanes_mask loads =
            lanes_and_less(lanes_and_not_above(turning, one, lanes_load(kept_switch->share)),
                           lanes_set(spring->load.acts_above), s);
        uint32_t *kept_loads = &kept->event.loads[number % 2];
        *kept_loads = lanes_bits(loads) | (*kept_loads & ~moment->turning);
    }
    lanes_store(scratch->made_good[0], sum_x);
    lanes_store(scratch->made_good[1], sum_y);
    lanes_store(scratch->made_good[2], torque);
}

// Adds what kernel_switch_all() left to the forces.
LANES_INLINE void kernel_switch_apply(const struct kernel_pose *pose,
                                      const struct kernel_scratch *scratch,
                                      struct kernel_load *load)
{
    const struct lanes x = lanes_load(scratch->made_good[0]);
    const struct lanes y = lanes_load(scratch->made_good[1]);
    const struct lanes road_x = lanes_fms(pose->cosine, x, lanes_mul(pose->sine, y));
    load->x = lanes_add(load->x, road_x);
    load->felt = lanes_add(load->felt, road_x);
    load->y = lanes_add(load->y, lanes_fma(pose->sine, x, lanes_mul(pose->cosine, y)));
    load->moment = lanes_add(load->moment, lanes_load(scratch->made_good[2]));
}

#endif
