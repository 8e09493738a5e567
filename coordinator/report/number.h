// Counts as text for people. Other numbers are written by common/table/decimal.
#ifndef SOBOX_COORDINATOR_REPORT_NUMBER_H
#define SOBOX_COORDINATOR_REPORT_NUMBER_H

#include <stdint.h>

enum { NUMBER_SIZE = 40 }; // [bytes] that any number fits

// A count with commas between thousands: "42,300". Returns `text`.
const char *number_count(uint64_t value, char text[NUMBER_SIZE]);

#endif
