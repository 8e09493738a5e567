// The feed in the text format of Prometheus
// (https://prometheus.io/docs/instrumenting/exposition_formats/): base units, totals that only grow
// end in _total, shares are ratios. Every run, search and worker is a set of labels; so that a
// sweep of thousands does not flood a Prometheus, searches are told of only while they run, the
// latest METRICS_SEARCH_MAX of them.
#ifndef SOBOX_MONITOR_HTTP_METRICS_H
#define SOBOX_MONITOR_HTTP_METRICS_H

#include "monitor/feed/feed.h"

#include <glib.h>

enum { METRICS_SEARCH_MAX = 100 };

#define METRICS_TYPE "text/plain; version=0.0.4; charset=utf-8"

// Appends all metrics as they stand at `now_ns`.
void metrics_write(const struct feed *feed, int64_t now_ns, GString *out);

#endif
