#include "common/protocol/protocol.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// The names stand in every run.db, history.csv and result.json that was ever written: another
// spelling would make those unreadable. So they are spelled out here once more, on purpose.
static void names_are_those_of_earlier_files(void **state)
{
    (void)state;
    static const char *const states[] = {"running", "waiting for workers", "done", "interrupted",
                                         "failed"};
    static const char *const phases[] = {"seek",    "explore", "consolidate",
                                         "certify", "explain", "done"};
    static const char *const statuses[] = {"running", "done", "purity_missed", "no_good_design"};
    for (int i = 0; i < RUN_STATE_COUNT; i++)
        assert_string_equal(protocol_run_state_name((enum run_state)i), states[i]);
    for (int i = 0; i < SEARCH_PHASE_COUNT; i++)
        assert_string_equal(protocol_phase_name((enum search_phase)i), phases[i]);
    for (int i = 0; i < SEARCH_STATUS_COUNT; i++)
        assert_string_equal(protocol_status_name((enum search_status)i), statuses[i]);
}

static void names_are_found_again(void **state)
{
    (void)state;
    enum run_state run = RUN_STATE_RUNNING;
    enum search_phase phase = SEARCH_PHASE_SEEK;
    enum search_status status = SEARCH_STATUS_RUNNING;
    assert_true(protocol_run_state_of("failed", &run));
    assert_int_equal(run, RUN_STATE_FAILED);
    assert_true(protocol_phase_of("explain", &phase));
    assert_int_equal(phase, SEARCH_PHASE_EXPLAIN);
    assert_true(protocol_status_of("no_good_design", &status));
    assert_int_equal(status, SEARCH_STATUS_NO_GOOD_DESIGN);
}

// A word of a later version must not turn into a value of this one.
static void unknown_name_leaves_the_value(void **state)
{
    (void)state;
    enum run_state run = RUN_STATE_DONE;
    enum search_phase phase = SEARCH_PHASE_CERTIFY;
    enum search_status status = SEARCH_STATUS_PURITY_MISSED;
    assert_false(protocol_run_state_of("Done", &run));
    assert_false(protocol_phase_of("", &phase));
    assert_false(protocol_status_of("done ", &status));
    assert_int_equal(run, RUN_STATE_DONE);
    assert_int_equal(phase, SEARCH_PHASE_CERTIFY);
    assert_int_equal(status, SEARCH_STATUS_PURITY_MISSED);
}

// A worker keeps the batches of a run that waits for workers, and forgets those of one that ended.
static void run_that_waits_has_not_ended(void **state)
{
    (void)state;
    assert_false(protocol_run_ended(RUN_STATE_RUNNING));
    assert_false(protocol_run_ended(RUN_STATE_WAITING));
    assert_true(protocol_run_ended(RUN_STATE_DONE));
    assert_true(protocol_run_ended(RUN_STATE_INTERRUPTED));
    assert_true(protocol_run_ended(RUN_STATE_FAILED));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_those_of_earlier_files),
        cmocka_unit_test(names_are_found_again),
        cmocka_unit_test(unknown_name_leaves_the_value),
        cmocka_unit_test(run_that_waits_has_not_ended),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
