// The lock that makes a coordinator the one writer of its run folder: run.db.lock, a file that is
// locked while a coordinator lives and removed when it ends. The kernel drops the lock with the
// process, so a killed coordinator leaves a file but no lock.
//
// SQLite's own exclusive lock would also shut out readers. A lock on the folder itself would leave
// no file, but network file systems refuse it.
#ifndef SOBOX_COORDINATOR_JOURNAL_JOURNAL_LOCK_H
#define SOBOX_COORDINATOR_JOURNAL_JOURNAL_LOCK_H

#include "common/base/error.h"

struct journal_lock {
    char *path; // owned; NULL while nothing is locked
    int file;   // descriptor that holds the lock
};

// Takes the lock of a run folder; on failure the struct is zeroed.
// Errors: STATUS_REFUSED (another process holds it: the text says which), STATUS_IO.
enum status journal_lock_take(struct journal_lock *lock, const char *directory,
                              struct error *error) MUST_USE;

// Gives it back. A zeroed struct is fine.
void journal_lock_release(struct journal_lock *lock);

#endif
