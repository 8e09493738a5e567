#include "common/wire/source.h"

#include "common/base/clock.h"
#include "common/wire/door.h"
#include "common/wire/wire_state.h"

// Messages handled before other sources get their turn.
enum { MESSAGES_A_TURN = 64 };

struct wire_source {
    GSource base;
    struct wire *wire;
    gpointer tags[WIRE_PORT_COUNT];
    size_t tag_count;
};

// A wire with a key asks again, in time, who has not answered.
static gboolean wait_for(GSource *base, gint *timeout_ms)
{
    const struct wire *wire = ((struct wire_source *)base)->wire;
    int64_t wake_ns = wire->door != NULL ? door_wake_ns(wire) : INT64_MAX;
    *timeout_ms = -1;
    if (wake_ns != INT64_MAX) {
        int64_t left_ns = MAX(wake_ns - clock_monotonic_ns(), 0);
        *timeout_ms = (gint)((left_ns + CLOCK_MILLISECOND_NS - 1) / CLOCK_MILLISECOND_NS);
    }
    return *timeout_ms == 0;
}

static gboolean has_arrived(GSource *base)
{
    struct wire_source *source = (struct wire_source *)base;
    if (source->wire->door != NULL && door_wake_ns(source->wire) <= clock_monotonic_ns())
        return TRUE;
    for (size_t i = 0; i < source->tag_count; i++)
        if (g_source_query_unix_fd(base, source->tags[i]) != 0)
            return TRUE;
    return FALSE;
}

// LCM's descriptors stay readable while messages wait, so what is left over comes next turn.
static gboolean dispatch(GSource *base, GSourceFunc callback, gpointer user)
{
    (void)callback;
    (void)user;
    wire_dispatch(((struct wire_source *)base)->wire, MESSAGES_A_TURN);
    return G_SOURCE_CONTINUE;
}

static GSourceFuncs functions = {.prepare = wait_for, .check = has_arrived, .dispatch = dispatch};

void wire_source_attach(struct wire *wire)
{
    wire_source_detach(wire);
    wire->source = g_source_new(&functions, sizeof(struct wire_source));
    struct wire_source *source = (struct wire_source *)wire->source;
    int descriptors[WIRE_PORT_COUNT];
    source->wire = wire;
    source->tag_count = wire_descriptors(wire, descriptors);
    for (size_t i = 0; i < source->tag_count; i++)
        source->tags[i] = g_source_add_unix_fd(wire->source, descriptors[i], G_IO_IN);
    g_source_set_can_recurse(wire->source, TRUE); // it does not, and is cheaper: watch.h
    g_source_set_name(wire->source, "wire");
    g_source_attach(wire->source, NULL);
}

void wire_source_detach(struct wire *wire)
{
    if (wire->source == NULL)
        return;
    g_source_destroy(wire->source);
    g_source_unref(wire->source);
    wire->source = NULL;
}
