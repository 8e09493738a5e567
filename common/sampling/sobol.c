#include "common/sampling/sobol.h"

#include "common/numeric/random.h"

#include <assert.h>
#include <pthread.h>
#include <stdbool.h>

// ---- primitive polynomials over GF(2), found when first needed
//
// Bit i of a polynomial is the coefficient of x^i. A polynomial of degree s is primitive when the
// powers of x modulo it run through all 2^s - 1 non-zero remainders.

enum { POLYNOMIAL_COUNT = PROTOCOL_VARIABLE_MAX };

static pthread_mutex_t polynomial_lock = PTHREAD_MUTEX_INITIALIZER;
static uint32_t polynomials[POLYNOMIAL_COUNT];
static uint32_t polynomial_found;
static uint32_t polynomial_next = 3; // the candidate to try next: x + 1 is the first

static uint32_t degree_of(uint32_t polynomial)
{
    return 31 - (uint32_t)__builtin_clz(polynomial);
}

static uint32_t multiply(uint32_t a, uint32_t b, uint32_t modulus)
{
    const uint32_t top = UINT32_C(1) << degree_of(modulus);
    uint32_t product = 0;
    for (; b != 0; b >>= 1) {
        if (b & 1)
            product ^= a;
        a <<= 1;
        if (a & top)
            a ^= modulus;
    }
    return product;
}

// x^exponent modulo a polynomial of degree 2 or more.
static uint32_t power_of_x(uint32_t exponent, uint32_t modulus)
{
    uint32_t result = 1;
    for (uint32_t square = 2; exponent != 0; exponent >>= 1) {
        if (exponent & 1)
            result = multiply(result, square, modulus);
        square = multiply(square, square, modulus);
    }
    return result;
}

static bool primitive(uint32_t polynomial)
{
    const uint32_t degree = degree_of(polynomial);
    if (degree == 1)
        return polynomial == 3;
    if ((polynomial & 1) == 0)
        return false;
    const uint32_t period = (UINT32_C(1) << degree) - 1;
    if (power_of_x(period, polynomial) != 1)
        return false;
    // The period divides 2^degree - 1; it is no less when no prime factor can be taken out.
    uint32_t left = period;
    for (uint32_t factor = 3; left > 1; factor += 2) {
        if (factor * factor > left)
            factor = left;
        if (left % factor != 0)
            continue;
        if (power_of_x(period / factor, polynomial) == 1)
            return false;
        while (left % factor == 0)
            left /= factor;
    }
    return true;
}

static uint32_t polynomial_of(uint32_t index)
{
    assert(index < POLYNOMIAL_COUNT);
    pthread_mutex_lock(&polynomial_lock);
    for (; polynomial_found <= index; polynomial_next++) {
        if (primitive(polynomial_next))
            polynomials[polynomial_found++] = polynomial_next;
    }
    const uint32_t polynomial = polynomials[index];
    pthread_mutex_unlock(&polynomial_lock);
    return polynomial;
}

// ---- direction numbers

// Keys the starts of the direction numbers: they belong to the sequence, not to a run.
static const uint32_t sobol_key[2] = {0x536F626F, 0x6C313637};

// Marks the counters of the scrambling; stratum.c uses the ones with second word 0.
#define SOBOL_COUNTER UINT32_C(0x80000000)

// Random odd integers below 2, 4, 8, ... start the recurrence that the polynomial defines.
static void unscrambled(uint32_t variable, uint32_t direction[SOBOL_BITS])
{
    if (variable == 0) {
        for (uint32_t bit = 0; bit < SOBOL_BITS; bit++)
            direction[bit] = UINT32_C(1) << (31 - bit);
        return;
    }
    const uint32_t polynomial = polynomial_of(variable - 1);
    const uint32_t degree = degree_of(polynomial);
    for (uint32_t bit = 0; bit < SOBOL_BITS; bit++) {
        if (bit < degree) {
            // An odd integer below 2^(bit + 1) as a fraction: its lowest digit is set, those
            // above are free.
            uint32_t block[4];
            random_philox((uint32_t[4]){variable, bit, 0, 0}, sobol_key, block);
            const uint32_t place = UINT32_C(1) << (31 - bit);
            direction[bit] = (block[0] & ~(place - 1)) | place;
            continue;
        }
        uint32_t next = direction[bit - degree] ^ direction[bit - degree] >> degree;
        for (uint32_t i = 1; i < degree; i++) {
            if (polynomial >> (degree - i) & 1)
                next ^= direction[bit - i];
        }
        direction[bit] = next;
    }
}

// Multiplies a fraction's digits by a random lower-triangular matrix: digit i of the result depends
// on digits 0 .. i, so that strata go to strata. rows[i] holds the random coefficients of digit i.
static uint32_t scramble(uint32_t fraction, const uint32_t rows[SOBOL_BITS])
{
    uint32_t result = 0;
    for (uint32_t digit = 0; digit < SOBOL_BITS; digit++) {
        const uint32_t place = UINT32_C(1) << (31 - digit);
        const uint32_t above = ~(place | (place - 1));
        const uint32_t coefficients = (rows[digit] & above) | place;
        if (__builtin_parity(fraction & coefficients))
            result |= place;
    }
    return result;
}

void sobol_init(struct sobol *sobol, const struct sampling *sampling, uint32_t variable)
{
    const uint32_t key[2] = {(uint32_t)sampling->seed, (uint32_t)(sampling->seed >> 32)};
    uint32_t counter[4] = {SOBOL_COUNTER | variable, 1, sampling->step, 0};
    uint32_t block[4];
    random_philox(counter, key, block);
    sobol->shift = block[0];
    sobol->tail = block[1];
    uint32_t rows[SOBOL_BITS];
    for (uint32_t row = 0; row < SOBOL_BITS; row += 4) {
        counter[1]++;
        random_philox(counter, key, rows + row);
    }
    unscrambled(variable, sobol->direction);
    for (uint32_t bit = 0; bit < SOBOL_BITS; bit++)
        sobol->direction[bit] = scramble(sobol->direction[bit], rows);
}

double sobol_of(const struct sobol *sobol, uint32_t index)
{
    uint32_t fraction = sobol->shift;
    for (uint32_t bits = index, bit = 0; bits != 0; bits >>= 1, bit++)
        fraction ^= (0 - (bits & 1)) & sobol->direction[bit];
    // The place within the finest stratum: 20 more bits, which a double still holds exactly.
    uint32_t tail = (index ^ sobol->tail) * UINT32_C(0x9E3779B1);
    tail ^= tail >> 15;
    tail *= UINT32_C(0x85EBCA77);
    return ((double)fraction + (double)(tail >> 12) * 0x1p-20) * 0x1p-32;
}
