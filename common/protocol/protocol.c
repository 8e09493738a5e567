#include "common/protocol/protocol.h"

#include <assert.h>
#include <string.h>

static const char *const run_state_names[RUN_STATE_COUNT] = {
    [RUN_STATE_RUNNING] = "running", [RUN_STATE_WAITING] = "waiting for workers",
    [RUN_STATE_DONE] = "done",       [RUN_STATE_INTERRUPTED] = "interrupted",
    [RUN_STATE_FAILED] = "failed",
};

static const char *const phase_names[SEARCH_PHASE_COUNT] = {
    [SEARCH_PHASE_SEEK] = "seek",
    [SEARCH_PHASE_EXPLORE] = "explore",
    [SEARCH_PHASE_CONSOLIDATE] = "consolidate",
    [SEARCH_PHASE_CERTIFY] = "certify",
    [SEARCH_PHASE_EXPLAIN] = "explain",
    [SEARCH_PHASE_DONE] = "done",
};

static const char *const status_names[SEARCH_STATUS_COUNT] = {
    [SEARCH_STATUS_RUNNING] = "running",
    [SEARCH_STATUS_DONE] = "done",
    [SEARCH_STATUS_PURITY_MISSED] = "purity_missed",
    [SEARCH_STATUS_NO_GOOD_DESIGN] = "no_good_design",
};

// The place of `name` among `count` names, or `count`.
static unsigned find(const char *const *names, unsigned count, const char *name)
{
    unsigned i = 0;
    while (i < count && strcmp(names[i], name) != 0)
        i++;
    return i;
}

bool protocol_run_ended(enum run_state state)
{
    return state != RUN_STATE_RUNNING && state != RUN_STATE_WAITING;
}

const char *protocol_run_state_name(enum run_state state)
{
    assert((unsigned)state < RUN_STATE_COUNT);
    return run_state_names[state];
}

const char *protocol_phase_name(enum search_phase phase)
{
    assert((unsigned)phase < SEARCH_PHASE_COUNT);
    return phase_names[phase];
}

const char *protocol_status_name(enum search_status status)
{
    assert((unsigned)status < SEARCH_STATUS_COUNT);
    return status_names[status];
}

bool protocol_run_state_of(const char *name, enum run_state *state)
{
    const unsigned found = find(run_state_names, RUN_STATE_COUNT, name);
    if (found < RUN_STATE_COUNT)
        *state = (enum run_state)found;
    return found < RUN_STATE_COUNT;
}

bool protocol_phase_of(const char *name, enum search_phase *phase)
{
    const unsigned found = find(phase_names, SEARCH_PHASE_COUNT, name);
    if (found < SEARCH_PHASE_COUNT)
        *phase = (enum search_phase)found;
    return found < SEARCH_PHASE_COUNT;
}

bool protocol_status_of(const char *name, enum search_status *status)
{
    const unsigned found = find(status_names, SEARCH_STATUS_COUNT, name);
    if (found < SEARCH_STATUS_COUNT)
        *status = (enum search_status)found;
    return found < SEARCH_STATUS_COUNT;
}

const char *protocol_kind_name(enum design_kind kind)
{
    static const char *const names[] = {
        [DESIGN_KIND_POINTS] = "points",
        [DESIGN_KIND_CURVES] = "curves",
        [DESIGN_KIND_LEVELS] = "levels",
        [DESIGN_KIND_EXTREMES] = "extremes",
    };
    return names[kind];
}

const char *protocol_promise_name(enum promise promise)
{
    static const char *const names[] = {
        [PROMISE_POINTS] = "points",
        [PROMISE_CURVES] = "curves",
        [PROMISE_EVERY] = "every",
    };
    return names[promise];
}

enum sampling_method protocol_kind_method(enum design_kind kind)
{
    static const enum sampling_method methods[] = {
        [DESIGN_KIND_POINTS] = SAMPLING_METHOD_UNIFORM,
        [DESIGN_KIND_CURVES] = SAMPLING_METHOD_CURVES,
        [DESIGN_KIND_LEVELS] = SAMPLING_METHOD_LEVELS,
        [DESIGN_KIND_EXTREMES] = SAMPLING_METHOD_EXTREMES,
    };
    return methods[kind];
}
