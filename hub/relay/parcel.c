#include "hub/relay/parcel.h"

#include <glib.h>

struct parcel *parcel_create(size_t size, size_t *held)
{
    struct parcel *parcel = g_malloc(sizeof *parcel + size);
    parcel->holders = 1;
    parcel->held = held;
    parcel->size = size;
    *held += size;
    return parcel;
}

void parcel_release(struct parcel *parcel)
{
    if (--parcel->holders > 0)
        return;
    *parcel->held -= parcel->size;
    g_free(parcel);
}
