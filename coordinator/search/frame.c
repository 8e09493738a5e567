#include "coordinator/search/frame.h"

#include <glib.h>
#include <math.h>

// The design space, narrowed to the bounds that are held.
static void hold_bounds(const struct scenario *scenario, struct box *held)
{
    const struct scenario_hold *hold = &scenario->search.hold;
    box_assign(held, &scenario->design_space);
    for (uint32_t v = 0; v < held->count; v++) {
        if (hold->lower != NULL && !isnan(hold->lower[v]))
            held->lower[v] = hold->lower[v];
        if (hold->upper != NULL && !isnan(hold->upper[v]))
            held->upper[v] = hold->upper[v];
    }
}

void frame_init(struct frame *frame, const struct scenario *scenario)
{
    const uint32_t all = scenario->design_space.count;
    struct box held;
    box_init(&held, all);
    hold_bounds(scenario, &held);
    box_init(&frame->all, all);
    box_assign(&frame->all, &scenario->design_space);
    box_init(&frame->space, box_free_count(&held));
    frame->variables = g_new(uint32_t, all + 1);
    uint32_t count = 0;
    for (uint32_t v = 0; v < all; v++) {
        if (!(held.upper[v] > held.lower[v])) {
            frame->all.lower[v] = frame->all.upper[v] = held.lower[v];
            continue;
        }
        frame->space.lower[count] = held.lower[v];
        frame->space.upper[count] = held.upper[v];
        frame->variables[count++] = v;
    }
    box_fini(&held);
}

void frame_fini(struct frame *frame)
{
    g_free(frame->variables);
    box_fini(&frame->space);
    box_fini(&frame->all);
    *frame = (struct frame){0};
}

void frame_widen(const struct frame *frame, const struct box *box, struct box *all)
{
    box_assign(all, &frame->all);
    for (uint32_t v = 0; v < box->count; v++) {
        all->lower[frame->variables[v]] = box->lower[v];
        all->upper[frame->variables[v]] = box->upper[v];
    }
}
