#include "coordinator/journal/journal_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { HOLDER_SIZE = 96 }; // [bytes] of "process 1234 on node7"

// Who holds the lock, as that process wrote it; only for the message, so anything odd in the file
// is shown as '?'.
static void read_holder(int file, char holder[HOLDER_SIZE])
{
    ssize_t size = pread(file, holder, HOLDER_SIZE - 1, 0);
    holder[size > 0 ? size : 0] = '\0';
    g_strchomp(holder);
    for (char *c = holder; *c != '\0'; c++)
        if (!g_ascii_isprint(*c))
            *c = '?';
}

// A lock that cannot be written to serves as well, so what goes wrong here is not told.
static void write_holder(int file)
{
    char holder[HOLDER_SIZE];
    int size = snprintf(holder, sizeof holder, "process %ld on %.60s\n", (long)getpid(),
                        g_get_host_name());
    if (ftruncate(file, 0) == 0 && pwrite(file, holder, (size_t)size, 0) != size)
        (void)ftruncate(file, 0);
}

// Whether `path` still names the file that is open: its last holder may have removed it between
// our opening and our locking.
static bool still_there(int file, const char *path)
{
    struct stat opened, named;
    return fstat(file, &opened) == 0 && stat(path, &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

enum status journal_lock_take(struct journal_lock *lock, const char *directory, struct error *error)
{
    char *path = g_build_filename(directory, "run.db.lock", NULL);
    *lock = (struct journal_lock){0};
    enum status status;
    for (;;) {
        int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (file < 0) {
            status =
                error_set(error, STATUS_IO, "%s: cannot be created: %s", path, strerror(errno));
            break;
        }
        // The lock belongs to the open file, not to the process, so that a second coordinator in
        // the same process is refused too.
        struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
        if (fcntl(file, F_OFD_SETLK, &whole) == 0) {
            if (still_there(file, path)) {
                write_holder(file);
                *lock = (struct journal_lock){.path = path, .file = file};
                return STATUS_OK;
            }
            close(file);
            continue;
        }
        if (errno == EAGAIN || errno == EACCES) {
            char holder[HOLDER_SIZE];
            read_holder(file, holder);
            status = error_set(
                error, STATUS_REFUSED,
                "%s: another coordinator%s%s%s is writing this run; wait for it or stop it",
                directory, holder[0] ? " (" : "", holder, holder[0] ? ")" : "");
        } else {
            status = error_set(error, STATUS_IO, "%s: cannot be locked: %s", path, strerror(errno));
        }
        close(file);
        break;
    }
    g_free(path);
    return status;
}

void journal_lock_release(struct journal_lock *lock)
{
    if (lock->path == NULL)
        return;
    unlink(lock->path); // before the lock ends, so that nobody locks a file about to vanish
    close(lock->file);
    g_free(lock->path);
    *lock = (struct journal_lock){0};
}
