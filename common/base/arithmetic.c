#include "common/base/arithmetic.h"

#include "common/base/log.h"

#include <fenv.h>

void arithmetic_start(void)
{
    if (fegetround() != FE_TONEAREST)
        log_note("a library that was loaded with this program had set another rounding mode, which "
                 "would change every result: numbers are rounded to the nearest again");
    fesetenv(FE_DFL_ENV);
}
