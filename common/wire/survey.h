// Looks at the network that a URL names and says in plain words what works, what is wrong, and what
// to do about it: sobox-worker --check-network.
//
//     udpm://   route -> interface -> time to live -> receive buffer -> each port -> other machines
//     tcpq://   hub reached -> speaks the protocol -> passes messages on -> who is there
#ifndef SOBOX_COMMON_WIRE_SURVEY_H
#define SOBOX_COMMON_WIRE_SURVEY_H

#include "common/wire/key.h"
#include "common/wire/url.h"

enum survey_verdict {
    SURVEY_GOOD,
    SURVEY_NOTE,  // works, but the user should know
    SURVEY_WRONG, // a cluster will not work like this
};

// Called for every finding, in order; `text` is a sentence, with its remedy where something is
// wrong.
typedef void survey_teller(void *user, enum survey_verdict verdict, const char *text);

enum {
    SURVEY_LISTEN_MS = 3000, // for other machines: workers say each second that they are there [ms]
    SURVEY_HUB_MS = 3000,    // for the answer of a hub [ms]
};

// Looks at the network of `url`, which is not memq://, with the key or NULL. Returns how many
// findings were SURVEY_WRONG. Initialises libsodium. Takes some seconds; sends nothing but calls
// that LCM programs ignore (neighbours.h), and with a hub messages to itself.
unsigned survey_network(const struct url *url, const struct key *key, survey_teller *tell,
                        void *user);

#endif
