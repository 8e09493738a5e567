#include "worker/components/springs_text.h"
#include "common/table/decimal.h"

#include <glib.h>

enum { AXIS_Y = 1, AXIS_Z = 2 };

static void append_list(GString *text, const double *numbers, uint32_t count)
{
    char digits[DECIMAL_SIZE];
    g_string_append_c(text, '[');
    for (uint32_t i = 0; i < count; i++) {
        g_string_append_printf(text, "%s%s", i > 0 ? ", " : "", decimal_text(numbers[i], digits));
    }
    g_string_append_c(text, ']');
}

static void append_forces(GString *text, const struct spring *spring,
                          enum scenario_direction direction)
{
    static const char letters[SCENARIO_DIRECTION_COUNT] = {
        [SCENARIO_DIRECTION_X] = 'x',
        [SCENARIO_DIRECTION_Y] = 'y',
    };
    g_string_append_printf(text, "    force_%c: {lower: 0, upper: ", letters[direction]);
    append_list(text, spring->force_upper[direction], spring->point_count);
    g_string_append(text, "}\n");
}

// What the spring holds, as comments.
static void append_comments(GString *text, const struct spring *spring, const struct group *group)
{
    if (group != NULL) {
        const struct component_box *box = &group->box;
        g_string_append_printf(
            text, "  # %u component%s along %g m; patch y %g .. %g, z %g .. %g m\n",
            group->component_count, group->component_count == 1 ? "" : "s", spring->path,
            box->min[AXIS_Y], box->max[AXIS_Y], box->min[AXIS_Z], box->max[AXIS_Z]);
    }
    const struct points_choice *chosen = &spring->chosen;
    if (chosen->of > 0) {
        g_string_append_printf(text,
                               "  # %u points for the curve's %u: missed by at most %.1f %% of the "
                               "greatest force,\n"
                               "  # %.1f %% of the energy in x and %.1f %% in y misplaced\n",
                               chosen->count, chosen->of, 100.0 * chosen->miss,
                               100.0 * chosen->misplaced[SCENARIO_DIRECTION_X],
                               100.0 * chosen->misplaced[SCENARIO_DIRECTION_Y]);
    }
}

static void append_geometry(GString *text, const struct spring *spring)
{
    char digits[2][DECIMAL_SIZE];
    g_string_append(text, "    position: ");
    append_list(text, spring->position, 2);
    g_string_append_printf(text, "\n    length: %s\n    height: %s\n",
                           decimal_text(spring->length, digits[0]),
                           decimal_text(spring->height, digits[1]));
}

static void append_spring(GString *text, const struct spring *spring, const struct group *group)
{
    append_comments(text, spring, group);
    g_string_append_printf(text, "  - name: %s\n", spring->name);
    if (group != NULL) {
        append_geometry(text, spring);
    }
    g_string_append(text, "    deformation: ");
    append_list(text, spring->deformation, spring->point_count);
    g_string_append_c(text, '\n');
    for (int k = 0; spring->forces && k < SCENARIO_DIRECTION_COUNT; k++) {
        append_forces(text, spring, (enum scenario_direction)k);
    }
}

char *springs_text(const struct spring *springs, uint32_t count, const struct group_list *groups)
{
    GString *text = g_string_new("springs:\n");
    for (uint32_t i = 0; i < count; i++) {
        append_spring(text, &springs[i], groups != NULL ? &groups->items[i] : NULL);
    }
    return g_string_free(text, FALSE);
}
