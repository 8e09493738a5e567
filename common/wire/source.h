// A wire as a GLib event source: the main loop polls its descriptors and dispatches what arrives.
#ifndef SOBOX_COMMON_WIRE_SOURCE_H
#define SOBOX_COMMON_WIRE_SOURCE_H

#include "common/wire/wire.h"

#include <glib.h>

// Attaches the wire to the default main context. Call it again after wire_subscribe() or
// wire_reopen() changed the descriptors: the old source goes. Detach with wire_source_detach().
void wire_source_attach(struct wire *wire);
void wire_source_detach(struct wire *wire);

#endif
