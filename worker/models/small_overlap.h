// The crash model of the scenario: turns vehicle, barrier and springs into a problem of the
// kinematics, and its results into the outcomes of common/scenario/outcome.h.
#ifndef SOBOX_WORKER_MODELS_SMALL_OVERLAP_H
#define SOBOX_WORKER_MODELS_SMALL_OVERLAP_H

#include "common/scenario/scenario.h"
#include "worker/kinematics/kinematics.h"
#include "worker/models/design.h"

// Standard gravity [m/s2], in which outcomes state decelerations.
#define SMALL_OVERLAP_GRAVITY 9.80665

// Prepares the problem of a scenario. Its forces are those of the scenario's variables, in their
// order, or with a `design` (not NULL) those that small_overlap_values() gives. Nothing is kept.
// The caller frees it with kinematics_free().
struct kinematics_problem *small_overlap_problem(const struct scenario *scenario,
                                                 const struct design *design,
                                                 struct kinematics_omitted omitted);

// The forces of a design as its problem takes them: values (kinematics_value_count()).
void small_overlap_values(const struct design *design, double *values);

// Turns results into outcomes where they stand: outcomes[outcome * stride + i] (count). The two
// lists have the same order; units, signs and the overlap as measure are what changes. `overlap` is
// the barrier's.
void small_overlap_outcomes(double overlap, uint32_t count, double *outcomes, size_t stride);

// Whether a crash with that greatest yaw [degrees] went beyond 90 degrees, where a spring's line
// meets the barrier's face no more: there it gave no force. False where the yaw is not finite.
bool small_overlap_turned(double yaw_max_deg);

#endif
