#include "tests/cluster/dice.h"

#include "common/numeric/random.h"

#include <math.h>

// One Philox block a throw; nothing here has to be fast.
static void dice_block(struct dice *dice, uint32_t block[4])
{
    const uint32_t counter[4] = {(uint32_t)dice->thrown, (uint32_t)(dice->thrown >> 32), 0, 0};
    const uint32_t key[2] = {(uint32_t)dice->seed, (uint32_t)(dice->seed >> 32)};
    dice->thrown++;
    random_philox(counter, key, block);
}

double dice_unit(struct dice *dice)
{
    uint32_t block[4];
    dice_block(dice, block);
    return random_unit(block[0], block[1]);
}

uint32_t dice_below(struct dice *dice, uint32_t below)
{
    return (uint32_t)(dice_unit(dice) * below);
}

bool dice_chance(struct dice *dice, double probability)
{
    return dice_unit(dice) < probability;
}

double dice_scale(struct dice *dice, double low, double high)
{
    return low * pow(high / low, dice_unit(dice));
}

int64_t dice_wait_ns(struct dice *dice, double mean_ns)
{
    return 1 + (int64_t)(-mean_ns * log1p(-dice_unit(dice)));
}

uint64_t dice_sender(struct dice *dice)
{
    uint32_t block[4];
    dice_block(dice, block);
    return (uint64_t)block[0] << 32 | block[1] | 1;
}
