#include "common/scenario/plausibility_find.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>

// Numbers that are each usual may still not be of one car. Each function holds some of them
// against each other.

static const struct plausibility_slip lengths[] = {{"mm", 1e-3}, {"cm", 1e-2}, {NULL, 0}};

// [m] From the centre of gravity to the barrier's face, and from a spring's place.
static double ahead(const struct scenario *scenario)
{
    return scenario->vehicle.cog[0] - scenario->barrier.face_x;
}

static double room_of(const struct scenario *scenario, const struct scenario_spring *spring)
{
    return ahead(scenario) + spring->position[0];
}

// [m] The spring's length, given or left open.
static double length_of(const struct scenario *scenario, const struct scenario_spring *spring)
{
    return spring->length > 0 ? spring->length : room_of(scenario, spring);
}

static double kinetic_energy(const struct scenario *scenario)
{
    const struct scenario_vehicle *vehicle = &scenario->vehicle;
    return 0.5 * vehicle->mass * vehicle->speed * vehicle->speed;
}

// ------------------------------------------------------------------------------------------------
// The vehicle

static void relate_inertia(const struct tree_node *vehicle, struct scenario *scenario)
{
    static const struct plausibility_slip inertias[] = {
        {"t m2", 1e3}, {"t mm2", 1e-3}, {"kg mm2", 1e-6}, {"kg cm2", 1e-4}, {NULL, 0}};
    const double mass = scenario->vehicle.mass, given = scenario->vehicle.yaw_inertia;
    const double gyration = sqrt(given / mass), front = ahead(scenario);
    struct plausibility_find find = {.scenario = scenario,
                                     .check = PLAUSIBILITY_GYRATION,
                                     .node = tree_spot(vehicle, "yaw_inertia"),
                                     .value = gyration,
                                     .given = given,
                                     .slips = inertias,
                                     .from = 0.09 * front * front * mass,
                                     .to = 2.25 * front * front * mass,
                                     .unit = "kg m2"};
    if (plausibility_find(&find))
        return;
    find.check = PLAUSIBILITY_SLENDERNESS;
    find.value = gyration / front;
    plausibility_find(&find);
}

// The front is as far ahead of the centre of gravity as the cube root of the mass has it, within a
// third. Where face_x alone says so and cog adds to it, cog is counted from elsewhere.
static void relate_cog(const struct tree_node *vehicle, struct scenario *scenario)
{
    const struct plausibility_row *row = &plausibility_rows[PLAUSIBILITY_COG];
    const double usual = 0.18 * cbrt(scenario->vehicle.mass);
    const double alone = -scenario->barrier.face_x / usual;
    if (alone < row->min || alone > row->max)
        return;
    const struct scenario_spring *first = &scenario->springs[0];
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_COG,
        .node = tree_spot(vehicle, "cog"),
        .value = ahead(scenario) / usual,
        .error = first->deformation[first->point_count - 1] > 1.5 * length_of(scenario, first),
        .hint = "cog from the front axle, where face_x and the springs are from the centre of "
                "gravity: leave it out",
    });
}

// ------------------------------------------------------------------------------------------------
// The springs' places

// [m] How far a y is past the barrier's face, on either side; not above 0 in front of it.
static double past_face(const struct scenario *scenario, double y)
{
    const double end = scenario->barrier.edge_y - scenario->vehicle.cog[1]; // from the COG
    return fmax(y - end, end - scenario->barrier.width - y);
}

// Which sign is wrong, if one is.
static const char *mirrored(const struct scenario *scenario, double y)
{
    const struct scenario_barrier *barrier = &scenario->barrier;
    if (y > 0 && barrier->edge_y > 0 && y < barrier->edge_y + barrier->width)
        return "y with the wrong sign: the struck side, with springs and edge_y, is at negative y";
    if (past_face(scenario, -y) <= 0)
        return "y with the wrong sign: the struck side is at negative y";
    return NULL;
}

static void relate_sides(const struct tree_node *springs, struct scenario *scenario)
{
    uint32_t missing = 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        missing += past_face(scenario, scenario->springs[i].position[1]) > 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const double y = scenario->springs[i].position[1];
        plausibility_find(&(struct plausibility_find){
            .scenario = scenario,
            .check = PLAUSIBILITY_MISS,
            .node = tree_child(springs->items[i], "position")->items[1],
            .value = past_face(scenario, y),
            .error = missing == scenario->spring_count,
            .hint = mirrored(scenario, y),
        });
    }
}

static void relate_gaps(const struct tree_node *springs, struct scenario *scenario)
{
    double least = INFINITY;
    uint32_t nearest = 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        const double gap = room_of(scenario, spring) - length_of(scenario, spring);
        if (gap < least)
            least = gap, nearest = i;
        plausibility_find(&(struct plausibility_find){
            .scenario = scenario,
            .check = PLAUSIBILITY_PRESSED,
            .node = tree_spot(springs->items[i], "length"),
            .value = -gap,
        });
    }
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_GAP,
        .node = tree_spot(springs->items[nearest], "length"),
        .value = least,
        .error = least > scenario->vehicle.speed * scenario->simulation.duration,
        .hint = "cog, position or length counted from elsewhere",
    });
}

// ------------------------------------------------------------------------------------------------
// Deformations

static void relate_deformations(const struct tree_node *springs, struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const struct scenario_spring *spring = &scenario->springs[i];
        const struct tree_node *points = tree_child(springs->items[i], "deformation");
        const double length = length_of(scenario, spring);
        const double last = spring->deformation[spring->point_count - 1];
        if (length <= 0)
            continue; // the reader says why that cannot be
        plausibility_find(&(struct plausibility_find){
            .scenario = scenario,
            .check = PLAUSIBILITY_DEFORMATION,
            .node = points->items[spring->point_count - 1],
            .value = last / length,
            .given = last,
            .slips = lengths,
            .from = 0.2 * length,
            .to = 1.01 * length,
            .unit = "m",
        });
    }
}

static void relate_firewall(const struct crash_document *document, struct scenario *scenario)
{
    const double length = length_of(scenario, &scenario->springs[0]);
    if (length <= 0)
        return;
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_FIREWALL,
        .node = document->firewall_distance,
        .value = scenario->firewall_distance / length,
        .given = scenario->firewall_distance,
        .slips = lengths,
        .from = 0.05,
        .to = 0.8 * length,
        .unit = "m",
    });
}

// The overlap by which lateral travel is judged, against the way that the A-pillar has to go. On a
// wall nobody goes that way.
static void relate_overlap(const struct tree_node *barrier, struct scenario *scenario)
{
    const struct tree_node *node = tree_child(barrier, "overlap");
    const double way = -past_face(scenario, scenario->springs[0].position[1]);
    const double end = scenario->barrier.edge_y - scenario->vehicle.cog[1];
    if (node == NULL || way <= 0 || end - scenario->springs[0].position[1] > 1.5)
        return;
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_OVERLAP_SPARE,
        .node = node,
        .value = scenario->barrier.overlap - (end - scenario->springs[0].position[1]),
        .hint =
            "a share of the car's width (0.25 for 25 %) in place of m; left out, it is that way",
    });
}

// ------------------------------------------------------------------------------------------------
// Forces

// [J] Greatest energy that a spring's axial force can take over a deformation: linear between
// points, none before the first, the last one's beyond it.
static double energy_max(const struct scenario_spring *spring, double deformation)
{
    const double *force = spring->force_upper[SCENARIO_DIRECTION_X], *at = spring->deformation;
    double energy = 0;
    for (uint32_t i = 0; i + 1 < spring->point_count && at[i] < deformation; i++) {
        const double to = fmin(at[i + 1], deformation);
        const double share = (to - at[i]) / (at[i + 1] - at[i]);
        energy += (to - at[i]) * (force[i] + 0.5 * share * (force[i + 1] - force[i]));
    }
    const uint32_t last = spring->point_count - 1;
    return fmax(0, energy + force[last] * fmax(0, deformation - at[last]));
}

// The firewall may not be reached, so the first spring, at the A-pillar, has less to give.
static double energy_of(const struct scenario *scenario, uint32_t index)
{
    const struct scenario_spring *spring = &scenario->springs[index];
    const double kept = index == 0 ? scenario->firewall_distance : 0;
    return energy_max(spring, fmax(0, length_of(scenario, spring) - kept));
}

static void relate_energy(const struct tree_node *springs, struct scenario *scenario)
{
    const double needed = kinetic_energy(scenario);
    double energy = 0;
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        energy += energy_of(scenario, i);
    const double ratio = energy / needed;
    if (scenario->response == SCENARIO_RESPONSE_GLANCING_OFF && ratio >= 0.5 && ratio <= 1)
        return;
    char figures[PLAUSIBILITY_HINT_SIZE];
    snprintf(figures, sizeof figures, "the springs absorb at most %.1f kJ, the car has %.1f kJ",
             energy * 1e-3, needed * 1e-3);
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_ENERGY,
        .node = tree_child(tree_child(springs->items[0], "force_x"), "upper"),
        .value = ratio,
        .figures = figures,
        .hint = ratio * 1e3 >= 0.5 && ratio * 1e3 < 50     ? "forces in kN in place of N"
                : ratio * 1e-3 >= 0.5 && ratio * 1e-3 < 50 ? "forces in mN in place of N"
                                                           : NULL,
    });
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const double share = energy_of(scenario, i) / energy;
        if (share > 0)
            plausibility_find(&(struct plausibility_find){
                .scenario = scenario,
                .check = PLAUSIBILITY_SPRING_SHARE,
                .node = tree_child(tree_child(springs->items[i], "force_x"), "upper"),
                .value = share,
                .hint = "forces of this spring in kN",
            });
    }
}

static double greatest(const double *numbers, uint32_t count)
{
    double greatest = -INFINITY;
    for (uint32_t i = 0; i < count; i++)
        greatest = fmax(greatest, numbers[i]);
    return greatest;
}

static double least(const double *numbers, uint32_t count)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < count; i++)
        least = fmin(least, numbers[i]);
    return least;
}

static const char *direction_key(int direction)
{
    return direction == SCENARIO_DIRECTION_X ? "force_x" : "force_y";
}

// Axial springs only push. Lateral forces of either sign may be meant, but not of the wrong one
// alone.
static void relate_signs(const struct tree_node *node, struct scenario *scenario,
                         const struct scenario_spring *spring)
{
    for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
        const double low = least(spring->force_lower[direction], spring->point_count);
        const bool pulls = greatest(spring->force_upper[direction], spring->point_count) <= 0;
        if (direction == SCENARIO_DIRECTION_X || pulls)
            plausibility_find(&(struct plausibility_find){
                .scenario = scenario,
                .check = PLAUSIBILITY_FORCE_SIGN,
                .node = tree_child(tree_child(node, direction_key(direction)), "lower"),
                .value = low,
                .error = direction == SCENARIO_DIRECTION_X && pulls,
                .hint = "a force on the barrier in place of one on the car",
            });
    }
}

// A point that is out of line with both its neighbours.
static void relate_points(const struct tree_node *node, struct scenario *scenario,
                          const struct scenario_spring *spring)
{
    for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++) {
        const double *force = spring->force_upper[direction];
        const struct tree_node *upper =
            tree_child(tree_child(node, direction_key(direction)), "upper");
        for (uint32_t i = 1; i + 1 < spring->point_count && upper->kind == TREE_SEQUENCE; i++) {
            const double low = fmin(force[i - 1], force[i + 1]);
            const double high = fmax(force[i - 1], force[i + 1]);
            if (low <= 0 || force[i] <= 0)
                continue;
            plausibility_find(&(struct plausibility_find){
                .scenario = scenario,
                .check = PLAUSIBILITY_FORCE_POINT,
                .node = upper->items[i],
                .value = force[i] < low ? force[i] / low : force[i] / high,
                .hint = force[i] < low ? "kN in place of N" : NULL,
            });
        }
    }
}

static void relate_directions(const struct tree_node *springs, struct scenario *scenario)
{
    double most[SCENARIO_DIRECTION_COUNT] = {0};
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        for (int direction = 0; direction < SCENARIO_DIRECTION_COUNT; direction++)
            most[direction] =
                fmax(most[direction], greatest(scenario->springs[i].force_upper[direction],
                                               scenario->springs[i].point_count));
    if (most[SCENARIO_DIRECTION_X] <= 0 || most[SCENARIO_DIRECTION_Y] <= 0)
        return;
    const double ratio = most[SCENARIO_DIRECTION_Y] / most[SCENARIO_DIRECTION_X];
    plausibility_find(&(struct plausibility_find){
        .scenario = scenario,
        .check = PLAUSIBILITY_FORCE_RATIO,
        .node = tree_child(tree_child(springs->items[0], "force_y"), "upper"),
        .value = ratio,
        .hint = ratio < 1 ? "force_y in kN" : "force_x in kN, or the two exchanged",
    });
}

void plausibility_relate(const struct crash_document *document, struct scenario *scenario)
{
    relate_inertia(document->vehicle, scenario);
    relate_cog(document->vehicle, scenario);
    relate_sides(document->springs, scenario);
    relate_gaps(document->springs, scenario);
    relate_deformations(document->springs, scenario);
    relate_firewall(document, scenario);
    relate_overlap(document->barrier, scenario);
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        relate_signs(document->springs->items[i], scenario, &scenario->springs[i]);
        relate_points(document->springs->items[i], scenario, &scenario->springs[i]);
    }
    relate_directions(document->springs, scenario);
    if (!plausibility_refused(scenario, NULL))
        relate_energy(document->springs, scenario);
}
