// The table for the terminal: at most 80 columns, no drawing characters.
#include "common/base/plain.h"
#include "coordinator/report/holding.h"
#include "coordinator/report/number.h"
#include "coordinator/report/report.h"
#include "coordinator/report/run_data.h"
#include "coordinator/report/seeds.h"
#include "coordinator/report/warnings.h"
#include "coordinator/report/worst.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- units, or none ----

// What a column's numbers are: (value - from) / span. With units kilonewtons and metres;
// normalised, as in the pictures, shares of all forces of a direction and of each spring's
// deformation, which tell nobody what the car is made of.
struct measure {
    double from, span;
    int decimals;
    const char *unit;
};

struct measures {
    struct measure force[SCENARIO_DIRECTION_COUNT];
    struct measure deformation;
};

static double measured(const struct measure *measure, double value)
{
    return (value - measure->from) / measure->span;
}

static struct measure share_between(double least, double greatest)
{
    return (struct measure){
        .from = least, .span = greatest > least ? greatest - least : 1, .decimals = 3, .unit = ""};
}

static struct measure force_share(const struct scenario *scenario,
                                  enum scenario_direction direction)
{
    double least = INFINITY, greatest = -INFINITY;
    for (uint32_t i = 0; i < scenario->design_space.count; i++) {
        if (scenario->variables[i].direction != direction)
            continue;
        least = fmin(least, scenario->design_space.lower[i]);
        greatest = fmax(greatest, scenario->design_space.upper[i]);
    }
    return share_between(least, greatest);
}

// ---- corridors ----

// Enough decimals of a kilonewton that the corridors of weak parts can be told apart.
static int force_decimals(const struct scenario_spring *spring)
{
    double greatest = 0;
    for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
        for (uint32_t k = 0; k < spring->point_count; k++)
            greatest = fmax(greatest, spring->force_upper[d][k]);
    return greatest >= 100e3 ? 1 : greatest >= 10e3 ? 2 : 3;
}

static struct measures measures_of(const struct scenario *scenario,
                                   const struct scenario_spring *spring, bool normalise)
{
    if (normalise)
        return (struct measures){.force = {force_share(scenario, SCENARIO_DIRECTION_X),
                                           force_share(scenario, SCENARIO_DIRECTION_Y)},
                                 .deformation =
                                     share_between(spring->deformation[0],
                                                   spring->deformation[spring->point_count - 1])};
    const struct measure force = {.span = 1e3, .decimals = force_decimals(spring), .unit = "[kN]"};
    return (struct measures){.force = {force, force},
                             .deformation = {.span = 1, .decimals = 3, .unit = "[m]"}};
}

static void print_interval(const struct run_data_search *search, uint32_t variable,
                           const struct measure *force, FILE *out)
{
    const struct box *space = &search->scenario.design_space, *box = search->box;
    double width = space->upper[variable] - space->lower[variable];
    fprintf(out, " %11.*f %9.*f", force->decimals, measured(force, box->lower[variable]),
            force->decimals, measured(force, box->upper[variable]));
    if (width > 0 && box->lower[variable] == box->upper[variable])
        fprintf(out, " %8s", "held");
    else if (width > 0)
        fprintf(out, " %8.1f", 100 * (box->upper[variable] - box->lower[variable]) / width);
    else
        fprintf(out, " %8s", "fixed");
}

static void print_spring(const struct run_data_search *search, uint32_t index, bool normalise,
                         FILE *out)
{
    const struct scenario_spring *spring = &search->scenario.springs[index];
    const struct measures measures = measures_of(&search->scenario, spring, normalise);
    const char *force_unit = measures.force[0].unit;
    fprintf(out, "\n%s\n", spring->name);
    fprintf(out, "%12s %11s %9s %8s %11s %9s %8s\n", "deformation", "F_x lower", "upper", "share",
            "F_y lower", "upper", "share");
    fprintf(out, "%12s %11s %9s %8s %11s %9s %8s\n", measures.deformation.unit, force_unit,
            force_unit, "[%]", force_unit, force_unit, "[%]");
    const uint32_t reached = reach_points(&search->reach, &search->scenario, index);
    for (uint32_t k = 0; k < spring->point_count; k++) {
        fprintf(out, "%c%11.3f", k < reached ? ' ' : '*',
                measured(&measures.deformation, spring->deformation[k]));
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
            print_interval(search, run_data_variable(search, index, (enum scenario_direction)d, k),
                           &measures.force[d], out);
        fputc('\n', out);
    }
}

// A bound and its spread over several seeds, with as many digits as the spread leaves it.
static void print_bound(const struct measure *measure, double bound, double spread, FILE *out)
{
    const double own = spread / measure->span;
    const int decimals = seeds_decimals(own, measure->decimals);
    const int shown = decimals < 0 ? 0 : decimals;
    const double unit = pow(10, -decimals);
    fprintf(out, " %9.*f", shown, round(measured(measure, bound) / unit) * unit);
    if (spread > 0)
        fprintf(out, " %6.*f", shown, fmax(round(own / unit), 1) * unit);
    else
        fprintf(out, " %6s", "-");
}

// A spring of a box that was searched with several seeds: the spread in place of the share.
static void print_spread(const struct run_data_search *search, uint32_t index,
                         const struct box *spread, bool normalise, FILE *out)
{
    const struct scenario_spring *spring = &search->scenario.springs[index];
    const struct measures measures = measures_of(&search->scenario, spring, normalise);
    const char *force_unit = measures.force[0].unit;
    const uint32_t reached = reach_points(&search->reach, &search->scenario, index);
    fprintf(out, "\n%s\n%12s", spring->name, "deformation");
    for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++)
        fprintf(out, " %9s %6s %9s %6s", d == 0 ? "F_x lower" : "F_y lower", "+-", "upper", "+-");
    fprintf(out, "\n%12s", measures.deformation.unit);
    for (int side = 0; side < 2 * SCENARIO_DIRECTION_COUNT; side++)
        fprintf(out, " %9s %6s", force_unit, force_unit);
    fputc('\n', out);
    for (uint32_t k = 0; k < spring->point_count; k++) {
        fprintf(out, "%c%11.3f", k < reached ? ' ' : '*',
                measured(&measures.deformation, spring->deformation[k]));
        for (int d = 0; d < SCENARIO_DIRECTION_COUNT; d++) {
            const uint32_t v = run_data_variable(search, index, (enum scenario_direction)d, k);
            print_bound(&measures.force[d], search->box->lower[v], spread->lower[v], out);
            print_bound(&measures.force[d], search->box->upper[v], spread->upper[v], out);
        }
        fputc('\n', out);
    }
}

// What the marks mean, where there are any.
static void print_reach(const struct run_data_search *search, FILE *out)
{
    char designs[NUMBER_SIZE];
    if (!reach_everything(&search->reach, &search->scenario))
        fprintf(out,
                "\n* none of %s simulated designs of these corridors presses the spring so\n"
                "  far that the force here plays a part\n",
                number_count(REACH_DESIGNS, designs));
}

// Cars that no barrier holds any more are told wherever there are some: no response but rotating
// asks for anything that would keep them out.
static void print_turned(const struct run_data_search *search, FILE *out)
{
    char turned[NUMBER_SIZE], designs[NUMBER_SIZE];
    if (search->reach.turned > 0)
        fprintf(out,
                "turned       %s of %s simulated designs turn beyond 90 degrees, where no\n"
                "             spring meets the barrier: their outcomes are those of no crash\n",
                number_count(search->reach.turned, turned), number_count(REACH_DESIGNS, designs));
}

// ---- variables that are no spring's ----

static void print_variable(const struct run_data_search *search, uint32_t index, int name_width,
                           bool normalise, FILE *out)
{
    const struct box *space = &search->scenario.design_space, *box = search->box;
    const double width = space->upper[index] - space->lower[index];
    const struct measure measure = normalise
                                       ? share_between(space->lower[index], space->upper[index])
                                       : (struct measure){.span = 1};
    fprintf(out, "%-*.*s %12.6g %12.6g", name_width, name_width,
            search->scenario.variables[index].name, measured(&measure, box->lower[index]),
            measured(&measure, box->upper[index]));
    if (width > 0 && box->lower[index] == box->upper[index])
        fprintf(out, " %7s", "held");
    else if (width > 0)
        fprintf(out, " %7.1f", 100 * (box->upper[index] - box->lower[index]) / width);
    else
        fprintf(out, " %7s", "fixed");
    fprintf(out, " %11.5g %11.5g\n", measured(&measure, space->lower[index]),
            measured(&measure, space->upper[index]));
}

// Names of their own have no unit that the program knows.
static void print_variables(const struct run_data_search *search, bool normalise, FILE *out)
{
    enum { WIDTH_MIN = 8, WIDTH_MAX = 20 }; // columns, so that a line has at most 80
    int name_width = WIDTH_MIN;
    const uint32_t count = search->scenario.design_space.count;
    for (uint32_t i = 0; i < count; i++)
        name_width =
            MAX(name_width, (int)MIN(strlen(search->scenario.variables[i].name), WIDTH_MAX));
    fprintf(out, "\n%-*s %12s %12s %7s %11s %11s\n", name_width, "variable", "lower", "upper",
            "share", "design from", "to");
    fprintf(out, "%-*s %12s %12s %7s\n", name_width, "", "", "", "[%]");
    for (uint32_t i = 0; i < count; i++)
        print_variable(search, i, name_width, normalise, out);
}

// ---- how it went ----

struct status_meaning {
    const char *status, *meaning;
};

static const struct status_meaning STATUS_MEANINGS[] = {
    {"done", "done: the corridors keep what was asked for"},
    {"purity_missed", "corridors found, but they do not keep what was asked for"},
    {"no_good_design", "no good design found"},
    {"running", "running, or stopped without notice: the corridors are not final"},
    {"interrupted", "interrupted, can be resumed: the corridors are not final"},
    {"failed", "failed, can be resumed: the corridors are not final"},
};

static const char *status_meaning(const char *status)
{
    for (size_t i = 0; i < G_N_ELEMENTS(STATUS_MEANINGS); i++)
        if (strcmp(STATUS_MEANINGS[i].status, status) == 0)
            return STATUS_MEANINGS[i].meaning;
    return status;
}

// Which constraint is worst violated by most samples, and by how many: what to relax first.
static void print_obstacle(const struct run_data_search *search, bool normalise, FILE *out)
{
    const struct scenario *scenario = &search->scenario;
    uint32_t worst = 0;
    for (uint32_t i = 1; i < scenario->constraint_count; i++)
        if (search->worst[i] > search->worst[worst])
            worst = i;
    if (search->worst[worst] == 0)
        return;
    char *words = holding_constraint(scenario, worst, normalise);
    char bad[NUMBER_SIZE], judged[NUMBER_SIZE];
    fprintf(out, "in the way   %s: violated worst by %s of %s samples\n", words,
            number_count(search->worst[worst], bad), number_count(search->judged, judged));
    g_free(words);
}

// One line a kind of designs: what each holds is another promise.
static void print_kind(enum design_kind kind, double estimate, double lower95, FILE *out)
{
    static const char *const meaning[] = {
        [DESIGN_KIND_POINTS] = "every force on its own",
        [DESIGN_KIND_CURVES] = "every curve at a level of its own",
        [DESIGN_KIND_LEVELS] = "one level for F_x, one for F_y",
        [DESIGN_KIND_EXTREMES] = "curves along bounds, or at a level",
    };
    fprintf(out, "  %-10s %.4f  at least %.4f   %s\n", protocol_kind_name(kind), estimate,
            floor(lower95 * 1e4) * 1e-4, meaning[kind]); // a bound is not rounded up
}

// What the corridors promise, and what they do not.
static void print_promise(const struct run_data_search *search, FILE *out)
{
    static const char *const meaning[] = {
        [PROMISE_POINTS] = "the wanted share of independent forces is good; whole curves are\n"
                           "             not promised",
        [PROMISE_CURVES] = "the wanted share of each kind below is good; single bad designs are\n"
                           "             not excluded",
        [PROMISE_EVERY] = "the wanted share of each kind below is good, and an adversarial\n"
                          "             search with fresh starts found no bad design",
    };
    const bool kept = strcmp(search->status, "done") == 0;
    const enum promise promise = search->scenario.search.promise;
    if (kept && search->scenario.curves.count < search->scenario.curves.variables)
        fprintf(out, "promise      %s: %s\n", protocol_promise_name(promise), meaning[promise]);
}

static void print_purity(const struct run_data_search *search, FILE *out)
{
    const struct journal_search *record = &search->record;
    char samples[NUMBER_SIZE];
    if (!record->finished || record->purity_samples == 0) {
        fprintf(out, "purity       not certified%s\n", record->finished ? "" : " yet");
        return;
    }
    fprintf(out, "purity       of %s fresh designs of each kind, with 95 %% confidence\n",
            number_count(record->purity_samples, samples));
    print_kind(DESIGN_KIND_POINTS, record->purity_estimate, record->purity_lower95, out);
    for (int kind = DESIGN_KIND_POINTS + 1; kind < DESIGN_KIND_COUNT; kind++) {
        const uint64_t count = search->kinds[kind].samples;
        if (count > 0)
            print_kind((enum design_kind)kind,
                       (double)(count - search->kinds[kind].bad) / (double)count,
                       search->kinds[kind].lower95, out);
    }
}

// How the bounds were rounded, and which were not: too narrow, or in the way of what is asked for.
static void print_rounding(const struct run_data_search *search, bool normalise, FILE *out)
{
    const struct scenario *scenario = &search->scenario;
    if (!(scenario->search.round > 0) || search->box == NULL || !search->record.finished)
        return;
    fputs("rounded      inwards", out);
    if (!normalise)
        fprintf(out, " to multiples of %.10g", scenario->search.round);
    const char *before = ", but for these, of which no width\n             would be left: ";
    for (uint32_t v = 0; v < search->box->count; v++) {
        if (scenario_is_rounded(scenario, search->box, v))
            continue;
        fprintf(out, "%s%s", before, scenario->variables[v].name);
        before = ", ";
    }
    fputc('\n', out);
}

static void print_cost(const struct run_data_search *search, FILE *out)
{
    char evaluations[NUMBER_SIZE], rate[NUMBER_SIZE];
    double wall = (double)search->wall_ns * 1e-9;
    fprintf(out, "simulated    %s designs in %u steps",
            number_count(search->evaluations, evaluations), search->steps->len);
    if (wall > 0)
        fprintf(out, ", %.*f s, %s designs/s", wall < 10 ? 2 : 0, wall,
                number_count((uint64_t)((double)search->evaluations / wall), rate));
    fputc('\n', out);
    if (search->record.non_finite > 0)
        fprintf(out, "             %s of them gave no finite outcome and count as bad\n",
                number_count(search->record.non_finite, evaluations));
}

static void print_title(const struct run_data_search *search, const char *name, FILE *out)
{
    const struct scenario *scenario = &search->scenario;
    fputs(name, out);
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP)
        fprintf(out, ", model %s", scenario_model_name(scenario->model));
    else if (scenario->case_count == 0)
        fprintf(out, ", response %s", scenario_response_name(scenario->response));
    for (uint32_t i = 0; i < scenario->case_count; i++)
        fprintf(out, "%s%s", i == 0 ? ", good in " : " and ", scenario->cases[i].name);
    fputc('\n', out);
}

// `spread` of the bounds over several seeds, or NULL.
static void print_search(const struct run_data_search *search, const struct report_table *table,
                         const struct box *spread, FILE *out)
{
    const bool normalise = table->normalise;
    char *name = plain_text(search->name), *status = plain_text(status_meaning(search->status));
    print_title(search, name, out);
    for (uint32_t i = 0; search->box != NULL && i < search->scenario.spring_count; i++)
        if (spread != NULL)
            print_spread(search, i, spread, normalise, out);
        else
            print_spring(search, i, normalise, out);
    print_reach(search, out);
    if (search->box != NULL && search->scenario.spring_count == 0)
        print_variables(search, normalise, out);
    if (table->bounds)
        holding_print_bounds(search, normalise, out);
    holding_print_summary(search, normalise, out);
    fprintf(out, "\nstatus       %s\n", status);
    warnings_print(search, out);
    if (run_data_found_nothing(search)) {
        // It is looked at first, and alone.
        if (search->scenario.search.reference != NULL && search->evaluations == 1)
            fputs("reference    search.reference is not a good design: no box may contain it\n",
                  out);
        print_obstacle(search, normalise, out);
        holding_print_least(search, normalise, out);
    } else {
        print_promise(search, out);
        print_purity(search, out);
        worst_print(search, normalise, out);
        if (search->box != NULL)
            fprintf(out, "log-volume   %.3f (0 is the whole design space)\n", search->log_volume);
        print_rounding(search, normalise, out);
        print_turned(search, out);
    }
    print_cost(search, out);
    g_free(name);
    g_free(status);
}

// ---- a sweep ----

// One line a search: their tables would bury each other.
static void print_line(const struct run_data_search *search, uint32_t index, int width, FILE *out)
{
    char *name = plain_text(search->name), *status = plain_text(search->status);
    char evaluations[NUMBER_SIZE];
    fprintf(out, "%5" PRIu32 " %-*.*s %-14.14s", index, width, width, name, status);
    if (search->box != NULL)
        fprintf(out, " %9.3f", search->log_volume);
    else
        fprintf(out, " %9s", "-");
    if (search->record.finished && search->record.purity_samples > 0)
        fprintf(out, " %9.4f", floor(search->record.purity_lower95 * 1e4) * 1e-4);
    else
        fprintf(out, " %9s", "-");
    fprintf(out, " %12s\n", number_count(search->evaluations, evaluations));
    g_free(name);
    g_free(status);
}

enum { LINES_MAX = 60, LINES_END = 10 }; // of a long sweep the first ones and the last are shown

// The case's name is worth more room than a terminal's width leaves it; a line that wraps is still
// a line.
static enum status print_lines(const struct run_data *data, FILE *out, struct error *error)
{
    char *name = plain_text(data->run.name);
    const uint32_t count = data->run.search_count;
    uint32_t warned = 0;
    int width = 24;
    enum status status = STATUS_OK;
    fprintf(out, "%s, %" PRIu32 " searches\n\n", name, count);
    for (uint32_t i = 0; i < count && status == STATUS_OK; i++) {
        if (count > LINES_MAX && i == LINES_MAX - LINES_END) {
            i = count - LINES_END;
            fprintf(out, "%5s ... all of them in summary.csv\n", "");
        }
        struct run_data_search search;
        status = run_data_load(data, i, &search, error);
        if (status != STATUS_OK)
            break;
        if (i == 0) {
            width = (int)MAX(24, MIN(60, strlen(search.name) + 2));
            fprintf(out, "%5s %-*s %-14s %9s %9s %12s\n", "", width, "search", "status", "log-vol.",
                    "purity>=", "designs");
        }
        print_line(&search, i, width, out);
        warned += warnings_any(&search);
        run_data_release(&search);
    }
    if (warned > 0)
        fprintf(out,
                "\nwarning      %" PRIu32 " of these searches are doubtful: result.json says why\n",
                warned);
    g_free(name);
    return status;
}

// Of a run that differs in its seeds alone the best box is the result.
static enum status print_seeds(const struct run_data *data, const struct report_table *table,
                               FILE *out, struct error *error)
{
    struct seeds seeds;
    struct run_data_search best = {0};
    enum status status = seeds_read(data, &seeds, error);
    if (status == STATUS_OK && seeds.searches > 0)
        status = run_data_load(data, seeds.best, &best, error);
    if (status == STATUS_OK && seeds.searches > 0) {
        fprintf(out, "\nbest of %" PRIu32 " seeds: ", seeds.searches);
        run_data_find_reach(&best);
        print_search(&best, table, seeds.searches > 1 ? &seeds.spread : NULL, out);
        fprintf(out, "seeds        log-volume %.3f to %.3f, mean %.3f, spread %.3f\n",
                seeds.log_volume_least, seeds.log_volume, seeds.log_volume_mean,
                seeds.log_volume_spread);
        if (seeds.searches > 1)
            fputs(
                "             +- is the spread of a bound, its standard deviation over the seeds;\n"
                "             digits that it leaves no meaning are not shown\n",
                out);
    }
    run_data_release(&best);
    seeds_fini(&seeds);
    return status;
}

// ---- all of it ----

static void print_files(const char *directory, FILE *out)
{
    static const char *const NAMES[] = {
        "corridors.svg",
        "corridors.png",
        "corridors.pdf",
        "corridors.gp",
        "corridors-compared.svg",
        "corridors-normalised.svg",
        "corridors-compared-normalised.svg",
        "corridors.csv",
        "history.csv",
        "summary.csv",
        "result.json",
        "cases.svg",
        "cases-normalised.svg",
        "volume.svg",
        "run.db",
    };
    const char *label = "files";
    for (size_t i = 0; i < G_N_ELEMENTS(NAMES); i++) {
        char *path = g_build_filename(directory, NAMES[i], NULL);
        if (g_file_test(path, G_FILE_TEST_EXISTS)) {
            fprintf(out, "%-12s %s\n", label, path);
            label = "";
        }
        g_free(path);
    }
}

enum status report_print(const char *directory, const struct report_table *table, FILE *out,
                         struct error *error)
{
    struct run_data data;
    enum status status = run_data_open(&data, directory, error);
    if (status != STATUS_OK)
        return status;
    if (run_data_is_sweep(&data)) {
        status = print_lines(&data, out, error);
        if (status == STATUS_OK && seeds_alone(&data))
            status = print_seeds(&data, table, out, error);
    } else {
        struct run_data_search search;
        status = run_data_load(&data, 0, &search, error);
        if (status == STATUS_OK) {
            run_data_find_reach(&search);
            print_search(&search, table, NULL, out);
        }
        run_data_release(&search);
    }
    if (status == STATUS_OK)
        print_files(directory, out);
    run_data_fini(&data);
    if (status != STATUS_OK)
        return status;
    if (fflush(out) != 0 || ferror(out))
        return error_set(error, STATUS_IO, "the report could not be printed");
    return STATUS_OK;
}
