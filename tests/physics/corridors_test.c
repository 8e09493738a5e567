// The corridors of the sedan show what the thesis found and engineering judgement demands (thesis
// 8.2 to 8.4, 8.8): the car is stopped by high axial forces, rotating takes low lateral forces,
// glancing off takes high ones, and who allows both responses has at least as much room.
#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"
#include "worker/batch/batch.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

// Up to here the sedan's front is reached in a crash that keeps s_L above the firewall's distance;
// beyond it the corridor says nothing (thesis 8.2.3). [m]
static const double DEFORMATION_REACHED = 1.0;
// Before this the bumper, lamps and radiator carry little, whatever the response. [m]
static const double DEFORMATION_STRUCTURE = 0.3;

struct corridors {
    struct scenario scenario;
    struct search *search;
    struct search_result result;
};

enum corridors_index { ANY, ROTATING, GLANCING_OFF, RESPONSE_COUNT };
static struct corridors corridors[RESPONSE_COUNT];

// Runs a whole search in this process.
static void corridors_find(struct corridors *found, const char *response)
{
    struct error error = {0};
    const char *overrides[] = {response};
    enum status status = scenario_read_file(
        &found->scenario, SOBOX_SOURCE_DIR "/deploy/scenarios/sedan-two-springs.yaml", overrides, 1,
        &error);
    if (status != STATUS_OK)
        fail_msg("%s", error.text);
    struct model *model = model_create(&found->scenario);
    found->search = search_create(&found->scenario, found->scenario.search.seed, 2);
    struct search_request request;
    while (search_request(found->search, &request)) {
        const struct batch batch = {.sampling = request.sampling,
                                    .count = request.sampling.samples};
        struct verdict *verdicts = calloc(batch.count, sizeof *verdicts);
        batch_evaluate(&found->scenario, model, request.box, &batch, 2, verdicts);
        search_complete(found->search, verdicts);
        free(verdicts);
    }
    search_result(found->search, &found->result);
    model_free(model);
}

static int find_all(void **state)
{
    (void)state;
    corridors_find(&corridors[ANY], "response=any");
    corridors_find(&corridors[ROTATING], "response=rotating");
    corridors_find(&corridors[GLANCING_OFF], "response=glancing_off");
    return 0;
}

static int free_all(void **state)
{
    (void)state;
    for (int i = 0; i < RESPONSE_COUNT; i++) {
        search_free(corridors[i].search);
        scenario_fini(&corridors[i].scenario);
    }
    return 0;
}

enum bound { LOWER, UPPER };

// Mean of one bound over the points of the structure that are reached, as a share of the greatest
// force the design space allows there.
static double bound_share(const struct corridors *found, enum scenario_direction direction,
                          enum bound bound)
{
    const struct scenario *scenario = &found->scenario;
    const struct box *box = found->result.box;
    double sum = 0;
    int count = 0;
    for (uint32_t i = 0; i < box->count; i++) {
        const struct scenario_variable *variable = &scenario->variables[i];
        const double deformation = scenario->springs[variable->spring].deformation[variable->point];
        if (variable->direction != direction || deformation < DEFORMATION_STRUCTURE ||
            deformation > DEFORMATION_REACHED)
            continue;
        sum += (bound == LOWER ? box->lower[i] : box->upper[i]) / scenario->design_space.upper[i];
        count++;
    }
    return sum / count;
}

// All three searches end with a box whose certificate holds; else nothing below means anything.
static void every_response_is_certified(void **state)
{
    (void)state;
    for (int i = 0; i < RESPONSE_COUNT; i++) {
        assert_int_equal(corridors[i].result.status, SEARCH_STATUS_DONE);
        assert_true(corridors[i].result.purity.lower95 >= 0.99);
    }
}

// A car that rotates must not be pushed off the barrier: its lateral corridor ends lower (thesis
// 8.3.3: about 0.4 of the possible force against nearly all of it).
static void rotating_ends_below_glancing_off_in_lateral_force(void **state)
{
    (void)state;
    const double rotating = bound_share(&corridors[ROTATING], SCENARIO_DIRECTION_Y, UPPER);
    const double glancing = bound_share(&corridors[GLANCING_OFF], SCENARIO_DIRECTION_Y, UPPER);
    print_message("F_y upper: rotating %.2f, glancing off %.2f\n", rotating, glancing);
    assert_true(rotating < glancing - 0.1);
}

// A car that glances off must be pushed: its lateral corridor begins higher (thesis 8.4.3).
static void glancing_off_begins_above_rotating_in_lateral_force(void **state)
{
    (void)state;
    const double rotating = bound_share(&corridors[ROTATING], SCENARIO_DIRECTION_Y, LOWER);
    const double glancing = bound_share(&corridors[GLANCING_OFF], SCENARIO_DIRECTION_Y, LOWER);
    print_message("F_y lower: rotating %.2f, glancing off %.2f\n", rotating, glancing);
    assert_true(glancing > rotating + 0.1);
}

// Where the structure has to stop the car the axial corridor begins high (thesis 8.3.3: about 0.7
// of the possible force) and reaches nearly as far up as the design space.
static void rotating_needs_high_axial_force(void **state)
{
    (void)state;
    const double lower = bound_share(&corridors[ROTATING], SCENARIO_DIRECTION_X, LOWER);
    const double upper = bound_share(&corridors[ROTATING], SCENARIO_DIRECTION_X, UPPER);
    print_message("F_x of rotating: %.2f to %.2f\n", lower, upper);
    assert_true(lower > 0.4);
    assert_true(upper > 0.9);
}

// `any` allows what either response allows, so its largest box is at least as large; a search that
// ends below sits in a local optimum. The tolerance is the search's own scatter.
static void any_is_at_least_as_wide_as_either_response(void **state)
{
    (void)state;
    const double any = corridors[ANY].result.log_volume;
    const double rotating = corridors[ROTATING].result.log_volume;
    const double glancing = corridors[GLANCING_OFF].result.log_volume;
    print_message("ln(volume): any %.2f, rotating %.2f, glancing off %.2f\n", any, rotating,
                  glancing);
    assert_true(any >= fmax(rotating, glancing) - 0.3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_response_is_certified),
        cmocka_unit_test(rotating_ends_below_glancing_off_in_lateral_force),
        cmocka_unit_test(glancing_off_begins_above_rotating_in_lateral_force),
        cmocka_unit_test(rotating_needs_high_axial_force),
        cmocka_unit_test(any_is_at_least_as_wide_as_either_response),
    };
    return cmocka_run_group_tests(tests, find_all, free_all);
}
