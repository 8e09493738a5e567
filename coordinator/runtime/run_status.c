#include "coordinator/runtime/run_status.h"

#include "sobox_run_status_t.h"

#include <glib.h>
#include <string.h>

void run_status_publish(struct wire *wire, const struct run_status *status,
                        const struct schedule_counters *counters)
{
    struct wire_counters heard;
    wire_counters(wire, &heard);
    sobox_run_status_t message = {
        .header.run = (int64_t)status->run,
        .state = (int8_t)status->state,
        .searches = (int32_t)status->searches,
        .searches_done = (int32_t)status->searches_done,
        .workers = (int32_t)counters->workers,
        .workers_refused = (int32_t)counters->workers_refused,
        .samples = (int64_t)counters->samples_counted,
        .batches = (int64_t)counters->batches_counted,
        .released = (int64_t)counters->released,
        .duplicates = (int64_t)counters->duplicates,
        .rejected = (int64_t)heard.rejected,
        .lost = (int64_t)heard.lost,
        .elapsed_ns = status->elapsed_ns,
        .service_ns = counters->service_ns,
    };
    g_strlcpy((char *)message.name, status->name, sizeof message.name);
    memcpy(message.fingerprint, status->fingerprint->bytes, DIGEST_SIZE);
    (void)!wire_publish(wire, WIRE_RUN_STATUS, &message);
}

enum run_state run_status_after(enum status status, bool all_done)
{
    switch (status) {
    case STATUS_OK:
        return all_done ? RUN_STATE_DONE : RUN_STATE_INTERRUPTED;
    case STATUS_INTERRUPTED:
        return RUN_STATE_INTERRUPTED;
    default:
        return RUN_STATE_FAILED;
    }
}
