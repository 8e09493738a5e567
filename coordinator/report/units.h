// Consistent units of those who take the corridors on: a simulation has one unit of force, length
// and time for everything.
#ifndef SOBOX_COORDINATOR_REPORT_UNITS_H
#define SOBOX_COORDINATOR_REPORT_UNITS_H

#include "common/base/error.h"

struct units {
    const char *name;   // "kN-mm-ms"
    const char *force;  // "kN"
    const char *length; // "mm"
    double per_newton;  // how many of the unit are one newton
    double per_metre;
};

// Finds a set of units by its name: N-m-s, N-mm-s, N-mm-ms, kN-m-s, kN-mm-s, kN-mm-ms.
// Errors: STATUS_INVALID, with all names.
enum status units_find(const char *name, const struct units **units, struct error *error) MUST_USE;

#endif
