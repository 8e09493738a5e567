#include "common/base/processors.h"

#include <errno.h>
#include <glib.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

int processors_of_variable(const char *value)
{
    if (value == NULL)
        return PROCESSORS_NO_LIMIT;
    char *end;
    errno = 0;
    const long number = strtol(value, &end, 10);
    end += strspn(end, " \t");
    const bool whole = end != value && (*end == '\0' || *end == ',');
    return errno == 0 && whole && number >= 1 && number < INT_MAX ? (int)number
                                                                  : PROCESSORS_NO_LIMIT;
}

int processors_of_quota(const char *text)
{
    char *end;
    const double quota = g_ascii_strtod(text, &end);
    if (end == text)
        return PROCESSORS_NO_LIMIT; // "max"
    const char *rest = end;
    const double period = g_ascii_strtod(rest, &end);
    if (end == rest || !(period > 0) || !(quota > 0) || quota / period >= INT_MAX)
        return PROCESSORS_NO_LIMIT;
    const int whole = (int)(quota / period);
    return whole < quota / period ? whole + 1 : whole;
}

// The path of this process's control group (version 2), from a line "0::/PATH". The caller frees
// it.
static char *control_group(void)
{
    char *text = NULL;
    if (!g_file_get_contents("/proc/self/cgroup", &text, NULL, NULL))
        return NULL;
    const char *line = g_str_has_prefix(text, "0::/") ? text : strstr(text, "\n0::/");
    char *path = NULL;
    if (line != NULL) {
        line = strchr(line, '/');
        path = g_strndup(line, strcspn(line, "\n"));
    }
    g_free(text);
    return path;
}

// The least quota of the control group and of all above it.
static int quota(void)
{
    int least = PROCESSORS_NO_LIMIT;
    char *group = control_group();
    while (group != NULL) {
        char *path = g_build_filename("/sys/fs/cgroup", group, "cpu.max", NULL), *text = NULL;
        if (g_file_get_contents(path, &text, NULL, NULL))
            least = MIN(least, processors_of_quota(text));
        g_free(text);
        g_free(path);
        char *slash = strrchr(group, '/');
        if (slash == NULL || group[1] == '\0')
            break;
        slash[slash == group ? 1 : 0] = '\0'; // the last one looked at is "/" itself
    }
    g_free(group);
    return least;
}

int processors_limited(int wanted)
{
    return MIN(wanted, processors_of_variable(g_getenv("OMP_THREAD_LIMIT")));
}

int processors_usable(void)
{
    int usable = (int)g_get_num_processors(); // by affinity
    usable = MIN(usable, quota());
    usable = MIN(usable, processors_of_variable(g_getenv("OMP_NUM_THREADS")));
    return MAX(1, processors_limited(usable));
}
