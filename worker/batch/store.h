// Scenarios and boxes by the digest of their text: those that batches wait for, those in use, and
// the ones used last, kept because the next batch will most likely want them again.
//
//              acquired                text whole             released by all
//   (nothing) ----------> missing ------------------> in use -----------------> idle
//                         |  released by all            ^  acquired again        |
//                         v                             +------------------------+
//                      forgotten <--------------------- room is needed, unused for longest
#ifndef SOBOX_WORKER_BATCH_STORE_H
#define SOBOX_WORKER_BATCH_STORE_H

#include "common/base/error.h"
#include "common/numeric/digest.h"
#include "common/sampling/moves.h"
#include "common/scenario/scenario.h"
#include "worker/batch/text.h"
#include "worker/models/model.h"

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

enum item_kind { ITEM_SCENARIO, ITEM_BOX, ITEM_KIND_COUNT };

enum {
    // Pieces of unfinished texts kept at once [bytes]. A text that does not fit beside those asked
    // for earlier waits for its turn, so the oldest always gets done.
    STORE_PARTIAL_SIZE_MAX = 8 << 20,
};

struct item {
    struct digest digest;
    enum item_kind kind;
    bool ready;
    uint32_t users; // batches that need it
    GList link;     // in the store's list of missing or of idle items; of none while in use

    // While it is missing.
    uint32_t variables;   // ITEM_BOX: what the batch that needed it first says of it
    uint64_t run;         // of the batch that needed it first
    struct text text;     // what has arrived of it
    int64_t ask_ns;       // when to ask for it
    int64_t interval_ns;  // until asking again
    uint32_t asked_count; // how often asked since the last new piece

    // Once it is ready.
    struct scenario scenario; // ITEM_SCENARIO, with
    struct model *model;      // the model made from it
    struct box box;           // ITEM_BOX, with
    struct moves moves;       // the attacks in it, if any
};

struct store {
    GHashTable *items[ITEM_KIND_COUNT]; // digest -> item
    uint32_t item_max[ITEM_KIND_COUNT];
    uint64_t scenario_size_max; // of the texts of all ready scenarios [bytes]
    uint64_t scenario_size;
    GQueue idle[ITEM_KIND_COUNT]; // unused for longest first
    GQueue missing;               // needed for longest first
    uint64_t partial_size;        // of all unfinished texts [bytes]
};

void store_init(struct store *store, uint32_t scenario_max, uint64_t scenario_size_max,
                uint32_t box_max);
void store_fini(struct store *store);

// The item of that digest, with one user more: ready, or missing and to be asked for from `now_ns`
// on. NULL when there is no room, because as many, or as great ones, as may be
// kept are all in use.
struct item *store_acquire(struct store *store, enum item_kind kind, const struct digest *digest,
                           uint64_t run, int64_t now_ns);

// One user less. What nobody uses any more is kept when it is ready, else forgotten.
void store_release(struct store *store, struct item *item);

// The item of that digest if it is missing, else NULL.
struct item *store_missing(struct store *store, enum item_kind kind, const struct digest *digest);

// Takes in a piece of a missing item's text, 0 <= offset, 0 < size, offset + size <= total. A size
// that no text of its kind has is ignored.
enum text_progress store_piece(struct store *store, struct item *item, uint32_t total,
                               uint32_t offset, const uint8_t *piece, uint32_t size);

// Makes a missing item, whose text is whole, ready. The text is released either way.
// Errors: STATUS_INVALID (not the text of that digest; a scenario that cannot be read; a box of odd
// size, not finite, or upside down).
enum status store_finish(struct store *store, struct item *item, struct error *error) MUST_USE;

// Makes a missing box ready from its text that came another way.
// Errors: STATUS_INVALID as store_finish().
enum status store_finish_box(struct store *store, struct item *item, const uint8_t *text,
                             uint32_t size, struct error *error) MUST_USE;

#endif
