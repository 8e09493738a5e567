// The scenarios of the runs that are watched: spring names, deformations, the design space. They do
// not travel with the status messages, a coordinator sends each by request under its digest, in
// pieces (text_request_t, text_t). Pure: says what to ask, takes what comes, knows no network.
//
// A run must not notice who watches, so little is asked: a few texts at a time, each again only
// after a pause, and after some tries in vain not for a minute. What comes is believed only if its
// digest is the one asked for, and read as untrusted as any file.
#ifndef SOBOX_MONITOR_TEXTS_TEXTS_H
#define SOBOX_MONITOR_TEXTS_TEXTS_H

#include "common/numeric/digest.h"
#include "common/scenario/scenario.h"

#include "sobox_text_request_t.h"
#include "sobox_text_t.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    TEXTS_KNOWN_MAX = 512,  // scenarios kept; the one unused for longest makes room
    TEXTS_WANTED_MAX = 4,   // asked for at a time
    TEXTS_TRIES = 6,        // then a text is given up
    TEXTS_GIVEN_UP_MAX = 64 // remembered as such
};
#define TEXTS_AGAIN_NS INT64_C(300000000)     // between two tries
#define TEXTS_FORGIVE_NS INT64_C(60000000000) // until a text given up may be wanted again

struct texts;

struct texts *texts_create(void);
void texts_free(struct texts *texts);

// The scenario of that digest, or NULL; borrowed until the next texts_want() or texts_heard().
const struct scenario *texts_find(struct texts *texts, const struct digest *digest);

// Wants the scenario of a run; returns whether it will be asked for: not when it is known, too many
// are being asked for, or it was given up lately.
bool texts_want(struct texts *texts, uint64_t run, const struct digest *digest, int64_t now_ns);

// Whether something is being asked for.
bool texts_waiting(const struct texts *texts);

// Fills in what to ask now (all but the header's wire fields); false when nothing is to be asked.
bool texts_ask(struct texts *texts, int64_t now_ns, sobox_text_request_t *message);

// Takes a piece; what was not asked for is ignored. Returns whether a scenario became known.
bool texts_heard(struct texts *texts, const sobox_text_t *message);

// Takes a whole text, however it came. False when it is not a scenario.
bool texts_learn(struct texts *texts, const struct digest *digest, const char *text, size_t size);

#endif
