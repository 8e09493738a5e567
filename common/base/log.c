#include "common/base/log.h"

#include "common/base/clock.h"
#include "common/base/plain.h"

#include <glib.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

static const char *log_program = "sobox";
static enum log_level log_level_shown = LOG_NORMAL;
static char log_progress_text[512]; // the line that stands at the bottom of the terminal, or ""

void log_start(const char *program, enum log_level level)
{
    log_program = program;
    log_level_shown = level;
}

// Notes that may be shown now, and those that were left out.
static struct {
    int left;
    int64_t counted_ns; // when `left` was last added to; 0 before the first note
    uint64_t left_out;
} log_notes = {.left = LOG_NOTES_BURST};

static bool terminal(void)
{
    return isatty(STDERR_FILENO) == 1;
}

// What a line says may hold the bytes of any file or packet.
static void put_plain(const char *text)
{
    char *plain = plain_text(text);
    fputs(plain, stderr);
    g_free(plain);
}

// Prints one line, lifting the progress line out of its way and putting it back below.
static void __attribute__((format(printf, 2, 0)))
line(const char *label, const char *format, va_list arguments)
{
    if (log_progress_text[0] != '\0')
        fputs("\r\033[K", stderr);
    char *text = g_strdup_vprintf(format, arguments);
    fprintf(stderr, "%s: %s", log_program, label);
    put_plain(text);
    fputc('\n', stderr);
    g_free(text);
    if (log_progress_text[0] != '\0')
        fputs(log_progress_text, stderr);
    fflush(stderr);
}

#define LOG_LINE(label)             \
    va_list arguments;              \
    va_start(arguments, format);    \
    line(label, format, arguments); \
    va_end(arguments)

void log_error(const char *format, ...)
{
    LOG_LINE("error: ");
}

void log_failure(const struct error *error)
{
    if (error->status != STATUS_INVALID) {
        log_error("%s", error->text);
        return;
    }
    log_progress_end();
    put_plain(error->text);
    fputc('\n', stderr);
}

void log_warning(const char *place, const char *text)
{
    if (log_level_shown < LOG_NORMAL)
        return;
    log_progress_end();
    put_plain(place);
    fputs(": warning: ", stderr);
    put_plain(text);
    fputc('\n', stderr);
}

// Whether there is room for one more note.
static bool notes_take(int64_t now_ns)
{
    const int64_t each_ns = LOG_NOTE_EACH_MS * CLOCK_MILLISECOND_NS;
    int64_t earned = (now_ns - log_notes.counted_ns) / each_ns;
    if (log_notes.counted_ns == 0 || earned >= LOG_NOTES_BURST - log_notes.left) {
        log_notes.left = LOG_NOTES_BURST;
        log_notes.counted_ns = now_ns;
    } else {
        log_notes.left += (int)earned;
        log_notes.counted_ns += earned * each_ns;
    }
    if (log_notes.left == 0) {
        log_notes.left_out++;
        return false;
    }
    log_notes.left--;
    return true;
}

static void say(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void say(const char *format, ...)
{
    LOG_LINE("");
}

void log_note(const char *format, ...)
{
    if (log_level_shown < LOG_NORMAL ||
        (log_level_shown < LOG_DEBUG && !notes_take(clock_monotonic_ns())))
        return;
    if (log_notes.left_out > 0)
        say("%" PRIu64 " notes were left out: too many at once", log_notes.left_out);
    log_notes.left_out = 0;
    LOG_LINE("");
}

void log_debug(const char *format, ...)
{
    if (log_level_shown < LOG_DEBUG)
        return;
    LOG_LINE("debug: ");
}

void log_progress(const char *format, ...)
{
    if (log_level_shown < LOG_NORMAL)
        return;
    va_list arguments;
    va_start(arguments, format);
    char *raw = g_strdup_vprintf(format, arguments);
    va_end(arguments);
    char *text = plain_text(raw);
    g_free(raw);
    if (terminal()) {
        snprintf(log_progress_text, sizeof log_progress_text, "%s", text);
        fprintf(stderr, "\r\033[K%s", text);
    } else {
        fprintf(stderr, "%s\n", text);
    }
    fflush(stderr);
    g_free(text);
}

void log_progress_end(void)
{
    if (log_progress_text[0] == '\0')
        return;
    log_progress_text[0] = '\0';
    fputc('\n', stderr);
}

long long log_progress_interval_ns(void)
{
    if (log_level_shown < LOG_NORMAL)
        return INT64_MAX;
    return terminal() ? CLOCK_SECOND_NS / 10 : 2 * CLOCK_SECOND_NS;
}
