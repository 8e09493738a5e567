#include "worker/reduction/patches.h"

#include <glib.h>
#include <math.h>
#include <string.h>

// Springs nearer than this stand one above the other. [m]
static const double same_y = 1e-6;

// ---- Columns ----

static int compare_springs(const void *a, const void *b, void *scenario_data)
{
    const struct scenario *scenario = scenario_data;
    const struct scenario_spring *one = &scenario->springs[*(const uint32_t *)a];
    const struct scenario_spring *other = &scenario->springs[*(const uint32_t *)b];
    if (fabs(one->position[1] - other->position[1]) >= same_y) {
        return one->position[1] < other->position[1] ? -1 : 1;
    }
    // Comparisons with NAN are false: springs without a height count as equal.
    return (one->height > other->height) - (one->height < other->height);
}

static enum status check_heights(const struct scenario *scenario, uint32_t below, uint32_t above,
                                 struct error *error)
{
    const struct scenario_spring *lower = &scenario->springs[below];
    const struct scenario_spring *upper = &scenario->springs[above];
    if (upper->height > lower->height) {
        return STATUS_OK;
    }
    return error_set(error, STATUS_INVALID,
                     "%s: springs %s and %s share y = %g m: expected a `height` of each, and "
                     "different ones, to share barrier forces between them",
                     scenario->name, lower->name, upper->name, lower->position[1]);
}

static enum status find_groups(struct patches *patches, const struct scenario *scenario,
                               const struct group_list *groups, struct error *error)
{
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const char *name = scenario->springs[i].name;
        for (uint32_t k = 0; k < groups->count; k++) {
            if (strcmp(groups->items[k].name, name) == 0) {
                patches->groups[i] = &groups->items[k];
            }
        }
        if (patches->groups[i] == NULL) {
            return error_set(error, STATUS_INVALID,
                             "%s: spring %s has no components: expected a group of its name",
                             scenario->name, name);
        }
    }
    return STATUS_OK;
}

enum status patches_init(struct patches *patches, const struct scenario *scenario,
                         const struct group_list *groups, struct error *error)
{
    *patches = (struct patches){.scenario = scenario};
    if (groups != NULL && find_groups(patches, scenario, groups, error) != STATUS_OK) {
        return STATUS_INVALID;
    }
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        patches->order[i] = i;
    }
    g_qsort_with_data(patches->order, (gint)scenario->spring_count, sizeof *patches->order,
                      compare_springs, (void *)scenario);
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        const uint32_t spring = patches->order[i];
        const uint32_t before = patches->order[i > 0 ? i - 1 : 0];
        const double apart =
            scenario->springs[spring].position[1] - scenario->springs[before].position[1];
        if (i == 0 || apart >= same_y) {
            patches->column_first[patches->column_count++] = i;
        } else if (groups == NULL && check_heights(scenario, before, spring, error) != STATUS_OK) {
            return STATUS_INVALID;
        }
    }
    patches->column_first[patches->column_count] = scenario->spring_count;
    return STATUS_OK;
}

// ---- Projection ----

// Moves P2 from the plane of the face onto the quarter circle at its edge. With the line's distance
// from the circle's centre, P2 lies half a chord before the centre's foot on the line.
static void round_edge(const struct scenario_barrier *barrier, double x, double y, double yaw,
                       double position_y, double *place, struct patches_spring *spring)
{
    const double radius = barrier->edge_radius;
    const double centre_y = barrier->edge_y - radius;
    if (spring->projection <= centre_y) {
        return;
    }
    const double from_x = x - barrier->face_x + radius;
    const double from_y = y - centre_y;
    const double along = from_x * cos(yaw) + from_y * sin(yaw);
    const double distance = from_x * sin(yaw) - from_y * cos(yaw) - position_y;
    const double square = radius * radius - distance * distance;
    const double half_chord = sqrt(fmax(square, 0.0));
    const double arm_x = half_chord * cos(yaw) + distance * sin(yaw);
    spring->projected = square >= 0.0 && arm_x >= 0.0 && cos(yaw) > 0.0;
    if (spring->projected) {
        *place = half_chord - along;
        spring->projection = centre_y + half_chord * sin(yaw) - distance * cos(yaw);
    }
}

// Equations 6.9 to 6.12 seen from the vehicle: P2 = (place, position_y).
static void project(const struct scenario *scenario, const struct scenario_spring *from, double x,
                    double y, double yaw, struct patches_spring *spring)
{
    const struct scenario_barrier *barrier = &scenario->barrier;
    const double way = x - barrier->face_x;
    const double position_y = from->position[1];
    double place = position_y * tan(yaw) - way / cos(yaw);
    spring->projection = y - way * tan(yaw) + position_y / cos(yaw);
    spring->projected = cos(yaw) > 0.0 && spring->projection <= barrier->edge_y &&
                        spring->projection >= barrier->edge_y - barrier->width;
    if (barrier->profile == SCENARIO_PROFILE_ROUNDED) {
        round_edge(barrier, x, y, yaw, position_y, &place, spring);
    }
    spring->deformation = from->length - from->position[0] + place;
}

void patches_move(struct patches *patches, double x, double y, double yaw)
{
    const struct scenario *scenario = patches->scenario;
    for (uint32_t i = 0; i < scenario->spring_count; i++) {
        project(scenario, &scenario->springs[i], x, y, yaw, &patches->springs[i]);
    }
    patches->shown_count = 0;
    double before = 0.0;
    for (uint32_t i = 0; i < patches->column_count; i++) {
        const struct patches_spring *spring =
            &patches->springs[patches->order[patches->column_first[i]]];
        if (!spring->projected) {
            continue;
        }
        if (patches->shown_count > 0) {
            patches->border[patches->shown_count - 1] = 0.5 * (before + spring->projection);
        }
        before = spring->projection;
        patches->border[patches->shown_count] = scenario->barrier.edge_y;
        patches->shown[patches->shown_count++] = i;
    }
}

// ---- Search ----

static double beyond(double at, double from, double to)
{
    return fmax(0.0, fmax(from - at, at - to));
}

// The spring whose rectangle is nearest, then whose middle is.
static uint32_t find_nearest(const struct patches *patches, double y, double z)
{
    uint32_t found = PATCHES_NONE;
    double found_apart = INFINITY;
    double found_off = INFINITY;
    for (uint32_t i = 0; i < patches->scenario->spring_count; i++) {
        const struct component_box *box = &patches->groups[i]->box;
        const double moved =
            patches->springs[i].projection - patches->scenario->springs[i].position[1];
        const double apart =
            hypot(beyond(y - moved, box->min[1], box->max[1]), beyond(z, box->min[2], box->max[2]));
        const double off = hypot(y - moved - 0.5 * (box->min[1] + box->max[1]),
                                 z - 0.5 * (box->min[2] + box->max[2]));
        if (patches->springs[i].projected &&
            (apart < found_apart || (apart == found_apart && off < found_off))) {
            found = i;
            found_apart = apart;
            found_off = off;
        }
    }
    return found;
}

uint32_t patches_find(const struct patches *patches, double y, double z)
{
    const struct scenario *scenario = patches->scenario;
    const struct scenario_barrier *barrier = &scenario->barrier;
    const double slack = 1e-9; // [m] a node at the face's end may miss it by a rounding error
    if (patches->shown_count == 0 || !(y <= barrier->edge_y + slack) ||
        !(y >= barrier->edge_y - barrier->width - slack)) {
        return PATCHES_NONE;
    }
    if (patches->groups[0] != NULL) {
        return find_nearest(patches, y, z);
    }
    uint32_t at = 0;
    while (at + 1 < patches->shown_count && y > patches->border[at]) {
        at++;
    }
    const uint32_t column = patches->shown[at];
    uint32_t row = patches->column_first[column];
    while (row + 1 < patches->column_first[column + 1]) {
        const double here = scenario->springs[patches->order[row]].height;
        const double next = scenario->springs[patches->order[row + 1]].height;
        if (z <= 0.5 * (here + next)) {
            break;
        }
        row++;
    }
    return patches->order[row];
}
