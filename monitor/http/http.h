// The monitor's web server: one page and what it needs, from inside the program, and nothing else.
//
//   /             the page; /page.css, /page.js, /chart.js with it
//   /events       the picture as server-sent events (picture.h); ?run=ID&search=NUMBER chooses what
//                 is told in detail
//   /samples.json the samples of the search's latest step over two variables (xray.h):
//                 ?run=ID&search=NUMBER&x=NUMBER&y=NUMBER, with &step=NUMBER those of an earlier
//                 one
//   /samples.csv  likewise all variables of them
//   /state.json   the picture once, complete, for scripts
//   /metrics      for Prometheus (metrics.h)
//
// It runs on the main loop of the thread that owns the feed. Nobody can make it wait or grow:
// connections, streams and the size of a request are limited, bodies refused, and a stream that is
// read too slowly skips what is out of date. What comes from another site is refused, whatever the
// browser would let it read: by the Host header (host.h), by Sec-Fetch-Site, and no answer permits
// it (CORS).
#ifndef SOBOX_MONITOR_HTTP_HTTP_H
#define SOBOX_MONITOR_HTTP_HTTP_H

#include "common/base/error.h"
#include "monitor/http/picture.h"

#include <stdint.h>

enum {
    HTTP_CONNECTION_MAX = 128,
    HTTP_STREAM_MAX = 48,           // of these, for events
    HTTP_CONNECTION_MEMORY = 16384, // [bytes] a request's line and headers; longer ones are refused
    HTTP_TIMEOUT_S = 30,            // without a byte; a stream says something every second
};

struct http;

// Serves `view` (borrowed until http_stop()) at "ADDRESS:PORT" on the default main context.
// Errors: STATUS_INVALID (not an address), STATUS_NETWORK (cannot be bound: the text says why).
enum status http_start(struct http **http, const char *address, const struct picture_view *view,
                       struct error *error) MUST_USE;

// Ends all connections. NULL is fine.
void http_stop(struct http *http);

// Where the page is, for people: "http://127.0.0.1:8765/". Borrowed.
const char *http_url(const struct http *http);

// Whether other machines reach it.
bool http_leaves_machine(const struct http *http);

#endif
