#include "coordinator/report/plot.h"
#include "common/plot/gnuplot.h"
#include "common/plot/picture.h"
#include "coordinator/report/bars.h"
#include "coordinator/report/figure.h"
#include "coordinator/report/run_data.h"
#include "coordinator/report/seeds.h"

#include <inttypes.h>
#include <string.h>

// ---- what is drawn ----

// Loads the one search of a run folder that is to be drawn.
static enum status load_search(struct run_data *data, const char *directory, uint32_t index,
                               struct run_data_search *search, struct error *error)
{
    enum status status = run_data_open(data, directory, error);
    if (status == STATUS_OK && index == REPORT_SEARCH_SHOWN)
        status = seeds_shown(data, &index, error);
    if (status == STATUS_OK && index >= data->run.search_count)
        status = error_set(error, STATUS_INVALID,
                           "%s: there is no search %" PRIu32 ", expected 0 to %" PRIu32, directory,
                           index, data->run.search_count - 1);
    if (status == STATUS_OK)
        status = run_data_load(data, index, search, error);
    if (status == STATUS_OK)
        run_data_find_reach(search);
    return status;
}

static enum status check_comparable(const struct run_data_search *search,
                                    const struct run_data_search *other,
                                    const struct report_plot *plot, struct error *error)
{
    if (other->box == NULL)
        return error_set(error, STATUS_INVALID, "%s: has no corridors to compare with",
                         plot->compare);
    if (search->scenario.spring_count == 0 || other->scenario.spring_count == 0) {
        if (bars_shared_variables(search, other) > 0)
            return STATUS_OK;
        return error_set(error, STATUS_INVALID,
                         "%s: none of its variables (%s, ...) has the name of one of the run it is "
                         "compared with (%s, ...)",
                         plot->compare, other->scenario.variables[0].name,
                         search->scenario.variables[0].name);
    }
    if (figure_shared_springs(search, other) == 0)
        return error_set(error, STATUS_INVALID,
                         "%s: none of its springs (%s, ...) has the name of one of the run it is "
                         "compared with (%s, ...)",
                         plot->compare, other->scenario.springs[0].name,
                         search->scenario.springs[0].name);
    return STATUS_OK;
}

static char *own_label(const struct scenario *scenario)
{
    if (scenario->model != SCENARIO_MODEL_SMALL_OVERLAP)
        return g_strdup_printf("corridor, model: %s", scenario_model_name(scenario->model));
    if (scenario->case_count > 0)
        return g_strdup_printf("corridor, good in %u cases", scenario->case_count);
    return g_strdup_printf("corridor, response: %s", scenario_response_name(scenario->response));
}

// The first thing in which two searches differ is what a reader wants to see in the legend.
static char *legend_label(const struct run_data_search *search, const struct run_data_search *other,
                          const char *directory)
{
    if (other == NULL)
        return own_label(&search->scenario);
    if (strcmp(search->name, other->name) != 0)
        return g_strdup(search->name);
    if (search->scenario.model == other->scenario.model &&
        search->scenario.response != other->scenario.response)
        return g_strdup_printf("response: %s", scenario_response_name(search->scenario.response));
    if (search->record.seed != other->record.seed)
        return g_strdup_printf("seed %" PRIu64, search->record.seed);
    char *absolute = g_canonicalize_filename(directory, NULL);
    char *label = g_path_get_basename(absolute);
    g_free(absolute);
    return label;
}

// ---- where it goes ----

char *plot_output(const char *directory, const char *name, const struct report_plot *plot)
{
    if (plot->output != NULL)
        return g_strdup(plot->output);
    char *file =
        g_strdup_printf("%s%s%s.%s", name, plot->compare != NULL ? "-compared" : "",
                        plot->normalise ? "-normalised" : "", picture_format_name(plot->format));
    char *path = g_build_filename(directory, file, NULL);
    g_free(file);
    return path;
}

static char *corridors_output(const char *directory, const struct report_plot *plot)
{
    char name[32] = "corridors";
    if (plot->search > 0 && plot->search != REPORT_SEARCH_SHOWN)
        g_snprintf(name, sizeof name, "corridors-%" PRIu32, plot->search);
    return plot_output(directory, name, plot);
}

static enum status draw_figure(struct figure *figure, const char *output,
                               enum picture_format format, struct error *error)
{
    char *stem = picture_stem(output);
    figure->stem = stem;
    // Two runs of which one has no springs have variables in common at best.
    const bool springs = figure->search->scenario.spring_count > 0 &&
                         (figure->other == NULL || figure->other->scenario.spring_count > 0);
    char *script = springs ? figure_script(figure) : bars_script(figure);
    enum status status = picture_write(script, output, format, error);
    g_free(script);
    g_free(stem);
    return status;
}

enum status report_draw(const char *directory, const struct report_plot *plot, struct error *error)
{
    struct run_data data = {0}, other_data = {0};
    struct run_data_search search = {0}, compared = {0};
    const struct run_data_search *other = plot->compare != NULL ? &compared : NULL;
    struct seeds seeds = {0};
    enum status status = load_search(&data, directory, plot->search, &search, error);
    if (status == STATUS_OK && plot->search == REPORT_SEARCH_SHOWN && seeds_alone(&data))
        status = seeds_read(&data, &seeds, error);
    if (status == STATUS_OK && other != NULL)
        status = load_search(&other_data, plot->compare, 0, &compared, error);
    if (status == STATUS_OK && other != NULL)
        status = check_comparable(&search, other, plot, error);
    if (status == STATUS_OK) {
        char *label = seeds.searches > 1 && other == NULL
                          ? g_strdup_printf("best of %" PRIu32 " seeds, bars: spread of each bound",
                                            seeds.searches)
                          : legend_label(&search, other, directory);
        char *other_label = other != NULL ? legend_label(other, &search, plot->compare) : NULL;
        char *output = corridors_output(directory, plot);
        if (seeds.searches > 1)
            search.name = search.scenario.name; // not that of its seed
        struct figure figure = {.search = &search,
                                .other = other,
                                .search_label = label,
                                .other_label = other_label,
                                .spread = seeds.searches > 1 ? &seeds.spread : NULL,
                                .normalise = plot->normalise};
        status = draw_figure(&figure, output, plot->format, error);
        g_free(output);
        g_free(other_label);
        g_free(label);
    }
    seeds_fini(&seeds);
    run_data_release(&compared);
    run_data_release(&search);
    run_data_fini(&other_data);
    run_data_fini(&data);
    return status;
}
