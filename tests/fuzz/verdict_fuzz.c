// Packed verdicts of an outcome: count (2 bytes), detail, number of constraints, then the packed
// bytes. What unpacks packs to the very same bytes.
#include "tests/fuzz/fuzz.h"

#include "common/numeric/verdict.h"

#include <assert.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct verdict verdicts[1 << 16];
    static uint8_t again[1 << 18];
    struct fuzz_input input = {.data = data, .size = size};
    uint32_t count = fuzz_u16(&input);
    enum verdict_detail detail = fuzz_byte(&input) % VERDICT_DETAIL_COUNT;
    uint32_t constraints = fuzz_byte(&input);
    if (!verdict_unpack(verdicts, count, detail, constraints, input.data, input.size))
        return 0;
    assert(verdict_good_count(verdicts, count) <= count);
    assert(verdict_packed_size_max(count, detail) <= sizeof again);
    assert(verdict_pack(verdicts, count, detail, again) == input.size);
    assert(memcmp(again, input.data, input.size) == 0);
    return 0;
}
