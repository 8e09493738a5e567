// A bundle of doubles, one lane a design, and what the kernel does with it. The kernel is written
// once against these few operations and compiled once per instruction set; a source defines
// LANES_PATH_... before it includes this.
//
// A bundle holds several machine vectors: their dependence chains are independent, so the machine
// works on one while it waits for another.
//
// Every operation is one IEEE operation, or a choice, in each lane. Where the machine's own
// instruction is peculiar (the minimum and maximum return the second operand when the two do not
// compare or are equal) the plain twin is written to match it, so that all paths give the same
// bits.
#ifndef SOBOX_WORKER_KINEMATICS_LANES_H
#define SOBOX_WORKER_KINEMATICS_LANES_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define LANES_INLINE static inline __attribute__((always_inline))

#if defined(LANES_PATH_AVX512)

#include <immintrin.h>
typedef __m512d lanes_vector;
typedef __mmask8 lanes_vector_mask;
enum { LANES_VECTOR = 8 };
#define VECTOR_SET(a) _mm512_set1_pd(a)
#define VECTOR_LOAD(p) _mm512_loadu_pd(p)
#define VECTOR_STORE(p, a) _mm512_storeu_pd(p, a)
#define VECTOR_ADD(a, b) _mm512_add_pd(a, b)
#define VECTOR_SUB(a, b) _mm512_sub_pd(a, b)
#define VECTOR_MUL(a, b) _mm512_mul_pd(a, b)
#define VECTOR_DIV(a, b) _mm512_div_pd(a, b)
#define VECTOR_SQRT(a) _mm512_sqrt_pd(a)
#define VECTOR_FMA(a, b, c) _mm512_fmadd_pd(a, b, c)
#define VECTOR_FNMA(a, b, c) _mm512_fnmadd_pd(a, b, c)
#define VECTOR_FMS(a, b, c) _mm512_fmsub_pd(a, b, c)
#define VECTOR_MIN(a, b) _mm512_min_pd(a, b)
#define VECTOR_MAX(a, b) _mm512_max_pd(a, b)
#define VECTOR_ABS(a) _mm512_abs_pd(a)
#define VECTOR_LESS(a, b) _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ)
#define VECTOR_AND_LESS(m, a, b) _mm512_mask_cmp_pd_mask(m, a, b, _CMP_LT_OQ)
#define VECTOR_AND_NOT_ABOVE(m, a, b) _mm512_mask_cmp_pd_mask(m, a, b, _CMP_LE_OQ)
#define VECTOR_BIT(a, bit) \
    _mm512_test_epi64_mask(_mm512_castpd_si512(a), _mm512_set1_epi64(INT64_C(1) << (bit)))
#define VECTOR_SELECT(m, a, b) _mm512_mask_blend_pd(m, b, a)
#define VECTOR_KEEP(m, a) _mm512_maskz_mov_pd(m, a)
#define VECTOR_KEEP_FMA(m, a, b, c) _mm512_maskz_fmadd_pd(m, a, b, c)
#define VECTOR_NONE 0
#define VECTOR_AND(m, n) _kand_mask8(m, n)
#define VECTOR_AND_NOT(m, n) _kandn_mask8(n, m)
#define VECTOR_OR(m, n) _kor_mask8(m, n)
#define VECTOR_DIFFER(m, n) _kxor_mask8(m, n)
#define VECTOR_ANY(m) ((m) != 0)
#define VECTOR_BITS(m) ((uint32_t)(m))
#define VECTOR_FROM_BITS(bits) ((__mmask8)(bits))

#elif defined(LANES_PATH_AVX2)

#include <immintrin.h>
typedef __m256d lanes_vector;
typedef __m256d lanes_vector_mask;
enum { LANES_VECTOR = 4 };
#define VECTOR_SET(a) _mm256_set1_pd(a)
#define VECTOR_LOAD(p) _mm256_loadu_pd(p)
#define VECTOR_STORE(p, a) _mm256_storeu_pd(p, a)
#define VECTOR_ADD(a, b) _mm256_add_pd(a, b)
#define VECTOR_SUB(a, b) _mm256_sub_pd(a, b)
#define VECTOR_MUL(a, b) _mm256_mul_pd(a, b)
#define VECTOR_DIV(a, b) _mm256_div_pd(a, b)
#define VECTOR_SQRT(a) _mm256_sqrt_pd(a)
#define VECTOR_FMA(a, b, c) _mm256_fmadd_pd(a, b, c)
#define VECTOR_FNMA(a, b, c) _mm256_fnmadd_pd(a, b, c)
#define VECTOR_FMS(a, b, c) _mm256_fmsub_pd(a, b, c)
#define VECTOR_MIN(a, b) _mm256_min_pd(a, b)
#define VECTOR_MAX(a, b) _mm256_max_pd(a, b)
#define VECTOR_ABS(a) _mm256_andnot_pd(_mm256_set1_pd(-0.0), a)
#define VECTOR_LESS(a, b) _mm256_cmp_pd(a, b, _CMP_LT_OQ)
#define VECTOR_AND_LESS(m, a, b) _mm256_and_pd(m, _mm256_cmp_pd(a, b, _CMP_LT_OQ))
#define VECTOR_AND_NOT_ABOVE(m, a, b) _mm256_and_pd(m, _mm256_cmp_pd(a, b, _CMP_LE_OQ))
// Only the sign of a mask's lane is ever looked at, so moving the bit there is enough.
#define VECTOR_BIT(a, bit) \
    _mm256_castsi256_pd(_mm256_slli_epi64(_mm256_castpd_si256(a), 63 - (bit)))
#define VECTOR_SELECT(m, a, b) _mm256_blendv_pd(b, a, m)
#define VECTOR_KEEP(m, a) _mm256_and_pd(m, a)
#define VECTOR_KEEP_FMA(m, a, b, c) _mm256_and_pd(m, _mm256_fmadd_pd(a, b, c))
#define VECTOR_NONE _mm256_setzero_pd()
#define VECTOR_AND(m, n) _mm256_and_pd(m, n)
#define VECTOR_AND_NOT(m, n) _mm256_andnot_pd(n, m)
#define VECTOR_OR(m, n) _mm256_or_pd(m, n)
#define VECTOR_DIFFER(m, n) _mm256_xor_pd(m, n)
#define VECTOR_ANY(m) (_mm256_movemask_pd(m) != 0)
#define VECTOR_BITS(m) ((uint32_t)_mm256_movemask_pd(m))
#define VECTOR_FROM_BITS(bits)                                                     \
    _mm256_castsi256_pd(_mm256_cmpeq_epi64(                                        \
        _mm256_and_si256(_mm256_set1_epi64x(bits), _mm256_set_epi64x(8, 4, 2, 1)), \
        _mm256_set_epi64x(8, 4, 2, 1)))

#elif defined(LANES_PATH_PLAIN)

typedef double lanes_vector;
typedef bool lanes_vector_mask;
enum { LANES_VECTOR = 1 };

LANES_INLINE bool vector_bit(double a, int bit)
{
    uint64_t bits;
    memcpy(&bits, &a, sizeof bits);
    return (bits >> bit & 1) != 0;
}

#define VECTOR_SET(a) (a)
#define VECTOR_LOAD(p) (*(p))
#define VECTOR_STORE(p, a) (*(p) = (a))
#define VECTOR_ADD(a, b) ((a) + (b))
#define VECTOR_SUB(a, b) ((a) - (b))
#define VECTOR_MUL(a, b) ((a) * (b))
#define VECTOR_DIV(a, b) ((a) / (b))
#define VECTOR_SQRT(a) __builtin_sqrt(a)
#define VECTOR_FMA(a, b, c) __builtin_fma(a, b, c)
#define VECTOR_FNMA(a, b, c) __builtin_fma(-(a), b, c)
#define VECTOR_FMS(a, b, c) __builtin_fma(a, b, -(c))
#define VECTOR_MIN(a, b) ((a) < (b) ? (a) : (b))
#define VECTOR_MAX(a, b) ((a) > (b) ? (a) : (b))
#define VECTOR_ABS(a) __builtin_fabs(a)
#define VECTOR_LESS(a, b) ((a) < (b))
#define VECTOR_AND_LESS(m, a, b) ((m) & ((a) < (b)))
#define VECTOR_AND_NOT_ABOVE(m, a, b) ((m) & ((a) <= (b)))
#define VECTOR_BIT(a, bit) vector_bit(a, bit)
#define VECTOR_SELECT(m, a, b) ((m) ? (a) : (b))
#define VECTOR_KEEP(m, a) ((m) ? (a) : 0.0)
#define VECTOR_KEEP_FMA(m, a, b, c) ((m) ? __builtin_fma(a, b, c) : 0.0)
#define VECTOR_NONE false
#define VECTOR_AND(m, n) ((m) & (n))
#define VECTOR_AND_NOT(m, n) ((m) & !(n))
#define VECTOR_OR(m, n) ((m) | (n))
#define VECTOR_DIFFER(m, n) ((m) != (n))
#define VECTOR_ANY(m) (m)
#define VECTOR_BITS(m) ((uint32_t)(m))
#define VECTOR_FROM_BITS(bits) (((bits)&1) != 0)

#else
#error "define LANES_PATH_AVX512, LANES_PATH_AVX2 or LANES_PATH_PLAIN first"
#endif

// Vectors in a bundle: 1, 2 or 4. The source may choose; see the README for what each costs.
#ifndef LANES_VECTORS
#define LANES_VECTORS 1
#endif

// Spelled out instead of looped, so that the compiler keeps a bundle in registers.
#if LANES_VECTORS == 1
#define LANES_EACH(expression) \
    {                          \
        {                      \
            expression(0)      \
        }                      \
    }
#define LANES_DO(statement) statement(0)
#elif LANES_VECTORS == 2
#define LANES_EACH(expression)           \
    {                                    \
        {                                \
            expression(0), expression(1) \
        }                                \
    }
#define LANES_DO(statement) statement(0) statement(1)
#elif LANES_VECTORS == 4
#define LANES_EACH(expression)                                         \
    {                                                                  \
        {                                                              \
            expression(0), expression(1), expression(2), expression(3) \
        }                                                              \
    }
#define LANES_DO(statement) statement(0) statement(1) statement(2) statement(3)
#endif

enum { LANES = LANES_VECTOR * LANES_VECTORS }; // designs in a bundle

struct lanes {
    lanes_vector v[LANES_VECTORS];
};

struct lanes_mask {
    lanes_vector_mask v[LANES_VECTORS];
};

LANES_INLINE struct lanes lanes_set(double a)
{
#define EACH(k) VECTOR_SET(a)
    return (struct lanes)LANES_EACH(EACH);
#undef EACH
}

LANES_INLINE struct lanes lanes_load(const double *from)
{
#define EACH(k) VECTOR_LOAD(from + (k)*LANES_VECTOR)
    return (struct lanes)LANES_EACH(EACH);
#undef EACH
}

LANES_INLINE void lanes_store(double *to, struct lanes a)
{
#define DO(k) VECTOR_STORE(to + (k)*LANES_VECTOR, a.v[k]);
    LANES_DO(DO)
#undef DO
}

// One function per operation, the bundle's vectors one after the other.
#define LANES_UNARY(name, OPERATION)                \
    LANES_INLINE struct lanes name(struct lanes a)  \
    {                                               \
        return (struct lanes)LANES_EACH(OPERATION); \
    }
#define LANES_BINARY(name, OPERATION)                              \
    LANES_INLINE struct lanes name(struct lanes a, struct lanes b) \
    {                                                              \
        return (struct lanes)LANES_EACH(OPERATION);                \
    }
#define LANES_TERNARY(name, OPERATION)                                             \
    LANES_INLINE struct lanes name(struct lanes a, struct lanes b, struct lanes c) \
    {                                                                              \
        return (struct lanes)LANES_EACH(OPERATION);                                \
    }

#define EACH(k) VECTOR_ADD(a.v[k], b.v[k])
LANES_BINARY(lanes_add, EACH)
#undef EACH
#define EACH(k) VECTOR_SUB(a.v[k], b.v[k])
LANES_BINARY(lanes_sub, EACH)
#undef EACH
#define EACH(k) VECTOR_MUL(a.v[k], b.v[k])
LANES_BINARY(lanes_mul, EACH)
#undef EACH
#define EACH(k) VECTOR_DIV(a.v[k], b.v[k])
LANES_BINARY(lanes_div, EACH)
#undef EACH
// The lesser; b when they are equal or do not compare.
#define EACH(k) VECTOR_MIN(a.v[k], b.v[k])
LANES_BINARY(lanes_min, EACH)
#undef EACH
// The greater; b when they are equal or do not compare.
#define EACH(k) VECTOR_MAX(a.v[k], b.v[k])
LANES_BINARY(lanes_max, EACH)
#undef EACH
#define EACH(k) VECTOR_SQRT(a.v[k])
LANES_UNARY(lanes_sqrt, EACH)
#undef EACH
#define EACH(k) VECTOR_ABS(a.v[k])
LANES_UNARY(lanes_abs, EACH)
#undef EACH
// a b + c, -a b + c, a b - c: rounded once.
#define EACH(k) VECTOR_FMA(a.v[k], b.v[k], c.v[k])
LANES_TERNARY(lanes_fma, EACH)
#undef EACH
#define EACH(k) VECTOR_FNMA(a.v[k], b.v[k], c.v[k])
LANES_TERNARY(lanes_fnma, EACH)
#undef EACH
#define EACH(k) VECTOR_FMS(a.v[k], b.v[k], c.v[k])
LANES_TERNARY(lanes_fms, EACH)
#undef EACH

// a < b.
LANES_INLINE struct lanes_mask lanes_less(struct lanes a, struct lanes b)
{
#define EACH(k) VECTOR_LESS(a.v[k], b.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// m and a < b.
LANES_INLINE struct lanes_mask lanes_and_less(struct lanes_mask m, struct lanes a, struct lanes b)
{
#define EACH(k) VECTOR_AND_LESS(m.v[k], a.v[k], b.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// m and a <= b.
LANES_INLINE struct lanes_mask lanes_and_not_above(struct lanes_mask m, struct lanes a,
                                                   struct lanes b)
{
#define EACH(k) VECTOR_AND_NOT_ABOVE(m.v[k], a.v[k], b.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// Whether that bit of the IEEE representation is set.
LANES_INLINE struct lanes_mask lanes_bit(struct lanes a, int bit)
{
#define EACH(k) VECTOR_BIT(a.v[k], bit)
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

LANES_INLINE struct lanes_mask lanes_none(void)
{
#define EACH(k) VECTOR_NONE
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

LANES_INLINE struct lanes_mask lanes_and(struct lanes_mask m, struct lanes_mask n)
{
#define EACH(k) VECTOR_AND(m.v[k], n.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// m and not n.
LANES_INLINE struct lanes_mask lanes_and_not(struct lanes_mask m, struct lanes_mask n)
{
#define EACH(k) VECTOR_AND_NOT(m.v[k], n.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

LANES_INLINE struct lanes_mask lanes_or(struct lanes_mask m, struct lanes_mask n)
{
#define EACH(k) VECTOR_OR(m.v[k], n.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// m or n and not both.
LANES_INLINE struct lanes_mask lanes_differ(struct lanes_mask m, struct lanes_mask n)
{
#define EACH(k) VECTOR_DIFFER(m.v[k], n.v[k])
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// Whether it is set in any lane. The one operation that looks across lanes: it may choose between
// two ways to the same bits and nothing else.
LANES_INLINE bool lanes_any(struct lanes_mask m)
{
    bool any = false;
#define DO(k) any |= VECTOR_ANY(m.v[k]);
    LANES_DO(DO)
#undef DO
    return any;
}

// A mask as a number, a bit a lane, and back. Bits of one spring fit a word where a vector would
// take a store of its own.
LANES_INLINE uint32_t lanes_bits(struct lanes_mask m)
{
    uint32_t bits = 0;
#define DO(k) bits |= VECTOR_BITS(m.v[k]) << ((k)*LANES_VECTOR);
    LANES_DO(DO)
#undef DO
    return bits;
}

LANES_INLINE struct lanes_mask lanes_from_bits(uint32_t bits)
{
#define EACH(k) VECTOR_FROM_BITS(bits >> ((k)*LANES_VECTOR))
    return (struct lanes_mask)LANES_EACH(EACH);
#undef EACH
}

// a where m is set, else b.
LANES_INLINE struct lanes lanes_select(struct lanes_mask m, struct lanes a, struct lanes b)
{
#define EACH(k) VECTOR_SELECT(m.v[k], a.v[k], b.v[k])
    return (struct lanes)LANES_EACH(EACH);
#undef EACH
}

// a where m is set, else 0.
LANES_INLINE struct lanes lanes_keep(struct lanes_mask m, struct lanes a)
{
#define EACH(k) VECTOR_KEEP(m.v[k], a.v[k])
    return (struct lanes)LANES_EACH(EACH);
#undef EACH
}

// a b + c where m is set, else 0.
LANES_INLINE struct lanes lanes_keep_fma(struct lanes_mask m, struct lanes a, struct lanes b,
                                         struct lanes c)
{
#define EACH(k) VECTOR_KEEP_FMA(m.v[k], a.v[k], b.v[k], c.v[k])
    return (struct lanes)LANES_EACH(EACH);
#undef EACH
}

#endif
