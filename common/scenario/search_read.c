#include "common/scenario/search_read.h"

#include "common/numeric/rounding.h"
#include "common/scenario/field.h"
#include "common/scenario/numbers.h"
#include "common/scenario/tie_read.h"
#include "common/scenario/words.h"

#include <assert.h>
#include <glib.h>
#include <stdio.h>
#include <string.h>

#define AT(structure, member) .offset = offsetof(struct structure, member)

// Times `samples` that an adversarial search takes at least: 6 a step, 24 steps that attack the box
// at the end, and twice as many before.
enum { SEARCH_EVERY_STEPS = 432 };

// The values of all samples of a step are in memory while it is trimmed: 1 GiB of doubles.
#define STEP_VALUES_MAX (UINT64_C(1) << 27)

struct search_document {
    struct scenario_search search;
    const struct tree_node *start;
    const struct tree_node *start_box;
    const struct tree_node *reference;
    const struct tree_node *weights;
    const struct tree_node *minimum_widths;
    const struct tree_node *hold;
    const struct tree_node *box;
    const struct tree_node *tie;
};

static const struct field search_fields[] = {
    {"samples", FIELD_COUNT, .optional = true, AT(search_document, search.samples),
     .range = FIELD_FROM_TO(1, 1e6)},
    {"exploration_steps", FIELD_COUNT, .optional = true,
     AT(search_document, search.exploration_steps), .range = FIELD_FROM_TO(0, 1e6)},
    {"consolidation_steps", FIELD_COUNT, .optional = true,
     AT(search_document, search.consolidation_steps), .range = FIELD_FROM_TO(0, 1e6)},
    {"sampling", FIELD_WORD, .optional = true, AT(search_document, search.sampling),
     .words = scenario_sampling_words},
    {"promise", FIELD_WORD, .optional = true, AT(search_document, search.promise),
     .words = scenario_promise_words},
    {"target_purity", FIELD_NUMBER, .optional = true, AT(search_document, search.target_purity),
     .range = FIELD_BETWEEN(0, 1)},
    {"certificate_samples", FIELD_COUNT, .optional = true,
     AT(search_document, search.certificate_samples), .range = FIELD_FROM_TO(1, 1e8)},
    {"seed", FIELD_COUNT_64, .optional = true, AT(search_document, search.seed),
     .range = FIELD_FROM_TO(0, FIELD_COUNT_MAX)},
    {"starts", FIELD_COUNT, .optional = true, AT(search_document, search.starts),
     .range = FIELD_FROM_TO(1, SCENARIO_START_MAX)},
    {"evaluations", FIELD_COUNT_64, .optional = true, AT(search_document, search.evaluations),
     .range = FIELD_FROM_TO(1, 1e12)},
    {"stagnation", FIELD_COUNT, .optional = true, AT(search_document, search.stagnation),
     .range = FIELD_FROM_TO(0, 1e6)},
    {"explain_samples", FIELD_COUNT, .optional = true, AT(search_document, search.explain_samples),
     .range = FIELD_FROM_TO(0, 1e6)},
    {"round", FIELD_NUMBER, .optional = true, AT(search_document, search.round),
     .range = FIELD_POSITIVE},
    {"start", FIELD_NODE, .optional = true, AT(search_document, start)},
    {"start_box", FIELD_NODE, .optional = true, AT(search_document, start_box)},
    {"reference", FIELD_NODE, .optional = true, AT(search_document, reference)},
    {"weights", FIELD_NODE, .optional = true, AT(search_document, weights)},
    {"minimum_widths", FIELD_NODE, .optional = true, AT(search_document, minimum_widths)},
    {"box", FIELD_NODE, .optional = true, AT(search_document, box)},
    {"hold", FIELD_NODE, .optional = true, AT(search_document, hold)},
    {"tie", FIELD_NODE, .optional = true, AT(search_document, tie)},
};

// Reads a design. Returns NULL with `error` filled.
static double *read_design(const struct tree_node *node, const struct scenario *scenario,
                           struct error *error)
{
    static const struct field_range any = FIELD_ANY;
    struct numbers numbers;
    numbers_init(&numbers, scenario->design_space.count);
    double *values = NULL;
    if (numbers_read(node, scenario, &any, numbers_unit(scenario), &numbers, error) &&
        numbers_inside_space(&numbers, scenario, error) &&
        numbers_complete(&numbers, node, scenario, error))
        values = g_steal_pointer(&numbers.values);
    numbers_fini(&numbers);
    return values;
}

// ------------------------------------------------------------------------------------------------
// Starts

static double *centre(const struct box *space)
{
    double *values = g_new(double, space->count);
    for (uint32_t i = 0; i < space->count; i++)
        values[i] = 0.5 * space->lower[i] + 0.5 * space->upper[i];
    return values;
}

static bool read_start(const struct tree_node *node, const struct scenario *scenario,
                       struct scenario_search *search, struct error *error)
{
    const bool word = node->kind == TREE_SCALAR && strcmp(node->text, "centre") == 0;
    search->start = word ? centre(&scenario->design_space) : read_design(node, scenario, error);
    return search->start != NULL;
}

struct bounds_document {
    const struct tree_node *lower;
    const struct tree_node *upper;
};

static const struct field box_fields[] = {
    {"lower", FIELD_NODE, AT(bounds_document, lower), .expected = "a number for every variable"},
    {"upper", FIELD_NODE, AT(bounds_document, upper), .expected = "a number for every variable"},
};

// Reads a whole box; what was read of one that is refused is the caller's to release as well.
static bool read_box(const struct tree_node *node, const struct scenario *scenario, struct box *box,
                     struct error *error)
{
    struct bounds_document document = {0};
    if (!field_read(node, box_fields, G_N_ELEMENTS(box_fields), &document, error))
        return false;
    box->lower = read_design(document.lower, scenario, error);
    box->upper = box->lower != NULL ? read_design(document.upper, scenario, error) : NULL;
    box->count = scenario->design_space.count;
    if (box->upper == NULL)
        return false;
    for (uint32_t i = 0; i < box->count; i++) {
        if (box->lower[i] <= box->upper[i])
            continue;
        tree_error(document.upper, error,
                   "expected %s at least at its lower bound of %.15g, found %.15g",
                   scenario->variables[i].name, box->lower[i], box->upper[i]);
        return false;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------
// What is held

static const struct field hold_fields[] = {
    {"lower", FIELD_NODE, .optional = true, AT(bounds_document, lower)},
    {"upper", FIELD_NODE, .optional = true, AT(bounds_document, upper)},
};

// Returns NULL with `error` filled.
static double *read_held(const struct tree_node *node, const struct scenario *scenario,
                         struct error *error)
{
    static const struct field_range any = FIELD_ANY;
    struct numbers numbers;
    numbers_init(&numbers, scenario->design_space.count);
    double *values = NULL;
    if (numbers_read(node, scenario, &any, numbers_unit(scenario), &numbers, error) &&
        numbers_inside_space(&numbers, scenario, error))
        values = g_steal_pointer(&numbers.values);
    numbers_fini(&numbers);
    return values;
}

// Held bounds as an interval: the design space where nothing is held.
static void held_interval(const struct scenario *scenario, const struct scenario_hold *hold,
                          uint32_t variable, double *lower, double *upper)
{
    *lower = scenario->design_space.lower[variable];
    *upper = scenario->design_space.upper[variable];
    if (hold->lower != NULL && !isnan(hold->lower[variable]))
        *lower = hold->lower[variable];
    if (hold->upper != NULL && !isnan(hold->upper[variable]))
        *upper = hold->upper[variable];
}

// Some corridor must have a width: one design alone is no box.
static bool leaves_width(const struct tree_node *node, const struct scenario *scenario,
                         const struct scenario_hold *hold, struct error *error)
{
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        double lower, upper;
        held_interval(scenario, hold, i, &lower, &upper);
        if (lower < upper)
            return true;
    }
    tree_error(node, error,
               "every variable has one value: expected a lower bound below its upper one "
               "(sobox-simulate looks at one design)");
    return false;
}

static bool read_hold(const struct tree_node *node, const struct scenario *scenario,
                      struct scenario_search *search, struct error *error)
{
    struct bounds_document document = {0};
    struct scenario_hold *hold = &search->hold;
    if (!field_read(node, hold_fields, G_N_ELEMENTS(hold_fields), &document, error))
        return false;
    if (node->count == 0) {
        tree_error(node, error, "expected lower, upper or both, found neither");
        return false;
    }
    if (document.lower != NULL &&
        (hold->lower = read_held(document.lower, scenario, error)) == NULL)
        return false;
    if (document.upper != NULL &&
        (hold->upper = read_held(document.upper, scenario, error)) == NULL)
        return false;
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        double lower, upper;
        held_interval(scenario, hold, i, &lower, &upper);
        if (lower <= upper)
            continue;
        tree_error(tree_spot(node, "upper"), error,
                   "expected the upper bound of %s at least at the lower one of %.15g, found %.15g",
                   scenario->variables[i].name, lower, upper);
        return false;
    }
    return leaves_width(node, scenario, hold, error);
}

// Says that an interval is too narrow to be rounded. Returns false.
static bool too_coarse(const struct tree_node *node, const struct scenario *scenario,
                       uint32_t variable, double step, double lower, double upper,
                       struct error *error)
{
    tree_error(node, error,
               "%s, %.15g to %.15g, has no width between multiples of %.15g: expected a smaller "
               "step",
               scenario->variables[variable].name, lower, upper, step);
    return false;
}

// Rounds a box to certify; an interval that is a value stays one.
static bool round_box(const struct tree_node *node, const struct scenario *scenario,
                      struct scenario_search *search, struct error *error)
{
    for (uint32_t v = 0; search->round > 0 && v < scenario->design_space.count; v++) {
        double *lower = &search->hold.lower[v], *upper = &search->hold.upper[v];
        if (*lower < *upper && !rounding_inwards(search->round, lower, upper))
            return too_coarse(node, scenario, v, search->round, *lower, *upper, error);
    }
    return true;
}

// No box can be rounded where the design space cannot.
static bool check_round(const struct tree_node *node, const struct scenario *scenario,
                        const struct scenario_search *search, struct error *error)
{
    for (uint32_t v = 0; search->round > 0 && v < scenario->design_space.count; v++) {
        double lower = scenario->design_space.lower[v], upper = scenario->design_space.upper[v];
        if (lower < upper && !rounding_inwards(search->round, &lower, &upper))
            return too_coarse(node, scenario, v, search->round, lower, upper, error);
    }
    return true;
}

// A box to certify: all of its bounds are held.
static bool read_given_box(const struct tree_node *node, const struct tree_node *round,
                           const struct scenario *scenario, struct scenario_search *search,
                           struct error *error)
{
    struct box box = {0};
    const bool read = read_box(node, scenario, &box, error);
    search->hold.lower = box.lower;
    search->hold.upper = box.upper;
    return read && leaves_width(node, scenario, &search->hold, error) &&
           round_box(round, scenario, search, error);
}

static bool same_number(const double *numbers, uint32_t a, uint32_t b)
{
    return numbers == NULL || numbers[a] == numbers[b] || (isnan(numbers[a]) && isnan(numbers[b]));
}

// Variables that share a corridor cannot be asked to differ in it.
static bool check_tie(const struct tree_node *node, const struct scenario *scenario,
                      const struct scenario_search *search, struct error *error)
{
    const struct {
        const char *key;
        const double *numbers;
    } lists[] = {
        {"weights", search->weights},           {"minimum_widths", search->minimum_widths},
        {"hold", search->hold.lower},           {"hold", search->hold.upper},
        {"start_box", search->start_box.lower}, {"start_box", search->start_box.upper},
    };
    for (uint32_t i = 0; search->tie != NULL && i < scenario->design_space.count; i++) {
        for (size_t k = 0; k < G_N_ELEMENTS(lists); k++) {
            if (same_number(lists[k].numbers, i, search->tie[i]))
                continue;
            tree_error(tree_child(node, lists[k].key), error,
                       "expected the same for %s and %s, which are tied",
                       scenario->variables[search->tie[i]].name, scenario->variables[i].name);
            return false;
        }
    }
    return true;
}

static bool check_minimum_widths(const struct tree_node *node, const struct scenario *scenario,
                                 const struct scenario_search *search, struct error *error)
{
    for (uint32_t i = 0; search->minimum_widths != NULL && i < scenario->design_space.count; i++) {
        double lower, upper;
        held_interval(scenario, &search->hold, i, &lower, &upper);
        if (search->minimum_widths[i] <= upper - lower)
            continue;
        tree_error(tree_child(node, "minimum_widths"), error,
                   "expected at most %.15g for %s, all there is, found %.15g", upper - lower,
                   scenario->variables[i].name, search->minimum_widths[i]);
        return false;
    }
    return true;
}

// Where a design, or a bound of the start box, must lie.
static bool check_within(const struct tree_node *node, const struct scenario *scenario,
                         const double *values, const struct box *box, const char *what,
                         struct error *error)
{
    for (uint32_t i = 0; values != NULL && i < box->count; i++) {
        if (values[i] >= box->lower[i] && values[i] <= box->upper[i])
            continue;
        tree_error(node, error, "expected %s inside %s, %.15g to %.15g, found %.15g",
                   scenario->variables[i].name, what, box->lower[i], box->upper[i], values[i]);
        return false;
    }
    return true;
}

// The start box begins with the bounds that are held.
static bool check_held(const struct tree_node *node, const struct scenario *scenario,
                       const double *held, const double *bounds, struct error *error)
{
    for (uint32_t i = 0; held != NULL && bounds != NULL && i < scenario->design_space.count; i++) {
        if (isnan(held[i]) || held[i] == bounds[i])
            continue;
        tree_error(node, error, "expected the held bound of %s, %.15g, found %.15g",
                   scenario->variables[i].name, held[i], bounds[i]);
        return false;
    }
    return true;
}

static bool check_places(const struct tree_node *node, const struct scenario *scenario,
                         const struct scenario_search *search, struct error *error)
{
    struct box held;
    box_init(&held, scenario->design_space.count);
    for (uint32_t i = 0; i < held.count; i++)
        held_interval(scenario, &search->hold, i, &held.lower[i], &held.upper[i]);
    const struct tree_node *start_box = tree_child(node, "start_box");
    const struct tree_node *reference = tree_child(node, "reference");
    bool met =
        check_within(tree_child(node, "start"), scenario, search->start, &held,
                     "the bounds that are held", error) &&
        check_within(reference, scenario, search->reference, &held, "the bounds that are held",
                     error) &&
        check_within(reference, scenario, search->reference, &search->start_box, "the start_box",
                     error) &&
        check_held(start_box, scenario, search->hold.lower, search->start_box.lower, error) &&
        check_held(start_box, scenario, search->hold.upper, search->start_box.upper, error);
    box_fini(&held);
    return met;
}

static bool check_counts(const struct tree_node *node, const struct scenario *scenario,
                         const struct scenario_search *search, struct error *error)
{
    const uint64_t samples_max = STEP_VALUES_MAX / scenario->design_space.count;
    const uint64_t least = (uint64_t)search->samples + search->certificate_samples;
    if (search->samples > samples_max) {
        tree_error(tree_spot(node, "samples"), error,
                   "expected at most %llu samples for %u variables, found %u",
                   (unsigned long long)samples_max, scenario->design_space.count, search->samples);
        return false;
    }
    // A certificate of each kind, and enough steps of an adversary for a box to take shape.
    const uint64_t least_every =
        4 * (uint64_t)search->certificate_samples + SEARCH_EVERY_STEPS * (uint64_t)search->samples;
    if (search->promise != PROMISE_POINTS && search->evaluations > 0 &&
        search->evaluations < least_every) {
        tree_error(tree_child(node, "evaluations"), error,
                   "expected at least %llu for this promise, a certificate of each kind of designs "
                   "and an adversarial search, found %llu; promise: points takes less",
                   (unsigned long long)least_every, (unsigned long long)search->evaluations);
        return false;
    }
    if (search->evaluations > 0 && search->evaluations < least) {
        tree_error(tree_child(node, "evaluations"), error,
                   "expected at least %llu, the samples of a step and of the certificate, found "
                   "%llu",
                   (unsigned long long)least, (unsigned long long)search->evaluations);
        return false;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------
// The whole

static bool read_lists(const struct tree_node *node, const struct search_document *document,
                       struct scenario *scenario, struct error *error)
{
    static const struct field_range positive = FIELD_POSITIVE, not_negative = FIELD_NOT_NEGATIVE;
    struct scenario_search *search = &scenario->search;
    if (document->start != NULL && document->start_box != NULL) {
        tree_error(document->start_box, error, "expected start or start_box, found both");
        return false;
    }
    if (document->weights != NULL &&
        (search->weights =
             numbers_read_partial(document->weights, scenario, &positive, NULL, 1, error)) == NULL)
        return false;
    if (document->minimum_widths != NULL && (search->minimum_widths = numbers_read_partial(
                                                 document->minimum_widths, scenario, &not_negative,
                                                 numbers_unit(scenario), 0, error)) == NULL)
        return false;
    if (document->reference != NULL &&
        (search->reference = read_design(document->reference, scenario, error)) == NULL)
        return false;
    return (document->start == NULL || read_start(document->start, scenario, search, error)) &&
           (document->start_box == NULL ||
            read_box(document->start_box, scenario, &search->start_box, error)) &&
           (document->hold == NULL || read_hold(document->hold, scenario, search, error)) &&
           (document->tie == NULL || tie_read(document->tie, scenario, search, error)) &&
           check_tie(node, scenario, search, error) &&
           check_minimum_widths(node, scenario, search, error) &&
           check_places(node, scenario, search, error);
}

bool search_read(const struct tree_node *node, struct scenario *scenario, struct error *error)
{
    struct search_document document = {.search = scenario->search};
    if (!field_read(node, search_fields, G_N_ELEMENTS(search_fields), &document, error))
        return false;
    scenario->search = document.search;
    if (!check_counts(node, scenario, &scenario->search, error))
        return false;
    // What says how to search, or which box to find, is not looked at where there is one.
    const struct tree_node *round = tree_spot(node, "round");
    return document.box != NULL
               ? read_given_box(document.box, round, scenario, &scenario->search, error)
               : check_round(round, scenario, &scenario->search, error) &&
                     read_lists(node, &document, scenario, error);
}
