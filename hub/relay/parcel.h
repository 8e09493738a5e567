// One message on its way, kept once for all the clients that it goes to.
#ifndef SOBOX_HUB_RELAY_PARCEL_H
#define SOBOX_HUB_RELAY_PARCEL_H

#include <stddef.h>
#include <stdint.h>

// Bytes on their way to any number of clients.
struct parcel {
    uint32_t holders; // queues that hold it, and who made it until parcel_release()
    size_t *held;     // counts the bytes of all parcels; outlives them
    size_t size;      // [bytes]
    uint8_t bytes[];
};

// A parcel with one holder, its maker, and room for `size` bytes, which are counted in `held`.
struct parcel *parcel_create(size_t size, size_t *held);
void parcel_release(struct parcel *parcel);

#endif
