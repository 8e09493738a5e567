// Event Verlet: what happens within a step.
//
// The other schemes look at a spring at whole steps only: one that lets go within a step has acted
// for half a step after the last time it was seen to act, whenever it really let go. On average
// that is right, for one crash it is an error of first order. Here the moment is found, by the
// straight line between the two times of whatever began or ended the force, and what the spring did
// up to then, or from then on, is made good at the time after: too late by part of a step, which is
// an error of second order.
//
// Loading is a switch on the growth of the deformation, and pushes against what moves it: a spring
// that was made to let go after the fact would by then have thrown the car. So how long each spring
// loads is worked out before its force acts, for the time from half a step before to half a step
// after, which is the time that the leapfrog gives to the forces of one moment. All rates are taken
// as even over it. A spring that comes to rest and would be pressed again, were it not for its own
// force, is held there by the share of its force that does so: a car that stands still, or a spring
// that another one presses against the barrier. Where no force wants to move it that share is 0, so
// the steps of a car at rest do nothing.
#ifndef SOBOX_WORKER_KINEMATICS_KERNEL_EVENTS_H
#define SOBOX_WORKER_KINEMATICS_KERNEL_EVENTS_H

#include "worker/kinematics/kernel_state.h"

// What one spring's branches have to know of the step that ends now.
struct kernel_step {
    struct lanes deformation; // [m] now
    struct lanes before;      // [m] at the time before
    struct lanes slip;        // share of the step at which it met or left the face
    struct lanes_mask outside_before, outside;
    struct lanes end;      // at which leaving the face ended its force, 1 where it did not
    struct lanes missing;  // [m] before, to its greatest deformation; with `crushed`
    struct lanes_mask gap; // where that was more than rounding
};

// a / (a - b): where the line from a to b is 0.
LANES_INLINE struct lanes kernel_crossing(struct lanes a, struct lanes b)
{
    return lanes_div(a, lanes_sub(a, b));
}

// Adds to x and y what a branch that began or ceased to act within the step did there, beside the
// half steps that count anyway: where a spring met or left the face or a curve's first point, or
// passed its greatest deformation. What ended or began with the growth is no matter of this.
LANES_INLINE void kernel_make_good(const struct kinematics_problem *problem,
                                   const struct problem_curve *curve, const double *coefficients,
                                   const struct kernel_step *step, bool loading,
                                   struct lanes_mask was, struct lanes_mask is, struct lanes weight,
                                   struct lanes *x, struct lanes *y)
{
    const struct lanes one = lanes_set(1.0);
    const struct lanes half = lanes_set(0.5);
    const struct lanes start = lanes_set(curve->acts_above);
    const struct lanes_mask all = lanes_less(lanes_set(0.0), one);
    const struct lanes_mask short_before = lanes_and_not_above(all, step->before, start);
    const struct lanes_mask short_now = lanes_and_not_above(all, step->deformation, start);
    const struct lanes_mask ended =
        lanes_and(lanes_and_not(was, is), lanes_or(step->outside, short_now));
    struct lanes_mask kept_off = lanes_or(step->outside_before, short_before);
    if (loading) {
        kept_off = lanes_or(kept_off, step->gap);
    }
    const struct lanes_mask began = lanes_and(lanes_and_not(is, was), kept_off);
    const struct lanes_mask changed = lanes_or(began, ended);
    if (!lanes_any(changed)) {
        return;
    }
    // It ends with the first thing that forbids it and begins once nothing does any more.
    struct lanes end = step->end;
    struct lanes begin = lanes_set(0.0);
    begin = lanes_select(step->outside_before, lanes_max(step->slip, begin), begin);
    if (lanes_any(lanes_or(short_before, short_now))) {
        const struct lanes reach =
            kernel_crossing(lanes_sub(step->before, start), lanes_sub(step->deformation, start));
        end = lanes_select(short_now, lanes_min(reach, end), end);
        begin = lanes_select(short_before, lanes_max(reach, begin), begin);
    }
    if (loading && lanes_any(step->gap)) {
        const struct lanes again =
            lanes_div(step->missing, lanes_sub(step->deformation, step->before));
        begin = lanes_select(step->gap, lanes_max(again, begin), begin);
    }

    const struct lanes moment = lanes_select(ended, end, begin);
    const struct lanes share = lanes_select(ended, moment, lanes_sub(one, moment));
    const struct lanes near = lanes_select(ended, step->before, step->deformation);
    const struct lanes there =
        lanes_fma(moment, lanes_sub(step->deformation, step->before), step->before);
    struct lanes near_x, near_y, there_x, there_y;
    kernel_curve(problem, curve, coefficients, near, changed, &near_x, &near_y);
    kernel_curve(problem, curve, coefficients, there, changed, &there_x, &there_y);
    // The mean force over its share of the step, less the half step that counts anyway.
    const struct lanes scale = lanes_mul(half, weight);
    const struct lanes more_x =
        lanes_mul(scale, lanes_fms(share, lanes_add(near_x, there_x), near_x));
    const struct lanes more_y =
        lanes_mul(scale, lanes_fms(share, lanes_add(near_y, there_y), near_y));
    *x = lanes_add(*x, lanes_keep(changed, more_x));
    *y = lanes_add(*y, lanes_keep(changed, more_y));
}

// Notes a pose, so that a spring's place can be worked out again, to the same bits.
LANES_INLINE void kernel_keep_pose(const struct kernel_pose *pose, uint32_t number,
                                   struct kernel_past *past)
{
    const uint32_t now = number % 2;
    lanes_store(past->inverse[now], pose->inverse);
    lanes_store(past->tangent[now], pose->tangent);
    lanes_store(past->axial[now], pose->axial);
    lanes_store(past->crossing[now], pose->crossing);
}

// e of spring `index` at step `number`, which is this one or the one before.
LANES_INLINE struct lanes kernel_past_place(const struct kinematics_problem *problem,
                                            struct problem_features features, uint32_t index,
                                            uint32_t number, const struct kernel_scratch *scratch)
{
    if (features.rounded) {
        return lanes_load(scratch->springs[index].place);
    }
    const struct kernel_past *past = &scratch->past;
    return lanes_fms(lanes_set(problem->springs[index].position_y),
                     lanes_load(past->tangent[number % 2]), lanes_load(past->axial[number % 2]));
}

LANES_INLINE struct lanes kernel_past_deformation(const struct kinematics_problem *problem,
                                                  struct problem_features features, uint32_t index,
                                                  uint32_t number,
                                                  const struct kernel_scratch *scratch)
{
    if (features.rounded) {
        return lanes_load(scratch->springs[index].event.deformation[number % 2]);
    }
    return lanes_add(lanes_set(problem->springs[index].reach),
                     kernel_past_place(problem, features, index, number, scratch));
}

// How far P2 lay inside the nearer end of the face [m].
LANES_INLINE struct lanes kernel_past_margin(const struct kinematics_problem *problem,
                                             struct problem_features features, uint32_t index,
                                             uint32_t number, const struct kernel_scratch *scratch)
{
    if (features.rounded) {
        return lanes_load(scratch->springs[index].event.edge[number % 2]);
    }
    const struct kernel_past *past = &scratch->past;
    const struct lanes projection =
        lanes_fma(lanes_set(problem->springs[index].position_y),
                  lanes_load(past->inverse[number % 2]), lanes_load(past->crossing[number % 2]));
    return lanes_min(lanes_sub(lanes_set(problem->edge_y), projection),
                     lanes_sub(projection, lanes_set(problem->far_y)));
}

// The share of the step at which a spring that slipped off ceased to load. On a rounded edge it
// does so shortly before: where e = sqrt(r^2 - h^2) - along rests, at a half chord of r h' /
// along'. The way from there to where it slips off, in h^2, is what the two half chords differ by
// in square. Up to the middle of the step the turn has been seen before.
LANES_INLINE struct lanes kernel_arc_end(const struct kinematics_problem *problem,
                                         const struct kernel_step *step,
                                         const struct kernel_pose *pose,
                                         const struct kernel_event *event, uint32_t number,
                                         struct lanes margin_before, struct lanes margin)
{
    const struct lanes zero = lanes_set(0.0);
    const struct lanes radius = lanes_set(problem->edge_radius);
    const struct lanes advance =
        lanes_sub(lanes_load(event->slip[number % 2]), lanes_load(event->slip[1 - number % 2]));
    const struct lanes rise = lanes_sub(margin_before, margin);
    const struct lanes turn = lanes_mul(radius, lanes_div(rise, advance));
    const struct lanes slip = lanes_mul(radius, lanes_max(pose->sine, zero));
    const struct lanes squares = lanes_fnma(slip, slip, lanes_mul(turn, turn));
    const struct lanes before = lanes_div(squares, lanes_mul(lanes_add(radius, radius), rise));
    const struct lanes earlier =
        lanes_min(step->slip, lanes_max(lanes_set(0.5), lanes_sub(step->slip, before)));
    const struct lanes end = lanes_select(lanes_less(zero, squares), earlier, step->slip);
    return lanes_select(step->outside, end, step->end);
}

// The step of one spring, from what was kept of it.
LANES_INLINE struct kernel_step kernel_step_of(const struct kinematics_problem *problem,
                                               struct problem_features features, uint32_t index,
                                               uint32_t number, const struct kernel_pose *pose,
                                               const struct kernel_scratch *scratch)
{
    const struct lanes zero = lanes_set(0.0);
    const struct kernel_spring *kept = &scratch->springs[index];
    const struct lanes margin = kernel_past_margin(problem, features, index, number, scratch);
    const struct lanes margin_before =
        kernel_past_margin(problem, features, index, number + 1, scratch);
    struct kernel_step step;
    step.deformation = kernel_past_deformation(problem, features, index, number, scratch);
    step.before = kernel_past_deformation(problem, features, index, number + 1, scratch);
    step.slip = kernel_crossing(margin_before, margin);
    step.outside_before = lanes_less(margin_before, zero);
    step.outside = lanes_less(margin, zero);
    step.end = lanes_select(step.outside, step.slip, lanes_set(1.0));
    if (features.rounded) {
        step.end =
            kernel_arc_end(problem, &step, pose, &kept->event, number, margin_before, margin);
    }
    step.missing = zero;
    step.gap = lanes_none();
    if (features.crushed) {
        const struct lanes rest = lanes_set(problem->rest);
        const struct lanes reference = lanes_sub(lanes_load(kept->reference[1 - number % 2]), rest);
        step.missing = lanes_sub(reference, step.before);
        step.gap = lanes_less(rest, step.missing);
    }
    return step;
}

// The deformation at which a spring left the face at that share of the step: what lies between the
// two times, or for a rounded edge what the line's own place says.
LANES_INLINE struct lanes kernel_left_at(struct problem_features features,
                                         const struct problem_spring *spring, uint32_t number,
                                         const struct kernel_event *event,
                                         const struct kernel_step *step)
{
    struct lanes before = step->before;
    struct lanes now = step->deformation;
    if (features.rounded) {
        const struct lanes reach = lanes_set(spring->reach);
        before = lanes_add(reach, lanes_load(event->slip[(number + 1) % 2]));
        now = lanes_add(reach, lanes_load(event->slip[number % 2]));
    }
    return lanes_fma(step->slip, lanes_sub(now, before), before);
}

// Notes a deformation of a spring where it is in contact.
LANES_INLINE void kernel_deepen(struct kernel_spring *kept, struct lanes_mask contact,
                                struct lanes deformation)
{
    const struct lanes deepest = lanes_load(kept->deepest);
    lanes_store(kept->deepest, lanes_select(contact, lanes_max(deformation, deepest), deepest));
}

// Where a spring slipped off the rounded edge within the step that ends now, at which deformation;
// remembers what the next step is held against. This is for the schemes that look at whole steps
// only, which would lose up to a step's way and, close to the tangent, the root of it.
LANES_INLINE struct lanes_mask kernel_slipped(const struct problem_spring *spring, uint32_t number,
                                              const struct kernel_place *place,
                                              struct lanes_mask contact, struct kernel_event *event,
                                              struct lanes *left_at)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    const struct lanes edge_before = lanes_load(event->edge[before]);
    const struct lanes slip_before = lanes_load(event->slip[before]);
    const struct lanes share = kernel_crossing(edge_before, place->edge);
    const struct lanes slip = lanes_fma(share, lanes_sub(place->slip, slip_before), slip_before);
    const struct lanes_mask left = lanes_and_not(
        lanes_and_less(lanes_from_bits(event->contact[before]), place->edge, lanes_set(0.0)),
        contact);
    *left_at = lanes_add(lanes_set(spring->reach), slip);
    lanes_store(event->edge[now], place->edge);
    lanes_store(event->slip[now], place->slip);
    event->contact[now] = lanes_bits(contact);
    return left;
}

// Finds what began and ended within the step that ends now and makes it good in the springs'
// forces. Where spring 0 left the face, `left` is set and `left_at` is the deformation at which it
// did. Most bundles see nothing of that in most steps, so this is called when one does, and stands
// by itself: the machine's registers belong to the loop over springs.
static __attribute__((noinline)) void kernel_find_events(const struct kinematics_problem *problem,
                                                         struct problem_features features,
                                                         uint32_t number, double weight,
                                                         const struct kernel_pose *pose,
                                                         struct kernel_scratch *scratch)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    const struct lanes zero = lanes_set(0.0);
    const struct lanes inverse = lanes_set(1.0 / weight);
    struct lanes sum_x = zero;
    struct lanes sum_y = zero;
    struct lanes moment = zero;
    for (uint32_t i = 0; i < problem->spring_count; i++) {
        const struct problem_spring *spring = &problem->springs[i];
        struct kernel_spring *kept = &scratch->springs[i];
        const struct kernel_event *event = &kept->event;
        const bool unload = features.unload && spring->unload.point_count > 0;
        const uint32_t parted =
            i == 0 || features.deepest ? event->contact[before] & ~event->contact[now] : 0;
        uint32_t other = event->loads[before] ^ event->loads[now];
        if (unload) {
            other |= event->unloads[before] ^ event->unloads[now];
        }
        if (other == 0 && parted == 0) {
            continue;
        }
        const struct kernel_step step = kernel_step_of(problem, features, i, number, pose, scratch);
        struct lanes x = zero;
        struct lanes y = zero;
        kernel_make_good(problem, &spring->load, scratch->coefficients, &step, true,
                         lanes_from_bits(event->loads[before]), lanes_from_bits(event->loads[now]),
                         inverse, &x, &y);
        if (unload) {
            kernel_make_good(problem, &spring->unload, scratch->coefficients, &step, false,
                             lanes_from_bits(event->unloads[before]),
                             lanes_from_bits(event->unloads[now]), inverse, &x, &y);
        }
        if (features.work) {
            lanes_store(kept->force_x, lanes_add(lanes_load(kept->force_x), x));
            lanes_store(kept->force_y, lanes_add(lanes_load(kept->force_y), y));
        }
        sum_x = lanes_add(sum_x, x);
        sum_y = lanes_add(sum_y, y);
        moment = lanes_fma(kernel_past_place(problem, features, i, number, scratch), y, moment);
        moment = lanes_fnma(lanes_set(spring->position_y), x, moment);
        if (parted != 0) {
            const struct lanes_mask left = lanes_and(lanes_from_bits(parted), step.outside);
            const struct lanes left_at = kernel_left_at(features, spring, number, event, &step);
            if (i == 0) {
                scratch->left = left;
                lanes_store(scratch->left_at, left_at);
            }
            if (features.deepest) {
                kernel_deepen(kept, left, left_at);
            }
        }
    }
    lanes_store(scratch->made_good[0], sum_x);
    lanes_store(scratch->made_good[1], sum_y);
    lanes_store(scratch->made_good[2], moment);
}

// Remembers of one spring what the next step is held against. Returns, as bits, where it began or
// ceased to act within the step that ends now, and for spring 0, or all whose greatest deformation
// is wanted, where it ceased to touch.
LANES_INLINE uint32_t kernel_keep_event(struct problem_features features, uint32_t index,
                                        uint32_t number, const struct kernel_place *place,
                                        struct lanes deformation, struct lanes_mask contact,
                                        struct lanes_mask loading, struct lanes_mask loads,
                                        struct lanes_mask unloads, struct kernel_event *event,
                                        struct kernel_bits *switches)
{
    const uint32_t now = number % 2;
    const uint32_t before = 1 - now;
    event->contact[now] = lanes_bits(contact);
    event->loading = lanes_bits(loading);
    switches->contact |= event->contact[now];
    switches->loading |= event->loading;
    switches->idle |= event->contact[now] & ~event->loading;
    event->loads[now] = features.late_start ? lanes_bits(loads) : event->loading;
    uint32_t other = event->loads[before] ^ event->loads[now];
    if (features.unload) {
        event->unloads[now] = lanes_bits(unloads);
        other |= event->unloads[before] ^ event->unloads[now];
    }
    if (index == 0 || features.deepest) {
        other |= event->contact[before] & ~event->contact[now];
    }
    if (features.rounded) {
        lanes_store(event->deformation[now], deformation);
        lanes_store(event->edge[now], place->edge);
        lanes_store(event->slip[now], place->slip);
        event->arc = lanes_bits(lanes_and(place->arc, contact));
    }
    return other;
}

#endif
