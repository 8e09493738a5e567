#include "common/sampling/stratum.h"

#include "common/numeric/random.h"

#include <assert.h>

// Eight rounds: from four on a Feistel network of good round functions cannot be told from a
// random permutation; the halves here are short and the function is cheap, so twice that.
enum { STRATUM_ROUNDS = 8 };

// Marks the counters that key permutations; sample counters never have this bit.
#define STRATUM_COUNTER UINT32_C(0x80000000)

void stratum_init(struct stratum *stratum, const struct sampling *sampling, uint32_t variable)
{
    assert(sampling->samples > 0);
    uint32_t bits = 0;
    while (bits < 32 && (uint64_t)1 << bits < sampling->samples)
        bits++;
    stratum->samples = sampling->samples;
    stratum->low_bits = bits - bits / 2;
    stratum->low_mask = (UINT32_C(1) << stratum->low_bits) - 1;
    stratum->high_mask = (UINT32_C(1) << bits / 2) - 1;
    const uint32_t counter[4] = {STRATUM_COUNTER | variable, 0, sampling->step, 0};
    const uint32_t key[2] = {(uint32_t)sampling->seed, (uint32_t)(sampling->seed >> 32)};
    random_philox(counter, key, stratum->key);
}

// Spreads every bit of a short word and the round's key over 32 bits.
static uint32_t mix(uint32_t word, uint32_t key)
{
    word = (word ^ key) * UINT32_C(0x9E3779B1);
    word ^= word >> 15;
    word = (word + key) * UINT32_C(0x85EBCA77);
    word ^= word >> 13;
    return word * UINT32_C(0xC2B2AE3D) >> 16;
}

static uint32_t permute(const struct stratum *stratum, uint32_t number)
{
    uint32_t low = number & stratum->low_mask;
    uint32_t high = number >> stratum->low_bits;
    for (uint32_t round = 0; round < STRATUM_ROUNDS; round += 2) {
        high ^= mix(low, stratum->key[round % 4] + round) & stratum->high_mask;
        low ^= mix(high, stratum->key[(round + 1) % 4] + round) & stratum->low_mask;
    }
    return high << stratum->low_bits | low;
}

uint32_t stratum_of(const struct stratum *stratum, uint32_t index)
{
    assert(index < stratum->samples);
    do
        index = permute(stratum, index);
    while (index >= stratum->samples);
    return index;
}
