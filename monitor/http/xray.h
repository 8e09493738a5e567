// The samples of a step as points over two variables, coloured by what stands in their way: the
// picture by which solution spaces are read. Coordinates are made again from the step's box and
// numbers (common/sampling), so these are the very designs that were evaluated.
#ifndef SOBOX_MONITOR_HTTP_XRAY_H
#define SOBOX_MONITOR_HTTP_XRAY_H

#include "common/scenario/scenario.h"
#include "monitor/feed/album.h"

#include <glib.h>
#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

// Writes
//   {step, phase, detail: "full"|"share", seed, samples, good, count, x, y,
//    sampled: {x: [lower, upper], y: [lower, upper]}, box: the same of the search's box after it,
//    points: [[x, y, constraint, violation]]}
// where constraint is -1 for a good sample and null where it is not told (certificates); violation
// is relative to the constraint's scale, null for a good sample or a non-finite outcome. False when
// there are no such variables.
bool xray_points(const struct album_picture *picture, uint32_t x, uint32_t y, GString *out);

// Writes all variables of all samples as CSV, exact to the bit, under the names of `scenario`
// (NULL: variables are numbered): sample, good, the constraint violated most and by how much, then
// values.
void xray_csv(const struct album_picture *picture, const struct scenario *scenario, GString *out);

// The constraints of a scenario: [{outcome, unit, min, max}], null for a bound that is not there.
json_t *xray_constraints(const struct scenario *scenario);

#endif
