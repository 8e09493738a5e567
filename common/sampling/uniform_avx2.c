// Random numbers in AVX2.
#include <immintrin.h>

typedef __m256i words;
enum { WORDS_LANES = 4 };
#define WORDS_SET(a) _mm256_set1_epi64x((long long)(a))
#define WORDS_INDEX() _mm256_setr_epi64x(0, 1, 2, 3)
#define WORDS_ADD(a, b) _mm256_add_epi64(a, b)
#define WORDS_MUL(a, b) _mm256_mul_epu32(a, b)
#define WORDS_HIGH(a) _mm256_srli_epi64(a, 32)
#define WORDS_XOR(a, b, c) _mm256_xor_si256(_mm256_xor_si256(a, b), c)
#define WORDS_STORE(p, a) _mm256_storeu_pd(p, a)
#define WORDS_UNIT(high, low) words_unit(high, low)

// A word without its lowest bits as a double: below 2^52, so that it may stand for the mantissa.
static inline __m256d words_double(__m256i a, int dropped)
{
    const __m256i word = _mm256_srli_epi64(_mm256_slli_epi64(a, 32), 32 + dropped);
    const __m256d shift = _mm256_set1_pd(0x1p52);
    return _mm256_sub_pd(_mm256_castsi256_pd(_mm256_or_si256(word, _mm256_castpd_si256(shift))),
                         shift);
}

// random_unit(), every step of which is exact.
static inline __m256d words_unit(__m256i high, __m256i low)
{
    const __m256d sum = _mm256_add_pd(_mm256_mul_pd(words_double(high, 5), _mm256_set1_pd(0x1p26)),
                                      words_double(low, 6));
    return _mm256_mul_pd(sum, _mm256_set1_pd(0x1p-53));
}

#include "common/sampling/uniform_wide.h"

void uniform_avx2(const struct sampling *sampling, uint32_t variable, uint32_t first,
                  double *restrict even, double *restrict odd)
{
    uniform_wide(sampling, variable, first, even, odd);
}
