// What a sweep would do: its cases, and how long they would take on this machine, judged from a
// moment of a few of them.
#ifndef SOBOX_COORDINATOR_RUNTIME_PREVIEW_H
#define SOBOX_COORDINATOR_RUNTIME_PREVIEW_H

#include "coordinator/runtime/run.h"

#include <stdio.h>

// Prints the cases that `choice` chooses to `out`, then an estimate of the time on `threads` cores.
// Every case's scenario is checked, as for a run. Nothing is written and nothing is sent.
// Errors: STATUS_INVALID (as run_create_sweep()), STATUS_IO.
enum status preview_print(const struct sweep *sweep, const struct run_choice *choice, int threads,
                          FILE *out, struct error *error) MUST_USE;

#endif
