#include "coordinator/search/given.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static double lower[2] = {0, 0};
static double upper[2] = {1, 1};
static double reference[2] = {0.5, 0.25};
static double start[2] = {0.75, 0.5};

struct fixture {
    struct scenario scenario;
    struct frame frame;
    struct given given;
    struct box box;
};

static void begin(struct fixture *fixture, double *given_reference, double *given_start)
{
    fixture->scenario = (struct scenario){
        .design_space = {.count = 2, .lower = lower, .upper = upper},
        .search = {.reference = given_reference, .start = given_start},
    };
    frame_init(&fixture->frame, &fixture->scenario);
    box_init(&fixture->box, 2);
    given_init(&fixture->given, &fixture->scenario.search, &fixture->frame);
}

static void end(struct fixture *fixture)
{
    given_fini(&fixture->given);
    frame_fini(&fixture->frame);
    box_fini(&fixture->box);
}

static void assert_looks_at(struct fixture *fixture, const double *design)
{
    given_box(&fixture->given, &fixture->box);
    for (uint32_t v = 0; v < 2; v++) {
        assert_true(fixture->box.lower[v] == design[v]);
        assert_true(fixture->box.upper[v] == design[v]);
    }
}

static void nothing_given_is_the_whole_space(void **state)
{
    (void)state;
    struct fixture fixture;
    begin(&fixture, NULL, NULL);
    assert_int_equal(fixture.given.stage, GIVEN_NONE);
    given_box(&fixture.given, &fixture.box);
    assert_true(box_equal(&fixture.box, &fixture.frame.space));
    end(&fixture);
}

static void reference_comes_before_the_start(void **state)
{
    (void)state;
    struct fixture fixture;
    begin(&fixture, reference, start);
    assert_looks_at(&fixture, reference);
    given_complete(&fixture.given, true);
    assert_looks_at(&fixture, start);
    given_complete(&fixture.given, true);
    assert_int_equal(fixture.given.stage, GIVEN_NONE);
    assert_true(fixture.given.begin.lower[0] == start[0]);
    end(&fixture);
}

// A bad start is passed over; the good reference is what is left to begin with.
static void bad_start_leaves_the_reference(void **state)
{
    (void)state;
    struct fixture fixture;
    begin(&fixture, reference, start);
    given_complete(&fixture.given, true);
    given_complete(&fixture.given, false);
    assert_int_equal(fixture.given.stage, GIVEN_NONE);
    assert_true(fixture.given.begin.lower[0] == reference[0]);
    end(&fixture);
}

static void bad_reference_is_refused(void **state)
{
    (void)state;
    struct fixture fixture;
    begin(&fixture, reference, start);
    given_complete(&fixture.given, false);
    assert_int_equal(fixture.given.stage, GIVEN_REFUSED);
    assert_int_equal(fixture.given.begin.count, 0);
    end(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_given_is_the_whole_space),
        cmocka_unit_test(reference_comes_before_the_start),
        cmocka_unit_test(bad_start_leaves_the_reference),
        cmocka_unit_test(bad_reference_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
