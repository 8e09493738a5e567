#include "common/base/status.h"

const char *status_text(enum status status)
{
    static const char *const texts[] = {
#define STATUS_TEXT(name, text) [name] = text,
        STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    };
    return texts[status];
}

enum exit_status status_exit(enum status status)
{
    switch (status) {
    case STATUS_OK:
        return EXIT_STATUS_DONE;
    case STATUS_INVALID:
        return EXIT_STATUS_INVALID;
    case STATUS_INTERRUPTED:
        return EXIT_STATUS_INTERRUPTED;
    case STATUS_IO:
    case STATUS_NETWORK:
    case STATUS_REFUSED:
    case STATUS_FAILED:
        break;
    }
    return EXIT_STATUS_FAILED;
}
