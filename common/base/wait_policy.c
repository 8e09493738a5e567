#include "common/base/wait_policy.h"

#include <stdlib.h>
#include <unistd.h>

void wait_policy_sleep(char **argv)
{
    static const char variable[] = "OMP_WAIT_POLICY";
    if (getenv(variable) != NULL || setenv(variable, "passive", 0) != 0)
        return;
    // /proc/self/exe is this very file, also when it was found on the PATH or replaced since.
    execv("/proc/self/exe", argv);
}
