#include "common/scenario/plausibility_find.h"

#include <glib.h>
#include <math.h>

// "at least 1 m/s", "100 to 60000 kg": what is usual.
static void put_range(GString *text, const struct plausibility_row *row)
{
    const char *gap = row->unit[0] != '\0' ? " " : "";
    if (isfinite(row->min) && isfinite(row->max))
        g_string_append_printf(text, "%.6g to %.6g%s%s", row->min, row->max, gap, row->unit);
    else
        g_string_append_printf(text, isfinite(row->min) ? "at least %.6g%s%s" : "at most %.6g%s%s",
                               isfinite(row->min) ? row->min : row->max, gap, row->unit);
}

// The unit in which the number would be a usual one, or NULL.
static const struct plausibility_slip *likely_slip(const struct plausibility_find *find)
{
    if (find->hint != NULL || find->slips == NULL)
        return NULL;
    for (const struct plausibility_slip *slip = find->slips; slip->unit != NULL; slip++) {
        const double right = fabs(find->given * slip->factor);
        if (right >= find->from && right <= find->to)
            return slip;
    }
    return NULL;
}

static char *describe(const struct plausibility_find *find, const struct plausibility_slip *slip)
{
    const struct plausibility_row *row = &plausibility_rows[find->check];
    char path[TREE_PATH_SIZE];
    GString *text = g_string_new(tree_path(find->node, path));
    g_string_append_printf(text, ": %s is %.5g%s%s, expected ", row->what, find->value,
                           row->unit[0] != '\0' ? " " : "", row->unit);
    put_range(text, row);
    g_string_append_printf(text, ": %s", row->reason);
    if (find->figures != NULL)
        g_string_append_printf(text, "; %s", find->figures);
    if (find->hint != NULL)
        g_string_append_printf(text, "; likely slip: %s", find->hint);
    if (slip != NULL)
        g_string_append_printf(text, "; likely slip: %.6g %s, which is %.4g%s%s", find->given,
                               slip->unit, find->given * slip->factor,
                               find->unit[0] != '\0' ? " " : "", find->unit);
    return g_string_free(text, FALSE);
}

static void add(struct scenario *scenario, const struct scenario_finding *finding)
{
    scenario->findings =
        g_renew(struct scenario_finding, scenario->findings, scenario->finding_count + 1);
    scenario->findings[scenario->finding_count++] = *finding;
}

bool plausibility_find(const struct plausibility_find *find)
{
    const struct plausibility_row *row = &plausibility_rows[find->check];
    if (find->value >= row->min && find->value <= row->max)
        return false;
    const struct plausibility_slip *slip = likely_slip(find);
    add(find->scenario,
        &(struct scenario_finding){
            .check = (int)find->check,
            .error = find->error || find->value < row->error_min || find->value > row->error_max,
            .likely = slip != NULL || find->hint != NULL,
            .slip = slip != NULL ? slip->unit : NULL,
            .place = g_strdup_printf("%s:%u:%u", find->node->source, find->node->line,
                                     find->node->column),
            .text = describe(find, slip),
        });
    return true;
}

void plausibility_find_copy(struct scenario *scenario, const struct scenario_finding *finding,
                            const char *case_name)
{
    struct scenario_finding copy = *finding;
    copy.place = g_strdup(finding->place);
    copy.text = g_strdup_printf("%s (in case %s)", finding->text, case_name);
    add(scenario, &copy);
}

void plausibility_find_free(struct scenario *scenario)
{
    for (uint32_t i = 0; i < scenario->finding_count; i++) {
        g_free(scenario->findings[i].place);
        g_free(scenario->findings[i].text);
    }
    g_free(scenario->findings);
    scenario->findings = NULL;
    scenario->finding_count = 0;
}
