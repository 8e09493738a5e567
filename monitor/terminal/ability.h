// What the terminal can do; apart from screen.c, because the names that <term.h> defines are those
// of half the language.
#ifndef SOBOX_MONITOR_TERMINAL_ABILITY_H
#define SOBOX_MONITOR_TERMINAL_ABILITY_H

#include <stdbool.h>

// Whether standard input and output are a terminal that can be painted on: "dumb" and unknown ones
// cannot.
bool ability_to_paint(void);

#endif
