// What a constraint costs: the log-volume that the box would gain if the constraint were relaxed by
// 1 %, that is if its min and its max were moved outwards by 1 % of its scale. The scale is that of
// its violation (constraint.c): the greater of |min| and |max|; where that is zero, 1 in the
// outcome's own unit for the crash model and for others what the outcome is made of
// (formula_outcome_scale()).
//
// No sample is evaluated anew: a bad one whose worst constraint is the relaxed one, and whose
// relative violation is at most 0.01, is good then. Of the samples in the box that is a share f of
// all, of the share b that is bad; where they are few, f follows from the density of the 20 least
// violations (or the lesser half of all). Of those in the slabs (explain.h) it changes how the bad
// mass grows when a variable's corridor is widened by e times its width,
//
//     M(e) = sum over its bounds of the bad share within their part of e, times that part,
//
// to M'(e). Compared are two boxes of the same bad share: one widened by a little, e0, without
// relaxing, and one widened by e1 with it,
//
//     (b + M(e0)) / (1 + e0) = (b - f + M'(e1)) / (1 + e1),    gain = ln (1 + e1) / (1 + e0).
//
// With e0 > 0 both are read where there are bad samples to read them by, also where the box is pure
// and b and f are 0: the difference is then how far the constraint's surface moved. Both bounds of
// a variable move if the constraint holds both, else the one that it holds.
//
// By the envelope theorem it makes no difference, to first order, which corridor takes what was
// gained, as long as no other constraint is in its way. So M and M' are means over the variables of
// which the bounds are held by this constraint and not by another; if there is none, over all that
// it holds in part.
//
// Its limits: one corridor is widened at a time, and the last of it costs most, so a large gain
// comes out too small (by a fifth at 0.3). A sample that violates another constraint a little less
// counts as good though it stays bad. Where every bound that the constraint holds is held by
// another one too, the gain is too small. It rests on a few dozen bad samples and has their noise:
// with 200 samples a bound, the default, it is right within a factor of two or so, with 2,000
// within 40 % (README.md has figures). It ranks constraints, and says whether a per cent is worth a
// tenth of the volume or a hundredth.
#ifndef SOBOX_COORDINATOR_SEARCH_GAIN_H
#define SOBOX_COORDINATOR_SEARCH_GAIN_H

#include "coordinator/search/explain.h"

extern const double gain_relaxation; // 0.01, in units of a constraint's scale

// What relaxing the constraint is worth, by the samples that `explain` has taken; its bounds'
// holders are concluded.
struct explain_gain gain_of(const struct explain *explain, uint32_t constraint);

#endif
