#include "messages.h"

#include "common/wire/source.h"

// With which the wires are opened: everything here holds in clear and sealed.
static struct key *shared_key;

static int with_a_key(void **state)
{
    static const uint8_t bytes[KEY_SIZE] = {1, 2, 3};
    (void)state;
    shared_key = key_create(bytes);
    return shared_key == NULL;
}

static int without_the_key(void **state)
{
    (void)state;
    key_free(shared_key);
    return 0;
}

// What the handler saw last.
struct seen {
    struct wire *wire;
    unsigned count[WIRE_KIND_COUNT];
    union codec_message last; // arrays are not kept
    uint8_t text_last;        // byte of the last batch that has a text
    enum wire_kind answer;    // published from within the handler; WIRE_KIND_COUNT: nothing
};

static void note(void *user, enum wire_kind kind, const void *message)
{
    static const size_t sizes[WIRE_KIND_COUNT] = {
#define SIZE(value, name) [value] = sizeof(sobox_##name##_t),
        CODEC_LIST(SIZE)
#undef SIZE
    };
    struct seen *seen = user;
    seen->count[kind]++;
    memcpy(&seen->last, message, sizes[kind]);
    if (kind == WIRE_SAMPLE_BATCH && seen->last.sample_batch.text_size > 0)
        seen->text_last = seen->last.sample_batch.text[seen->last.sample_batch.text_size - 1];
    if (seen->answer != WIRE_KIND_COUNT) {
        union codec_message answer;
        message_make(seen->answer, &answer);
        assert_int_equal(wire_publish(seen->wire, seen->answer, &answer), STATUS_OK);
    }
}

// A wire over memq:// with all kinds subscribed to.
static struct wire *wire_all(struct seen *seen, uint32_t mtu)
{
    struct wire_settings settings = wire_settings_default();
    struct wire *wire = NULL;
    settings.mtu = mtu;
    settings.key = shared_key;
    assert_int_equal(wire_open(&wire, &settings, MESSAGE_SENDER, NULL), STATUS_OK);
    *seen = (struct seen){.wire = wire, .answer = WIRE_KIND_COUNT};
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        assert_int_equal(wire_subscribe(wire, kind, note, seen, NULL), STATUS_OK);
    return wire;
}

static enum status publish(struct wire *wire, enum wire_kind kind)
{
    union codec_message message;
    message_make(kind, &message);
    return wire_publish(wire, kind, &message);
}

// The coordinator with a worker inside needs every kind to come back to its own process.
static void every_kind_comes_back_over_memq(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        assert_int_equal(publish(wire, kind), STATUS_OK);
    assert_int_equal(wire_dispatch(wire, 100), WIRE_KIND_COUNT);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        assert_int_equal(seen.count[kind], 1);
    assert_int_equal(wire_heard(wire), WIRE_KIND_COUNT);
    wire_close(wire);
}

// The header is the wire's business: the caller's values there must not travel.
static void publishing_fills_the_header(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    union codec_message message;
    for (int i = 0; i < 3; i++) {
        message_make(WIRE_TEXT_REQUEST, &message);
        message.header = (sobox_header_t){.protocol = 99, .sequence = 99, .sender = 99, .run = 4};
        assert_int_equal(wire_publish(wire, WIRE_TEXT_REQUEST, &message), STATUS_OK);
        assert_int_equal(wire_dispatch(wire, 1), 1);
        assert_int_equal(seen.last.header.protocol, WIRE_PROTOCOL);
        assert_int_equal(seen.last.header.sequence, i);
        assert_int_equal(seen.last.header.sender, MESSAGE_SENDER);
        assert_int_equal(seen.last.header.run, 4);
    }
    wire_close(wire);
}

// Payloads of exactly wire_payload_max() travel whole, one element more is refused: the figure is
// what the schedule and the texts cut their messages to.
static void payload_fills_the_mtu_and_no_more(void **state)
{
    (void)state;
    static const uint32_t mtus[] = {WIRE_MTU_DEFAULT, 9000, WIRE_MTU_MAX};
    for (size_t i = 0; i < 3; i++) {
        struct seen seen;
        struct wire *wire = wire_all(&seen, mtus[i]);
        union codec_message message;
        message_make(WIRE_SAMPLE_BATCH, &message);
        size_t bytes = wire_payload_max(wire, WIRE_SAMPLE_BATCH);
        const int32_t count = (int32_t)bytes;
        static uint8_t text[WIRE_MTU_MAX];
        text[count - 1] = 77;
        message.sample_batch.text = text;
        message.sample_batch.text_size = count;
        assert_int_equal(wire_publish(wire, WIRE_SAMPLE_BATCH, &message), STATUS_OK);
        text[count - 1] = 0;
        message.sample_batch.text_size = count + 1;
        assert_int_equal(wire_publish(wire, WIRE_SAMPLE_BATCH, &message), STATUS_INVALID);

        message_make(WIRE_TEXT, &message);
        message.text.piece_size = (int32_t)wire_payload_max(wire, WIRE_TEXT);
        message.text.total_size = 1 << 20;
        message.text.offset = 0;
        assert_int_equal(wire_publish(wire, WIRE_TEXT, &message), STATUS_OK);
        message.text.piece_size++;
        assert_int_equal(wire_publish(wire, WIRE_TEXT, &message), STATUS_INVALID);

        assert_int_equal(wire_dispatch(wire, 100), 2);
        assert_int_equal(seen.count[WIRE_SAMPLE_BATCH], 1);
        assert_int_equal(seen.text_last, 77);
        assert_int_equal(seen.count[WIRE_TEXT], 1);
        assert_int_equal(wire_payload_max(wire, WIRE_RUN_STATUS), 0);
        wire_close(wire);
    }
}

// What every receiver would refuse is not sent: the mistake shows where it was made.
static void invalid_message_is_not_sent(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    union codec_message message;
    message_make(WIRE_SAMPLE_BATCH, &message);
    message.sample_batch.text_size = -1;
    assert_int_equal(wire_publish(wire, WIRE_SAMPLE_BATCH, &message), STATUS_INVALID);
    message.sample_batch.text_size = 0x20000001;
    assert_int_equal(wire_publish(wire, WIRE_SAMPLE_BATCH, &message), STATUS_INVALID);
    assert_int_equal(wire_dispatch(wire, 1), 0);
    wire_close(wire);
}

// Timers must get their turn while messages wait: dispatch stops at its limit and leaves the rest.
static void dispatch_stops_at_its_limit(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    for (int i = 0; i < 10; i++)
        assert_int_equal(publish(wire, WIRE_TEXT), STATUS_OK);
    assert_int_equal(wire_dispatch(wire, 4), 4);
    assert_int_equal(seen.count[WIRE_TEXT], 4);
    assert_int_equal(wire_dispatch(wire, 100), 6);
    assert_int_equal(wire_dispatch(wire, 100), 0);
    wire_close(wire);
}

// A worker inside the process answers from within the handler, while LCM is in its own.
static void handler_may_publish(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    seen.answer = WIRE_OUTCOME_BATCH;
    assert_int_equal(publish(wire, WIRE_SAMPLE_BATCH), STATUS_OK);
    assert_int_equal(wire_dispatch(wire, 3), 3); // each answer is answered again
    assert_int_equal(seen.count[WIRE_SAMPLE_BATCH], 1);
    assert_int_equal(seen.count[WIRE_OUTCOME_BATCH], 2);
    wire_close(wire);
}

// memq:// itself grows without end; a handler that never gets its turn must not.
static void memq_queue_is_bounded(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    struct wire_counters counters;
    unsigned sent = 0;
    while (sent < 1000000 && publish(wire, WIRE_TEXT_REQUEST) == STATUS_OK)
        sent++;
    assert_in_range(sent, 1000, 100000);
    assert_int_equal(wire_dispatch(wire, 1), 1);
    assert_int_equal(publish(wire, WIRE_TEXT_REQUEST), STATUS_OK);
    while (wire_dispatch(wire, 1000) > 0)
        ;
    wire_counters(wire, &counters);
    assert_int_equal(counters.published, sent + 1);
    assert_int_equal(counters.received, sent + 1);
    assert_int_equal(counters.failed, 1);
    assert_int_equal(counters.lost, 1); // the refused one has left a gap
    wire_close(wire);
}

// Nobody listens to a kind without a handler; sending it is no error and fills nothing.
static void unheard_kind_is_sent_and_forgotten(void **state)
{
    (void)state;
    struct wire_settings settings = wire_settings_default();
    struct wire *wire = NULL;
    assert_int_equal(wire_open(&wire, &settings, MESSAGE_SENDER, NULL), STATUS_OK);
    for (int i = 0; i < 20000; i++)
        assert_int_equal(publish(wire, WIRE_SEARCH_STATUS), STATUS_OK);
    int descriptors[WIRE_PORT_COUNT];
    assert_int_equal(wire_descriptors(wire, descriptors), 0);
    assert_int_equal(wire_dispatch(wire, 10), 0);
    wire_close(wire);
}

// The main loop polls the wire: one turn of it delivers what was published before.
static void source_delivers_in_the_main_loop(void **state)
{
    (void)state;
    struct seen seen;
    struct wire *wire = wire_all(&seen, WIRE_MTU_DEFAULT);
    wire_source_attach(wire);
    wire_source_attach(wire); // again, as after wire_reopen()
    for (int i = 0; i < 100; i++)
        assert_int_equal(publish(wire, WIRE_TEXT), STATUS_OK);
    while (g_main_context_iteration(NULL, FALSE))
        ;
    assert_int_equal(seen.count[WIRE_TEXT], 100);
    assert_int_equal(wire_reopen(wire, NULL), STATUS_OK); // memq:// is left alone
    wire_close(wire);                                     // takes the source with it
    assert_false(g_main_context_iteration(NULL, FALSE));
}

// What cannot work is refused with a sentence, before LCM gets to see it.
static void unusable_settings_are_refused(void **state)
{
    (void)state;
    struct wire *wire = NULL;
    struct error error;
    struct wire_settings settings = {.url = "tcpq://localhost:7700", .mtu = WIRE_MTU_DEFAULT};
    assert_int_equal(wire_open(&wire, &settings, 1, &error), STATUS_INVALID);
    assert_non_null(strstr(error.text, "tcpq://localhost:7700"));
    settings = (struct wire_settings){.url = "memq://", .mtu = WIRE_MTU_MAX + 1};
    assert_int_equal(wire_open(&wire, &settings, 1, &error), STATUS_INVALID);
    settings.mtu = 100;
    assert_int_equal(wire_open(&wire, &settings, 1, &error), STATUS_INVALID);
    assert_null(wire);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_comes_back_over_memq),
        cmocka_unit_test(publishing_fills_the_header),
        cmocka_unit_test(payload_fills_the_mtu_and_no_more),
        cmocka_unit_test(invalid_message_is_not_sent),
        cmocka_unit_test(dispatch_stops_at_its_limit),
        cmocka_unit_test(handler_may_publish),
        cmocka_unit_test(memq_queue_is_bounded),
        cmocka_unit_test(unheard_kind_is_sent_and_forgotten),
        cmocka_unit_test(source_delivers_in_the_main_loop),
        cmocka_unit_test(unusable_settings_are_refused),
    };
    int failed = cmocka_run_group_tests_name("in clear", tests, NULL, NULL);
    return failed + cmocka_run_group_tests_name("sealed", tests, with_a_key, without_the_key);
}
