// How large a box the search finds, how pure, and in what time: the problems of
// deploy/scenarios/benchmarks, whose answers are known, at two budgets, and the shipped vehicles.
// In one process, without a network. Prints CSV.
//
//     search_bench [options] problems [NAME...]     beside the best public peer's figures
//     search_bench [options] vehicles [NAME...]     log-volumes of the shipped scenarios
//
//     --seeds N             searches a row (default 10, with seeds 1..N)
//     --threads N           searches at a time (default 2); each is on one thread
//     --budget small|large  only 100 samples x (20 + 20) steps, or 200 x (100 + 100)
//     --target P            target purity of all rows, in place of each row's own
//     --set KEY=VALUE       overrides the scenarios
//     --each                a row a seed
//
// A problem is measured at its first certificate, when the steps of the budget are spent: what a
// search does beyond, because the certificate missed, is not in the comparison.
#include "common/base/clock.h"
#include "common/numeric/statistics.h"
#include "common/scenario/scenario_read.h"
#include "coordinator/search/search.h"
#include "coordinator/search/trim.h"
#include "worker/batch/batch.h"

#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    BENCH_SEEDS_MAX = 1000,
    BENCH_OVERRIDES_MAX = 16,
    BENCH_FRESH = 100000,     // samples by which a box is judged
    BENCH_FRESH_SEED = 77777, // of no search
    BENCH_CELLS = 400,        // of [0, 1], when distributions are folded
};

enum budget { BUDGET_SMALL, BUDGET_LARGE, BUDGET_COUNT };

static const struct {
    const char *name;
    const char *overrides[3];
} budgets[BUDGET_COUNT] = {
    {"small",
     {"search.samples=100", "search.exploration_steps=20", "search.consolidation_steps=20"}},
    {"large",
     {"search.samples=200", "search.exploration_steps=100", "search.consolidation_steps=100"}},
};

// What a search of the peer reached, median of ten seeds: SSO Toolbox, commit 5289641, adaptive
// growth, each sample of its steps counted. 0: not measured.
struct peer {
    double volume;
    double same_purity;
    double purity;
};

// A problem, its exact answer, and how pure a box is asked for. Where the peer's figure is a volume
// at a purity, the target is chosen so that the boxes are as pure as the peer's: volumes compare
// only then.
struct problem {
    const char *name;  // of the scenario
    uint32_t ball;     // dimensions of a hypersphere, whose volumes compare at equal purity; else 0
    double widths[10]; // exact; the last one that is given stands for all that follow
    double target[BUDGET_COUNT];
    struct peer peer[BUDGET_COUNT];
};

static const struct problem problems[] = {
    {.name = "hypersphere-2",
     .ball = 2,
     .widths = {1},
     .target = {0.99, 0.99},
     .peer = {{1.01, 0.97, 0.9994}, {0.991, 0.98, 1.0000}}},
    {.name = "hypersphere-5",
     .ball = 5,
     .widths = {1},
     .target = {0.99, 0.99},
     .peer = {{2.00, 0.90, 0.9977}, {1.48, 0.91, 0.9998}}},
    {.name = "hypersphere-10",
     .ball = 10,
     .widths = {1},
     .target = {0.99, 0.99},
     .peer = {{9.90, 0.73, 0.9962}, {5.96, 0.82, 0.9996}}},
    {.name = "hypersphere-20",
     .ball = 20,
     .widths = {1},
     .target = {0.99, 0.99},
     .peer = {{420, 0.50, 0.9938}, {187, 0.63, 0.9996}}},
    {.name = "hypersphere-30",
     .ball = 30,
     .widths = {1},
     .target = {0.99, 0.99},
     .peer = {{20900, 0.31, 0.9938}, {9005, 0.53, 0.9996}}},
    {.name = "hypersphere-100", .ball = 100, .widths = {1}, .target = {0.99, 0.99}},
    {.name = "two-section-crash",
     .widths = {222240, 111120},
     .target = {0.997, 0.9994},
     .peer = {{0.990, 0, 0.9990}, {0.983, 0, 1.0000}}},
    {.name = "ellipse",
     .widths = {M_SQRT2},
     .target = {0.9965, 0.999},
     .peer = {{1.047, 0, 0.9990}, {0.999, 0, 0.9999}}},
    {.name = "ordered-crash-3", .widths = {222240, 111120, 74080}, .target = {0.998, 0.999}},
    {.name = "ordered-crash-5",
     .widths = {222240, 111120, 74080, 55560, 44448},
     .target = {0.998, 0.999}},
    {.name = "corridor-crash",
     .widths = {155520, 77760, 77760, 77760, 155520, 155520, 77760, 77760, 77760, 155520},
     .target = {0.998, 0.999}},
    {.name = "rosenbrock", .widths = {1.0725, 0.5806}, .target = {0.998, 0.999}},
    {.name = "linear", .widths = {0.5, 0.25, 0.1}, .target = {0.998, 0.999}},
};

static const char *const vehicles[] = {
    "sedan-two-springs", "sedan-ten-springs",      "suv-two-springs",
    "suv-ten-springs",   "sports-car-two-springs", "sports-car-ten-springs",
};
static const char *const responses[] = {"any", "rotating", "glancing_off"};

static struct {
    int seeds;
    int threads;
    int budget; // BUDGET_COUNT: both
    double target;
    bool each;
    const char *overrides[BENCH_OVERRIDES_MAX];
    size_t override_count;
    char **names; // of the rows wanted; none: all
    int name_count;
} options = {.seeds = 10, .threads = 2, .budget = BUDGET_COUNT};

// ---- Time ----

static int64_t thread_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (int64_t)time.tv_sec * CLOCK_SECOND_NS + time.tv_nsec;
}

static _Thread_local int64_t trim_ns;

bool __real_trim(const struct box *grown, const struct box *previous, const struct cloud *good,
                 const struct cloud *bad, const struct trim_options *trimming, struct box *trimmed);
bool __wrap_trim(const struct box *grown, const struct box *previous, const struct cloud *good,
                 const struct cloud *bad, const struct trim_options *trimming, struct box *trimmed);

// The linker gives all who call trim() this one, so that the search needs no clock.
bool __wrap_trim(const struct box *grown, const struct box *previous, const struct cloud *good,
                 const struct cloud *bad, const struct trim_options *trimming, struct box *trimmed)
{
    const int64_t start = thread_ns();
    const bool found = __real_trim(grown, previous, good, bad, trimming, trimmed);
    trim_ns += thread_ns() - start;
    return found;
}

// ---- One search ----

// What one search did.
struct found {
    // When it first asked for a certificate.
    double log_volume;  // ln of the product of the widths, in the variables' units
    double purity;      // of BENCH_FRESH samples
    double width_error; // largest |width / exact - 1|
    double evaluations;
    double seconds;        // processor time, of search and model
    double search_seconds; // of the search alone
    double trim_seconds;
    // At its end.
    bool certified;
    double end_log_volume; // relative to the design space
    double end_evaluations;
    double end_purity; // as certified
};

static struct scenario read_scenario(const char *path, const char *const *own, size_t own_count)
{
    const char *overrides[BENCH_OVERRIDES_MAX + 8];
    size_t count = 0;
    for (size_t i = 0; i < own_count; i++)
        overrides[count++] = own[i];
    for (size_t i = 0; i < options.override_count; i++)
        overrides[count++] = options.overrides[i];
    struct scenario scenario;
    struct error error = {0};
    g_autofree char *file = g_strconcat(SOBOX_SOURCE_DIR "/deploy/scenarios/", path, ".yaml", NULL);
    if (scenario_read_file(&scenario, file, overrides, count, &error) != STATUS_OK) {
        fprintf(stderr, "%s\n", error.text);
        exit(EXIT_FAILURE);
    }
    return scenario;
}

// The share of good designs among fresh uniform samples of a box.
static double true_purity(const struct scenario *scenario, const struct model *model,
                          const struct box *box)
{
    const struct batch batch = {
        .sampling = {.seed = BENCH_FRESH_SEED, .samples = BENCH_FRESH},
        .count = BENCH_FRESH,
    };
    g_autofree struct verdict *verdicts = g_new(struct verdict, BENCH_FRESH);
    batch_evaluate(scenario, model, box, &batch, 1, verdicts);
    return (double)verdict_good_count(verdicts, BENCH_FRESH) / BENCH_FRESH;
}

static double exact_width(const struct problem *problem, uint32_t variable)
{
    uint32_t last = G_N_ELEMENTS(problem->widths) - 1;
    while (last > 0 && problem->widths[last] == 0)
        last--;
    return problem->widths[variable < last ? variable : last];
}

static void measure_widths(const struct problem *problem, const struct box *box,
                           struct found *found)
{
    for (uint32_t v = 0; v < box->count; v++) {
        const double width = box->upper[v] - box->lower[v];
        found->log_volume += log(width);
        if (problem != NULL)
            found->width_error =
                fmax(found->width_error, fabs(width / exact_width(problem, v) - 1));
    }
}

// Searches to the end; `problem` is NULL for a vehicle, of which only the end is of interest.
static void run_search(const struct scenario *scenario, const struct model *model, uint64_t seed,
                       const struct problem *problem, struct found *found)
{
    *found = (struct found){0};
    trim_ns = 0;
    int64_t search_ns = 0;
    const int64_t begin = thread_ns();
    struct search *search = search_create(scenario, seed, 1);
    struct search_request request;
    struct verdict *verdicts = NULL;
    bool spent = false; // the budget
    while (search_request(search, &request)) {
        if (request.phase == SEARCH_PHASE_CERTIFY && !spent) {
            spent = true;
            found->seconds = 1e-9 * (double)(thread_ns() - begin);
            found->search_seconds = 1e-9 * (double)search_ns;
            found->trim_seconds = 1e-9 * (double)trim_ns;
            measure_widths(problem, request.box, found);
            if (problem != NULL)
                found->purity = true_purity(scenario, model, request.box);
        }
        found->evaluations += spent ? 0 : request.sampling.samples;
        const struct batch batch = {.sampling = request.sampling,
                                    .count = request.sampling.samples,
                                    .detail = request.detail};
        verdicts = g_renew(struct verdict, verdicts, batch.count);
        batch_evaluate(scenario, model, request.box, &batch, 1, verdicts);
        const int64_t start = thread_ns();
        search_complete(search, verdicts);
        search_ns += thread_ns() - start;
    }
    struct search_result result;
    search_result(search, &result);
    found->certified = result.status == SEARCH_STATUS_DONE;
    found->end_log_volume = result.log_volume;
    found->end_evaluations = (double)result.evaluations;
    found->end_purity = result.purity.estimate;
    if (problem == NULL) {
        found->seconds = 1e-9 * (double)(thread_ns() - begin);
        found->search_seconds = 1e-9 * (double)search_ns;
        found->trim_seconds = 1e-9 * (double)trim_ns;
    }
    g_free(verdicts);
    search_free(search);
}

static struct found *run_seeds(const struct scenario *scenario, const struct problem *problem)
{
    struct found *found = g_new(struct found, options.seeds);
    struct model *model = model_create(scenario);
#pragma omp parallel for schedule(dynamic) num_threads(options.threads)
    for (int i = 0; i < options.seeds; i++)
        run_search(scenario, model, (uint64_t)i + 1, problem, &found[i]);
    model_free(model);
    return found;
}

// ---- The best box of the same purity ----

// The distribution of the sum of squares of n uniform numbers of [-1, 1], by folding that of one
// with itself. Shares of cells, whose mass is split between the cell's ends so that means stay.
static double *sum_of_squares(uint32_t n, uint32_t *count)
{
    double one[BENCH_CELLS + 1] = {0};
    for (int i = 0; i < BENCH_CELLS; i++) {
        const double from = (double)i / BENCH_CELLS;
        const double to = (double)(i + 1) / BENCH_CELLS;
        const double mass = sqrt(to) - sqrt(from);
        const double mean = (to * sqrt(to) - from * sqrt(from)) / 3 / mass;
        const double up = (mean - from) * BENCH_CELLS;
        one[i] += mass * (1 - up);
        one[i + 1] += mass * up;
    }
    double *sum = g_new0(double, (size_t)n *BENCH_CELLS + 1);
    double *next = g_new0(double, (size_t)n *BENCH_CELLS + 1);
    sum[0] = 1;
    for (uint32_t k = 0; k < n; k++) {
        memset(next, 0, ((size_t)n * BENCH_CELLS + 1) * sizeof *next);
        for (uint32_t i = 0; i <= k * BENCH_CELLS; i++) {
            for (uint32_t j = 0; j <= BENCH_CELLS; j++)
                next[i + j] += sum[i] * one[j];
        }
        double *swap = sum;
        sum = next;
        next = swap;
    }
    g_free(next);
    *count = n * BENCH_CELLS + 1;
    return sum;
}

// ln of the volume of the centred cube that has this purity in a ball of radius sqrt(n) / 2. Of
// half-width h it has the share of good designs P(sum of squares <= n / 4 / h^2).
static double cube_log_volume(const double *sum, uint32_t count, uint32_t n, double purity)
{
    double below = 0;
    uint32_t i = 0;
    while (i < count && below + sum[i] < purity)
        below += sum[i++];
    double least =
        i > 0 ? i - 0.5 : 0; // the distribution function passes through the cells' middles
    least += i < count && sum[i] > 0 ? (purity - below) / sum[i] : 0;
    const double square = fmin(least / BENCH_CELLS, n);
    return n * log(sqrt(n / square));
}

// ---- Rows ----

static int by_value(const void *a, const void *b)
{
    const double one = *(const double *)a;
    const double two = *(const double *)b;
    return (one > two) - (one < two);
}

// Prints median, least and most.
static void print_three(int digits, const double *values, int count)
{
    g_autofree double *sorted = g_memdup2(values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, by_value);
    const double median =
        count % 2 == 1 ? sorted[count / 2] : (sorted[count / 2 - 1] + sorted[count / 2]) / 2;
    const double three[3] = {median, sorted[0], sorted[count - 1]};
    for (int i = 0; i < 3; i++)
        printf(",%.*g", digits, three[i]);
}

static void print_head(const char *first, const char *const *columns, size_t count,
                       const char *last)
{
    printf("%s", first);
    for (size_t i = 0; i < count; i++)
        printf(",%s,%s_min,%s_max", columns[i], columns[i], columns[i]);
    printf("%s\n", last);
}

static bool wanted(const char *name)
{
    for (int i = 0; i < options.name_count; i++) {
        if (strcmp(name, options.names[i]) == 0)
            return true;
    }
    return options.name_count == 0;
}

enum { PROBLEM_COLUMNS = 8 };
static const char *const problem_columns[PROBLEM_COLUMNS] = {
    "volume_ratio", "side_ratio", "same_purity",    "purity",
    "width_error",  "seconds",    "search_seconds", "trim_seconds",
};

static void print_problem(const struct problem *problem, enum budget budget, double target,
                          const struct found *found, uint32_t variables, int count, int seed)
{
    double exact = 0;
    for (uint32_t v = 0; v < variables; v++)
        exact += log(exact_width(problem, v));
    uint32_t cells = 0;
    g_autofree double *sum = problem->ball > 0 ? sum_of_squares(problem->ball, &cells) : NULL;
    double values[PROBLEM_COLUMNS][BENCH_SEEDS_MAX];
    double evaluations = 0;
    double end_evaluations = 0;
    int certified = 0;
    for (int i = 0; i < count; i++) {
        const struct found *one = &found[i];
        const double ratio = one->log_volume - exact;
        values[0][i] = exp(ratio);
        values[1][i] = exp(ratio / variables);
        values[2][i] =
            sum == NULL
                ? NAN
                : exp(one->log_volume - cube_log_volume(sum, cells, variables, one->purity));
        values[3][i] = one->purity;
        values[4][i] = one->width_error;
        values[5][i] = one->seconds;
        values[6][i] = one->search_seconds;
        values[7][i] = one->trim_seconds;
        evaluations += one->evaluations / count;
        end_evaluations += one->end_evaluations / count;
        certified += one->certified;
    }
    static const int digits[PROBLEM_COLUMNS] = {4, 4, 4, 6, 4, 3, 3, 3};
    if (seed > 0)
        printf("%d,", seed);
    printf("%s,%s,%d,%g,%.0f,%d,%.0f", problem->name, budgets[budget].name, count, target,
           evaluations, certified, end_evaluations);
    for (int column = 0; column < PROBLEM_COLUMNS; column++)
        print_three(digits[column], values[column], count);
    const struct peer *peer = &problem->peer[budget];
    printf(",%.4g,%.4g,%.4f\n", peer->volume, peer->same_purity, peer->purity);
    fflush(stdout);
}

static void bench_problem(const struct problem *problem, enum budget budget)
{
    const double target = options.target > 0 ? options.target : problem->target[budget];
    g_autofree char *purity = g_strdup_printf("search.target_purity=%.10g", target);
    const char *own[4] = {budgets[budget].overrides[0], budgets[budget].overrides[1],
                          budgets[budget].overrides[2], purity};
    g_autofree char *path = g_strconcat("benchmarks/", problem->name, NULL);
    struct scenario scenario = read_scenario(path, own, G_N_ELEMENTS(own));
    struct found *found = run_seeds(&scenario, problem);
    const uint32_t variables = scenario.design_space.count;
    if (options.each) {
        for (int i = 0; i < options.seeds; i++)
            print_problem(problem, budget, target, &found[i], variables, 1, i + 1);
    } else {
        print_problem(problem, budget, target, found, variables, options.seeds, 0);
    }
    g_free(found);
    scenario_fini(&scenario);
}

static void bench_problems(void)
{
    print_head(options.each ? "seed,problem,budget,seeds,target,evaluations,certified,"
                              "evaluations_to_the_end"
                            : "problem,budget,seeds,target,evaluations,certified,"
                              "evaluations_to_the_end",
               problem_columns, PROBLEM_COLUMNS, ",peer_volume_ratio,peer_same_purity,peer_purity");
    for (size_t i = 0; i < G_N_ELEMENTS(problems); i++) {
        for (enum budget budget = 0; budget < BUDGET_COUNT; budget++) {
            if (wanted(problems[i].name) &&
                (options.budget == BUDGET_COUNT || options.budget == (int)budget))
                bench_problem(&problems[i], budget);
        }
    }
}

enum { VEHICLE_COLUMNS = 6 };
static const char *const vehicle_columns[VEHICLE_COLUMNS] = {
    "log_volume", "purity", "evaluations", "seconds", "search_seconds", "trim_seconds",
};

static void print_vehicle(const char *vehicle, const char *response, const struct found *found,
                          int count, int seed)
{
    double values[VEHICLE_COLUMNS][BENCH_SEEDS_MAX];
    int certified = 0;
    for (int i = 0; i < count; i++) {
        values[0][i] = found[i].end_log_volume;
        values[1][i] = found[i].end_purity;
        values[2][i] = found[i].end_evaluations;
        values[3][i] = found[i].seconds;
        values[4][i] = found[i].search_seconds;
        values[5][i] = found[i].trim_seconds;
        certified += found[i].certified;
    }
    static const int digits[VEHICLE_COLUMNS] = {4, 6, 6, 3, 3, 3};
    if (seed > 0)
        printf("%d,", seed);
    printf("%s,%s,%d,%d", vehicle, response, count, certified);
    for (int column = 0; column < VEHICLE_COLUMNS; column++)
        print_three(digits[column], values[column], count);
    putchar('\n');
    fflush(stdout);
}

static void bench_vehicle(const char *vehicle, const char *response)
{
    g_autofree char *own = g_strconcat("response=", response, NULL);
    const char *const overrides[1] = {own};
    struct scenario scenario = read_scenario(vehicle, overrides, 1);
    struct found *found = run_seeds(&scenario, NULL);
    if (options.each) {
        for (int i = 0; i < options.seeds; i++)
            print_vehicle(vehicle, response, &found[i], 1, i + 1);
    } else {
        print_vehicle(vehicle, response, found, options.seeds, 0);
    }
    g_free(found);
    scenario_fini(&scenario);
}

static void bench_vehicles(void)
{
    print_head(options.each ? "seed,vehicle,response,seeds,certified"
                            : "vehicle,response,seeds,certified",
               vehicle_columns, VEHICLE_COLUMNS, "");
    for (size_t i = 0; i < G_N_ELEMENTS(vehicles); i++) {
        for (size_t j = 0; j < G_N_ELEMENTS(responses) && wanted(vehicles[i]); j++)
            bench_vehicle(vehicles[i], responses[j]);
    }
}

// ---- The program ----

static void refuse(const char *what)
{
    fprintf(stderr,
            "search_bench: %s\n"
            "expected: search_bench [--seeds N] [--threads N] [--budget small|large] [--target P] "
            "[--set KEY=VALUE]... [--each] problems|vehicles [NAME...]\n",
            what);
    exit(2);
}

static int count_of(const char *text, int most)
{
    char *end;
    const long count = strtol(text, &end, 10);
    if (*end != 0 || count < 1 || count > most)
        refuse("a count out of its range");
    return (int)count;
}

static void take_option(const char *option, const char *value)
{
    if (strcmp(option, "--seeds") == 0) {
        options.seeds = count_of(value, BENCH_SEEDS_MAX);
    } else if (strcmp(option, "--threads") == 0) {
        options.threads = count_of(value, 1024);
    } else if (strcmp(option, "--budget") == 0) {
        options.budget = BUDGET_SMALL;
        while (options.budget < BUDGET_COUNT && strcmp(value, budgets[options.budget].name) != 0)
            options.budget++;
        if (options.budget == BUDGET_COUNT)
            refuse("a budget is small or large");
    } else if (strcmp(option, "--target") == 0) {
        options.target = strtod(value, NULL);
    } else if (strcmp(option, "--set") == 0 && options.override_count < BENCH_OVERRIDES_MAX) {
        options.overrides[options.override_count++] = value;
    } else {
        refuse("an option that there is not");
    }
}

int main(int argc, char **argv)
{
    int at = 1;
    while (at < argc && argv[at][0] == '-') {
        if (strcmp(argv[at], "--each") == 0) {
            options.each = true;
            at++;
            continue;
        }
        if (at + 1 >= argc)
            refuse("an option without its value");
        take_option(argv[at], argv[at + 1]);
        at += 2;
    }
    if (at >= argc)
        refuse("nothing to measure");
    options.names = argv + at + 1;
    options.name_count = argc - at - 1;
    if (strcmp(argv[at], "problems") == 0)
        bench_problems();
    else if (strcmp(argv[at], "vehicles") == 0)
        bench_vehicles();
    else
        refuse("neither problems nor vehicles");
    return 0;
}
