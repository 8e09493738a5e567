// A scenario: everything that defines a search, as read from one YAML file (design.md section 2),
// in SI units, checked as a whole, and from then on const to everyone. This header is plain data;
// scenario_read.h turns YAML into it.
#ifndef SOBOX_COMMON_SCENARIO_SCENARIO_H
#define SOBOX_COMMON_SCENARIO_SCENARIO_H

#include "common/numeric/box.h"
#include "common/numeric/digest.h"
#include "common/scenario/outcome.h"

#include <stddef.h>
#include <stdint.h>

enum {
    SCENARIO_NAME_SIZE = 64,          // [bytes] of any name, with its NUL
    SCENARIO_SPRING_MAX = 64,         // spring pairs
    SCENARIO_POINT_MAX = 32,          // discretization points of a spring
    SCENARIO_VARIABLE_MAX = 4096,     // = springs x 2 directions x points
    SCENARIO_CONSTRAINT_MAX = 64,     // so that a constraint fits a byte on the wire
    SCENARIO_TEXT_SIZE_MAX = 1 << 20, // [bytes] of YAML; larger files are refused
};

enum scenario_model { SCENARIO_MODEL_SMALL_OVERLAP };
enum scenario_profile { SCENARIO_PROFILE_FLAT, SCENARIO_PROFILE_ROUNDED };
enum scenario_integrator {
    SCENARIO_INTEGRATOR_CENTRAL_DIFFERENCE,
    SCENARIO_INTEGRATOR_VELOCITY_VERLET,
    SCENARIO_INTEGRATOR_RUNGE_KUTTA_4,
};
enum scenario_response {
    SCENARIO_RESPONSE_ANY,
    SCENARIO_RESPONSE_ROTATING,
    SCENARIO_RESPONSE_GLANCING_OFF,
};
enum scenario_sampling {
    SCENARIO_SAMPLING_UNIFORM,
    SCENARIO_SAMPLING_LATIN_HYPERCUBE,
    SCENARIO_SAMPLING_SOBOL,
};
enum scenario_direction { SCENARIO_DIRECTION_X, SCENARIO_DIRECTION_Y, SCENARIO_DIRECTION_COUNT };

struct scenario_vehicle {
    double mass;        // [kg] > 0
    double yaw_inertia; // [kg m2] > 0
    double speed;       // [m/s] > 0, towards the barrier (-x)
    double cog[2];      // [m] place of the centre of gravity at first contact
};

struct scenario_barrier {
    double face_x;      // [m] x of the face
    double edge_y;      // [m] y of the face's inner end; the face runs from here towards -y
    double width;       // [m] > 0
    double overlap;     // [m] > 0; the length by which AbWAP and AbWP are made dimensionless
    double edge_radius; // [m] of the rounded profile
    enum scenario_profile profile;
};

// An axial and a lateral spring that share a place and the axial deformation.
struct scenario_spring {
    char name[SCENARIO_NAME_SIZE];
    double position[2];                     // [m] from the COG in vehicle axes
    double length;                          // [m] undeformed
    uint32_t point_count;                   // 2..SCENARIO_POINT_MAX
    double deformation[SCENARIO_POINT_MAX]; // [m] ascending
    double force_lower[SCENARIO_DIRECTION_COUNT][SCENARIO_POINT_MAX]; // [N] the design space
    double force_upper[SCENARIO_DIRECTION_COUNT][SCENARIO_POINT_MAX]; // [N]
};

struct scenario_simulation {
    double duration;  // [s] > 0
    double time_step; // [s] > 0, not above the duration
    enum scenario_integrator integrator;
};

// min <= outcome <= max.
struct scenario_constraint {
    uint32_t outcome; // index among the model's outcomes
    double min;       // -INFINITY where there is none
    double max;       // INFINITY where there is none
    double scale;     // > 0: relative violation = (min - value or value - max) / scale
};

struct scenario_search {
    uint32_t samples;             // a step
    uint32_t exploration_steps;   // at most
    uint32_t consolidation_steps; // at most
    uint32_t certificate_samples;
    double target_purity; // in (0, 1)
    uint64_t seed;
    enum scenario_sampling sampling;
};

// One free or fixed force of the design space.
struct scenario_variable {
    char name[SCENARIO_NAME_SIZE + 32]; // "front.force_x[3]" for the crash model
    uint32_t spring;                    // index
    uint32_t point;                     // index of the discretization point
    enum scenario_direction direction;
};

struct scenario {
    char name[SCENARIO_NAME_SIZE];
    enum scenario_model model;
    struct scenario_vehicle vehicle;
    struct scenario_barrier barrier;
    struct scenario_spring *springs; // (spring_count) the first one sits at the A-pillar
    uint32_t spring_count;           // 1..SCENARIO_SPRING_MAX
    struct scenario_simulation simulation;
    enum scenario_response response;
    double firewall_distance; // [m] least s_L
    struct scenario_search search;

    // Derived when the file is read.
    struct scenario_variable
        *variables;          // (design_space.count) spring by spring; x points, y points
    struct box design_space; // one interval a variable
    struct scenario_constraint *constraints; // (constraint_count) of the response, then the user's
    uint32_t constraint_count;               // 1..SCENARIO_CONSTRAINT_MAX

    char *text;           // the complete scenario as canonical YAML, overrides applied
    size_t text_size;     // [bytes] without the NUL that follows
    struct digest digest; // of the text: the scenario's name on the network
};

// A scenario with every optional value at its default and nothing else. The caller releases it.
void scenario_init(struct scenario *scenario);

// Releases what a scenario owns. A zeroed struct is fine.
void scenario_fini(struct scenario *scenario);

// How many outcomes the scenario's model has: OUTCOME_ENERGY_ABSORBED + spring_count.
uint32_t scenario_outcome_count(const struct scenario *scenario);

// The outcome of that name, or scenario_outcome_count() when there is none.
uint32_t scenario_outcome_find(const struct scenario *scenario, const char *name);

// Writes the outcome's name, for instance "s_L" or "energy_absorbed.front"; returns `name`.
const char *scenario_outcome_name(const struct scenario *scenario, uint32_t outcome,
                                  char name[SCENARIO_NAME_SIZE + 32]);

// The outcome's unit, "1" where it has none.
const char *scenario_outcome_unit(const struct scenario *scenario, uint32_t outcome);

// Words as they stand in the file: "any", "central_difference", "uniform", "flat", "x".
const char *scenario_response_name(enum scenario_response response);
const char *scenario_integrator_name(enum scenario_integrator integrator);
const char *scenario_sampling_name(enum scenario_sampling sampling);
const char *scenario_profile_name(enum scenario_profile profile);
const char *scenario_direction_name(enum scenario_direction direction);

#endif
