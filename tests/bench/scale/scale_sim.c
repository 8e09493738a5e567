// How many workers a coordinator keeps busy: the real dispatcher and the real searches on the
// simulated network and clock of tests/cluster, with what everything costs as measured (costs.h).
// Prints CSV, a row a cluster; tests/bench/README.md says what they mean.
//
//     scale_sim [--help] [--workers N,N,...] [--searches N] ...
//
// Without options it goes through the whole grid, some minutes on one core.
#include "common/scenario/scenario_read.h"
#include "tests/bench/scale/centre.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WINDOW_BEGIN \
    0.25 // share of the samples after which workers and schedule are in their stride

enum { LIST_MAX = 32 };

// What is simulated.
struct cluster {
    struct costs costs;
    uint32_t workers;
    uint32_t threads; // of a worker
    uint32_t searches;
    uint32_t samples; // a step
    double round_trip_ns;
    double loss;
    uint32_t mtu; // [bytes]
    uint32_t trimmers;
    uint64_t seed;
};

struct figures {
    double efficiency; // of all cores' time, what went into samples that count
    double samples_s;
    double batches_s;
    double loop; // share of the time in which it was busy
    double listen;
    double trim;
    double open;      // searches, at the end
    double step_trim; // share of an open search's time in which its step is trimmed
    uint64_t released;
    uint64_t copies;
};

// A moment of the simulation.
struct mark {
    int64_t ns;
    uint64_t samples;
    struct centre_busy busy;
    struct schedule_counters counters;
};

// Four variables and a ball: cheap to sample and to trim for real, and a quarter to a third of the
// samples is bad, as in any search. Steps enough that no search ends.
static const char yaml[] = "name: scale\n"
                           "model: hypersphere\n"
                           "variables:\n"
                           "  - {name: x_1, lower: -1, upper: 1}\n"
                           "  - {name: x_2, lower: -1, upper: 1}\n"
                           "  - {name: x_3, lower: -1, upper: 1}\n"
                           "  - {name: x_4, lower: -1, upper: 1}\n"
                           "constraints: {distance: {max: 0}}\n";

static void read_scenario(struct scenario *scenario, const struct cluster *cluster)
{
    char samples[64];
    g_snprintf(samples, sizeof samples, "search.samples=%u", cluster->samples);
    const char *const overrides[] = {samples};
    struct error error = {0};
    if (scenario_read_text(scenario, "scale", yaml, sizeof yaml - 1, overrides, 1, &error) !=
        STATUS_OK) {
        fprintf(stderr, "scale_sim: %s\n", error.text);
        exit(EXIT_FAILURE);
    }
}

// ---- One cluster ----

// Samples to go through: some steps of each search that can be open, and some batches for each
// worker; and a bound, because each is sampled and trimmed for real.
static uint64_t samples_wanted(const struct cluster *cluster,
                               const struct schedule_settings *settings)
{
    const uint64_t steps = (cluster->searches > 1 ? 4 : 25) *
                           (uint64_t)MIN(cluster->searches, OPENING_MAX) * cluster->samples;
    const uint64_t batch = MIN(settings->batch_samples_max[VERDICT_DETAIL_FULL], cluster->samples);
    const uint64_t batches = 8 * (uint64_t)cluster->workers * batch;
    return cluster->searches > 1 ? MAX(steps, batches) : steps;
}

// As the coordinator's runtime sets it by the size of messages: 3.1 bytes a sample that is bad.
static struct schedule_settings settings_for(uint32_t mtu)
{
    struct schedule_settings settings = schedule_settings_default();
    const uint32_t payload = mtu - 160;
    settings.batch_samples_max[VERDICT_DETAIL_FULL] = MIN((uint32_t)(payload / 3.125), 65536);
    settings.batch_samples_max[VERDICT_DETAIL_SHARE] = MIN(payload * 8, 65536);
    return settings;
}

static void set_mark(struct mark *mark, const struct centre *centre, int64_t now_ns)
{
    *mark = (struct mark){.ns = now_ns, .samples = centre->samples, .busy = centre->busy};
    dispatcher_counters(centre->dispatcher, &mark->counters);
}

static void measure(struct figures *figures, const struct cluster *cluster,
                    const struct mark *begin, const struct mark *end)
{
    const double ns = (double)(end->ns - begin->ns);
    const double samples = (double)(end->samples - begin->samples);
    const double cores = (double)cluster->workers * cluster->threads;
    *figures = (struct figures){
        .efficiency = samples * cluster->costs.sample_ns / (cores * ns),
        .samples_s = samples / ns * 1e9,
        .batches_s =
            (double)(end->counters.batches_counted - begin->counters.batches_counted) / ns * 1e9,
        .loop = (end->busy.loop - begin->busy.loop) / ns,
        .listen = (end->busy.listen - begin->busy.listen) / ns,
        .trim = (end->busy.trim - begin->busy.trim) / ns / cluster->trimmers,
        .released = end->counters.released - begin->counters.released,
        .copies = end->counters.copies - begin->counters.copies,
    };
}

static void simulate(const struct cluster *cluster, struct figures *figures)
{
    struct dice dice = {.seed = cluster->seed};
    struct network network;
    struct fleet fleet;
    struct centre centre;
    struct scenario scenario;
    const struct schedule_settings settings = settings_for(cluster->mtu);
    read_scenario(&scenario, cluster);
    network_init(&network, &dice);
    network.weather = (struct weather){.loss = cluster->loss,
                                       .delay_ns = cluster->round_trip_ns / 2,
                                       .jitter_ns = cluster->round_trip_ns / 20,
                                       .stray_ns = 1};
    fleet_init(&fleet, &cluster->costs, &network, &dice, cluster->workers, cluster->threads);
    centre_init(&centre, &cluster->costs, &scenario, &settings, cluster->searches,
                cluster->trimmers, &network, &fleet);

    const uint64_t wanted = samples_wanted(cluster, &settings);
    struct mark begin = {0};
    struct mark end;
    int64_t now_ns = 0;
    while (centre.samples < wanted && centre.done_count < cluster->searches) {
        int64_t wake_ns = MIN(network_wake_ns(&network), fleet_wake_ns(&fleet));
        wake_ns = MIN(wake_ns, centre_wake_ns(&centre));
        now_ns = MAX(now_ns, wake_ns);
        struct packet *packet;
        while ((packet = network_receive(&network, now_ns)) != NULL) {
            if (packet->to == 0)
                centre_receive(&centre, packet, now_ns);
            else
                fleet_receive(&fleet, packet, now_ns);
        }
        fleet_wake(&fleet, now_ns);
        centre_wake(&centre, now_ns);
        if (begin.ns == 0 && (double)centre.samples >= WINDOW_BEGIN * (double)wanted)
            set_mark(&begin, &centre, now_ns);
    }
    set_mark(&end, &centre, now_ns);
    measure(figures, cluster, &begin, &end);
    figures->open = centre.opening.open_count;
    figures->step_trim = figures->trim * cluster->trimmers / MAX(figures->open, 1);
    centre_fini(&centre);
    fleet_fini(&fleet);
    network_fini(&network);
    scenario_fini(&scenario);
}

// ---- Printing ----

// What keeps the workers from having more to do: a thread of the coordinator, or that there are too
// few searches, each of which waits for its trim, or for messages to go there and back.
static const char *bottleneck(const struct figures *figures)
{
    if (figures->efficiency >= 0.9)
        return "workers";
    if (figures->loop >= 0.9)
        return "loop";
    if (figures->trim >= 0.9)
        return "trimmers";
    if (figures->listen >= 0.9)
        return "listening";
    if (figures->open >= OPENING_MAX)
        return "open searches";
    return figures->step_trim >= 0.5 ? "trim of a step" : "way of a step";
}

static void print_row(const struct cluster *cluster, const struct figures *figures)
{
    printf("%u,%u,%u,%u,%g,%g,%g,%u,%u,%.4g,%.4g,%.4g,%.3g,%.3g,%.3g,%g,%llu,%llu,%s\n",
           cluster->workers, cluster->threads, cluster->searches, cluster->samples,
           cluster->costs.sample_ns * 1e-3, cluster->round_trip_ns * 1e-6, 100 * cluster->loss,
           cluster->mtu, cluster->trimmers, 100 * figures->efficiency, figures->samples_s,
           figures->batches_s, 100 * figures->loop, 100 * figures->listen, 100 * figures->trim,
           figures->open, (unsigned long long)figures->released,
           (unsigned long long)figures->copies, bottleneck(figures));
    fflush(stdout);
}

// ---- The grid ----

struct list {
    double values[LIST_MAX];
    size_t count;
};

struct options {
    char *workers, *searches, *samples, *sample_us, *round_trip_ms, *loss;
    gint threads, mtu, trimmers;
    gdouble trim_sample_ns, send_ns, take_ns;
    gint64 seed;
    gdouble at_least;
};

static struct list read_list(const char *option, const char *text)
{
    struct list list = {0};
    char **parts = g_strsplit(text, ",", 0);
    for (char **part = parts; *part != NULL; part++) {
        char *end;
        const double value = g_ascii_strtod(*part, &end);
        if (end == *part || *end != '\0' || !isfinite(value) || value < 0 ||
            list.count == LIST_MAX) {
            fprintf(stderr, "scale_sim: --%s %s: expected at most %d numbers, as 1,2,3\n", option,
                    text, LIST_MAX);
            exit(2);
        }
        list.values[list.count++] = value;
    }
    g_strfreev(parts);
    return list;
}

static void expect(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "scale_sim: expected %s\n", what);
    exit(2);
}

static void check(const struct cluster *cluster)
{
    expect(cluster->workers >= 1 && cluster->workers < NETWORK_PLACE_MAX, "1 to 8,199 workers");
    expect(cluster->threads >= 1 && cluster->threads <= 4096, "1 to 4,096 threads");
    expect(cluster->searches >= 1 && cluster->searches <= 1000000, "1 to 1,000,000 searches");
    expect(cluster->samples >= 1 && cluster->samples <= 1000000, "1 to 1,000,000 samples");
    expect(cluster->costs.sample_ns > 0, "a sample to take some time");
    expect(cluster->loss < 0.5, "less than half of the packets to be lost");
    expect(cluster->mtu >= 1000 && cluster->mtu <= 60000, "an mtu of 1,000 to 60,000 bytes");
    expect(cluster->trimmers >= 1 && cluster->trimmers <= 4096, "1 to 4,096 trimming threads");
}

// Returns whether every cluster was used as well as was expected.
static bool run_grid(const struct options *options, struct cluster cluster)
{
    bool enough = true;
    const struct list workers = read_list("workers", options->workers);
    const struct list searches = read_list("searches", options->searches);
    const struct list samples = read_list("samples", options->samples);
    const struct list sample_us = read_list("sample-us", options->sample_us);
    const struct list round_trips = read_list("round-trip-ms", options->round_trip_ms);
    const struct list losses = read_list("loss", options->loss);
    expect(searches.count == samples.count, "as many values of --samples as of --searches");
    printf("workers,threads,searches,samples,sample_us,round_trip_ms,loss_percent,mtu,trimmers,"
           "efficiency_percent,samples_per_s,batches_per_s,loop_percent,listen_percent,"
           "trim_percent,open,released,copies,limit\n");
    for (size_t s = 0; s < searches.count; s++)
        for (size_t u = 0; u < sample_us.count; u++)
            for (size_t r = 0; r < round_trips.count; r++)
                for (size_t l = 0; l < losses.count; l++)
                    for (size_t w = 0; w < workers.count; w++) {
                        cluster.searches = (uint32_t)searches.values[s];
                        cluster.samples = (uint32_t)samples.values[s];
                        cluster.costs.sample_ns = 1e3 * sample_us.values[u];
                        cluster.round_trip_ns = 1e6 * round_trips.values[r];
                        cluster.loss = losses.values[l] / 100;
                        cluster.workers = (uint32_t)workers.values[w];
                        check(&cluster);
                        struct figures figures;
                        simulate(&cluster, &figures);
                        print_row(&cluster, &figures);
                        enough &= 100 * figures.efficiency >= options->at_least;
                    }
    return enough;
}

int main(int argc, char **argv)
{
    struct costs costs = costs_default();
    struct options options = {
        .threads = 16,
        .mtu = 1400,
        .trimmers = 16,
        .trim_sample_ns = costs.trim_sample_ns,
        .send_ns = costs.send_ns,
        .take_ns = costs.take_ns,
        .seed = 1,
    };
    const GOptionEntry entries[] = {
        {"workers", 0, 0, G_OPTION_ARG_STRING, &options.workers, "1,4,16,64,256,1024,4096", "N,.."},
        {"searches", 0, 0, G_OPTION_ARG_STRING, &options.searches, "1,100,10000", "N,.."},
        {"samples", 0, 0, G_OPTION_ARG_STRING, &options.samples,
         "a step of each of these: 20000,20000,200", "N,.."},
        {"sample-us", 0, 0, G_OPTION_ARG_STRING, &options.sample_us,
         "what one takes one core: 1,10,100,1000", "US,.."},
        {"round-trip-ms", 0, 0, G_OPTION_ARG_STRING, &options.round_trip_ms, "0.1,1", "MS,.."},
        {"loss", 0, 0, G_OPTION_ARG_STRING, &options.loss, "0,1", "PERCENT,.."},
        {"threads", 0, 0, G_OPTION_ARG_INT, &options.threads, "of a worker (16)", "N"},
        {"mtu", 0, 0, G_OPTION_ARG_INT, &options.mtu, "(1400)", "BYTES"},
        {"trimmers", 0, 0, G_OPTION_ARG_INT, &options.trimmers, "trimming threads (16)", "N"},
        {"trim-sample-ns", 0, 0, G_OPTION_ARG_DOUBLE, &options.trim_sample_ns, "see costs.h", "NS"},
        {"send-ns", 0, 0, G_OPTION_ARG_DOUBLE, &options.send_ns, "see costs.h", "NS"},
        {"take-ns", 0, 0, G_OPTION_ARG_DOUBLE, &options.take_ns, "see costs.h", "NS"},
        {"at-least", 0, 0, G_OPTION_ARG_DOUBLE, &options.at_least,
         "fail where less of the workers' time is used", "PERCENT"},
        {"seed", 0, 0, G_OPTION_ARG_INT64, &options.seed, "of everything (1)", "S"},
        {0},
    };
    GOptionContext *context = g_option_context_new("- how many workers a coordinator keeps busy");
    g_option_context_add_main_entries(context, entries, NULL);
    GError *error = NULL;
    if (!g_option_context_parse(context, &argc, &argv, &error)) {
        fprintf(stderr, "scale_sim: %s\n", error->message);
        return 2;
    }
    g_option_context_free(context);
    if (options.searches == NULL && options.samples == NULL)
        options.samples = g_strdup("20000,20000,200");
    options.searches = options.searches ? options.searches : g_strdup("1,100,10000");
    options.samples = options.samples ? options.samples : g_strdup("20000");
    options.workers = options.workers ? options.workers : g_strdup("1,4,16,64,256,1024,4096");
    options.sample_us = options.sample_us ? options.sample_us : g_strdup("1,10,100,1000");
    options.round_trip_ms = options.round_trip_ms ? options.round_trip_ms : g_strdup("0.1,1");
    options.loss = options.loss ? options.loss : g_strdup("0,1");
    costs.trim_sample_ns = options.trim_sample_ns;
    costs.send_ns = options.send_ns;
    costs.take_ns = options.take_ns;
    const bool enough = run_grid(&options, (struct cluster){.costs = costs,
                                                            .threads = (uint32_t)options.threads,
                                                            .mtu = (uint32_t)options.mtu,
                                                            .trimmers = (uint32_t)options.trimmers,
                                                            .seed = (uint64_t)options.seed});
    char *const texts[] = {options.workers,   options.searches,      options.samples,
                           options.sample_us, options.round_trip_ms, options.loss};
    for (size_t i = 0; i < G_N_ELEMENTS(texts); i++)
        g_free(texts[i]);
    return enough ? EXIT_SUCCESS : EXIT_FAILURE;
}
