// The latest steps of a search with their samples, as step_status_t tells of them: which box was
// sampled, and what came of each sample. Coordinates are not kept: samples are functions of seed,
// step, number and box, and whoever wants to see them makes them again.
//
// A step may come in several messages, each with the bounds of some variables: it is shown when all
// are there, and forgotten when the next one begins before. Of a long search the steps kept span
// its whole course, as points of a history do.
#ifndef SOBOX_MONITOR_FEED_ALBUM_H
#define SOBOX_MONITOR_FEED_ALBUM_H

#include "common/numeric/digest.h"
#include "common/numeric/verdict.h"
#include "common/sampling/sampling.h"

#include "sobox_step_status_t.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    ALBUM_PICTURE_MAX = 64,          // steps kept of a search,
    ALBUM_SIZE_MAX = 2 * 1024 * 1024 // or so many bytes; never fewer than two
};

// A step and its samples 0 .. count - 1.
struct album_picture {
    uint64_t ordinal; // the how manieth it is, from 0 on
    struct sampling sampling;
    struct digest scenario;
    enum search_phase phase;
    enum verdict_detail detail;
    uint32_t good;            // of all samples of the step
    uint32_t count;           // samples whose verdicts are known
    struct verdict *verdicts; // (count)
    struct box sampled;       // the box that was sampled
    struct box box;           // the search's box after the step
};

struct album {
    uint64_t added;      // pictures so far
    uint32_t stride;     // of so many one stays
    GPtrArray *pictures; // struct album_picture *, steps ascending; read-only
    struct album_picture *pending;
    uint32_t missing; // variables of the pending one whose bounds have not come
};

void album_init(struct album *album);
void album_fini(struct album *album);

// Takes a message that passed the wire's checks. Returns whether a picture became complete; what
// does not hold together is dropped.
bool album_hear(struct album *album, const sobox_step_status_t *message);

// Adds a picture whose verdicts and boxes are complete, and takes it over; made with
// album_picture() and filled in.
void album_add(struct album *album, struct album_picture *picture);

// A picture with room for `count` verdicts and two boxes of `variables`.
struct album_picture *album_picture(uint32_t count, uint32_t variables);

// The picture of the step, or the last one before it; the newest for UINT32_MAX. NULL: none.
const struct album_picture *album_find(const struct album *album, uint32_t step);

#endif
