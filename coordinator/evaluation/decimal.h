// Numbers as text and back, for tables of millions of rows: ten times as fast as the C library for
// the numbers that such tables are made of, and by the C library for all others.
//
// Both ways are exact: what is read is the double nearest to the text, and what is written reads
// back as the same double.
#ifndef SOBOX_COORDINATOR_EVALUATION_DECIMAL_H
#define SOBOX_COORDINATOR_EVALUATION_DECIMAL_H

#include <stdbool.h>
#include <stddef.h>

enum { DECIMAL_SIZE = 32 }; // [bytes] that any number fits, without a NUL

// Reads exactly `size` bytes as a finite decimal number ("450e3", "-.5", "12"). False when they are
// none: nothing or blanks, words as nan and inf, hexadecimal numbers, anything too large.
bool decimal_read(const char *text, size_t size, double *number);

// Writes the number and returns the bytes it took: at most 17 digits, 15 where these are enough;
// "nan", "inf" or "-inf" for what is no number.
size_t decimal_write(double number, char text[DECIMAL_SIZE]);

#endif
