#include "common/numeric/verdict.h"

#include <math.h>
#include <string.h>

enum {
    VERDICT_FINITE_MAX = 0xFEFF, // exponent and leading mantissa of the greatest finite single
    VERDICT_SHIFT = 15,          // mantissa bits of a single that are dropped
    VERDICT_BAD_SIZE = 3,        // [bytes] of a bad one on the wire
    VERDICT_MARGIN_SIZE = 4,     // [bytes] of a margin
};

uint16_t verdict_violation(double relative)
{
    if (isnan(relative) || relative == INFINITY)
        return VERDICT_NON_FINITE;
    if (relative <= 0)
        return VERDICT_GOOD;
    float single = (float)relative;
    if (isinf(single))
        return VERDICT_FINITE_MAX;
    uint32_t bits;
    memcpy(&bits, &single, sizeof bits);
    bits >>= VERDICT_SHIFT;
    return bits > 0 ? (uint16_t)bits : 1;
}

double verdict_relative(uint16_t violation)
{
    if (violation == VERDICT_GOOD)
        return 0;
    if (violation > VERDICT_FINITE_MAX)
        return INFINITY;
    uint32_t bits = (uint32_t)violation << VERDICT_SHIFT | UINT32_C(1) << (VERDICT_SHIFT - 1);
    float single;
    memcpy(&single, &bits, sizeof single);
    return (double)single;
}

static size_t bits_size(uint32_t count)
{
    return (size_t)count / 8 + (count % 8 != 0);
}

// What stands before the bad ones: bits and margins.
static size_t head_size(uint32_t count, enum verdict_detail detail)
{
    const size_t margin_size = detail == VERDICT_DETAIL_MARGIN ? VERDICT_MARGIN_SIZE : 0;
    return bits_size(count) + count * margin_size;
}

size_t verdict_packed_size_max(uint32_t count, enum verdict_detail detail)
{
    size_t bad_size = detail != VERDICT_DETAIL_SHARE ? VERDICT_BAD_SIZE : 0;
    return head_size(count, detail) + count * bad_size;
}

static void pack_margins(const struct verdict *verdicts, uint32_t count, uint8_t *packed)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &verdicts[i].margin, sizeof bits);
        for (uint32_t byte = 0; byte < VERDICT_MARGIN_SIZE; byte++)
            *packed++ = (uint8_t)(bits >> 8 * byte);
    }
}

static float packed_margin(const uint8_t *packed)
{
    uint32_t bits = 0;
    for (uint32_t byte = 0; byte < VERDICT_MARGIN_SIZE; byte++)
        bits |= (uint32_t)packed[byte] << 8 * byte;
    float margin;
    memcpy(&margin, &bits, sizeof margin);
    return margin;
}

size_t verdict_pack(const struct verdict *verdicts, uint32_t count, enum verdict_detail detail,
                    uint8_t *packed)
{
    size_t size = bits_size(count);
    if (size != 0)
        memset(packed, 0, size);
    if (detail == VERDICT_DETAIL_MARGIN)
        pack_margins(verdicts, count, packed + size);
    size = head_size(count, detail);
    for (uint32_t i = 0; i < count; i++) {
        if (verdicts[i].violation == VERDICT_GOOD) {
            packed[i / 8] |= (uint8_t)(1u << (i % 8));
        } else if (detail != VERDICT_DETAIL_SHARE) {
            packed[size++] = verdicts[i].constraint;
            packed[size++] = (uint8_t)verdicts[i].violation;
            packed[size++] = (uint8_t)(verdicts[i].violation >> 8);
        }
    }
    return size;
}

static bool packed_good(const uint8_t *packed, uint32_t i)
{
    return packed[i / 8] >> (i % 8) & 1;
}

// Whether `size` bytes begin with `count` margins, all of them numbers or infinite.
static bool margins_valid(uint32_t count, const uint8_t *packed, size_t size)
{
    if (size / VERDICT_MARGIN_SIZE < count)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        if (isnan(packed_margin(packed + (size_t)i * VERDICT_MARGIN_SIZE)))
            return false;
    }
    return true;
}

// Whether `packed` is something that verdict_pack() writes; looks at no byte beyond its size.
static bool packed_valid(uint32_t count, enum verdict_detail detail, uint32_t constraint_count,
                         const uint8_t *packed, size_t packed_size)
{
    size_t size = bits_size(count);
    if (packed_size < size)
        return false;
    if (count % 8 != 0 && packed[size - 1] >> (count % 8) != 0)
        return false;
    if (detail == VERDICT_DETAIL_SHARE)
        return packed_size == size;
    if (detail == VERDICT_DETAIL_MARGIN && !margins_valid(count, packed + size, packed_size - size))
        return false;
    size = head_size(count, detail);
    size_t bad = 0;
    for (uint32_t i = 0; i < count; i++)
        bad += !packed_good(packed, i);
    if (packed_size - size != bad * VERDICT_BAD_SIZE)
        return false;
    for (const uint8_t *at = packed + size; bad > 0; bad--, at += VERDICT_BAD_SIZE) {
        if (at[0] >= constraint_count || (at[1] == 0 && at[2] == 0))
            return false;
    }
    return true;
}

bool verdict_unpack(struct verdict *verdicts, uint32_t count, enum verdict_detail detail,
                    uint32_t constraint_count, const uint8_t *packed, size_t packed_size)
{
    if (detail >= VERDICT_DETAIL_COUNT)
        return false;
    if (!packed_valid(count, detail, constraint_count, packed, packed_size))
        return false;
    const uint8_t *margins = packed + bits_size(count);
    const uint8_t *at = packed + head_size(count, detail);
    for (uint32_t i = 0; i < count; i++) {
        verdicts[i] = (struct verdict){.violation = VERDICT_GOOD};
        if (detail == VERDICT_DETAIL_MARGIN)
            verdicts[i].margin = packed_margin(margins + (size_t)i * VERDICT_MARGIN_SIZE);
        if (packed_good(packed, i))
            continue;
        verdicts[i].violation = 1;
        if (detail != VERDICT_DETAIL_SHARE) {
            verdicts[i].constraint = at[0];
            verdicts[i].violation = (uint16_t)(at[1] | at[2] << 8);
            at += VERDICT_BAD_SIZE;
        }
    }
    return true;
}

uint32_t verdict_good_count(const struct verdict *verdicts, uint32_t count)
{
    uint32_t good = 0;
    for (uint32_t i = 0; i < count; i++)
        good += verdicts[i].violation == VERDICT_GOOD;
    return good;
}
