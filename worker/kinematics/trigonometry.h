// Sine and cosine of a bundle. Our own, because every machine's libm rounds differently and results
// must not depend on the machine.
//
// The angle is brought to |r| <= pi/4 by subtracting a multiple of pi/2 in two parts (Cody and
// Waite), then sine and cosine of r come from minimax polynomials in r^2 (Remez, found for this
// file; their own errors are 3.4e-18 and 4.7e-20).
//
// Measured against extended precision: the absolute error of both is below 1.8e-16 (0.8 ulp of 1)
// for |angle| <= 1000. Beyond, the error grows slowly with the angle; the value stays within [-1,
// 1] but for rounding as long as |angle| < 1e9. An infinite angle gives NaN.
#ifndef SOBOX_WORKER_KINEMATICS_TRIGONOMETRY_H
#define SOBOX_WORKER_KINEMATICS_TRIGONOMETRY_H

#include "worker/kinematics/lanes.h"

// |angle| below which the multiple of pi/2 is 0 and the reduction changes nothing: a little less
// than pi/4, so that rounding cannot matter.
#define TRIGONOMETRY_SMALL 0.78

// Polynomials for |r| <= pi/4: sin r = r + r^3 P(r^2), cos r = 1 - r^2/2 + r^4 Q(r^2). Neighbouring
// terms are paired (Estrin), which shortens the chain of dependent operations from 5 to 3.
LANES_INLINE void trigonometry_kernel(struct lanes r, struct lanes *sine, struct lanes *cosine)
{
    const struct lanes z = lanes_mul(r, r);
    const struct lanes zz = lanes_mul(z, z);
    const struct lanes s0 =
        lanes_fma(z, lanes_set(0x1.111111110f87ap-7), lanes_set(-0x1.5555555555549p-3));
    const struct lanes s1 =
        lanes_fma(z, lanes_set(0x1.71de3577b5b74p-19), lanes_set(-0x1.a01a019c11985p-13));
    const struct lanes s2 =
        lanes_fma(z, lanes_set(0x1.5d9300c402528p-33), lanes_set(-0x1.ae5e6639d6315p-26));
    const struct lanes c0 =
        lanes_fma(z, lanes_set(-0x1.6c16c16c1517ep-10), lanes_set(0x1.555555555554cp-5));
    const struct lanes c1 =
        lanes_fma(z, lanes_set(-0x1.27e4f809eff25p-22), lanes_set(0x1.a01a019cb1bccp-16));
    const struct lanes c2 =
        lanes_fma(z, lanes_set(-0x1.8fae9c39b630dp-37), lanes_set(0x1.1ee9ebe8b7c39p-29));
    const struct lanes p = lanes_fma(zz, lanes_fma(zz, s2, s1), s0);
    const struct lanes q = lanes_fma(zz, lanes_fma(zz, c2, c1), c0);
    *sine = lanes_fma(lanes_mul(r, z), p, r);
    *cosine = lanes_fma(zz, q, lanes_fnma(z, lanes_set(0.5), lanes_set(1.0)));
}

// Sine and cosine of any angle [rad].
LANES_INLINE void trigonometry_full(struct lanes angle, struct lanes *sine, struct lanes *cosine)
{
    // Adding 1.5 x 2^52 rounds to an integer and leaves it in the low bits of the representation.
    const struct lanes shift = lanes_set(0x1.8p52);
    const struct lanes shifted = lanes_fma(angle, lanes_set(0x1.45f306dc9c883p-1), shift);
    const struct lanes quarter = lanes_sub(shifted, shift);
    struct lanes r = lanes_fnma(quarter, lanes_set(0x1.921fb54442d18p+0), angle);
    r = lanes_fnma(quarter, lanes_set(0x1.1a62633145c07p-54), r);
    struct lanes s;
    struct lanes c;
    trigonometry_kernel(r, &s, &c);
    // Odd quarters swap sine and cosine; the sine is negative in quarters 2 and 3, the cosine in 1
    // and 2, that is where the next quarter's sine is.
    const struct lanes_mask odd = lanes_bit(shifted, 0);
    const struct lanes_mask sine_negative = lanes_bit(shifted, 1);
    const struct lanes_mask cosine_negative = lanes_bit(lanes_add(shifted, lanes_set(1.0)), 1);
    const struct lanes zero = lanes_set(0.0);
    const struct lanes sine_absolute = lanes_select(odd, c, s);
    const struct lanes cosine_absolute = lanes_select(odd, s, c);
    *sine = lanes_select(sine_negative, lanes_sub(zero, sine_absolute), sine_absolute);
    *cosine = lanes_select(cosine_negative, lanes_sub(zero, cosine_absolute), cosine_absolute);
}

// The same, and the same bits, faster while all angles are small. `magnitude` is |angle|.
LANES_INLINE void trigonometry_sine_cosine(struct lanes angle, struct lanes magnitude,
                                           struct lanes *sine, struct lanes *cosine)
{
    if (lanes_any(lanes_less(lanes_set(TRIGONOMETRY_SMALL), magnitude))) {
        trigonometry_full(angle, sine, cosine);
    } else {
        trigonometry_kernel(angle, sine, cosine);
    }
}

#endif
