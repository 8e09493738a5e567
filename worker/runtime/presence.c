#include "worker/runtime/presence.h"

#include "common/base/pace.h"

#include <stddef.h>

static bool silent(const struct presence_coordinator *coordinator, int64_t now_ns)
{
    return now_ns - coordinator->heard_ns > PRESENCE_SILENCE_NS;
}

static struct presence_coordinator *find(struct presence *presence, uint64_t sender)
{
    for (uint32_t i = 0; i < presence->coordinator_count; i++) {
        if (presence->coordinators[i].sender == sender)
            return &presence->coordinators[i];
    }
    return NULL;
}

// A place for a new one: the next free one, or that of the one silent for longest.
static struct presence_coordinator *place(struct presence *presence)
{
    if (presence->coordinator_count < PRESENCE_COORDINATOR_MAX)
        return &presence->coordinators[presence->coordinator_count++];
    struct presence_coordinator *oldest = &presence->coordinators[0];
    for (uint32_t i = 1; i < PRESENCE_COORDINATOR_MAX; i++) {
        if (presence->coordinators[i].heard_ns < oldest->heard_ns)
            oldest = &presence->coordinators[i];
    }
    return oldest;
}

bool presence_coordinator(struct presence *presence, uint64_t sender, int64_t now_ns)
{
    struct presence_coordinator *known = find(presence, sender);
    bool new = known == NULL || silent(known, now_ns);
    if (known == NULL)
        known = place(presence);
    *known = (struct presence_coordinator){.sender = sender, .heard_ns = now_ns};
    return new;
}

void presence_coordinator_ended(struct presence *presence, uint64_t sender)
{
    struct presence_coordinator *known = find(presence, sender);
    if (known != NULL)
        *known = presence->coordinators[--presence->coordinator_count];
}

void presence_worker(struct presence *presence)
{
    presence->workers_counted++;
}

bool presence_second(struct presence *presence)
{
    presence->workers = presence->workers_counted;
    presence->workers_counted = 0;
    presence->pace = pace_next(presence->pace > 0 ? presence->pace : 1, presence->workers);
    if (++presence->waited < presence->pace)
        return false;
    presence->waited = 0;
    return true;
}

uint32_t presence_coordinator_count(const struct presence *presence, int64_t now_ns)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < presence->coordinator_count; i++)
        count += !silent(&presence->coordinators[i], now_ns);
    return count;
}

bool presence_crowded(const struct presence *presence)
{
    return presence->workers > PRESENCE_CROWD;
}

uint32_t presence_spread_ms(const struct presence *presence)
{
    const uint32_t workers = presence->workers * (presence->pace > 0 ? presence->pace : 1);
    const uint32_t spread_ms = workers / PRESENCE_SPREAD_RATE;
    return spread_ms > PRESENCE_SPREAD_MS ? spread_ms : PRESENCE_SPREAD_MS;
}
