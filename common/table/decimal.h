// Numbers as text and back, the same in every locale and on every processor. What is read is the
// double nearest to the text, and what is written is the shortest decimal that reads back as the
// same double. Tables of millions of rows are read and written by it, so numbers as such tables
// hold them take whole-number arithmetic only, a tenth of the C library's time, and the library
// does the others.
#ifndef SOBOX_COMMON_TABLE_DECIMAL_H
#define SOBOX_COMMON_TABLE_DECIMAL_H

#include <stdbool.h>
#include <stddef.h>

enum { DECIMAL_SIZE = 32 }; // [bytes] that any number fits, with its NUL

// Reads exactly `size` bytes as a finite decimal number ("450e3", "-.5", "12"). False when they are
// none: nothing or blanks, words as nan and inf, hexadecimal numbers, anything too large.
bool decimal_read(const char *text, size_t size, double *number);

// Writes the number with 15, 16 or 17 digits, the first that read back: 15 are enough for most
// numbers that people write, 17 for all there are. Large and small ones have an exponent
// ("1e+300"). What is no number becomes "nan", "inf" or "-inf". Returns the bytes written without
// the NUL.
size_t decimal_write(double number, char text[DECIMAL_SIZE]);

// The same; returns `text`.
const char *decimal_text(double number, char text[DECIMAL_SIZE]);

#endif
