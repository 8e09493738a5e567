#include "coordinator/report/seeds.h"

#include <math.h>
#include <string.h>

// Mean and sum of squares about it, search by search (Welford).
struct running {
    double mean, squares;
};

static void running_take(struct running *running, uint32_t count, double value)
{
    const double before = value - running->mean;
    running->mean += before / count;
    running->squares += before * (value - running->mean);
}

// NAN where one value alone says nothing.
static double running_spread(const struct running *running, uint32_t count)
{
    return count > 1 ? sqrt(running->squares / (count - 1)) : NAN;
}

bool seeds_alone(const struct run_data *data)
{
    return data->axes[0] != NULL && data->axes[1] == NULL &&
           strcmp(data->axes[0], "search.seed") == 0;
}

// The reading in progress.
struct reading {
    struct seeds *seeds;
    struct running log_volume;
    struct running *sides; // (2 x variables)
    bool best_done;
};

static bool is_better(const struct reading *reading, bool done, double log_volume)
{
    if (reading->seeds->searches == 0 || done != reading->best_done)
        return reading->seeds->searches == 0 || done;
    return log_volume > reading->seeds->log_volume;
}

static void take_search(struct reading *reading, uint32_t index,
                        const struct run_data_search *search)
{
    struct seeds *seeds = reading->seeds;
    if (search->box == NULL || !search->record.finished)
        return;
    const bool done = strcmp(search->status, "done") == 0;
    if (is_better(reading, done, search->log_volume)) {
        seeds->best = index;
        seeds->log_volume = search->log_volume;
        reading->best_done = done;
    }
    if (seeds->searches++ == 0) {
        box_init(&seeds->spread, search->box->count);
        reading->sides = g_new0(struct running, 2 * (size_t)search->box->count);
        seeds->log_volume_least = search->log_volume;
    }
    seeds->log_volume_least = fmin(seeds->log_volume_least, search->log_volume);
    running_take(&reading->log_volume, seeds->searches, search->log_volume);
    for (uint32_t v = 0; v < seeds->spread.count; v++) {
        running_take(&reading->sides[2 * v], seeds->searches, search->box->lower[v]);
        running_take(&reading->sides[2 * v + 1], seeds->searches, search->box->upper[v]);
    }
}

enum status seeds_read(const struct run_data *data, struct seeds *seeds, struct error *error)
{
    *seeds = (struct seeds){0};
    struct reading reading = {.seeds = seeds};
    enum status status = STATUS_OK;
    for (uint32_t i = 0; i < data->run.search_count && status == STATUS_OK; i++) {
        struct run_data_search search;
        status = run_data_load(data, i, &search, error);
        if (status == STATUS_OK)
            take_search(&reading, i, &search);
        run_data_release(&search);
    }
    seeds->log_volume_mean = reading.log_volume.mean;
    seeds->log_volume_spread = running_spread(&reading.log_volume, seeds->searches);
    for (uint32_t v = 0; v < seeds->spread.count; v++) {
        seeds->spread.lower[v] = running_spread(&reading.sides[2 * v], seeds->searches);
        seeds->spread.upper[v] = running_spread(&reading.sides[2 * v + 1], seeds->searches);
    }
    g_free(reading.sides);
    if (status != STATUS_OK)
        seeds_fini(seeds);
    return status;
}

void seeds_fini(struct seeds *seeds)
{
    box_fini(&seeds->spread);
    *seeds = (struct seeds){0};
}

enum status seeds_shown(const struct run_data *data, uint32_t *index, struct error *error)
{
    *index = 0;
    if (!seeds_alone(data))
        return STATUS_OK;
    struct seeds seeds;
    enum status status = seeds_read(data, &seeds, error);
    *index = seeds.best;
    seeds_fini(&seeds);
    return status;
}

int seeds_decimals(double spread, int most)
{
    if (!(spread > 0))
        return most;
    const int decimals = -(int)floor(log10(spread));
    return decimals < most ? decimals : most;
}
