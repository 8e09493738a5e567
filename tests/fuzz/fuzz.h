// What every target of this folder gives: a function that is called with bytes of somebody's choice
// and must survive them. libFuzzer chooses them where it is linked in (SOBOX_FUZZ), else replay.c
// reads them from files. What a target claims beyond survival it asserts.
#ifndef SOBOX_TESTS_FUZZ_FUZZ_H
#define SOBOX_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

// Always 0: there is no input that is not worth keeping.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// Bytes that are used up from the front; what is missing is 0.
struct fuzz_input {
    const uint8_t *data;
    size_t size;
};

static inline uint8_t fuzz_byte(struct fuzz_input *input)
{
    if (input->size == 0)
        return 0;
    input->size--;
    return *input->data++;
}

static inline uint32_t fuzz_u16(struct fuzz_input *input)
{
    uint32_t high = fuzz_byte(input);
    return high << 8 | fuzz_byte(input);
}

static inline uint32_t fuzz_u32(struct fuzz_input *input)
{
    uint32_t high = fuzz_u16(input);
    return high << 16 | fuzz_u16(input);
}

// At most `size` bytes; how many there were goes into `taken`.
static inline const uint8_t *fuzz_bytes(struct fuzz_input *input, size_t size, size_t *taken)
{
    const uint8_t *bytes = input->data;
    *taken = size < input->size ? size : input->size;
    input->data += *taken;
    input->size -= *taken;
    return bytes;
}

#endif
