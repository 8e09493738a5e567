// The feed as plain text: a line a run and a second for people, or one JSON object a line for
// programs.
#ifndef SOBOX_MONITOR_TERMINAL_LINES_H
#define SOBOX_MONITOR_TERMINAL_LINES_H

#include "monitor/feed/feed.h"

#include <stdio.h>

// Prints a line for each run heard since `since_ns`, and one for each problem among its workers in
// plain words. Returns how many runs there were.
unsigned lines_print(const struct feed *feed, int64_t since_ns, int64_t now_ns, FILE *out);

// Prints {"time": seconds since 1970, "runs": [...], "workers": [...], "problems": [...]} on one
// line.
void lines_print_json(const struct feed *feed, int64_t now_ns, double time_s, FILE *out);

#endif
