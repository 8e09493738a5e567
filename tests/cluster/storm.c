#include "tests/cluster/storm.h"

#include "tests/cluster/coordinator_node.h"
#include "tests/cluster/network.h"
#include "tests/cluster/trace.h"
#include "tests/cluster/worker_node.h"

#include <glib.h>
#include <string.h>

#define MICROSECOND_NS 1e3
#define MILLISECOND_NS 1e6
#define SECOND_NS 1e9

// The run must end so soon after the weather has cleared, and after twice the time that all workers
// together need for its work: silence (3 s) and announcements (1 s) of workers that were cut off,
// and a lease that had backed off.
#define STORM_AFTER_NS (10 * SECOND_NS)

// A process that is down is started again by then.
#define STORM_RESTART_NS (2 * SECOND_NS)

enum { STORM_PLACE_MAX = 16 };

// What is done again in the whole run of a calm day: copies of late batches, and leases that lapsed
// where boxes are fetched. One day in hundreds has any.
enum { CALM_COPIES_MAX = 2, CALM_RELEASED_MAX = 16 };

struct storm {
    const struct problem *problem;
    struct dice dice;
    struct network network;
    struct schedule_settings settings;
    struct coordinator_node coordinator;
    struct worker_node workers[STORM_PLACE_MAX]; // from place 1 on
    uint32_t worker_count;
    int64_t starts_ns[STORM_PLACE_MAX]; // when the process of a place is to be started; 0: never
    int64_t now_ns;
    int64_t clear_ns;
    int64_t fault_ns; // the next one
    double fault_mean_ns;
    double fault_duration_ns; // greatest
    uint32_t faults;
};

// ---- Drawing ----

static void storm_draw_weather(struct storm *storm)
{
    struct dice *dice = &storm->dice;
    storm->network.weather = (struct weather){
        .loss = dice_chance(dice, 0.2) ? 0 : dice_scale(dice, 0.001, 0.4),
        .twice = dice_chance(dice, 0.5) ? 0 : dice_scale(dice, 0.001, 0.5),
        .stray = dice_chance(dice, 0.5) ? 0 : dice_scale(dice, 0.001, 0.3),
        .delay_ns = dice_scale(dice, 5 * MICROSECOND_NS, 20 * MILLISECOND_NS),
        .jitter_ns = dice_scale(dice, MICROSECOND_NS, 20 * MILLISECOND_NS),
        .stray_ns = dice_scale(dice, MICROSECOND_NS, 500 * MILLISECOND_NS),
    };
}

static const struct weather weather_clear = {
    .delay_ns = 20 * MICROSECOND_NS, .jitter_ns = 0.1 * MICROSECOND_NS, .stray_ns = 1};

static void storm_draw_worker(struct storm *storm, uint32_t place, double sample_ns)
{
    struct dice *dice = &storm->dice;
    struct worker_node *worker = &storm->workers[place];
    worker_node_init(worker, &storm->network, dice, place);
    worker->sample_ns = sample_ns * dice_scale(dice, 0.2, 5);
    worker->overhead_ns = dice_scale(dice, 2 * MICROSECOND_NS, 50 * MICROSECOND_NS);
    worker->threads = 1 + dice_below(dice, 8);
    storm->starts_ns[place] = 1 + dice_wait_ns(dice, 100 * MILLISECOND_NS);
}

static void storm_draw(struct storm *storm, bool calm)
{
    struct dice *dice = &storm->dice;
    storm->settings = schedule_settings_default();
    storm->settings.batch_samples_max[VERDICT_DETAIL_FULL] = (uint32_t)dice_scale(dice, 8, 500);
    storm->settings.batch_samples_max[VERDICT_DETAIL_MARGIN] =
        storm->settings.batch_samples_max[VERDICT_DETAIL_FULL];
    storm->settings.batch_samples_max[VERDICT_DETAIL_SHARE] = (uint32_t)dice_scale(dice, 64, 9000);
    network_init(&storm->network, dice);
    coordinator_node_init(&storm->coordinator, &storm->network, dice, storm->problem,
                          1 + dice_below(dice, PROBLEM_SEARCHES), &storm->settings);
    storm->coordinator.boxes_by_request = dice_chance(dice, 0.3);
    storm->coordinator.piece_size = (uint32_t)dice_scale(dice, 100, 1300);
    storm->worker_count = 1 + dice_below(dice, 8);
    storm->coordinator.worker_count = storm->worker_count;
    // A calm day is to show that nothing is wasted; an unknown model that is very slow is found out
    // by leases that lapse.
    double sample_ns = dice_scale(dice, MICROSECOND_NS, (calm ? 0.2 : 4) * MILLISECOND_NS);
    for (uint32_t place = 1; place <= storm->worker_count; place++)
        storm_draw_worker(storm, place, sample_ns);
    // One may be of another version, never the first one.
    if (storm->worker_count > 1 && dice_chance(dice, 0.2))
        storm->workers[2].wrong_version = true;

    storm->starts_ns[0] = 1 + dice_wait_ns(dice, 100 * MILLISECOND_NS);
    storm->clear_ns = (int64_t)dice_scale(dice, 0.3 * SECOND_NS, 10 * SECOND_NS);
    storm->fault_mean_ns = dice_scale(dice, 10 * MILLISECOND_NS, 3 * SECOND_NS);
    storm->fault_duration_ns = dice_scale(dice, 10 * MILLISECOND_NS, 8 * SECOND_NS);
    storm->fault_ns = dice_wait_ns(dice, storm->fault_mean_ns);
    storm_draw_weather(storm);
    if (calm) {
        storm->network.weather = weather_clear;
        storm->clear_ns = storm->fault_ns = INT64_MAX;
    }
}

// ---- Faults ----

static int64_t fault_end_ns(struct storm *storm)
{
    return storm->now_ns +
           (int64_t)dice_scale(&storm->dice, MILLISECOND_NS, storm->fault_duration_ns);
}

static void fault_coordinator(struct storm *storm)
{
    struct coordinator_node *coordinator = &storm->coordinator;
    int64_t end_ns = fault_end_ns(storm);
    if (!coordinator->running)
        return;
    if (dice_chance(&storm->dice, 0.5)) {
        trace_line(storm->now_ns, "coordinator", "killed");
        coordinator_node_kill(coordinator);
        storm->starts_ns[0] =
            storm->now_ns + (int64_t)dice_scale(&storm->dice, MICROSECOND_NS, STORM_RESTART_NS);
    } else {
        trace_line(storm->now_ns, "coordinator", "stopped until %.6f", (double)end_ns * 1e-9);
        coordinator->stopped_until_ns = end_ns;
    }
}

static void fault_worker(struct storm *storm, uint32_t place)
{
    struct worker_node *worker = &storm->workers[place];
    int64_t end_ns = fault_end_ns(storm);
    uint32_t fault = dice_below(&storm->dice, 6);
    static const char *const names[] = {"killed", "leaves", "stopped", "stuck", "slow", "cut off"};
    trace_line(storm->now_ns, "fault", "worker %u %s until %.6f", place, names[fault],
               (double)end_ns * 1e-9);
    switch (fault) {
    case 0:
        worker_node_kill(worker);
        storm->starts_ns[place] = end_ns;
        break;
    case 1:
        worker_node_leave(worker, storm->now_ns);
        storm->starts_ns[place] = end_ns;
        break;
    case 2:
        worker->stopped_until_ns = end_ns;
        break;
    case 3:
        worker->stuck_until_ns = end_ns;
        if (worker->busy && worker->work_end_ns < end_ns)
            worker->work_end_ns = end_ns;
        break;
    case 4:
        worker->slowness = dice_scale(&storm->dice, 0.1, 30);
        break;
    default:
        // Both directions or one.
        storm->network.cut_until_ns[place][0] = dice_chance(&storm->dice, 0.8) ? end_ns : 0;
        storm->network.cut_until_ns[place][1] = dice_chance(&storm->dice, 0.8) ? end_ns : 0;
        break;
    }
}

// The cluster falls into two halves: no worker of one hears the coordinator.
static void fault_partition(struct storm *storm)
{
    int64_t end_ns = fault_end_ns(storm);
    trace_line(storm->now_ns, "fault", "partition until %.6f", (double)end_ns * 1e-9);
    for (uint32_t place = 1; place <= storm->worker_count; place++) {
        if (dice_chance(&storm->dice, 0.5))
            storm->network.cut_until_ns[place][0] = storm->network.cut_until_ns[place][1] = end_ns;
    }
}

static void storm_strike(struct storm *storm)
{
    storm->faults++;
    storm->fault_ns = storm->now_ns + dice_wait_ns(&storm->dice, storm->fault_mean_ns);
    uint32_t kind = dice_below(&storm->dice, 10);
    if (kind == 0)
        fault_coordinator(storm);
    else if (kind == 1)
        fault_partition(storm);
    else if (kind == 2)
        storm_draw_weather(storm);
    else
        fault_worker(storm, 1 + dice_below(&storm->dice, storm->worker_count));
}

// From now on nothing goes wrong any more.
static void storm_clear(struct storm *storm)
{
    trace_line(storm->now_ns, "weather", "clears");
    storm->clear_ns = INT64_MAX;
    storm->fault_ns = INT64_MAX;
    storm->network.weather = weather_clear;
    memset(storm->network.cut_until_ns, 0, sizeof storm->network.cut_until_ns);
    storm->coordinator.stopped_until_ns = storm->now_ns;
    for (uint32_t place = 1; place <= storm->worker_count; place++) {
        struct worker_node *worker = &storm->workers[place];
        worker->stopped_until_ns = storm->now_ns;
        worker->stuck_until_ns = storm->now_ns;
        worker->slowness = 1;
        if (worker->busy && worker->work_end_ns > storm->now_ns)
            worker->work_end_ns = storm->now_ns;
    }
    for (uint32_t place = 0; place <= storm->worker_count; place++) {
        if (storm->starts_ns[place] > storm->now_ns)
            storm->starts_ns[place] = storm->now_ns;
    }
}

// ---- Time ----

static int64_t storm_wake_ns(const struct storm *storm)
{
    int64_t wake_ns = MIN(storm->clear_ns, storm->fault_ns);
    wake_ns = MIN(wake_ns, network_wake_ns(&storm->network));
    wake_ns = MIN(wake_ns, coordinator_node_wake_ns(&storm->coordinator));
    for (uint32_t place = 0; place <= storm->worker_count; place++) {
        if (storm->starts_ns[place] > 0)
            wake_ns = MIN(wake_ns, storm->starts_ns[place]);
        if (place > 0)
            wake_ns = MIN(wake_ns, worker_node_wake_ns(&storm->workers[place]));
    }
    return wake_ns;
}

static void storm_start_due(struct storm *storm)
{
    for (uint32_t place = 0; place <= storm->worker_count; place++) {
        if (storm->starts_ns[place] == 0 || storm->starts_ns[place] > storm->now_ns)
            continue;
        storm->starts_ns[place] = 0;
        if (place == 0)
            coordinator_node_start(&storm->coordinator, storm->now_ns);
        else
            worker_node_start(&storm->workers[place], storm->now_ns);
    }
}

// Goes to the next moment at which something happens, and lets it.
static void storm_step(struct storm *storm)
{
    int64_t wake_ns = storm_wake_ns(storm);
    TRACE_CHECK(storm->now_ns, wake_ns < INT64_MAX);
    storm->now_ns = MAX(storm->now_ns, wake_ns);
    if (storm->clear_ns <= storm->now_ns)
        storm_clear(storm);
    if (storm->fault_ns <= storm->now_ns)
        storm_strike(storm);
    storm_start_due(storm);
    struct packet *packet;
    while ((packet = network_receive(&storm->network, storm->now_ns)) != NULL) {
        if (packet->to == 0)
            coordinator_node_receive(&storm->coordinator, packet, storm->now_ns);
        else
            worker_node_receive(&storm->workers[packet->to], packet, storm->now_ns);
    }
    for (uint32_t place = 1; place <= storm->worker_count; place++)
        worker_node_wake(&storm->workers[place], storm->now_ns);
    coordinator_node_wake(&storm->coordinator, storm->now_ns);
}

// ---- The end ----

// How long the run may go on after the weather has cleared.
static double storm_after_max_ns(const struct storm *storm)
{
    double rate = 0, samples = 0;
    for (uint32_t place = 1; place <= storm->worker_count; place++) {
        const struct worker_node *worker = &storm->workers[place];
        if (!worker->wrong_version)
            rate += 1 / (worker->sample_ns / worker->threads + worker->overhead_ns);
    }
    for (uint32_t i = 0; i < storm->coordinator.search_count; i++)
        samples += (double)storm->problem->samples[i];
    return STORM_AFTER_NS + 2 * samples / rate;
}

static void storm_check_results(const struct storm *storm)
{
    for (uint32_t i = 0; i < storm->coordinator.search_count; i++) {
        struct search_result result;
        search_result(storm->coordinator.searches[i].search, &result);
        if (!digest_equal(&result.digest, &storm->problem->digests[i]))
            trace_fail(storm->now_ns, "search %u has another digest than the calm run", i);
        TRACE_CHECK(storm->now_ns, result.evaluations == storm->problem->samples[i]);
    }
}

static void storm_check_leases(const struct storm *storm)
{
    struct schedule_counters counters;
    dispatcher_counters(storm->coordinator.dispatcher, &counters);
    TRACE_CHECK(storm->now_ns, counters.batches_leased == 0);
    TRACE_CHECK(storm->now_ns, counters.batches_waiting == 0);
}

// In calm weather nothing is handed out again, and nothing is done twice but a copy or two. A batch
// whose box has to be fetched is an exception: batches whose box is there overtake it, and when
// they are long ones it is late, or its lease lapses, although nothing was lost. Each step of an
// attack has such a box.
static void storm_check_calm(const struct storm *storm, const struct storm_report *report)
{
    const struct schedule_counters *counters = &report->counters;
    const uint64_t released_max = storm->coordinator.boxes_by_request ? CALM_RELEASED_MAX : 0;
    const uint64_t again = counters->released + counters->copies;
    TRACE_CHECK(storm->now_ns, counters->released <= released_max);
    TRACE_CHECK(storm->now_ns, counters->copies <= CALM_COPIES_MAX + released_max);
    TRACE_CHECK(storm->now_ns, counters->duplicates <= again);
    TRACE_CHECK(storm->now_ns, counters->unknown <= counters->released);
    TRACE_CHECK(storm->now_ns, report->evaluated == report->samples || again > 0);
}

static void storm_report(const struct storm *storm, int64_t cleared_ns, struct storm_report *report)
{
    *report = (struct storm_report){
        .end_ns = storm->now_ns,
        .after_ns = MAX(storm->now_ns - cleared_ns, 0),
        .workers = storm->worker_count,
        .faults = storm->faults,
        .packets = storm->network.sent,
        .batches = storm->coordinator.batches_sent,
    };
    for (uint32_t i = 0; i < storm->coordinator.search_count; i++)
        report->samples += storm->problem->samples[i];
    for (uint32_t place = 1; place <= storm->worker_count; place++)
        report->evaluated += storm->workers[place].evaluated;
    coordinator_node_counters(&storm->coordinator, &report->counters);
}

void storm_run(const struct problem *problem, uint64_t seed, bool calm, struct storm_report *report)
{
    struct storm *storm = g_new0(struct storm, 1);
    storm->problem = problem;
    storm->dice.seed = seed;
    storm_draw(storm, calm);
    const int64_t cleared_ns = storm->clear_ns;
    const double after_max_ns = storm_after_max_ns(storm);
    while (!coordinator_node_done(&storm->coordinator)) {
        storm_step(storm);
        if (!calm)
            TRACE_CHECK(storm->now_ns, (double)(storm->now_ns - cleared_ns) < after_max_ns);
    }
    storm_check_results(storm);
    storm_check_leases(storm);
    storm_report(storm, cleared_ns, report);
    if (calm)
        storm_check_calm(storm, report);
    for (uint32_t place = 1; place <= storm->worker_count; place++)
        worker_node_fini(&storm->workers[place]);
    coordinator_node_fini(&storm->coordinator);
    network_fini(&storm->network);
    g_free(storm);
}
