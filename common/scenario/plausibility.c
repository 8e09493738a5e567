#include "common/scenario/plausibility.h"

#include "common/base/log.h"
#include "common/scenario/outcome.h"
#include "common/scenario/plausibility_find.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// The limits. Usual values: kart 150 kg, car 800 to 3000 kg, lorry 12 to 44 t; tests at 4 to 25
// m/s.
const struct plausibility_row plausibility_rows[] = {
    [PLAUSIBILITY_MASS] = {"vehicle.mass", "mass", "kg", 50, 100, 60e3, 500e3,
                           "a kart with its driver has 150 kg, a lorry 12 to 44 t"},
    [PLAUSIBILITY_GYRATION] =
        {"vehicle.yaw_inertia", "radius of gyration, sqrt(yaw_inertia / mass),", "m", 0.1, 0.3, 5,
         10, "it is 0.5 m for a kart, 1.2 to 1.5 m for a car, 2 to 4 m for a lorry"},
    [PLAUSIBILITY_SLENDERNESS] =
        {"vehicle.yaw_inertia", "radius of gyration over the distance to the face", "", -INFINITY,
         0.3, 2, INFINITY,
         "it is near 0.6 in a car; smaller, it may be the inertia of roll or of another car"},
    [PLAUSIBILITY_SPEED] = {"vehicle.speed", "speed", "m/s", -INFINITY, 1, 30, 100,
                            "crash tests are run at 4 to 25 m/s, 15 to 90 km/h"},
    [PLAUSIBILITY_COG] = {"vehicle.cog", "distance to the face over 0.18 m (mass / kg)^(1/3)", "",
                          -INFINITY, 0.6, 1.45, INFINITY, "it is near 1 from kart to lorry",
                          "where face_x alone would fit the mass"},
    [PLAUSIBILITY_FACE] =
        {"barrier.face_x", "distance from the centre of gravity ahead to the face", "m", 0.1, 0.3,
         8, 20, "the car travels towards -x; its front is 0.9 m (kart) to 4 m (lorry) ahead"},
    [PLAUSIBILITY_EDGE] = {"barrier.edge_y", "inner end of the face, from the centre of gravity,",
                           "m", -5, -2, 20, 200,
                           "cars are at most 2.6 m wide, and walls have an end"},
    [PLAUSIBILITY_WIDTH] = {"barrier.width", "width of the face", "m", -INFINITY, 0.05, 20, 200,
                            "a pole has 0.25 m, a wall some metres"},
    [PLAUSIBILITY_RADIUS] = {"barrier.edge_radius", "radius of the edge", "m", -INFINITY, -INFINITY,
                             0.5, 5, "the barrier of the small overlap test has 0.15 m"},
    [PLAUSIBILITY_OVERLAP] = {"barrier.overlap", "overlap", "m", -INFINITY, 0.02, 3, 5,
                              "a car is at most 2.6 m wide"},
    [PLAUSIBILITY_OVERLAP_SPARE] = {"barrier.overlap",
                                    "overlap beyond the way of the A-pillar to the end of the face",
                                    "m", -INFINITY, -0.03, 0.5, INFINITY,
                                    "with less, AbWAP says too early that the A-pillar has passed",
                                    "up to 1.5 m from it"},
    [PLAUSIBILITY_AHEAD] =
        {"springs.position", "place ahead of the centre of gravity, -x,", "m", -0.3, 0, 8, 20,
         "the car travels towards -x, so what is ahead, as its A-pillars are, has a negative x"},
    [PLAUSIBILITY_BESIDE] = {"springs.position", "place towards the struck side, -y,", "m", -5, -2,
                             2, 5, "half the width of a lorry is 1.3 m"},
    [PLAUSIBILITY_MISS] = {"springs.position", "distance sideways past the barrier's face", "m",
                           -INFINITY, -INFINITY, 0, INFINITY,
                           "such a spring never touches while the car goes straight",
                           "an error where every spring is past it"},
    [PLAUSIBILITY_LENGTH] = {"springs.length", "length", "m", -INFINITY, 0.1, 5, 20,
                             "the front of a car has 1 to 1.5 m before the A-pillar"},
    [PLAUSIBILITY_PRESSED] =
        {"springs.length", "deformation at first contact", "m", -INFINITY, -INFINITY, 0.01, 0.5,
         "a spring ends at the face or before it, position_x + cog_x - face_x from its place"},
    [PLAUSIBILITY_GAP] =
        {"springs.length", "gap at first contact", "m", -INFINITY, -INFINITY, 0.05, INFINITY,
         "cog is the place of the car when its first spring touches",
         "of the nearest spring; an error where the car does not get there in time"},
    [PLAUSIBILITY_HEIGHT] = {"springs.height", "height above the road", "m", -20, 0, 3, 20,
                             "barrier and cells are at most some metres high"},
    [PLAUSIBILITY_DEFORMATION] =
        {"springs.deformation", "last deformation over the spring's length", "", -INFINITY, 0.2,
         1.01, 1.5,
         "beyond its length a spring is gone; beyond its last point its force is a guess"},
    [PLAUSIBILITY_FORCE_SIGN] =
        {"springs.force_x", "least force", "N", -INFINITY, 0, INFINITY, INFINITY,
         "a positive force_x pushes the car back, a positive force_y away from the barrier",
         "an error where no force_x is positive; of force_y where none is"},
    [PLAUSIBILITY_FORCE_POINT] = {"springs.force_x",
                                  "upper bound over that of the points beside it", "", -INFINITY,
                                  0.003, 300, INFINITY,
                                  "the force of a structure changes less from point to point"},
    [PLAUSIBILITY_FORCE_RATIO] = {"springs.force_y", "greatest force_y over greatest force_x", "",
                                  -INFINITY, 0.01, 3, INFINITY,
                                  "lateral forces are a part of the axial ones",
                                  "where there are both"},
    [PLAUSIBILITY_SPRING_SHARE] = {"springs.force_x",
                                   "share of the energy that all springs can absorb", "", -INFINITY,
                                   0.001, INFINITY,
                                   INFINITY, "a spring that does nothing is better left out"},
    [PLAUSIBILITY_ENERGY] = {"springs.force_x",
                             "energy that the springs can absorb over the car's kinetic energy", "",
                             0.005, 1, 100, 500, "below 1 the structure cannot stop the car",
                             "of glancing_off from 0.5 on it is fine"},
    [PLAUSIBILITY_FIREWALL] = {"firewall_distance",
                               "firewall_distance over the first spring's length", "", -INFINITY,
                               -INFINITY, 0.8, 0.99,
                               "s_L_min begins at that length and only falls"},
    [PLAUSIBILITY_DURATION] = {"simulation.duration", "duration", "s", -INFINITY, 0.03, 1, 10,
                               "a crash lasts 0.1 to 0.2 s"},
    [PLAUSIBILITY_TIME_STEP] = {"simulation.time_step", "time step", "s", -INFINITY, -INFINITY,
                                0.005, 0.05, "the integrators are made for 1 ms and less"},
    [PLAUSIBILITY_CONSTRAINT_YAW] = {"constraints.yaw_deg, .yaw_max_deg", "limit of a yaw", "deg",
                                     -INFINITY, 1.6, 360, 1e4, "cars turn by some tens of degrees"},
    [PLAUSIBILITY_CONSTRAINT_LENGTH] =
        {"constraints.s_L, .s_L_min, .travel_x, .travel_y, .deformation_max", "limit of a length",
         "m", -INFINITY, -INFINITY, 10, 100, "a car travels some metres while it crashes"},
    [PLAUSIBILITY_CONSTRAINT_SHARE] = {"constraints.AbWAP, .AbWP", "limit of a share", "",
                                       -INFINITY, -INFINITY, 10, INFINITY,
                                       "1 is the whole overlap"},
    [PLAUSIBILITY_CONSTRAINT_SPEED] = {"constraints.delta_vx, .delta_vy",
                                       "limit over the car's speed", "", -INFINITY, -INFINITY, 2,
                                       INFINITY, "a car hardly loses more speed than it has"},
    [PLAUSIBILITY_CONSTRAINT_DECELERATION] = {"constraints.decel_max_g, .decel_mean_g",
                                              "limit of a deceleration", "g", -INFINITY, -INFINITY,
                                              150, INFINITY, "cars see 20 to 80 g"},
    [PLAUSIBILITY_CONSTRAINT_ENERGY] = {"constraints.kinetic_energy, .energy_absorbed",
                                        "limit over the car's kinetic energy", "", -INFINITY, 0.001,
                                        2, INFINITY, "that is all the energy there is"},
};
_Static_assert(G_N_ELEMENTS(plausibility_rows) == PLAUSIBILITY_CHECK_COUNT, "a row for each check");

// ------------------------------------------------------------------------------------------------
// Single numbers

static const struct plausibility_slip lengths[] = {{"mm", 1e-3}, {"cm", 1e-2}, {NULL, 0}};
static const struct plausibility_slip masses[] = {{"t", 1e3}, {"g", 1e-3}, {NULL, 0}};
static const struct plausibility_slip speeds[] = {
    {"km/h", 1 / 3.6}, {"mph", 0.44704}, {"mm/s", 1e-3}, {NULL, 0}};
static const struct plausibility_slip times[] = {{"ms", 1e-3}, {"us", 1e-6}, {NULL, 0}};

// What is ahead of the car has a negative x, which other programs count forwards.
static const char *forwards(double ahead, double least, char hint[PLAUSIBILITY_HINT_SIZE])
{
    if (ahead > -least)
        return NULL;
    snprintf(hint, PLAUSIBILITY_HINT_SIZE, "x counted positive forwards: here it is %.6g m", ahead);
    return hint;
}

static void check_vehicle(const struct tree_node *node, struct scenario *scenario)
{
    const struct scenario_vehicle *vehicle = &scenario->vehicle;
    plausibility_find(&(struct plausibility_find){.scenario = scenario,
                                                  .check = PLAUSIBILITY_MASS,
                                                  .node = tree_spot(node, "mass"),
                                                  .value = vehicle->mass,
                                                  .given = vehicle->mass,
                                                  .slips = masses,
                                                  .from = 100,
                                                  .to = 60e3,
                                                  .unit = "kg"});
    plausibility_find(&(struct plausibility_find){.scenario = scenario,
                                                  .check = PLAUSIBILITY_SPEED,
                                                  .node = tree_spot(node, "speed"),
                                                  .value = vehicle->speed,
                                                  .given = vehicle->speed,
                                                  .slips = speeds,
                                                  .from = 4,
                                                  .to = 30,
                                                  .unit = "m/s"});
}

// A length of the file, or one that follows from it.
static void check_length(struct scenario *scenario, enum plausibility_check check,
                         const struct tree_node *node, double value, double given, const char *hint)
{
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = check,
        .node = node,
        .value = value,
        .given = given,
        .slips = lengths,
        .from = fmax(check == PLAUSIBILITY_WIDTH ? 0.3 : 0.1, plausibility_rows[check].min),
        .to = 5,
        .unit = "m",
        .hint = hint});
}

static void check_barrier(const struct tree_node *node, struct scenario *scenario)
{
    const struct scenario_barrier *barrier = &scenario->barrier;
    const double *cog = scenario->vehicle.cog;
    const double ahead = cog[0] - barrier->face_x;
    char hint[PLAUSIBILITY_HINT_SIZE];
    check_length(scenario, PLAUSIBILITY_FACE, tree_spot(node, "face_x"), ahead, barrier->face_x,
                 barrier->face_x < 20 ? forwards(-barrier->face_x, 0.3, hint) : NULL);
    check_length(scenario, PLAUSIBILITY_EDGE, tree_spot(node, "edge_y"), barrier->edge_y - cog[1],
                 barrier->edge_y, NULL);
    check_length(scenario, PLAUSIBILITY_WIDTH, tree_spot(node, "width"), barrier->width,
                 barrier->width, NULL);
    check_length(scenario, PLAUSIBILITY_RADIUS, tree_spot(node, "edge_radius"),
                 barrier->edge_radius, barrier->edge_radius, NULL);
    if (tree_child(node, "overlap") != NULL)
        check_length(scenario, PLAUSIBILITY_OVERLAP, tree_spot(node, "overlap"), barrier->overlap,
                     barrier->overlap,
                     barrier->overlap <= 100 ? "per cent of the car's width in place of m" : NULL);
}

static void check_spring(const struct tree_node *node, struct scenario *scenario, uint32_t index)
{
    const struct scenario_spring *spring = &scenario->springs[index];
    const struct tree_node *position = tree_child(node, "position");
    const double x = spring->position[0], y = spring->position[1];
    char hint[PLAUSIBILITY_HINT_SIZE];
    check_length(scenario, PLAUSIBILITY_AHEAD, position->items[0], -x, x, forwards(-x, 0, hint));
    check_length(scenario, PLAUSIBILITY_BESIDE, position->items[1], -y, y, NULL);
    if (tree_child(node, "length") != NULL)
        check_length(scenario, PLAUSIBILITY_LENGTH, tree_spot(node, "length"), spring->length,
                     spring->length, NULL);
    if (tree_child(node, "height") != NULL)
        check_length(scenario, PLAUSIBILITY_HEIGHT, tree_spot(node, "height"), spring->height,
                     spring->height, NULL);
}

static void check_simulation(const struct tree_node *node, struct scenario *scenario)
{
    const struct scenario_simulation *simulation = &scenario->simulation;
    plausibility_find(&(struct plausibility_find){.scenario = scenario,
                                                  .check = PLAUSIBILITY_DURATION,
                                                  .node = tree_spot(node, "duration"),
                                                  .value = simulation->duration,
                                                  .given = simulation->duration,
                                                  .slips = times,
                                                  .from = 0.03,
                                                  .to = 1,
                                                  .unit = "s"});
    plausibility_find(&(struct plausibility_find){.scenario = scenario,
                                                  .check = PLAUSIBILITY_TIME_STEP,
                                                  .node = tree_spot(node, "time_step"),
                                                  .value = simulation->time_step,
                                                  .given = simulation->time_step,
                                                  .slips = times,
                                                  .from = 5e-4,
                                                  .to = 0.005,
                                                  .unit = "s"});
}

void plausibility_crash(const struct crash_document *document, struct scenario *scenario)
{
    check_vehicle(document->vehicle, scenario);
    check_barrier(document->barrier, scenario);
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        check_spring(document->springs->items[i], scenario, i);
    if (document->simulation != NULL)
        check_simulation(document->simulation, scenario);
    if (!plausibility_refused(scenario, NULL))
        plausibility_relate(document, scenario);
}

// ------------------------------------------------------------------------------------------------
// Limits of outcomes

static const struct plausibility_slip shares[] = {{"%", 1e-2}, {NULL, 0}};
static const struct plausibility_slip decelerations[] = {{"m/s2", 1 / 9.81}, {NULL, 0}};
static const struct plausibility_slip angles[] = {{"rad", 180 / G_PI}, {NULL, 0}};
static const struct plausibility_slip energies[] = {{"kJ", 1e3}, {NULL, 0}};

// What is checked of a limit of an outcome: in `find` its row and what it may have been meant as.
// Returns false for outcomes of which any limit may be meant.
static bool limit_of(const struct scenario *scenario, uint32_t outcome, double limit,
                     struct plausibility_find *find)
{
    const struct scenario_vehicle *vehicle = &scenario->vehicle;
    const double energy = 0.5 * vehicle->mass * vehicle->speed * vehicle->speed;
    const uint32_t first_deformation = OUTCOME_ENERGY_ABSORBED + scenario->spring_count;
    *find = (struct plausibility_find){.value = fabs(limit), .given = limit};
    if (outcome == OUTCOME_YAW_DEG || outcome == OUTCOME_YAW_MAX_DEG) {
        find->check = PLAUSIBILITY_CONSTRAINT_YAW;
        find->slips = angles, find->from = 1.6, find->to = 360, find->unit = "deg";
    } else if (outcome == OUTCOME_ABWAP || outcome == OUTCOME_ABWP) {
        find->check = PLAUSIBILITY_CONSTRAINT_SHARE;
        find->slips = shares, find->from = 0.1, find->to = 10, find->unit = "";
    } else if (outcome == OUTCOME_DELTA_VX || outcome == OUTCOME_DELTA_VY) {
        find->check = PLAUSIBILITY_CONSTRAINT_SPEED;
        find->value /= vehicle->speed;
        find->slips = speeds, find->from = 1, find->to = 2 * vehicle->speed, find->unit = "m/s";
    } else if (outcome == OUTCOME_DECEL_MAX_G || outcome == OUTCOME_DECEL_MEAN_G) {
        find->check = PLAUSIBILITY_CONSTRAINT_DECELERATION;
        find->slips = decelerations, find->from = 5, find->to = 150, find->unit = "g";
    } else if (outcome == OUTCOME_KINETIC_ENERGY ||
               (outcome >= OUTCOME_ENERGY_ABSORBED && outcome < first_deformation)) {
        find->check = PLAUSIBILITY_CONSTRAINT_ENERGY;
        find->value /= energy;
        find->slips = energies, find->from = 0.001 * energy, find->to = energy, find->unit = "J";
    } else if (outcome >= first_deformation || outcome == OUTCOME_S_L ||
               outcome == OUTCOME_S_L_MIN || outcome == OUTCOME_TRAVEL_X ||
               outcome == OUTCOME_TRAVEL_Y) {
        find->check = PLAUSIBILITY_CONSTRAINT_LENGTH;
        find->slips = lengths, find->from = 0.01, find->to = 5, find->unit = "m";
    } else {
        return false;
    }
    return true;
}

void plausibility_constraints(const struct tree_node *constraints, struct scenario *scenario)
{
    if (constraints == NULL || scenario->model != SCENARIO_MODEL_SMALL_OVERLAP)
        return;
    for (uint32_t i = 0; i < constraints->count; i++) {
        const struct tree_node *bounds = constraints->items[i];
        const uint32_t outcome = scenario_outcome_find(scenario, constraints->keys[i]->text);
        for (uint32_t k = 0; k < bounds->count; k++) {
            struct plausibility_find find;
            const double limit = g_ascii_strtod(bounds->items[k]->text, NULL);
            if (limit == 0 || !limit_of(scenario, outcome, limit, &find))
                continue; // a zero has no unit
            find.scenario = scenario;
            find.node = bounds->items[k];
            plausibility_find(&find);
        }
    }
}

// ------------------------------------------------------------------------------------------------
// What was found

static const struct scenario_finding *first_error(const struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        if (scenario->findings[i].error)
            return &scenario->findings[i];
    return NULL;
}

static bool has_slip(const struct scenario *scenario, const char *unit)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        if (g_strcmp0(scenario->findings[i].slip, unit) == 0)
            return true;
    return false;
}

// A file that was written for another program is wrong as a whole, in one of two ways that are
// usual among them.
static const char *system_of_units(const struct scenario *scenario)
{
    if (!has_slip(scenario, "mm"))
        return "";
    if (has_slip(scenario, "t"))
        return "; the whole file seems to be in t, mm, s, N, expected kg, m, s, N";
    if (has_slip(scenario, "ms"))
        return "; the whole file seems to be in kg, mm, ms, kN, expected kg, m, s, N";
    return "";
}

bool plausibility_refused(const struct scenario *scenario, struct error *error)
{
    const struct scenario_finding *first = first_error(scenario);
    if (first == NULL)
        return false;
    GString *others = g_string_new(NULL);
    for (uint32_t i = (uint32_t)(first - scenario->findings) + 1; i < scenario->finding_count; i++)
        if (scenario->findings[i].error)
            g_string_append_printf(others, "%s%s", others->len == 0 ? "; also at " : ", ",
                                   scenario->findings[i].place);
    if (others->len > PLAUSIBILITY_HINT_SIZE)
        g_string_assign(others, "; and more of the kind");
    error_set(error, STATUS_INVALID, "%s: %s%s%s", first->place, first->text,
              system_of_units(scenario), others->str);
    g_string_free(others, TRUE);
    return true;
}

bool plausibility_explains(const struct scenario *scenario, struct error *error)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        if (scenario->findings[i].error && scenario->findings[i].likely)
            return plausibility_refused(scenario, error);
    return false;
}

void plausibility_tell(const struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        log_warning(scenario->findings[i].place, scenario->findings[i].text);
}

static bool is_known(const struct scenario *scenario, const struct scenario_finding *finding)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++)
        if (strcmp(scenario->findings[i].place, finding->place) == 0 &&
            g_str_has_prefix(scenario->findings[i].text, finding->text))
            return true;
    return false;
}

void plausibility_join_cases(struct scenario *scenario)
{
    plausibility_find_free(scenario);
    for (uint32_t i = 0; i < scenario->case_count; i++) {
        const struct scenario *of_case = &scenario->cases[i];
        for (uint32_t k = 0; k < of_case->finding_count; k++) {
            const struct scenario_finding *finding = &of_case->findings[k];
            if (!is_known(scenario, finding))
                plausibility_find_copy(scenario, finding, of_case->name);
        }
    }
}
