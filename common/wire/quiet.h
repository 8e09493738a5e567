// LCM 1.3.1 prints to standard error where it should return a reason, in several lines and partly
// from freed memory. Between quiet_start() and quiet_end() what is written to standard error is
// kept aside, so that the user sees one clear line, ours. For the short calls that create an lcm_t
// or open it for listening only.
#ifndef SOBOX_COMMON_WIRE_QUIET_H
#define SOBOX_COMMON_WIRE_QUIET_H

enum { QUIET_TEXT_SIZE = 512 }; // [bytes] kept of what was printed

struct quiet {
    int saved;                  // standard error as it was; -1: nothing is kept aside
    int kept;                   // file in memory that stands in for it
    char text[QUIET_TEXT_SIZE]; // after quiet_end(): what was printed, cut, newlines as blanks
};

void quiet_start(struct quiet *quiet);
void quiet_end(struct quiet *quiet);

#endif
