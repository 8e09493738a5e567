// Lines for the person at the terminal, on standard error: "sobox-worker: note: ...", without
// anything that a terminal would obey (plain.h). A progress
// line (log_progress) stays at the bottom of a terminal and is redrawn under the notes; elsewhere
// it becomes a plain line now and then. Called from the program's message thread only.
#ifndef SOBOX_COMMON_BASE_LOG_H
#define SOBOX_COMMON_BASE_LOG_H

#include "common/base/error.h"

enum log_level {
    LOG_QUIET,  // errors only: --quiet
    LOG_NORMAL, // notes and progress
    LOG_DEBUG,  // every decision: --verbose
};

// Names the program in front of each line and says how much is shown. `program` is borrowed for
// the life of the process.
void log_start(const char *program, enum log_level level);

// An error: always shown.
void log_error(const char *format, ...) __attribute__((format(printf, 1, 2)));

// The error with which a program ends. One about the user's input (STATUS_INVALID) stands alone on
// its line, "FILE:LINE:COLUMN: ...", so that editors find the place; any other as log_error().
void log_failure(const struct error *error);

// What is doubtful about the user's input but does not end the program: shown as log_failure()
// shows an error, "PLACE: warning: TEXT", but with LOG_QUIET.
void log_warning(const char *place, const char *text);

enum {
    LOG_NOTES_BURST = 100,  // notes shown one right after the other
    LOG_NOTE_EACH_MS = 500, // then one in so long [ms]
};

// Something the user should know and perhaps act on: always shown but with LOG_QUIET. What happens
// on a network can give rise to notes without end; more than LOG_NOTES_BURST are left out, and the
// next one that is shown says how many were. With LOG_DEBUG none is left out.
void log_note(const char *format, ...) __attribute__((format(printf, 1, 2)));

// A decision of the program, for those who look for the reason of something.
void log_debug(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Replaces the progress line. On a terminal it is redrawn in place; elsewhere it is printed as a
// line of its own, so the caller calls it seldom there (see log_progress_interval_ns).
void log_progress(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Ends the progress line so that other output starts on a fresh line.
void log_progress_end(void);

// How often it makes sense to call log_progress: 0.1 s on a terminal, 2 s elsewhere, and never
// (INT64_MAX) when progress is not shown. [ns]
long long log_progress_interval_ns(void);

#endif
