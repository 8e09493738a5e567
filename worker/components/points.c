#include "worker/components/points.h"
#include "worker/components/polyline.h"

#include <glib.h>
#include <math.h>

// A sample so near to an end stands for the end. [m]
static const double same_place = 1e-4;

// The curve with its ends as samples of their own.
struct merged {
    double *x;                          // [m] (count)
    double *y[POLYLINE_ORDINATE_COUNT]; // [N] (count) each
    bool *kept;                         // (count)
    bool *is_end;                       // (count)
    uint32_t count;
};

static void merged_init(struct merged *merged, uint32_t count_max)
{
    merged->x = g_new(double, count_max);
    for (int k = 0; k < POLYLINE_ORDINATE_COUNT; k++) {
        merged->y[k] = g_new(double, count_max);
    }
    merged->kept = g_new0(bool, count_max);
    merged->is_end = g_new0(bool, count_max);
    merged->count = 0;
}

static void merged_fini(struct merged *merged)
{
    g_free(merged->x);
    for (int k = 0; k < POLYLINE_ORDINATE_COUNT; k++) {
        g_free(merged->y[k]);
    }
    g_free(merged->kept);
    g_free(merged->is_end);
}

// The curve's forces at an end, which lies between sample `next` - 1 and `next`.
static void add_end(struct merged *merged, const struct reference *curve, uint32_t next, double end)
{
    const uint32_t at = merged->count++;
    merged->x[at] = end;
    merged->kept[at] = merged->is_end[at] = true;
    const uint32_t before = next > 0 ? next - 1 : 0;
    const uint32_t after = next < curve->count ? next : curve->count - 1;
    const double width = curve->deformation[after] - curve->deformation[before];
    const double share = width > 0.0 ? (end - curve->deformation[before]) / width : 0.0;
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        const double from = curve->force[k][before];
        merged->y[k][at] = from + share * (curve->force[k][after] - from);
    }
}

static void add_sample(struct merged *merged, const struct reference *curve, uint32_t from)
{
    const uint32_t at = merged->count++;
    merged->x[at] = curve->deformation[from];
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        merged->y[k][at] = curve->force[k][from];
    }
}

static bool beside_end(double x, const double *ends, uint32_t end_count)
{
    bool beside = false;
    for (uint32_t i = 0; i < end_count; i++) {
        beside = beside || fabs(ends[i] - x) < same_place;
    }
    return beside;
}

// Ends beyond the curve are not part of it: of them nothing is known but that they are points.
static bool within(const struct reference *curve, double end)
{
    return end > curve->deformation[0] - same_place &&
           end < curve->deformation[curve->count - 1] + same_place;
}

static void merge(struct merged *merged, const struct reference *curve, const double *ends,
                  uint32_t end_count)
{
    uint32_t end = 0;
    for (uint32_t i = 0; i <= curve->count; i++) {
        const double x = i < curve->count ? curve->deformation[i] : INFINITY;
        for (; end < end_count && ends[end] < x + same_place; end++) {
            if (within(curve, ends[end])) {
                add_end(merged, curve, i, ends[end]);
            }
        }
        if (i < curve->count && !beside_end(x, ends, end_count)) {
            add_sample(merged, curve, i);
        }
    }
}

static double greatest(const double *numbers, uint32_t count)
{
    double most = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        most = fmax(most, fabs(numbers[i]));
    }
    return most;
}

static struct polyline_rule make_rule(const struct polyline *line, const struct points_rule *rule,
                                      uint32_t point_max)
{
    const double each[] = {greatest(line->y[0], line->count), greatest(line->y[1], line->count)};
    const double least = 0.1 * fmax(each[0], each[1]);
    struct polyline_rule made = {.tolerance = rule->tolerance, .point_max = point_max};
    for (int k = 0; k < POLYLINE_ORDINATE_COUNT; k++) {
        made.scale[k] = least > 0.0 ? fmax(each[k], least) : INFINITY;
    }
    return made;
}

static double worst_misplaced(struct points_choice *choice, const struct polyline *line,
                              const bool *kept, const struct polyline_rule *rule)
{
    double worst = 0.0;
    for (int k = 0; k < SCENARIO_DIRECTION_COUNT; k++) {
        choice->misplaced[k] = polyline_misplaced(line, k, kept);
        // A direction of little force may have its energy anywhere.
        const bool little = greatest(line->y[k], line->count) < rule->scale[k];
        worst = fmax(worst, little ? 0.0 : choice->misplaced[k]);
    }
    return worst;
}

// Thins until the energy is at its place too, for which less may be missed than the tolerance.
static void thin(struct points_choice *choice, const struct merged *merged,
                 const struct points_rule *rule, uint32_t point_max)
{
    const struct polyline line = {merged->x, {merged->y[0], merged->y[1]}, merged->count};
    struct polyline_rule made = make_rule(&line, rule, point_max);
    uint32_t kept = polyline_thin(&line, &made, merged->kept);
    while (worst_misplaced(choice, &line, merged->kept, &made) > rule->tolerance &&
           kept < point_max && kept < merged->count) {
        made.tolerance *= 0.5;
        kept = polyline_thin(&line, &made, merged->kept);
    }
    choice->miss = polyline_miss(&line, &made, merged->kept);
}

static void list_points(struct points_choice *choice, const struct merged *merged,
                        const struct reference *curve, const double *ends, uint32_t end_count)
{
    uint32_t end = 0;
    choice->count = 0;
    for (; end < end_count && !within(curve, ends[end]) && ends[end] < merged->x[0]; end++) {
        choice->deformation[choice->count++] = ends[end];
    }
    for (uint32_t i = 0; i < merged->count; i++) {
        if (merged->kept[i]) {
            const double x = merged->x[i];
            choice->deformation[choice->count++] =
                merged->is_end[i] ? x : round(x / same_place) / round(1.0 / same_place);
        }
    }
    for (; end < end_count; end++) {
        if (!within(curve, ends[end])) {
            choice->deformation[choice->count++] = ends[end];
        }
    }
}

enum status points_choose(struct points_choice *choice, const struct reference *curve,
                          const double *ends, uint32_t end_count, const struct points_rule *rule,
                          struct error *error)
{
    uint32_t beyond = 0;
    for (uint32_t i = 0; i < end_count; i++) {
        beyond += !within(curve, ends[i]);
    }
    if (end_count > 0 && end_count + 2 > rule->point_max) {
        return error_set(error, STATUS_INVALID,
                         "spring %s: its components begin and end at %u places and its curve at 2: "
                         "expected at least so many points, found at most %u",
                         curve->name, end_count, rule->point_max);
    }
    *choice = (struct points_choice){.of = curve->count};
    struct merged merged;
    merged_init(&merged, curve->count + end_count);
    merge(&merged, curve, ends, end_count);
    thin(choice, &merged, rule, rule->point_max - beyond);
    list_points(choice, &merged, curve, ends, end_count);
    merged_fini(&merged);
    return STATUS_OK;
}
