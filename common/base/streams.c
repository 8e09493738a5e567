#include "common/base/streams.h"

#include "common/base/log.h"
#include "common/base/status.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Opened the wrong way round, so that using it is the same error as before (EBADF). The lowest
// number that is free is the closed stream's, because those below it are open by then.
static void fill(int stream)
{
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF &&
        open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream)
        abort();
}

// A program that failed has said why, most likely this.
static void finish(int exit_status, void *unused)
{
    (void)unused;
    errno = 0;
    const bool written = fflush(stdout) == 0 && !ferror(stdout);
    if (written || exit_status != EXIT_STATUS_DONE)
        return;
    if (errno != 0)
        log_error("standard output: %s", strerror(errno));
    else
        log_error("standard output: writing failed");
    _exit(EXIT_STATUS_FAILED);
}

void streams_start(void)
{
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
        fill(stream);
    on_exit(finish, NULL);
}
