#include "coordinator/runtime/opening.h"

#include "common/protocol/protocol.h"

#include <assert.h>
#include <unistd.h>

_Static_assert(2 * (int)OPENING_MAX <= (int)PROTOCOL_SCENARIO_MAX,
               "workers must keep all open scenarios of two coordinators");

// The coordinator's share of the machine's memory: workers and the system's cache of the journal
// want some too.
enum { MEMORY_DIVISOR = 4 };

// Of the bad samples a search knows at most so many bytes are kept (SEARCH_ARCHIVE of search.c),
// and a list that grows by doubling may have that much room again.
#define OPENING_ARCHIVE_SIZE (UINT64_C(2) << 26)

// What a search takes at its beginning, beside its variables [bytes].
#define OPENING_BASE_SIZE (UINT64_C(64) << 10)

struct opening opening_default(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long page_size = sysconf(_SC_PAGESIZE);
    const uint64_t size = pages > 0 && page_size > 0 ? (uint64_t)pages * (uint64_t)page_size : 0;
    return (struct opening){.memory_size = size / MEMORY_DIVISOR};
}

uint64_t opening_size(const struct scenario *scenario)
{
    const struct scenario_search *search = &scenario->search;
    const uint64_t steps = (uint64_t)search->exploration_steps + search->consolidation_steps;
    const uint64_t row = (uint64_t)scenario->design_space.count * sizeof(double);
    // A third of the samples is bad, and lists that grow by doubling have room for twice what is in
    // them; scratch and verdicts of a step come on top.
    const uint64_t known = steps * search->samples * row * 2 / 3;
    const uint64_t step = search->samples * (row + 2 * sizeof(uint32_t)) + 1024 * row;
    return OPENING_BASE_SIZE + step + (known < OPENING_ARCHIVE_SIZE ? known : OPENING_ARCHIVE_SIZE);
}

void opening_open(struct opening *opening, const struct scenario *scenario)
{
    const uint64_t size = opening_size(scenario);
    opening->open_count++;
    opening->open_size += size;
    if (size > opening->greatest_size)
        opening->greatest_size = size;
}

void opening_close(struct opening *opening, const struct scenario *scenario)
{
    const uint64_t size = opening_size(scenario);
    assert(opening->open_count > 0);
    assert(opening->open_size >= size);
    opening->open_count--;
    opening->open_size -= size;
}

bool opening_wanted(const struct opening *opening, const struct schedule_counters *counters,
                    double trims)
{
    if (opening->open_count == 0)
        return true;
    if (opening->open_count >= OPENING_MAX || trims >= OPENING_TRIMS_MAX ||
        counters->workers == 0 || counters->batches_waiting > 0)
        return false;
    return opening->open_count < OPENING_LEAST ||
           opening->open_size + opening->greatest_size <= opening->memory_size;
}
