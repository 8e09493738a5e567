// Random numbers in AVX-512.
#include <immintrin.h>

typedef __m512i words;
enum { WORDS_LANES = 8 };
#define WORDS_SET(a) _mm512_set1_epi64((long long)(a))
#define WORDS_INDEX() _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7)
#define WORDS_ADD(a, b) _mm512_add_epi64(a, b)
#define WORDS_MUL(a, b) _mm512_mul_epu32(a, b)
#define WORDS_HIGH(a) _mm512_srli_epi64(a, 32)
#define WORDS_XOR(a, b, c) _mm512_ternarylogic_epi64(a, b, c, 0x96)
#define WORDS_STORE(p, a) _mm512_storeu_pd(p, a)
#define WORDS_UNIT(high, low) words_unit(high, low)

// random_unit(): its 53 bits as one integer, which a double holds exactly.
static inline __m512d words_unit(__m512i high, __m512i low)
{
    const __m512i leading = _mm512_srli_epi64(_mm512_slli_epi64(high, 32), 37);
    const __m512i trailing = _mm512_srli_epi64(_mm512_slli_epi64(low, 32), 38);
    const __m512i all = _mm512_or_si512(_mm512_slli_epi64(leading, 26), trailing);
    return _mm512_mul_pd(_mm512_cvtepi64_pd(all), _mm512_set1_pd(0x1p-53));
}

#include "common/sampling/uniform_wide.h"

void uniform_avx512(const struct sampling *sampling, uint32_t variable, uint32_t first,
                    double *restrict even, double *restrict odd)
{
    uniform_wide(sampling, variable, first, even, odd);
}
