// The heap keeps its order through random insertions, moves and removals.
#include "coordinator/schedule/heap.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { ENTRIES = 200 };

static struct heap_entry entries[ENTRIES];

// A small generator of our own: the test must not depend on the C library's.
static uint32_t draw(uint32_t *state, uint32_t below)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) % below;
}

static int before(const struct heap_entry *a, const struct heap_entry *b)
{
    return a->key != b->key ? a->key < b->key : a->tie < b->tie;
}

// The least entry that is in, other than `without`, found the slow way.
static struct heap_entry *least(const struct heap_entry *without)
{
    struct heap_entry *found = NULL;
    for (size_t i = 0; i < ENTRIES; i++) {
        if (entries[i].position != 0 && &entries[i] != without &&
            (found == NULL || before(&entries[i], found)))
            found = &entries[i];
    }
    return found;
}

// First and second agree with a search through everything after each of many random operations:
// a removal from the middle has to move its replacement up or down.
static void first_and_second_are_the_least(void **state)
{
    (void)state;
    struct heap heap = {0};
    uint32_t random = 1;
    for (size_t i = 0; i < ENTRIES; i++)
        entries[i] = (struct heap_entry){.tie = i};
    for (int i = 0; i < 20000; i++) {
        struct heap_entry *entry = &entries[draw(&random, ENTRIES)];
        if (draw(&random, 3) == 0)
            heap_remove(&heap, entry);
        else
            heap_put(&heap, entry, draw(&random, 50));
        assert_ptr_equal(heap_first(&heap), least(NULL));
        assert_ptr_equal(heap_second(&heap), least(heap_first(&heap)));
    }
    while (heap.count > 0)
        heap_remove(&heap, heap_first(&heap));
    assert_null(least(NULL));
    heap_fini(&heap);
}

// An empty heap has no first, and taking out what is not in changes nothing.
static void empty_heap_is_harmless(void **state)
{
    (void)state;
    struct heap heap = {0};
    struct heap_entry entry = {0};
    assert_null(heap_first(&heap));
    assert_null(heap_second(&heap));
    heap_remove(&heap, &entry);
    heap_put(&heap, &entry, 1);
    assert_null(heap_second(&heap));
    heap_remove(&heap, &entry);
    assert_null(heap_first(&heap));
    heap_fini(&heap);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_and_second_are_the_least),
        cmocka_unit_test(empty_heap_is_harmless),
    };
    return cmocka_run_group_tests_name("heap", tests, NULL, NULL);
}
