#include "coordinator/search/given.h"

// Passes over what was not given.
static void settle(struct given *given)
{
    const struct scenario_search *settings = given->settings;
    if (given->stage == GIVEN_REFERENCE && settings->reference == NULL)
        given->stage = GIVEN_START;
    if (given->stage == GIVEN_START && settings->start == NULL && settings->start_box.count == 0)
        given->stage = GIVEN_NONE;
}

void given_init(struct given *given, const struct scenario_search *settings,
                const struct frame *frame)
{
    *given = (struct given){.settings = settings, .frame = frame, .stage = GIVEN_REFERENCE};
    settle(given);
}

void given_fini(struct given *given)
{
    box_fini(&given->begin);
    *given = (struct given){0};
}

// Puts the free variables of a design, or of a box's bounds, into a box.
static void narrow(const struct frame *frame, const double *lower, const double *upper,
                   struct box *box)
{
    for (uint32_t v = 0; v < frame->space.count; v++) {
        box->lower[v] = lower[frame->variables[v]];
        box->upper[v] = upper[frame->variables[v]];
    }
}

void given_box(const struct given *given, struct box *box)
{
    const struct scenario_search *settings = given->settings;
    if (given->stage == GIVEN_REFERENCE)
        narrow(given->frame, settings->reference, settings->reference, box);
    else if (given->stage == GIVEN_START && settings->start != NULL)
        narrow(given->frame, settings->start, settings->start, box);
    else if (given->stage == GIVEN_START)
        narrow(given->frame, settings->start_box.lower, settings->start_box.upper, box);
    else
        box_assign(box, &given->frame->space);
}

void given_complete(struct given *given, bool any_good)
{
    // No good box contains a bad reference, whatever the share of good designs about it: a design
    // that must stay inside is one that must be good.
    if (given->stage == GIVEN_REFERENCE && !any_good) {
        given->stage = GIVEN_REFUSED;
        return;
    }
    if (any_good) {
        if (given->begin.count == 0)
            box_init(&given->begin, given->frame->space.count);
        given_box(given, &given->begin);
    }
    given->stage = given->stage == GIVEN_REFERENCE ? GIVEN_START : GIVEN_NONE;
    settle(given);
}
