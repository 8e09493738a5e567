// How often workers announce themselves. Each hears all the others, so with one announcement a
// second from each the traffic would grow with the square of the workers. Everybody slows down
// alike instead:
//
//     heard in a second    more than PACE_HEARD_MAX      fewer than PACE_HEARD_MIN
//     own pace             half as often                 twice as often, up to once a second
//
// So thousands of workers are heard some hundred times a second, all together. Whoever waits for a
// worker's next word derives from the number of workers how long that may take.
#ifndef SOBOX_COMMON_BASE_PACE_H
#define SOBOX_COMMON_BASE_PACE_H

#include <stdint.h>

enum {
    PACE_HEARD_MAX = 512, // a second: 2 ms of one core for whoever hears them
    PACE_HEARD_MIN = 200, // less than half of it, or workers would go back and forth
    PACE_MAX = 64,        // seconds between two announcements, at most
};

// The seconds between two announcements from now on, for one that announced itself every `seconds`
// (1 .. PACE_MAX) and heard `heard` announcements in the last second.
uint32_t pace_next(uint32_t seconds, uint32_t heard);

// The seconds between two announcements of one of so many workers, at most.
uint32_t pace_most(uint32_t workers);

#endif
