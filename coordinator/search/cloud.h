// Points of the design space that were simulated, in the free variables only: what the search
// knows. A sample is a fact whatever box it was drawn from, so bad ones are kept and keep counting
// against every later box. Stored column by column (one variable of all points together), which is
// how the trim walks over them.
#ifndef SOBOX_COORDINATOR_SEARCH_CLOUD_H
#define SOBOX_COORDINATOR_SEARCH_CLOUD_H

#include "common/numeric/box.h"

#include <stddef.h>
#include <stdint.h>

struct cloud {
    uint32_t variables;  // columns
    uint32_t count;      // points
    uint32_t capacity;   // points there is room for: the distance between columns
    double *values;      // (variables x capacity) in the variable's unit
    uint16_t *violation; // (capacity) as in struct verdict
};

// An empty cloud. The caller releases it with cloud_fini().
void cloud_init(struct cloud *cloud, uint32_t variables);

// Releases a cloud. A zeroed struct is fine.
void cloud_fini(struct cloud *cloud);

// Forgets all points and keeps the memory.
void cloud_clear(struct cloud *cloud);

// Makes room for `count` more points.
void cloud_reserve(struct cloud *cloud, uint32_t count);

// Adds a point; point[i * stride] is its variable i.
void cloud_add(struct cloud *cloud, const double *point, size_t stride, uint16_t violation);

// Adds those points of `from` that lie in `box` (same variables).
void cloud_add_inside(struct cloud *cloud, const struct cloud *from, const struct box *box);

// Whether all points lie in `box`.
bool cloud_inside(const struct cloud *cloud, const struct box *box);

// Forgets the oldest points until at most `count` are left.
void cloud_keep_newest(struct cloud *cloud, uint32_t count);

// The newest points of a cloud, at most `count`: a view that owns nothing and holds until the cloud
// changes.
struct cloud cloud_newest(const struct cloud *cloud, uint32_t count);

// Column of a variable.
static inline const double *cloud_column(const struct cloud *cloud, uint32_t variable)
{
    return cloud->values + (size_t)variable * cloud->capacity;
}

#endif
