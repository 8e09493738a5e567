// What a large cluster would tell its monitors, without the cluster: the status messages of many
// workers and of a sweep of many searches, evenly over time, for monitor_bench.
//
//     status_storm URL WORKERS SEARCHES SECONDS
//
// Each worker tells of itself once a second and each search ten times, which is thirty times what a
// coordinator says of a thousand (coordinator/runtime/tell.h); samples, names of cases and the run
// come as often as from a coordinator. It prints how many messages it sent.
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/numeric/verdict.h"
#include "common/wire/wire.h"

#include "sobox_cases_t.h"
#include "sobox_run_status_t.h"
#include "sobox_search_status_t.h"
#include "sobox_step_status_t.h"
#include "sobox_worker_status_t.h"

#include <glib.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TICKS = 100, VARIABLES = 18, SAMPLES = 200, RUN = 4711 }; // ticks a second

struct storm {
    struct wire *coordinator;
    struct wire **workers;
    int64_t worker_count, search_count;
    double bounds[2 * VARIABLES];
    uint8_t packed[SAMPLES / 8 + VARIABLES * 32];
    int64_t tick;
    uint64_t sent;
};

static void publish(struct storm *storm, struct wire *wire, enum wire_kind kind, void *message)
{
    if (wire_publish(wire, kind, message) == STATUS_OK)
        storm->sent++;
}

static void tell_worker(struct storm *storm, int64_t index)
{
    const int64_t now_ns = storm->tick * (CLOCK_SECOND_NS / TICKS) + CLOCK_SECOND_NS;
    sobox_worker_status_t message = {
        .process = (int32_t)index,
        .threads = 16,
        .queue = 20,
        .batches = storm->tick * 50,
        .samples = storm->tick * 10000,
        .busy_ns = now_ns - now_ns / 20,
        .uptime_ns = now_ns,
        .buffer_size = 4 << 20,
    };
    g_snprintf((char *)message.host, sizeof message.host, "crash%" G_GINT64_FORMAT, index);
    publish(storm, storm->workers[index], WIRE_WORKER_STATUS, &message);
}

static void tell_search(struct storm *storm, int64_t index)
{
    const double done = (double)(storm->tick % 20000) / 20000;
    sobox_search_status_t message = {
        .header.run = RUN,
        .search = (int32_t)index,
        .standing = 1,
        .phase = 1,
        .step = (int32_t)(200 * done),
        .step_count = 202,
        .evaluations = storm->tick * 200,
        .good_share = 0.75,
        .log_volume = -20 + 15 * done,
        .variables = VARIABLES,
        .bound_count = 2 * VARIABLES,
        .bounds = storm->bounds,
    };
    publish(storm, storm->coordinator, WIRE_SEARCH_STATUS, &message);
}

static void tell_step(struct storm *storm, int64_t index)
{
    sobox_step_status_t message = {
        .header.run = RUN,
        .search = (int32_t)index,
        .step = (int32_t)(storm->tick / 100),
        .phase = 1,
        .detail = VERDICT_DETAIL_SHARE,
        .samples = SAMPLES,
        .good = SAMPLES,
        .count = SAMPLES,
        .variables = VARIABLES,
        .window = VARIABLES,
        .packed_size = sizeof storm->packed,
        .packed = storm->packed,
    };
    publish(storm, storm->coordinator, WIRE_STEP_STATUS, &message);
}

static void tell_case(struct storm *storm, int64_t index)
{
    char text[64];
    const int size = g_snprintf(text, sizeof text, "seed=%" G_GINT64_FORMAT "%c%" G_GINT64_FORMAT,
                                index, '\0', index) +
                     1;
    sobox_cases_t message = {
        .header.run = RUN,
        .first = (int32_t)index,
        .columns = 2,
        .text_size = size,
        .text = (uint8_t *)text,
    };
    publish(storm, storm->coordinator, WIRE_CASES, &message);
}

static void tell_run(struct storm *storm)
{
    sobox_run_status_t message = {
        .header.run = RUN,
        .name = "storm",
        .searches = (int32_t)storm->search_count,
        .workers = (int32_t)storm->worker_count,
        .samples = storm->tick * 1000000,
        .batches = storm->tick * 5000,
        .elapsed_ns = storm->tick * (CLOCK_SECOND_NS / TICKS),
    };
    publish(storm, storm->coordinator, WIRE_RUN_STATUS, &message);
}

// The share of `count` that is due in this tick when all are in `ticks`.
static void spread(struct storm *storm, int64_t count, int64_t ticks,
                   void (*tell)(struct storm *, int64_t))
{
    const int64_t place = storm->tick % ticks;
    for (int64_t i = count * place / ticks; i < count * (place + 1) / ticks; i++)
        tell(storm, i);
}

static void tick(struct storm *storm)
{
    if (storm->tick % TICKS == 0)
        tell_run(storm);
    spread(storm, storm->worker_count, TICKS, tell_worker);
    spread(storm, storm->search_count, TICKS / 10, tell_search);
    if (storm->tick % 3 == 0 && storm->search_count > 0)
        tell_step(storm, storm->tick / 3 % storm->search_count);
    if (storm->tick % 10 == 0 && storm->search_count > 0)
        tell_case(storm, storm->tick / 10 % storm->search_count);
    storm->tick++;
}

static struct wire *wire_at(const char *url, uint64_t sender)
{
    struct wire_settings settings = wire_settings_default();
    settings.url = url;
    struct wire *wire = NULL;
    struct error error = {0};
    if (wire_open(&wire, &settings, sender, &error) != STATUS_OK) {
        fprintf(stderr, "status_storm: %s\n", error.text);
        exit(EXIT_FAILURE);
    }
    return wire;
}

int main(int argc, char **argv)
{
    if (argc != 5 || sodium_init() < 0) {
        fprintf(stderr, "usage: status_storm URL WORKERS SEARCHES SECONDS\n");
        return 2;
    }
    struct storm storm = {
        .worker_count = atoll(argv[2]),
        .search_count = atoll(argv[3]),
        .coordinator = wire_at(argv[1], 1),
    };
    storm.workers = g_new(struct wire *, storm.worker_count);
    for (int64_t i = 0; i < storm.worker_count; i++)
        storm.workers[i] = wire_at(argv[1], (uint64_t)i + 2);
    for (int i = 0; i < VARIABLES; i++)
        storm.bounds[VARIABLES + i] = 450e3;
    memset(storm.packed, 0xff, SAMPLES / 8);
    const int64_t end_ns = clock_monotonic_ns() + atoll(argv[4]) * CLOCK_SECOND_NS;
    int64_t next_ns = clock_monotonic_ns();
    for (int64_t now_ns = next_ns; now_ns < end_ns; now_ns = clock_monotonic_ns()) {
        if (now_ns < next_ns)
            usleep((useconds_t)((next_ns - now_ns) / 1000));
        tick(&storm);
        next_ns += CLOCK_SECOND_NS / TICKS;
    }
    printf("%" G_GUINT64_FORMAT "\n", storm.sent);
    for (int64_t i = 0; i < storm.worker_count; i++)
        wire_close(storm.workers[i]);
    wire_close(storm.coordinator);
    g_free(storm.workers);
    return 0;
}
