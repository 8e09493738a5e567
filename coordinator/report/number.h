// Numbers as text, the same in every locale.
#ifndef SOBOX_COORDINATOR_REPORT_NUMBER_H
#define SOBOX_COORDINATOR_REPORT_NUMBER_H

#include <stdint.h>

enum { NUMBER_SIZE = 40 }; // [bytes] that any number fits

// The shortest decimal that reads back as the same double ("0.15", "450000"); "nan", "inf", "-inf"
// for what is not a number. Returns `text`.
const char *number_exact(double value, char text[NUMBER_SIZE]);

// A count with commas between thousands: "42,300". Returns `text`.
const char *number_count(uint64_t value, char text[NUMBER_SIZE]);

#endif
