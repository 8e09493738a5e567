// The corridors of three cars show the thesis's pictures 8.1, 8.2 and 8.4 and what engineering
// judgement demands (thesis 8.2 to 8.4, 8.8): the car is stopped by high axial forces, rotating
// takes low lateral forces, glancing off takes high ones, and who allows both responses has at
// least as much room. Their designs move as real cars do.
//
// Bounds are stated as shares of the greatest force that the design space allows, the mean over the
// points from 0.2 of the deformation on that the firewall leaves room for. The thesis has
//
//                     F_x lower   F_y lower     upper
//     any                   0.7   at most 0.3   nearly 1
//     rotating              0.7   0             0.4
//     glancing off          0.6   0.6           1
//
// for cars whose numbers it does not give. What is held here are the trends, with 0.3 to either
// side: how high a bound lies depends on the car, and on what the box promises.
#include "common/sampling/sampling.h"
#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"
#include "worker/batch/batch.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static const double TOLERANCE = 0.3; // of a share

// What the velocity of real cars changes by in this test, along the travel and across, the 10th to
// the 90th percentile of 333 tests (tests/data/README.md has their medians). [m/s]
static const double ALONG[2] = {11.0, 16.2}, ACROSS[2] = {4.4, 8.6};

enum car { SEDAN, SUV, SPORTS_CAR, CAR_COUNT };
static const char *const car_files[CAR_COUNT] = {"sedan-two-springs", "suv-two-springs",
                                                 "sports-car-two-springs"};

enum response { ANY, ROTATING, GLANCING_OFF, RESPONSE_COUNT };
static const char *const response_words[RESPONSE_COUNT] = {"any", "rotating", "glancing_off"};

struct corridors {
    struct scenario scenario;
    struct search *search;
    struct search_result result;
};
static struct corridors corridors[CAR_COUNT][RESPONSE_COUNT];

// Runs a whole search in this process.
static void corridors_find(struct corridors *found, enum car car, enum response response)
{
    struct error error = {0};
    char path[1024], wanted[64];
    snprintf(path, sizeof path, SOBOX_SOURCE_DIR "/deploy/scenarios/%s.yaml", car_files[car]);
    snprintf(wanted, sizeof wanted, "response=%s", response_words[response]);
    const char *overrides[] = {wanted};
    enum status status = scenario_read_file(&found->scenario, path, overrides, 1, &error);
    if (status != STATUS_OK)
        fail_msg("%s", error.text);
    struct model *model = model_create(&found->scenario);
    found->search = search_create(&found->scenario, found->scenario.search.seed, 2);
    struct search_request request;
    while (search_request(found->search, &request)) {
        const struct batch batch = {.sampling = request.sampling,
                                    .count = request.sampling.samples,
                                    .detail = request.detail};
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
    for (int car = 0; car < CAR_COUNT; car++)
        for (int response = 0; response < RESPONSE_COUNT; response++)
            corridors_find(&corridors[car][response], (enum car)car, (enum response)response);
    return 0;
}

static int free_all(void **state)
{
    (void)state;
    for (int i = 0; i < CAR_COUNT * RESPONSE_COUNT; i++) {
        struct corridors *found = &corridors[i / RESPONSE_COUNT][i % RESPONSE_COUNT];
        search_free(found->search);
        scenario_fini(&found->scenario);
    }
    return 0;
}

// ---- The pictures ----

enum bound { LOWER, UPPER };

// The share of a bound, as the head of this file says.
static double bound_share(const struct corridors *found, enum scenario_direction direction,
                          enum bound bound)
{
    const struct scenario *scenario = &found->scenario;
    const struct scenario_spring *spring = &scenario->springs[0];
    const double from = 0.2 * spring->deformation[spring->point_count - 1];
    const double to = spring->length - scenario->firewall_distance;
    const struct box *box = found->result.box;
    double sum = 0;
    int count = 0;
    for (uint32_t i = 0; i < box->count; i++) {
        const struct scenario_variable *variable = &scenario->variables[i];
        const double deformation = spring->deformation[variable->point];
        if (variable->direction != direction || deformation < from || deformation > to)
            continue;
        sum += (bound == LOWER ? box->lower[i] : box->upper[i]) / scenario->design_space.upper[i];
        count++;
    }
    return sum / count;
}

struct picture {
    double x[2], y[2]; // shares: lower, upper
};

static struct picture picture_of(enum car car, enum response response)
{
    const struct corridors *found = &corridors[car][response];
    const struct picture picture = {
        .x = {bound_share(found, SCENARIO_DIRECTION_X, LOWER),
              bound_share(found, SCENARIO_DIRECTION_X, UPPER)},
        .y = {bound_share(found, SCENARIO_DIRECTION_Y, LOWER),
              bound_share(found, SCENARIO_DIRECTION_Y, UPPER)},
    };
    print_message("%-22s %-12s F_x %.2f to %.2f, F_y %.2f to %.2f, ln(volume) %.2f\n",
                  car_files[car], response_words[response], picture.x[LOWER], picture.x[UPPER],
                  picture.y[LOWER], picture.y[UPPER], found->result.log_volume);
    return picture;
}

static void assert_near(double share, double thesis)
{
    if (!(fabs(share - thesis) <= TOLERANCE))
        fail_msg("expected %.2f as in the thesis, found %.2f", thesis, share);
}

// All searches end with a box whose certificate holds; else nothing below means anything.
static void every_response_is_certified(void **state)
{
    (void)state;
    for (int i = 0; i < CAR_COUNT * RESPONSE_COUNT; i++) {
        const struct search_result *result =
            &corridors[i / RESPONSE_COUNT][i % RESPONSE_COUNT].result;
        assert_int_equal(result->status, SEARCH_STATUS_DONE);
        assert_true(result->purity.lower95 >= 0.99);
    }
}

// Picture 8.1: who allows both responses needs a strong structure along, and is free across.
static void any_is_strong_along_and_free_across(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct picture picture = picture_of((enum car)car, ANY);
        assert_near(picture.x[LOWER], 0.7);
        assert_true(picture.x[UPPER] > 0.9);
        assert_true(picture.y[LOWER] < 0.3);
        assert_true(picture.y[UPPER] > 0.75);
    }
}

// Picture 8.2: a car that rotates must be stopped, and must not be pushed off the barrier.
static void rotating_is_strong_along_and_weak_across(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct picture picture = picture_of((enum car)car, ROTATING);
        assert_near(picture.x[LOWER], 0.7);
        assert_true(picture.x[UPPER] > 0.9);
        assert_true(picture.y[LOWER] < 0.1);
        assert_near(picture.y[UPPER], 0.4);
    }
}

// Picture 8.4: a car that glances off must be pushed.
static void glancing_off_is_strong_both_ways(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct picture picture = picture_of((enum car)car, GLANCING_OFF);
        assert_near(picture.x[LOWER], 0.6);
        assert_true(picture.x[UPPER] > 0.9);
        assert_near(picture.y[LOWER], 0.6);
        assert_true(picture.y[UPPER] > 0.9);
    }
}

// The lateral corridor of rotating ends below that of glancing off and begins below it.
static void rotating_lies_below_glancing_off_across(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct picture rotating = picture_of((enum car)car, ROTATING);
        const struct picture glancing = picture_of((enum car)car, GLANCING_OFF);
        assert_true(rotating.y[UPPER] < glancing.y[UPPER] - 0.1);
        assert_true(rotating.y[LOWER] < glancing.y[LOWER] - 0.1);
    }
}

// `any` allows what either response allows, so its largest box is at least as large; a search that
// ends below sits in a local optimum. The tolerance is the search's own scatter.
static void any_is_at_least_as_wide_as_either_response(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct corridors *of = corridors[car];
        assert_true(of[ANY].result.log_volume >=
                    fmax(of[ROTATING].result.log_volume, of[GLANCING_OFF].result.log_volume) - 0.3);
    }
}

// ---- Motion ----

enum { DESIGNS = 32 * MODEL_BLOCK };

struct motion {
    double along, both; // shares of the designs of a box whose velocity changes as measured
};

static bool within(double value, const double range[2])
{
    return value >= range[0] && value <= range[1];
}

static struct motion motion_of(enum car car, enum response response)
{
    const struct corridors *found = &corridors[car][response];
    const struct box *box = found->result.box;
    struct model *model = model_create(&found->scenario);
    double *values = calloc((size_t)box->count * MODEL_BLOCK, sizeof *values);
    double *outcomes = calloc((size_t)model_outcome_count(model) * MODEL_BLOCK, sizeof *outcomes);
    const double *along = outcomes + (size_t)OUTCOME_DELTA_VX * MODEL_BLOCK;
    const double *across = outcomes + (size_t)OUTCOME_DELTA_VY * MODEL_BLOCK;
    const struct sampling sampling = {.seed = 77, .step = 1, .samples = DESIGNS};
    struct motion motion = {0};
    for (uint32_t first = 0; first < DESIGNS; first += MODEL_BLOCK) {
        sampling_fill(&sampling, box, first, MODEL_BLOCK, values, MODEL_BLOCK);
        model_evaluate(model, MODEL_BLOCK, values, outcomes);
        for (uint32_t i = 0; i < MODEL_BLOCK; i++) {
            motion.along += within(along[i], ALONG) ? 1.0 / DESIGNS : 0;
            motion.both += within(along[i], ALONG) && within(across[i], ACROSS) ? 1.0 / DESIGNS : 0;
        }
    }
    free(outcomes);
    free(values);
    model_free(model);
    print_message(
        "%-22s %-12s within the measured range: %.0f %% along, %.0f %% along and across\n",
        car_files[car], response_words[response], 100 * motion.along, 100 * motion.both);
    return motion;
}

// Most designs lose as much speed along the travel as real cars do. Across it is most of `any`
// only: real cars that rotate have a median of 4.6 m/s, at the lower end of the range of all cars.
static void designs_move_as_real_cars_do(void **state)
{
    (void)state;
    for (int car = 0; car < CAR_COUNT; car++) {
        const struct motion any = motion_of((enum car)car, ANY);
        const struct motion rotating = motion_of((enum car)car, ROTATING);
        assert_true(any.along >= 0.6 && rotating.along >= 0.6);
        assert_true(any.both >= 0.5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_response_is_certified),
        cmocka_unit_test(any_is_strong_along_and_free_across),
        cmocka_unit_test(rotating_is_strong_along_and_weak_across),
        cmocka_unit_test(glancing_off_is_strong_both_ways),
        cmocka_unit_test(rotating_lies_below_glancing_off_across),
        cmocka_unit_test(any_is_at_least_as_wide_as_either_response),
        cmocka_unit_test(designs_move_as_real_cars_do),
    };
    return cmocka_run_group_tests(tests, find_all, free_all);
}
