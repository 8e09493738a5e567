// A worker's intake: batches for scenarios and boxes that are known, asked for, wrong or never
// come, texts in pieces that overlap, lie or end early. The first two bytes are the size of a
// scenario's text that follows, which some batches name by its right digest; then come records.
#include "tests/fuzz/fuzz.h"

#include "worker/batch/intake.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { DESIGNS = 240 }; // this byte or a greater one: a record of given designs
enum { RECORDS_MAX = 300, BOUNDS_MAX = 64, TEXT_MAX = 1024 * 1024 };

enum what { BATCH, TEXT, WHOLE_TEXT, REQUEST, TAKE, DONE, LATER, WHAT_COUNT };

struct world {
    struct intake *intake;
    struct fuzz_input input;
    const uint8_t *text;
    size_t text_size;
    struct digest digest; // of the text
    int64_t now_ns;
    struct intake_work taken[16];
    unsigned taken_count;
};

static struct digest any_digest(struct world *world)
{
    uint8_t pick = fuzz_byte(&world->input);
    return pick < 128 ? world->digest : (struct digest){.bytes = {pick}};
}

static void give_batch(struct world *world)
{
    double bounds[BOUNDS_MAX];
    struct intake_batch batch = {
        .run = 1 + fuzz_byte(&world->input) % 4,
        .coordinator = 1 + fuzz_byte(&world->input) % 4,
        .scenario = any_digest(world),
        .box = any_digest(world),
        .identity = {.batch = fuzz_byte(&world->input),
                     .step = fuzz_byte(&world->input),
                     .first = fuzz_u16(&world->input),
                     .count = 1 + fuzz_byte(&world->input)},
        .sampling = {.seed = 1, .samples = 1 << 20},
        .variables = 1 + fuzz_byte(&world->input) % BOUNDS_MAX,
        .text_size = fuzz_byte(&world->input) % sizeof bounds,
        .text = (const uint8_t *)bounds,
    };
    // Bounds, of which the last bytes may be attacks.
    const uint32_t variables = batch.variables;
    for (uint32_t i = 0; i < BOUNDS_MAX; i++)
        bounds[i] = (i < variables ? 1.0 : 2.0) * fuzz_byte(&world->input);
    if (fuzz_byte(&world->input) < 128)
        batch.sampling.method = SAMPLING_METHOD_MOVES;
    if (batch.text_size > 0 && fuzz_byte(&world->input) < 200)
        batch.box = digest_of(bounds, batch.text_size);
    struct error error = {0};
    enum status status = intake_batch(world->intake, &batch, world->now_ns, &error);
    assert(status == STATUS_OK || error.text[0] != '\0');
}

// What check.c lets through: as many values for each design, all finite.
static void give_designs(struct world *world)
{
    double values[BOUNDS_MAX];
    const uint32_t count = 1 + fuzz_byte(&world->input) % 8;
    const uint32_t each = 1 + fuzz_byte(&world->input) % (BOUNDS_MAX / 8);
    for (uint32_t i = 0; i < count * each; i++)
        values[i] = fuzz_byte(&world->input);
    const struct intake_batch batch = {
        .run = 1,
        .coordinator = 1,
        .scenario = any_digest(world),
        .identity = {.batch = fuzz_byte(&world->input),
                     .first = fuzz_u16(&world->input),
                     .count = count},
        .designs = values,
        .design_value_count = count * each,
    };
    struct error error = {0};
    enum status status = intake_batch(world->intake, &batch, world->now_ns, &error);
    assert(status == STATUS_OK || error.text[0] != '\0');
}

static void give_text(struct world *world, const uint8_t *piece, size_t size, uint32_t offset,
                      uint32_t total)
{
    struct digest digest = any_digest(world);
    struct error error = {0};
    // What check.c lets through.
    if (size == 0 || total == 0 || total > TEXT_MAX || size > total || offset > total - size)
        return;
    enum status status = intake_text(world->intake, &digest, total, offset, piece, (uint32_t)size,
                                     world->now_ns, &error);
    assert(status == STATUS_OK || error.text[0] != '\0');
}

static void take(struct world *world)
{
    struct intake_work *work = &world->taken[world->taken_count];
    if (world->taken_count == sizeof world->taken / sizeof world->taken[0] ||
        !intake_take(world->intake, work))
        return;
    world->taken_count++;
    assert(work->scenario != NULL);
    const uint32_t variables = work->scenario->design_space.count;
    const struct intake_batch *batch = &work->batch;
    if (work->box == NULL)
        assert(batch->designs != NULL &&
               batch->design_value_count == batch->identity.count * variables);
    else
        assert(batch->designs == NULL && work->box->count == variables);
}

static void give_record(struct world *world)
{
    struct fuzz_input *input = &world->input;
    struct intake_request request;
    const uint8_t what = fuzz_byte(input);
    if (what >= DESIGNS) {
        give_designs(world);
        return;
    }
    switch (what % WHAT_COUNT) {
    case BATCH:
        give_batch(world);
        break;
    case TEXT: {
        uint32_t offset = fuzz_u16(input), total = fuzz_u32(input);
        size_t size;
        const uint8_t *piece = fuzz_bytes(input, fuzz_byte(input), &size);
        give_text(world, piece, size, offset, total);
        break;
    }
    case WHOLE_TEXT: {
        size_t from = fuzz_u16(input), size = fuzz_u16(input);
        from = from < world->text_size ? from : world->text_size;
        size = size < world->text_size - from ? size : world->text_size - from;
        give_text(world, world->text + from, size, (uint32_t)from, (uint32_t)world->text_size);
        break;
    }
    case REQUEST:
        while (intake_request(world->intake, world->now_ns, &request))
            ;
        break;
    case TAKE:
        take(world);
        break;
    case DONE:
        if (world->taken_count > 0)
            intake_done(world->intake, &world->taken[--world->taken_count]);
        break;
    default:
        world->now_ns += (int64_t)fuzz_byte(input) * 20000000;
        break;
    }
    assert(intake_queue(world->intake) <= INTAKE_QUEUE_MAX);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct world world = {.input = {.data = data, .size = size}};
    size_t wanted = fuzz_u16(&world.input);
    world.text = fuzz_bytes(&world.input, wanted, &world.text_size);
    world.digest = digest_of(world.text, world.text_size);
    world.intake = intake_create();
    for (unsigned i = 0; i < RECORDS_MAX && world.input.size > 0; i++)
        give_record(&world);
    while (world.taken_count > 0)
        intake_done(world.intake, &world.taken[--world.taken_count]);
    intake_free(world.intake);
    return 0;
}
