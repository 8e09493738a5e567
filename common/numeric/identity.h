// Random numbers that tell things apart everywhere: processes on the network, runs. They come from
// the kernel and have nothing to do with the random numbers of a search (random.h).
#ifndef SOBOX_COMMON_NUMERIC_IDENTITY_H
#define SOBOX_COMMON_NUMERIC_IDENTITY_H

#include <stdint.h>

// A number that nobody else has drawn: never 0, and positive as the signed number that travels.
uint64_t identity_random(void);

#endif
