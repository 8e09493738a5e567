// The simulated coordinator: the real dispatcher, the real searches and the real rule for opening
// them, and a model of the threads they run in. Virtual time passes while a thread works, and what
// comes meanwhile waits for it:
//
//     packet --> LCM's thread --> loop: dispatcher_take(), batches sent, steps written
//                                   ^                     | a step is sampled
//                                   +--- trimming threads +
//
// Verdicts are not sent: when all samples of a step are counted they are computed here, which gives
// the same ones.
#ifndef SOBOX_TESTS_BENCH_SCALE_CENTRE_H
#define SOBOX_TESTS_BENCH_SCALE_CENTRE_H

#include "coordinator/dispatch/dispatcher.h"
#include "coordinator/runtime/opening.h"
#include "coordinator/search/search.h"
#include "tests/bench/scale/fleet.h"
#include "worker/models/model.h"

struct centre_search {
    struct search *search; // NULL unless it is open
    struct search_request request;
    struct heap_entry trim; // when its trim is done
};

// How long its threads have worked so far [ns].
struct centre_busy {
    double loop;
    double listen;
    double trim; // all trimming threads together
};

struct centre {
    const struct costs *costs;
    const struct scenario *scenario; // of all searches, each with a seed of its own
    struct model *model;
    struct network *network;
    struct fleet *fleet;
    GHashTable *places; // sender number -> place

    struct dispatcher *dispatcher;
    struct opening opening;
    struct centre_search *searches; // (search_count)
    uint32_t search_count;
    uint32_t search_next; // to be opened
    uint32_t done_count;
    bool opening_due; // an opening is among `jobs`

    int64_t loop_ns;   // the loop is busy until then
    int64_t listen_ns; // so is LCM's thread
    struct heap jobs;  // for the loop, by when they are there
    uint64_t job_count;
    uint32_t trimmers;
    uint32_t trimming;     // in work
    uint32_t trims;        // given to the threads and not back on the loop
    GQueue trims_waiting;  // of struct centre_search
    struct heap trims_due; // those in work

    struct centre_busy busy;
    uint64_t samples; // counted
};

void centre_init(struct centre *centre, const struct costs *costs, const struct scenario *scenario,
                 const struct schedule_settings *settings, uint32_t search_count, uint32_t trimmers,
                 struct network *network, struct fleet *fleet);
void centre_fini(struct centre *centre);

// A packet has arrived; it is the centre's from now on.
void centre_receive(struct centre *centre, struct packet *packet, int64_t now_ns);

// Does what its threads get done at `now_ns`, and when they will next get something done.
void centre_wake(struct centre *centre, int64_t now_ns);
int64_t centre_wake_ns(const struct centre *centre);

#endif
