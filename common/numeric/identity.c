#include "common/numeric/identity.h"

#include <sodium.h>

uint64_t identity_random(void)
{
    uint64_t number;
    do {
        randombytes_buf(&number, sizeof number);
        number >>= 1;
    } while (number == 0);
    return number;
}
