// The store alone, with bounds so small that a few scenarios reach them.
#include "worker/batch/store.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { TEXT_SIZE_MAX = 256, MANY = 100 };

// Scenario number `number`; all are equally long.
static size_t text_of(char text[TEXT_SIZE_MAX], int number)
{
    const int size =
        snprintf(text, TEXT_SIZE_MAX,
                 "name: number-%d\nmodel: hypersphere\nvariables:\n"
                 "  - {name: x, lower: -1, upper: 1}\nconstraints: {distance: {max: 0}}\n",
                 100 + number);
    assert_in_range(size, 1, TEXT_SIZE_MAX - 1);
    return (size_t)size;
}

static struct digest digest_of_number(int number)
{
    char text[TEXT_SIZE_MAX];
    const size_t size = text_of(text, number);
    return digest_of(text, size);
}

static struct item *acquire(struct store *store, int number)
{
    const struct digest digest = digest_of_number(number);
    return store_acquire(store, ITEM_SCENARIO, &digest, 1, 0);
}

// Acquires a scenario and makes it ready.
static struct item *prepare(struct store *store, int number)
{
    char text[TEXT_SIZE_MAX];
    const uint32_t size = (uint32_t)text_of(text, number);
    struct item *item = acquire(store, number);
    assert_non_null(item);
    assert_false(item->ready);
    assert_int_equal(store_piece(store, item, size, 0, (const uint8_t *)text, size), TEXT_WHOLE);
    struct error error;
    assert_int_equal(store_finish(store, item, &error), STATUS_OK);
    return item;
}

static size_t prepared_size(void)
{
    struct store store;
    store_init(&store, MANY, SIZE_MAX, MANY);
    struct item *item = prepare(&store, 0);
    const size_t size = item->scenario.text_size;
    store_release(&store, item);
    store_fini(&store);
    return size;
}

// Great scenarios are bounded by what they take, not by how many they are: those unused for longest
// go, and one that went is missing again and can be fetched again.
static void scenarios_unused_for_longest_go_when_their_texts_are_too_long(void **state)
{
    (void)state;
    struct store store;
    store_init(&store, MANY, 3 * prepared_size(), MANY);
    for (int number = 0; number < 4; number++)
        store_release(&store, prepare(&store, number));
    struct item *kept = acquire(&store, 1);
    assert_true(kept->ready);
    store_release(&store, kept);
    struct item *gone = acquire(&store, 0);
    assert_false(gone->ready);
    store_release(&store, gone);
    store_release(&store, prepare(&store, 0));
    store_fini(&store);
}

// What batches need stays, however great: others wait for their turn.
static void scenarios_in_use_stay(void **state)
{
    (void)state;
    struct store store;
    store_init(&store, MANY, 2 * prepared_size(), MANY);
    struct item *first = prepare(&store, 0);
    struct item *second = prepare(&store, 1);
    assert_null(acquire(&store, 2));
    store_release(&store, first);
    struct item *third = prepare(&store, 2);
    assert_ptr_equal(acquire(&store, 1), second);
    store_release(&store, second);
    store_release(&store, second);
    store_release(&store, third);
    store_fini(&store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenarios_unused_for_longest_go_when_their_texts_are_too_long),
        cmocka_unit_test(scenarios_in_use_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
