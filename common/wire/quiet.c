#include "common/wire/quiet.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

void quiet_start(struct quiet *quiet)
{
    *quiet = (struct quiet){.saved = -1, .kept = memfd_create("stderr", MFD_CLOEXEC)};
    if (quiet->kept < 0)
        return;
    fflush(stderr);
    quiet->saved = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (quiet->saved >= 0)
        dup2(quiet->kept, STDERR_FILENO);
}

void quiet_end(struct quiet *quiet)
{
    if (quiet->saved >= 0) {
        fflush(stderr);
        dup2(quiet->saved, STDERR_FILENO);
        close(quiet->saved);
        ssize_t size = pread(quiet->kept, quiet->text, sizeof quiet->text - 1, 0);
        quiet->text[size > 0 ? size : 0] = '\0';
        for (char *at = quiet->text; *at != '\0'; at++)
            if (*at == '\n')
                *at = ' ';
    }
    if (quiet->kept >= 0)
        close(quiet->kept);
    quiet->saved = quiet->kept = -1;
}
