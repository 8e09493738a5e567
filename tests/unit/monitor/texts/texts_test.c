// Scenarios asked for piece by piece, over a network that loses, doubles and lies.
#include "monitor/texts/texts.h"

#include "common/scenario/scenario_read.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { PIECE = 100 };

struct fixture {
    struct texts *texts;
    struct scenario scenario; // as the coordinator has it
};

static int setup(void **state)
{
    struct fixture *fixture = g_new0(struct fixture, 1);
    struct error error = {0};
    fixture->texts = texts_create();
    const enum status status = scenario_read_file(
        &fixture->scenario, SOBOX_SOURCE_DIR "/deploy/scenarios/sedan-two-springs.yaml", NULL, 0,
        &error);
    assert_int_equal(status, STATUS_OK);
    *state = fixture;
    return 0;
}

static int teardown(void **state)
{
    struct fixture *fixture = *state;
    texts_free(fixture->texts);
    scenario_fini(&fixture->scenario);
    g_free(fixture);
    return 0;
}

static bool hear_piece(struct fixture *fixture, size_t offset)
{
    const struct scenario *scenario = &fixture->scenario;
    sobox_text_t message = {
        .total_size = (int32_t)scenario->text_size,
        .offset = (int32_t)offset,
        .piece_size = (int32_t)MIN((size_t)PIECE, scenario->text_size - offset),
        .piece = (uint8_t *)scenario->text + offset,
    };
    memcpy(message.digest, scenario->digest.bytes, DIGEST_SIZE);
    return texts_heard(fixture->texts, &message);
}

static bool hear_all(struct fixture *fixture, size_t from)
{
    bool known = false;
    for (size_t offset = from; offset < fixture->scenario.text_size; offset += PIECE)
        known = hear_piece(fixture, offset);
    return known;
}

static void scenario_is_known_when_all_pieces_came(void **state)
{
    struct fixture *fixture = *state;
    assert_null(texts_find(fixture->texts, &fixture->scenario.digest));
    assert_true(texts_want(fixture->texts, 5, &fixture->scenario.digest, 0));
    sobox_text_request_t request;
    assert_true(texts_ask(fixture->texts, 0, &request));
    assert_int_equal(request.header.run, 5);
    assert_int_equal(request.offset, 0);
    assert_false(texts_ask(fixture->texts, TEXTS_AGAIN_NS - 1, &request));
    assert_true(hear_all(fixture, 0));
    const struct scenario *known = texts_find(fixture->texts, &fixture->scenario.digest);
    assert_non_null(known);
    assert_string_equal(known->springs[0].name, fixture->scenario.springs[0].name);
    assert_false(texts_waiting(fixture->texts));
    assert_false(texts_want(fixture->texts, 5, &fixture->scenario.digest, 0));
}

// Lost, doubled and late pieces: what is lacking is asked for from its first byte on.
static void lost_piece_is_asked_for_again(void **state)
{
    struct fixture *fixture = *state;
    texts_want(fixture->texts, 5, &fixture->scenario.digest, 0);
    sobox_text_request_t request;
    texts_ask(fixture->texts, 0, &request);
    hear_piece(fixture, 0);
    hear_piece(fixture, 0);
    hear_piece(fixture, 2 * PIECE);
    assert_true(texts_ask(fixture->texts, TEXTS_AGAIN_NS, &request));
    assert_int_equal(request.offset, PIECE);
    assert_true(hear_all(fixture, PIECE));
}

// Anyone may send a piece: a text that is not the one asked for is not believed, and the right one
// is taken after it.
static void lie_is_not_believed(void **state)
{
    struct fixture *fixture = *state;
    texts_want(fixture->texts, 5, &fixture->scenario.digest, 0);
    fixture->scenario.text[PIECE + 3] ^= 1;
    assert_false(hear_all(fixture, 0));
    fixture->scenario.text[PIECE + 3] ^= 1;
    assert_null(texts_find(fixture->texts, &fixture->scenario.digest));
    assert_true(hear_all(fixture, 0));
}

// A run that is over answers nobody: asking ends, and begins again at most once a minute.
static void asking_in_vain_ends(void **state)
{
    struct fixture *fixture = *state;
    texts_want(fixture->texts, 5, &fixture->scenario.digest, 0);
    sobox_text_request_t request;
    int64_t now_ns = 0;
    for (int i = 0; i < TEXTS_TRIES; i++, now_ns += TEXTS_AGAIN_NS)
        assert_true(texts_ask(fixture->texts, now_ns, &request));
    assert_false(texts_ask(fixture->texts, now_ns, &request));
    assert_false(texts_waiting(fixture->texts));
    assert_false(texts_want(fixture->texts, 5, &fixture->scenario.digest, now_ns));
    now_ns += TEXTS_FORGIVE_NS;
    assert_true(texts_want(fixture->texts, 5, &fixture->scenario.digest, now_ns));
}

// Thousands of searches may be heard of at once: few are asked for at a time.
static void few_are_asked_for_at_a_time(void **state)
{
    struct fixture *fixture = *state;
    for (uint8_t i = 0; i < TEXTS_WANTED_MAX; i++)
        assert_true(texts_want(fixture->texts, 5, &(struct digest){.bytes = {i}}, 0));
    assert_false(texts_want(fixture->texts, 5, &fixture->scenario.digest, 0));
}

#define TEST(claim) cmocka_unit_test_setup_teardown(claim, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(scenario_is_known_when_all_pieces_came),
        TEST(lost_piece_is_asked_for_again),
        TEST(lie_is_not_believed),
        TEST(asking_in_vain_ends),
        TEST(few_are_asked_for_at_a_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
