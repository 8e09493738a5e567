// Whether a crash scenario can be meant. Every number of a scenario may be of the right type and in
// its range and the whole still be no crash: a mass in tonnes, a speed in km/h, springs on the side
// that the barrier does not touch. Such a scenario runs, and what comes out looks like a result. So
// the reader holds each scenario against a table of what cars and crash tests are like:
//
//     found        error_min    min          max    error_max
//     ---------------|-----------|------------|---------|----------
//       an error       a warning     silence     warning    an error
//
// What cannot be meant is an error, what is unlikely a warning. Either says where, what was found,
// what is usual and why, and the likely slip where one unit or sign would set it right. The limits
// are wide: they look for slips of a factor or a sign, not for unusual cars, and no lorry, kart or
// full-width wall may be suspected.
#ifndef SOBOX_COMMON_SCENARIO_PLAUSIBILITY_H
#define SOBOX_COMMON_SCENARIO_PLAUSIBILITY_H

#include "common/scenario/crash_read.h"

// A row of the table. README.md and sobox-scenario(5) show it; a test holds them to it.
struct plausibility_row {
    const char *key;  // of the scenario, as in the manual
    const char *what; // the quantity that has limits
    const char *unit; // "" for a number without one
    double error_min; // below it is an error, and above error_max; infinite where there is none
    double min;       // below it is a warning, and above max
    double max;
    double error_max;
    const char *reason; // why these limits
    const char *only;   // when it is looked at, for those who read the table; NULL: always
};

enum plausibility_check {
    PLAUSIBILITY_MASS,
    PLAUSIBILITY_GYRATION,
    PLAUSIBILITY_SLENDERNESS,
    PLAUSIBILITY_SPEED,
    PLAUSIBILITY_COG,
    PLAUSIBILITY_FACE,
    PLAUSIBILITY_EDGE,
    PLAUSIBILITY_WIDTH,
    PLAUSIBILITY_RADIUS,
    PLAUSIBILITY_OVERLAP,
    PLAUSIBILITY_OVERLAP_SPARE,
    PLAUSIBILITY_AHEAD,
    PLAUSIBILITY_BESIDE,
    PLAUSIBILITY_MISS,
    PLAUSIBILITY_LENGTH,
    PLAUSIBILITY_PRESSED,
    PLAUSIBILITY_GAP,
    PLAUSIBILITY_HEIGHT,
    PLAUSIBILITY_DEFORMATION,
    PLAUSIBILITY_FORCE_SIGN,
    PLAUSIBILITY_FORCE_POINT,
    PLAUSIBILITY_FORCE_RATIO,
    PLAUSIBILITY_SPRING_SHARE,
    PLAUSIBILITY_ENERGY,
    PLAUSIBILITY_FIREWALL,
    PLAUSIBILITY_DURATION,
    PLAUSIBILITY_TIME_STEP,
    PLAUSIBILITY_CONSTRAINT_YAW,
    PLAUSIBILITY_CONSTRAINT_LENGTH,
    PLAUSIBILITY_CONSTRAINT_SHARE,
    PLAUSIBILITY_CONSTRAINT_SPEED,
    PLAUSIBILITY_CONSTRAINT_DECELERATION,
    PLAUSIBILITY_CONSTRAINT_ENERGY,
    PLAUSIBILITY_CHECK_COUNT,
};

// The table, PLAUSIBILITY_CHECK_COUNT rows in the order of the enum.
extern const struct plausibility_row plausibility_rows[];

// Holds what the file gives against the table and adds what it finds to the scenario's findings.
// The values are those of the file: lengths and overlap that it leaves open are 0 still.
void plausibility_crash(const struct crash_document *document, struct scenario *scenario);

// The same for the limits of outcomes, after everything else; `constraints` may be NULL.
void plausibility_constraints(const struct tree_node *constraints, struct scenario *scenario);

// Fills `error` (STATUS_INVALID) with the first error among the findings, and where the others are.
// Returns whether there is one.
bool plausibility_refused(const struct scenario *scenario, struct error *error);

// The same where an error has a likely slip, from which whatever else is wrong may follow.
bool plausibility_explains(const struct scenario *scenario, struct error *error);

// Says the warnings on standard error, each with its place.
void plausibility_tell(const struct scenario *scenario);

// Takes over the findings of the cases, each with its case's name, in place of the scenario's own:
// nothing is simulated with what the cases began from. What several cases share is kept once.
void plausibility_join_cases(struct scenario *scenario);

#endif
