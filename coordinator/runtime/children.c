#include "coordinator/runtime/children.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/processors.h"

#include <errno.h>
#include <glib.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

struct child {
    struct children *owner;
    GPid process; // 0 once it has ended
    guint watch;
};

struct children {
    uint32_t count;
    uint32_t alive;
    children_watcher *watcher;
    void *user;
    struct child items[]; // (count)
};

enum { STOP_WAIT_MS = 2000, STOP_POLL_MS = 5 };

// The sobox-worker that was installed or built together with this program.
static char *worker_program(void)
{
    char *self = g_file_read_link("/proc/self/exe", NULL);
    char *folder = self ? g_path_get_dirname(self) : g_strdup(".");
    char *beside = g_build_filename(folder, "sobox-worker", NULL);
    g_free(self);
    g_free(folder);
    if (g_file_test(beside, G_FILE_TEST_IS_EXECUTABLE))
        return beside;
    g_free(beside);
    return g_find_program_in_path("sobox-worker");
}

static void ended(GPid process, gint wait_status, gpointer user)
{
    struct child *child = user;
    struct children *children = child->owner;
    g_spawn_close_pid(process);
    child->process = 0;
    child->watch = 0;
    children->alive--;
    if (WIFSIGNALED(wait_status))
        log_note("local worker %d was ended by signal %d; %u left", (int)process,
                 WTERMSIG(wait_status), children->alive);
    else
        log_note("local worker %d ended with status %d; %u left", (int)process,
                 WEXITSTATUS(wait_status), children->alive);
    if (children->watcher != NULL)
        children->watcher(children->user, children->alive);
}

static enum status start_one(struct child *child, const char *const *arguments, struct error *error)
{
    GError *reason = NULL;
    const GSpawnFlags flags = G_SPAWN_DO_NOT_REAP_CHILD;
    if (!g_spawn_async(NULL, (char **)arguments, NULL, flags, NULL, NULL, &child->process,
                       &reason)) {
        error_set(error, STATUS_FAILED, "cannot start a local worker: %s", reason->message);
        g_error_free(reason);
        return STATUS_FAILED;
    }
    child->owner->alive++;
    child->watch = g_child_watch_add(child->process, ended, child);
    return STATUS_OK;
}

enum status children_start(struct children **children, const struct children_settings *settings,
                           struct error *error)
{
    *children = NULL;
    char *program = worker_program();
    if (program == NULL)
        return error_set(error, STATUS_FAILED,
                         "sobox-worker is neither beside this program nor on the PATH");
    int threads = settings->threads;
    if (threads == 0)
        threads = MAX(1, processors_usable() / (int)settings->count);

    struct children *made = g_malloc0(sizeof *made + settings->count * sizeof(struct child));
    made->count = settings->count;
    char *threads_text = g_strdup_printf("%d", threads);
    char *mtu_text = g_strdup_printf("%u", settings->mtu);
    char *parent_text = g_strdup_printf("%d", (int)getpid());
    const char *const arguments[] = {
        program, "--url", settings->url, "--threads", threads_text, "--mtu", mtu_text, "--parent",
        parent_text, settings->verbose ? "--verbose" : "--quiet",
        // Last, because without a key the list ends here. The key itself never shows in a list of
        // processes.
        settings->key_file != NULL ? "--key-file" : NULL, settings->key_file, NULL};
    enum status status = STATUS_OK;
    for (uint32_t i = 0; status == STATUS_OK && i < made->count; i++) {
        made->items[i].owner = made;
        status = start_one(&made->items[i], arguments, error);
    }
    g_free(threads_text);
    g_free(mtu_text);
    g_free(parent_text);
    g_free(program);
    if (status != STATUS_OK) {
        children_stop(made);
        return status;
    }
    *children = made;
    return STATUS_OK;
}

void children_watch(struct children *children, children_watcher *watcher, void *user)
{
    children->watcher = watcher;
    children->user = user;
}

uint32_t children_alive(const struct children *children)
{
    return children->alive;
}

// Takes notice of a child that has ended, without waiting.
static bool reap(struct child *child)
{
    int wait_status;
    if (child->process == 0)
        return true;
    if (waitpid(child->process, &wait_status, WNOHANG) == 0)
        return false;
    child->process = 0;
    return true;
}

static bool reap_all(struct children *children)
{
    bool all = true;
    for (uint32_t i = 0; i < children->count; i++)
        all &= reap(&children->items[i]);
    return all;
}

static void signal_all(const struct children *children, int number)
{
    for (uint32_t i = 0; i < children->count; i++) {
        if (children->items[i].process != 0)
            kill(children->items[i].process, number);
    }
}

void children_stop(struct children *children)
{
    if (children == NULL)
        return;
    // From here on we wait ourselves; the main loop no longer runs.
    for (uint32_t i = 0; i < children->count; i++) {
        if (children->items[i].watch != 0)
            g_source_remove(children->items[i].watch);
    }
    signal_all(children, SIGTERM);
    for (int waited_ms = 0; !reap_all(children) && waited_ms < STOP_WAIT_MS;
         waited_ms += STOP_POLL_MS)
        g_usleep(STOP_POLL_MS * 1000);
    signal_all(children, SIGKILL);
    for (uint32_t i = 0; i < children->count; i++) {
        if (children->items[i].process != 0)
            waitpid(children->items[i].process, NULL, 0);
    }
    g_free(children);
}

// Whether nobody has this UDP port open now. Sharing is not asked for, so even listeners that share
// make the bind fail.
static bool port_free(uint16_t port)
{
    int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0)
        return false;
    const struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_ANY)};
    bool free = bind(descriptor, (const struct sockaddr *)&address, sizeof address) == 0;
    close(descriptor);
    return free;
}

char *children_private_url(void)
{
    // Below the kernel's own range of ephemeral ports (32768 up), so that no outgoing connection
    // takes one of the three in the meantime.
    enum { PORT_FIRST = 20000, PORT_SPAN = 12000, TRIES = 200 };
    uint16_t port = 0;
    for (int i = 0; i < TRIES; i++) {
        port = (uint16_t)(PORT_FIRST + g_random_int_range(0, PORT_SPAN / 3) * 3);
        if (port_free(port) && port_free(port + 1) && port_free(port + 2))
            break;
    }
    return g_strdup_printf("udpm://239.255.76.67:%u?ttl=0", port);
}
