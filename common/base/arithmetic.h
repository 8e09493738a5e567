// The floating-point arithmetic of the process. Results are the same bits everywhere because all of
// them are rounded to the nearest number; a library that was loaded along (LD_PRELOAD, a plug-in)
// may have set another rounding mode or had small numbers flushed to zero, without a word.
#ifndef SOBOX_COMMON_BASE_ARITHMETIC_H
#define SOBOX_COMMON_BASE_ARITHMETIC_H

// Sets the arithmetic right, and says so where it was another. Call it in main() before threads are
// started: they inherit it.
void arithmetic_start(void);

#endif
