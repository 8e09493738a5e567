#include "worker/batch/text.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { TOTAL = 1000 };

static uint8_t whole[TOTAL];

static int fill_whole(void **state)
{
    (void)state;
    for (size_t i = 0; i < TOTAL; i++)
        whole[i] = (uint8_t)(i * 7 + i / 256);
    return 0;
}

static enum text_progress piece(struct text *text, uint32_t begin, uint32_t end)
{
    return text_piece(text, TOTAL, begin, whole + begin, end - begin);
}

// Pieces in order put the text together; each is new and the last one completes it.
static void pieces_in_order_make_the_text(void **state)
{
    (void)state;
    struct text text = {0};
    for (uint32_t begin = 0; begin < TOTAL - 100; begin += 100) {
        assert_int_equal(piece(&text, begin, begin + 100), TEXT_MORE);
        assert_int_equal(text_missing(&text), begin + 100);
    }
    assert_int_equal(piece(&text, TOTAL - 100, TOTAL), TEXT_WHOLE);
    assert_memory_equal(text.bytes, whole, TOTAL);
    text_clear(&text);
    assert_null(text.bytes);
}

// The last piece with others missing is a gap, and the first missing byte is where to ask from.
static void missing_piece_is_a_gap(void **state)
{
    (void)state;
    struct text text = {0};
    assert_int_equal(piece(&text, 0, 300), TEXT_MORE);
    assert_int_equal(piece(&text, 500, 700), TEXT_MORE);
    assert_int_equal(piece(&text, 700, TOTAL), TEXT_GAP);
    assert_int_equal(text_missing(&text), 300);
    assert_int_equal(piece(&text, 300, 400), TEXT_MORE);
    assert_int_equal(text_missing(&text), 400);
    assert_int_equal(piece(&text, 400, 500), TEXT_WHOLE);
    assert_memory_equal(text.bytes, whole, TOTAL);
    text_clear(&text);
}

// A piece that came before, whole or in parts of others, brings nothing.
static void doubled_piece_brings_nothing(void **state)
{
    (void)state;
    struct text text = {0};
    assert_int_equal(piece(&text, 100, 200), TEXT_MORE);
    assert_int_equal(piece(&text, 200, 300), TEXT_MORE);
    assert_int_equal(piece(&text, 100, 200), TEXT_NOTHING);
    assert_int_equal(piece(&text, 150, 250), TEXT_NOTHING);
    assert_int_equal(piece(&text, 50, 350), TEXT_MORE);
    assert_int_equal(text.part_count, 1);
    text_clear(&text);
}

// Any cut in any order gives the text: pieces of random place and length until all is there, beside
// a plain map of the bytes that have arrived.
static void random_pieces_make_the_text(void **state)
{
    (void)state;
    GRand *rand = g_rand_new_with_seed(20);
    for (int round = 0; round < 50; round++) {
        struct text text = {0};
        bool here[TOTAL] = {false};
        uint32_t count = 0;
        while (count < TOTAL) {
            uint32_t begin = (uint32_t)g_rand_int_range(rand, 0, TOTAL);
            uint32_t size = (uint32_t)g_rand_int_range(rand, 1, 80);
            uint32_t end = MIN(TOTAL, begin + size);
            uint32_t before = count;
            for (uint32_t i = begin; i < end; i++) {
                count += !here[i];
                here[i] = true;
            }
            enum text_progress progress = piece(&text, begin, end);
            assert_int_equal(progress == TEXT_NOTHING, count == before);
            assert_int_equal(progress == TEXT_WHOLE, count == TOTAL);
            uint32_t missing = 0;
            while (missing < TOTAL && here[missing])
                missing++;
            assert_int_equal(text_missing(&text), missing);
        }
        assert_memory_equal(text.bytes, whole, TOTAL);
        text_clear(&text);
    }
    g_rand_free(rand);
}

// A sender that scatters single bytes gets no memory for it, and the text is completed all the same
// once proper pieces arrive.
static void scattered_bytes_are_bounded(void **state)
{
    (void)state;
    enum { LARGE = 4 * TEXT_PART_MAX };
    uint8_t *bytes = g_malloc0(LARGE);
    struct text text = {0};
    for (uint32_t i = 1; i < LARGE; i += 2)
        text_piece(&text, LARGE, i, bytes + i, 1);
    assert_int_equal(text.part_count, TEXT_PART_MAX);
    assert_int_equal(text_piece(&text, LARGE, 0, bytes, LARGE), TEXT_WHOLE);
    text_clear(&text);
    g_free(bytes);
}

// Two senders that disagree about the size: the later one starts anew, so that a forged size blocks
// nobody for ever.
static void other_size_starts_anew(void **state)
{
    (void)state;
    struct text text = {0};
    uint8_t forged[10] = {0};
    assert_int_equal(text_piece(&text, 5000, 0, forged, sizeof forged), TEXT_MORE);
    assert_int_equal(piece(&text, 0, 400), TEXT_MORE);
    assert_int_equal(text.size, TOTAL);
    assert_int_equal(piece(&text, 400, TOTAL), TEXT_WHOLE);
    assert_memory_equal(text.bytes, whole, TOTAL);
    text_clear(&text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_in_order_make_the_text),
        cmocka_unit_test(missing_piece_is_a_gap),
        cmocka_unit_test(doubled_piece_brings_nothing),
        cmocka_unit_test(random_pieces_make_the_text),
        cmocka_unit_test(scattered_bytes_are_bounded),
        cmocka_unit_test(other_size_starts_anew),
    };
    return cmocka_run_group_tests(tests, fill_whole, NULL);
}
