#include "common/base/pace.h"

uint32_t pace_next(uint32_t seconds, uint32_t heard)
{
    if (heard > PACE_HEARD_MAX && seconds < PACE_MAX)
        return 2 * seconds;
    if (heard < PACE_HEARD_MIN && seconds > 1)
        return seconds / 2;
    return seconds;
}

// They slow down only while more than PACE_HEARD_MAX are heard, and speed up again below
// PACE_HEARD_MIN.
uint32_t pace_most(uint32_t workers)
{
    uint32_t seconds = 1;
    while (seconds < PACE_MAX && workers > PACE_HEARD_MAX &&
           workers / (2 * seconds) >= PACE_HEARD_MIN)
        seconds *= 2;
    return seconds;
}
