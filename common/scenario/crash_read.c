#include "common/scenario/crash_read.h"

#include "common/scenario/constraint.h"
#include "common/scenario/field.h"
#include "common/scenario/plausibility.h"
#include "common/scenario/words.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define STEPS_MAX 1e6 // of one simulation: 0.15 s at 0.15 us; more is a slip of the pen

static const struct field_range any_number = FIELD_ANY;

#define AT(structure, member) .offset = offsetof(struct structure, member)

// The node that holds number `index` of a value that is a number for all or a list.
static const struct tree_node *number_node(const struct tree_node *node, uint32_t index)
{
    return node->kind == TREE_SEQUENCE ? node->items[index] : node;
}

// ------------------------------------------------------------------------------------------------
// Vehicle, barrier, simulation

static const struct field vehicle_fields[] = {
    {"mass", FIELD_NUMBER, AT(scenario_vehicle, mass), .range = FIELD_POSITIVE, .unit = "kg"},
    {"yaw_inertia", FIELD_NUMBER, AT(scenario_vehicle, yaw_inertia), .range = FIELD_POSITIVE,
     .unit = "kg m2"},
    {"speed", FIELD_NUMBER, AT(scenario_vehicle, speed), .range = FIELD_POSITIVE, .unit = "m/s"},
    {"cog", FIELD_NUMBER_PAIR, .optional = true, AT(scenario_vehicle, cog), .range = FIELD_ANY,
     .unit = "m"},
};

static const struct field barrier_fields[] = {
    {"face_x", FIELD_NUMBER, AT(scenario_barrier, face_x), .range = FIELD_ANY, .unit = "m"},
    {"edge_y", FIELD_NUMBER, AT(scenario_barrier, edge_y), .range = FIELD_ANY, .unit = "m"},
    {"width", FIELD_NUMBER, .optional = true, AT(scenario_barrier, width), .range = FIELD_POSITIVE,
     .unit = "m"},
    {"overlap", FIELD_NUMBER, .optional = true, AT(scenario_barrier, overlap),
     .range = FIELD_POSITIVE, .unit = "m"},
    {"profile", FIELD_WORD, .optional = true, AT(scenario_barrier, profile),
     .words = scenario_profile_words},
    {"edge_radius", FIELD_NUMBER, .optional = true, AT(scenario_barrier, edge_radius),
     .range = FIELD_POSITIVE, .unit = "m"},
};

static const struct field simulation_fields[] = {
    {"duration", FIELD_NUMBER, .optional = true, AT(scenario_simulation, duration),
     .range = FIELD_POSITIVE, .unit = "s"},
    {"time_step", FIELD_NUMBER, .optional = true, AT(scenario_simulation, time_step),
     .range = FIELD_POSITIVE, .unit = "s"},
    {"integrator", FIELD_WORD, .optional = true, AT(scenario_simulation, integrator),
     .words = scenario_integrator_words},
    {"reloading", FIELD_WORD, .optional = true, AT(scenario_simulation, reloading),
     .words = scenario_reloading_words},
};

static bool read_vehicle(const struct tree_node *node, struct scenario *scenario,
                         struct error *error)
{
    return field_read(node, vehicle_fields, G_N_ELEMENTS(vehicle_fields), &scenario->vehicle,
                      error);
}

static bool read_barrier(const struct tree_node *node, struct scenario *scenario,
                         struct error *error)
{
    return field_read(node, barrier_fields, G_N_ELEMENTS(barrier_fields), &scenario->barrier,
                      error);
}

static bool check_barrier(const struct tree_node *node, const struct scenario *scenario,
                          struct error *error)
{
    const struct scenario_barrier *barrier = &scenario->barrier;
    if (barrier->profile == SCENARIO_PROFILE_ROUNDED && barrier->edge_radius > barrier->width) {
        tree_error(tree_spot(node, "edge_radius"), error,
                   "expected an edge_radius of at most the barrier's width of %g m, found %g",
                   barrier->width, barrier->edge_radius);
        return false;
    }
    return true;
}

static bool read_simulation(const struct tree_node *node, struct scenario *scenario,
                            struct error *error)
{
    return node == NULL || field_read(node, simulation_fields, G_N_ELEMENTS(simulation_fields),
                                      &scenario->simulation, error);
}

static bool check_simulation(const struct tree_node *node, const struct scenario *scenario,
                             struct error *error)
{
    const struct scenario_simulation *simulation = &scenario->simulation;
    if (node == NULL)
        return true;
    if (simulation->time_step > simulation->duration) {
        tree_error(tree_spot(node, "time_step"), error,
                   "expected a time_step of at most the duration of %g s, found %g",
                   simulation->duration, simulation->time_step);
        return false;
    }
    if (simulation->duration / simulation->time_step > STEPS_MAX) {
        tree_error(tree_spot(node, "time_step"), error,
                   "expected a time_step of at least %g s (a million steps), found %g",
                   simulation->duration / STEPS_MAX, simulation->time_step);
        return false;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------
// Springs

struct spring_document {
    struct scenario_spring spring;
    const struct tree_node *deformation;
    const struct tree_node *force[SCENARIO_DIRECTION_COUNT];
};

static const struct field spring_fields[] = {
    {"name", FIELD_IDENTIFIER, AT(spring_document, spring.name)},
    {"position", FIELD_NUMBER_PAIR, AT(spring_document, spring.position), .range = FIELD_ANY,
     .unit = "m", .expected = "a list of two numbers: x and y from the COG in m"},
    {"length", FIELD_NUMBER, .optional = true, AT(spring_document, spring.length),
     .range = FIELD_POSITIVE, .unit = "m"},
    {"height", FIELD_NUMBER, .optional = true, AT(spring_document, spring.height),
     .range = FIELD_ANY, .unit = "m"},
    {"deformation", FIELD_NODE, AT(spring_document, deformation),
     .expected = "an ascending list of deformations in m"},
    {"force_x", FIELD_NODE, AT(spring_document, force[SCENARIO_DIRECTION_X]),
     .expected = "a mapping with lower and upper in N"},
    {"force_y", FIELD_NODE, AT(spring_document, force[SCENARIO_DIRECTION_Y]),
     .expected = "a mapping with lower and upper in N"},
};

struct force_document {
    const struct tree_node *lower;
    const struct tree_node *upper;
};

static const struct field force_fields[] = {
    {"lower", FIELD_NODE, AT(force_document, lower), .expected = "a number or a list in N"},
    {"upper", FIELD_NODE, AT(force_document, upper), .expected = "a number or a list in N"},
};

static bool read_deformation(const struct tree_node *node, struct scenario_spring *spring,
                             struct error *error)
{
    static const struct field_range not_negative = FIELD_NOT_NEGATIVE;
    if (node->kind != TREE_SEQUENCE || node->count < 2 || node->count > SCENARIO_POINT_MAX) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(node, error, "expected a list of 2 to %d deformations in m, found %s",
                   SCENARIO_POINT_MAX, tree_shown(node, shown));
        return false;
    }
    spring->point_count = node->count;
    if (!field_read_numbers(node, &not_negative, "m", spring->deformation, node->count, error))
        return false;
    for (uint32_t i = 1; i < node->count; i++) {
        if (spring->deformation[i] > spring->deformation[i - 1])
            continue;
        tree_error(node->items[i], error,
                   "expected ascending deformations, here more than %.15g m, found %.15g",
                   spring->deformation[i - 1], spring->deformation[i]);
        return false;
    }
    return true;
}

static bool read_force(const struct tree_node *node, struct scenario_spring *spring,
                       enum scenario_direction direction, struct error *error)
{
    struct force_document force;
    double *lower = spring->force_lower[direction], *upper = spring->force_upper[direction];
    if (!field_read(node, force_fields, G_N_ELEMENTS(force_fields), &force, error) ||
        !field_read_numbers(force.lower, &any_number, "N", lower, spring->point_count, error) ||
        !field_read_numbers(force.upper, &any_number, "N", upper, spring->point_count, error))
        return false;
    for (uint32_t i = 0; i < spring->point_count; i++) {
        if (lower[i] <= upper[i])
            continue;
        tree_error(number_node(force.upper, i), error,
                   "expected at least the lower bound of %.15g N, found %.15g", lower[i], upper[i]);
        return false;
    }
    return true;
}

// The structure lies between the spring's place and the barrier's face, and there must be some.
static bool place_spring(const struct tree_node *node, const struct scenario *scenario,
                         struct scenario_spring *spring, struct error *error)
{
    double room = spring->position[0] + scenario->vehicle.cog[0] - scenario->barrier.face_x;
    if (room <= 0) {
        tree_error(tree_child(node, "position"), error,
                   "the spring is %g m behind the barrier's face: expected an x of more than %g m, "
                   "found %g",
                   -room, spring->position[0] - room, spring->position[0]);
        return false;
    }
    if (tree_child(node, "length") == NULL)
        spring->length = room;
    return true;
}

static bool place_springs(const struct tree_node *node, struct scenario *scenario,
                          struct error *error)
{
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        if (!place_spring(node->items[i], scenario, &scenario->springs[i], error))
            return false;
    return true;
}

static bool read_spring(const struct tree_node *node, struct scenario_spring *spring,
                        struct error *error)
{
    struct spring_document document = {.spring.height = NAN};
    if (!field_read(node, spring_fields, G_N_ELEMENTS(spring_fields), &document, error))
        return false;
    *spring = document.spring;
    return read_deformation(document.deformation, spring, error) &&
           read_force(document.force[SCENARIO_DIRECTION_X], spring, SCENARIO_DIRECTION_X, error) &&
           read_force(document.force[SCENARIO_DIRECTION_Y], spring, SCENARIO_DIRECTION_Y, error);
}

static bool name_is_new(const struct tree_node *node, const struct scenario *scenario,
                        uint32_t index, struct error *error)
{
    for (uint32_t i = 0; i < index; i++) {
        if (strcmp(scenario->springs[i].name, scenario->springs[index].name) != 0)
            continue;
        tree_error(tree_child(node, "name"), error,
                   "expected a name that no other spring has, found %s, the name of springs.%u",
                   scenario->springs[index].name, i);
        return false;
    }
    return true;
}

static bool read_springs(const struct tree_node *node, struct scenario *scenario,
                         struct error *error)
{
    if (node->kind != TREE_SEQUENCE || node->count < 1 || node->count > SCENARIO_SPRING_MAX) {
        char shown[TREE_SHOWN_SIZE];
        tree_error(node, error, "expected a list of 1 to %d springs, found %s", SCENARIO_SPRING_MAX,
                   tree_shown(node, shown));
        return false;
    }
    scenario->spring_count = node->count;
    scenario->springs = g_new0(struct scenario_spring, node->count);
    for (uint32_t i = 0; i < node->count; i++) {
        if (!read_spring(node->items[i], &scenario->springs[i], error) ||
            !name_is_new(node->items[i], scenario, i, error))
            return false;
    }
    return true;
}

// The overlap that the file leaves open: from where the first spring starts to the end of the face,
// so that AbWAP and AbWP of 1 say that the A-pillar has passed the barrier (thesis 8.1.2).
static bool default_overlap(const struct crash_document *document, struct scenario *scenario,
                            struct error *error)
{
    struct scenario_barrier *barrier = &scenario->barrier;
    if (tree_child(document->barrier, "overlap") != NULL)
        return true;
    const double *position = scenario->springs[0].position;
    double inner = barrier->edge_y - scenario->vehicle.cog[1]; // [m] y of the end, from the COG
    barrier->overlap = inner - position[1];
    if (barrier->overlap > 0)
        return true;
    tree_error(tree_child(document->springs->items[0], "position"), error,
               "the first spring starts %g m beside the barrier's end: expected a y of less than "
               "%g m, or a barrier.overlap by which lateral travel is judged, found %g",
               -barrier->overlap, inner, position[1]);
    return false;
}

// ------------------------------------------------------------------------------------------------
// Variables

static void name_variable(struct scenario_variable *variable, const struct scenario_spring *spring)
{
    snprintf(variable->name, sizeof variable->name, "%s.force_%s[%u]", spring->name,
             scenario_direction_name(variable->direction), variable->point);
}

// The variables in their order: spring by spring, all x points, then all y points.
static void make_variables(struct scenario *scenario)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        count += SCENARIO_DIRECTION_COUNT * scenario->springs[i].point_count;
    g_assert(count <= SCENARIO_VARIABLE_MAX);
    box_init(&scenario->design_space, count);
    scenario->variables = g_new0(struct scenario_variable, count);
    curve_map_init(&scenario->curves, count);
    scenario->curves.count = SCENARIO_DIRECTION_COUNT * scenario->spring_count;
    scenario->curves.group_count = SCENARIO_DIRECTION_COUNT;

    uint32_t at = 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
            for (uint32_t point = 0; point < spring->point_count; point++, at++) {
                scenario->variables[at] = (struct scenario_variable){
                    .spring = i,
                    .point = point,
                    .direction = (enum scenario_direction)direction,
                };
                name_variable(&scenario->variables[at], spring);
                scenario->curves.curve[at] = SCENARIO_DIRECTION_COUNT * i + (uint32_t)direction;
                scenario->curves.group[at] = (uint32_t)direction;
                scenario->design_space.lower[at] = spring->force_lower[direction][point];
                scenario->design_space.upper[at] = spring->force_upper[direction][point];
            }
        }
    }
}

static bool require_free_variable(const struct tree_node *springs, const struct scenario *scenario,
                                  struct error *error)
{
    if (box_free_count(&scenario->design_space) > 0)
        return true;
    tree_error(springs, error,
               "every force is fixed: expected at least one with its lower bound below its upper");
    return false;
}

// ------------------------------------------------------------------------------------------------
// The whole

// Just below 90 degrees, from where on a spring's line meets the barrier's face no more: a rotating
// car must stay there, or what it did beyond was done without the barrier.
#define YAW_MAX_DEG nextafter(90.0, 0.0)

// Thesis section 8.1. The firewall is passed when the A-pillar
// comes too near at any time in contact, not only at the last.
static void add_response(struct scenario *scenario)
{
    constraint_add(scenario, OUTCOME_S_L_MIN, scenario->firewall_distance, INFINITY);
    switch (scenario->response) {
    case SCENARIO_RESPONSE_ANY:
        break;
    case SCENARIO_RESPONSE_ROTATING:
        constraint_add(scenario, OUTCOME_ABWP, -INFINITY, 1.0);
        constraint_add(scenario, OUTCOME_YAW_MAX_DEG, -INFINITY, YAW_MAX_DEG);
        break;
    case SCENARIO_RESPONSE_GLANCING_OFF:
        constraint_add(scenario, OUTCOME_ABWAP, 1.0, INFINITY);
        constraint_add(scenario, OUTCOME_ABWP, 1.0, INFINITY);
        break;
    }
}

// What fits together, and what follows from it.
static bool complete(const struct crash_document *document, struct scenario *scenario,
                     struct error *error)
{
    return check_barrier(document->barrier, scenario, error) &&
           check_simulation(document->simulation, scenario, error) &&
           place_springs(document->springs, scenario, error) &&
           default_overlap(document, scenario, error);
}

bool crash_read(const struct crash_document *document, struct scenario *scenario,
                struct error *error)
{
    if (!read_vehicle(document->vehicle, scenario, error) ||
        !read_barrier(document->barrier, scenario, error) ||
        !read_simulation(document->simulation, scenario, error) ||
        !read_springs(document->springs, scenario, error))
        return false;
    plausibility_crash(document, scenario);
    if (!complete(document, scenario, error)) {
        // What does not fit mostly follows from a slip, which is the better thing to point at.
        plausibility_explains(scenario, error);
        return false;
    }
    make_variables(scenario);
    if (!require_free_variable(document->springs, scenario, error))
        return false;
    add_response(scenario);
    return true;
}
