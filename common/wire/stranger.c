#include "common/wire/stranger.h"

#include "common/base/log.h"

#include <inttypes.h>

static const struct {
    uint64_t least; // messages, before the person is told
    const char *text;
} tellings[STRANGER_COUNT] = {
#define STRANGER_TEXT(name, least, text) [name] = {least, text},
    STRANGER_LIST(STRANGER_TEXT)
#undef STRANGER_TEXT
};

bool stranger_heard(struct strangers *strangers, enum stranger stranger, uint64_t count,
                    int64_t now_ns)
{
    uint64_t heard = strangers->of[stranger].heard += count;
    uint64_t told = strangers->of[stranger].told;
    if (count == 0 || heard < tellings[stranger].least || heard < 2 * told ||
        (told > 0 && now_ns - strangers->of[stranger].told_ns < STRANGER_QUIET_NS))
        return false;
    strangers->of[stranger].told = heard;
    strangers->of[stranger].told_ns = now_ns;
    log_note("heard %" PRIu64 " message%s %s", heard, heard == 1 ? "" : "s",
             tellings[stranger].text);
    return true;
}
