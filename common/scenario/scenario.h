// A scenario: everything that defines a search, as read from one YAML file (design.md section 2),
// in SI units, checked as a whole, and from then on const to everyone. This header is plain data;
// scenario_read.h turns YAML into it.
#ifndef SOBOX_COMMON_SCENARIO_SCENARIO_H
#define SOBOX_COMMON_SCENARIO_SCENARIO_H

#include "common/numeric/box.h"
#include "common/numeric/curve_map.h"
#include "common/numeric/digest.h"
#include "common/protocol/protocol.h"
#include "common/scenario/outcome.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SCENARIO_NAME_SIZE = 64,                       // [bytes] of any name, with its NUL
    SCENARIO_SPRING_MAX = 64,                      // spring pairs
    SCENARIO_POINT_MAX = 32,                       // discretization points of a spring
    SCENARIO_VARIABLE_MAX = PROTOCOL_VARIABLE_MAX, // = springs x 2 directions x points
    SCENARIO_CONSTRAINT_MAX = 255,    // of all cases, so that a constraint fits a byte on the wire
    SCENARIO_CASE_MAX = 32,           // load cases of one scenario
    SCENARIO_ROW_MAX = 256,           // rows of the matrix of the linear model
    SCENARIO_START_MAX = 1024,        // starts of one search
    SCENARIO_NO_SPRING = UINT32_MAX,  // the spring of a variable that is no spring's force
    SCENARIO_OUTCOME_NAME_SIZE = 160, // [bytes] "CASE.energy_absorbed.SPRING" with its NUL
    SCENARIO_TEXT_SIZE_MAX = PROTOCOL_TEXT_SIZE_MAX, // [bytes] of YAML; larger files are refused
};

// What turns a design into outcomes. All but the first are functions in closed form (formula.h).
enum scenario_model {
    SCENARIO_MODEL_SMALL_OVERLAP,
    SCENARIO_MODEL_HYPERSPHERE,
    SCENARIO_MODEL_ELLIPSE,
    SCENARIO_MODEL_LINEAR,
    SCENARIO_MODEL_ROSENBROCK,
    SCENARIO_MODEL_TWO_SECTION_CRASH,
    SCENARIO_MODEL_ORDERED_CRASH,
    SCENARIO_MODEL_CORRIDOR_CRASH,
    SCENARIO_MODEL_COUNT,
};
enum scenario_profile { SCENARIO_PROFILE_FLAT, SCENARIO_PROFILE_ROUNDED };
enum scenario_integrator {
    SCENARIO_INTEGRATOR_CENTRAL_DIFFERENCE,
    SCENARIO_INTEGRATOR_VELOCITY_VERLET,
    SCENARIO_INTEGRATOR_RUNGE_KUTTA_4,
    SCENARIO_INTEGRATOR_EVENT_VERLET,
};
enum scenario_reloading { SCENARIO_RELOADING_THESIS, SCENARIO_RELOADING_CRUSHED };
enum scenario_response {
    SCENARIO_RESPONSE_ANY,
    SCENARIO_RESPONSE_ROTATING,
    SCENARIO_RESPONSE_GLANCING_OFF,
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
    double overlap;     // [m] > 0; the length by which AbWAP and AbWP are made dimensionless: by
                        // default from the first spring's start to the end of the face
    double edge_radius; // [m] of the rounded profile
    enum scenario_profile profile;
};

// An axial and a lateral spring that share a place and the axial deformation. The crash is planar:
// only measured barrier forces are shared by height, among springs at the same y.
struct scenario_spring {
    char name[SCENARIO_NAME_SIZE];
    double position[2];   // [m] from the COG in vehicle axes
    double length;        // [m] undeformed
    double height;        // [m] above the road, NAN where none is given; see above
    uint32_t point_count; // 2..SCENARIO_POINT_MAX
    double deformation[SCENARIO_POINT_MAX];                           // [m] ascending
    double force_lower[SCENARIO_DIRECTION_COUNT][SCENARIO_POINT_MAX]; // [N] the design space
    double force_upper[SCENARIO_DIRECTION_COUNT][SCENARIO_POINT_MAX]; // [N]
};

struct scenario_simulation {
    double duration;  // [s] > 0
    double time_step; // [s] > 0, not above the duration
    enum scenario_integrator integrator;
    enum scenario_reloading reloading; // of a spring that let go and is pressed again
};

// min <= outcome <= max.
struct scenario_constraint {
    uint32_t outcome; // index among the scenario's outcomes: with cases, those of all of them
    double min;       // -INFINITY where there is none
    double max;       // INFINITY where there is none
    double scale;     // > 0: relative violation = (min - value or value - max) / scale
};

// Something that cannot be meant, or is unlikely (plausibility.h).
struct scenario_finding {
    int check;        // enum plausibility_check: the row of the table
    bool error;       // it cannot be meant; else it is unlikely
    bool likely;      // the text names a likely slip
    const char *slip; // the unit that was probably meant, or NULL; never released
    char *place;      // "sedan.yaml:14:9"
    char *text;       // "vehicle.mass: mass of 1.65 kg, expected ..."
};

#define SCENARIO_EXPLAIN_AUTO UINT32_MAX

// The two bounds of every variable; NAN where a bound is not held.
struct scenario_hold {
    double *lower; // (variables) or NULL: none is held
    double *upper; // (variables) or NULL: none is held
};

// How to search. Lists have one number a variable, fixed ones included, in the unit of the variable
// and the order of scenario.variables; a list that the file does not give is NULL. What the reader
// promises about them is said here and need not be checked again.
struct scenario_search {
    uint32_t samples;             // a step
    uint32_t exploration_steps;   // at most
    uint32_t consolidation_steps; // at most
    uint32_t certificate_samples;
    double target_purity; // in (0, 1)
    uint64_t seed;
    enum promise promise;          // which designs of the box must be good
    enum sampling_method sampling; // of all steps but the certificate's, which are uniform

    uint32_t starts;      // starts to try, 0..SCENARIO_START_MAX; 0: as many as the search finds
                          // right. A given start is the first of them; each has at least two
                          // steps of exploration
    uint64_t evaluations; // budget of the whole search, its certificate included; 0: no limit
                          // beside the counts of steps. At least samples + certificate_samples
    uint32_t stagnation;  // steps over which the mean log-volume must grow, lest exploration, or
                          // a consolidation at rest, ends early; 0: all steps are spent
    uint32_t explain_samples; // just outside each bound, to say what holds it; 0: it is not said.
                              // SCENARIO_EXPLAIN_AUTO: as many as are worth their cost

    double round; // the bounds of the box are rounded inwards to multiples of it before the box is
                  // certified, in the variable's unit; 0: they are not

    double *start;        // the design from which to begin, inside the design space
    struct box start_box; // the box from which to begin, inside the design space; count 0: none.
                          // Not given together with `start`
    double *reference;    // a design that every box the search keeps must contain: inside the
                          // design space and what is held. Whether it is good is for the search to
                          // find out. With `start_box`, inside that too

    double *weights;        // > 0; 1 where none is given. The search makes the sum of weight x
                            // ln(width) over the free variables large. Results still state the
                            // plain log_volume
    double *minimum_widths; // >= 0, at most the variable's width in the design space (or, where
                            // both bounds are held, between them); 0 where none is given
    // Of a `box` in the file, which is to be certified, all bounds are held, and nothing else that
    // shapes a box is given.
    struct scenario_hold hold; // bounds of corridors that stay where they are, inside the design
                               // space, lower not above upper. Held both and equal, a variable has
                               // that one value
    uint32_t *tie;             // the first variable (lowest index) of those that share a corridor;
                               // the variable's own index when it shares with none. They have the
                               // same interval in the design space, the same weight, minimum
                               // width, held bounds, and bounds of start_box. The corridors are
                               // equal; the values of a design within them are independent
};

// One free or fixed number of a design.
struct scenario_variable {
    char name[SCENARIO_NAME_SIZE + 32]; // "front.force_x[3]" for the crash model, else the user's
    uint32_t spring;                    // index, or SCENARIO_NO_SPRING in other models
    uint32_t point;                     // index of the discretization point; 0 without a spring
    enum scenario_direction direction;  // meaningless without a spring
};

// A number that a formula computes with: of the design, or the same for all designs.
struct scenario_input {
    uint32_t variable; // index, or SCENARIO_CONSTANT
    double value;      // of a constant
};
#define SCENARIO_CONSTANT UINT32_MAX

// What a model in closed form computes with: formula.h says which inputs and constants in which
// order. All zero for the crash model.
struct scenario_formula {
    struct scenario_input *inputs; // (input_count)
    uint32_t input_count;
    double *constants; // (constant_count) that are never part of a design: a matrix, lengths
    uint32_t constant_count;
    uint32_t rows; // of the linear model's matrix; points of a corridor_crash's curve; else 0
};

// With cases, a design is good only if it is good in every one: each is a scenario of its own, the
// outer one with the case's overrides, and has the same variables, bounds and deformation points.
// The outer scenario's outcomes are then those of the cases, one after the other, and so are its
// constraints; its own vehicle, barrier, springs and formula are what the cases began from, and
// nothing is evaluated with them.
struct scenario {
    char name[SCENARIO_NAME_SIZE]; // of a case its own
    enum scenario_model model;

    // Of the crash model.
    struct scenario_vehicle vehicle;
    struct scenario_barrier barrier;
    struct scenario_spring *springs; // (spring_count) the first one sits at the A-pillar
    uint32_t spring_count;           // 1..SCENARIO_SPRING_MAX; 0 for other models
    struct scenario_simulation simulation;
    enum scenario_response response;
    double firewall_distance; // [m] least s_L_min

    // Of the other models.
    struct scenario_formula formula;

    struct scenario_search search; // of a case all default: the outer scenario's holds

    struct scenario *cases; // (case_count) none of them has cases itself
    uint32_t case_count;    // 0 or 1..SCENARIO_CASE_MAX

    // Derived when the file is read.
    // Variables stand spring by spring, x points before y points; else in the order of the file.
    struct scenario_variable *variables;     // (design_space.count)
    struct curve_map curves;                 // which variables make a curve
    struct box design_space;                 // one interval a variable
    struct scenario_constraint *constraints; // (constraint_count) of the response or formula, then
                                             // the user's; with cases, case by case
    uint32_t constraint_count;               // 1..SCENARIO_CONSTRAINT_MAX

    // What is not plausible about the file's numbers: with cases, about those of the cases.
    struct scenario_finding *findings; // (finding_count)
    uint32_t finding_count;

    // Of a case NULL, 0 and zeroed.
    char *text;           // the complete scenario as canonical YAML, overrides applied
    size_t text_size;     // [bytes] without the NUL that follows
    struct digest digest; // of the text: the scenario's name on the network
};

// A scenario with every optional value at its default and nothing else. The caller releases it.
void scenario_init(struct scenario *scenario);

// Releases what a scenario owns. A zeroed struct is fine.
void scenario_fini(struct scenario *scenario);

// How many outcomes a design of the scenario has: for the crash model OUTCOME_ENERGY_ABSORBED +
// 2 spring_count, for others those of the formula, with cases the sum over them.
uint32_t scenario_outcome_count(const struct scenario *scenario);

// The outcome of that name, or scenario_outcome_count() when there is none.
uint32_t scenario_outcome_find(const struct scenario *scenario, const char *name);

// Whether every bound is held: there is a box to certify, and nothing to search.
bool scenario_is_box(const struct scenario *scenario);

// Whether search.round holds of a variable's interval: no bound of it that may move is anything but
// a multiple. Without search.round it does.
bool scenario_is_rounded(const struct scenario *scenario, const struct box *box, uint32_t variable);

// Writes the outcome's name, for instance "s_L", "energy_absorbed.front", or with cases
// "wagon.s_L"; returns `name`.
const char *scenario_outcome_name(const struct scenario *scenario, uint32_t outcome,
                                  char name[SCENARIO_OUTCOME_NAME_SIZE]);

// The outcome's unit, "1" where it has none.
const char *scenario_outcome_unit(const struct scenario *scenario, uint32_t outcome);

// Words as they stand in the file: "any", "central_difference", "uniform", "flat", "x".
const char *scenario_model_name(enum scenario_model model);
const char *scenario_response_name(enum scenario_response response);
const char *scenario_integrator_name(enum scenario_integrator integrator);
const char *scenario_reloading_name(enum scenario_reloading reloading);
const char *scenario_sampling_name(enum sampling_method sampling);
const char *scenario_profile_name(enum scenario_profile profile);
const char *scenario_direction_name(enum scenario_direction direction);

#endif
