#include "coordinator/report/plot.h"
#include "common/base/whole_file.h"
#include "coordinator/report/bars.h"
#include "coordinator/report/figure.h"
#include "coordinator/report/gnuplot.h"
#include "coordinator/report/run_data.h"

#include <assert.h>
#include <glib/gstdio.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

const char *report_format_name(enum report_format format)
{
    static const char *const NAMES[] = {
        [REPORT_SVG] = "svg", [REPORT_PNG] = "png", [REPORT_PDF] = "pdf"};
    assert(format < G_N_ELEMENTS(NAMES));
    return NAMES[format];
}

// ---- what is drawn ----

// Loads the one search of a run folder that is to be drawn.
static enum status load_search(struct run_data *data, const char *directory, uint32_t index,
                               struct run_data_search *search, struct error *error)
{
    enum status status = run_data_open(data, directory, error);
    if (status == STATUS_OK && index >= data->run.search_count)
        status = error_set(error, STATUS_INVALID,
                           "%s: there is no search %" PRIu32 ", expected 0 to %" PRIu32, directory,
                           index, data->run.search_count - 1);
    if (status == STATUS_OK)
        status = run_data_load(data, index, search, error);
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
                        plot->normalise ? "-normalised" : "", report_format_name(plot->format));
    char *path = g_build_filename(directory, file, NULL);
    g_free(file);
    return path;
}

static char *corridors_output(const char *directory, const struct report_plot *plot)
{
    char name[32] = "corridors";
    if (plot->search > 0)
        g_snprintf(name, sizeof name, "corridors-%" PRIu32, plot->search);
    return plot_output(directory, name, plot);
}

// The path without its ending: "run/corridors" of "run/corridors.svg".
static char *path_stem(const char *path)
{
    char *stem = g_strdup(path);
    char *dot = strrchr(stem, '.'), *slash = strrchr(stem, G_DIR_SEPARATOR);
    if (dot != NULL && dot > (slash != NULL ? slash + 1 : stem))
        *dot = '\0';
    return stem;
}

char *plot_stem(const char *output)
{
    char *path = path_stem(output), *stem = g_path_get_basename(path);
    g_free(path);
    return stem;
}

enum status plot_write(const char *script, const char *output, enum report_format format,
                       struct error *error)
{
    char *path = path_stem(output), *script_path = g_strconcat(path, ".gp", NULL);
    GBytes *picture = NULL;
    enum status status = whole_file_write(script_path, script, strlen(script), error);
    if (status == STATUS_OK)
        status = gnuplot_run(script_path, report_format_name(format), &picture, error);
    if (status == STATUS_OK)
        status = whole_file_write(output, g_bytes_get_data(picture, NULL),
                                  g_bytes_get_size(picture), error);
    g_clear_pointer(&picture, g_bytes_unref);
    g_free(script_path);
    g_free(path);
    return status;
}

// gnuplot takes a script from a file only where it may also be run by hand; this one goes again.
enum status plot_inline(const char *script, char **svg, struct error *error)
{
    GError *failure = NULL;
    char *path = NULL;
    *svg = NULL;
    const int file = g_file_open_tmp("sobox-report-XXXXXX.gp", &path, &failure);
    if (file < 0) {
        error_set(error, STATUS_IO, "%s", failure->message);
        g_error_free(failure);
        return STATUS_IO;
    }
    close(file);
    GBytes *picture = NULL;
    enum status status = whole_file_write(path, script, strlen(script), error);
    if (status == STATUS_OK)
        status = gnuplot_run(path, "svg", &picture, error);
    if (status == STATUS_OK) {
        char *text = g_strndup(g_bytes_get_data(picture, NULL), g_bytes_get_size(picture));
        const char *element = strstr(text, "<svg");
        *svg = g_strdup(element != NULL ? element : text);
        g_free(text);
    }
    g_clear_pointer(&picture, g_bytes_unref);
    g_unlink(path);
    g_free(path);
    return status;
}

static enum status draw_figure(struct figure *figure, const char *output, enum report_format format,
                               struct error *error)
{
    char *stem = plot_stem(output);
    figure->stem = stem;
    // Two runs of which one has no springs have variables in common at best.
    const bool springs = figure->search->scenario.spring_count > 0 &&
                         (figure->other == NULL || figure->other->scenario.spring_count > 0);
    char *script = springs ? figure_script(figure) : bars_script(figure);
    enum status status = plot_write(script, output, format, error);
    g_free(script);
    g_free(stem);
    return status;
}

enum status report_draw(const char *directory, const struct report_plot *plot, struct error *error)
{
    struct run_data data = {0}, other_data = {0};
    struct run_data_search search = {0}, compared = {0};
    const struct run_data_search *other = plot->compare != NULL ? &compared : NULL;
    enum status status = load_search(&data, directory, plot->search, &search, error);
    if (status == STATUS_OK && other != NULL)
        status = load_search(&other_data, plot->compare, 0, &compared, error);
    if (status == STATUS_OK && other != NULL)
        status = check_comparable(&search, other, plot, error);
    if (status == STATUS_OK) {
        char *label = legend_label(&search, other, directory);
        char *other_label = other != NULL ? legend_label(other, &search, plot->compare) : NULL;
        char *output = corridors_output(directory, plot);
        struct figure figure = {.search = &search,
                                .other = other,
                                .search_label = label,
                                .other_label = other_label,
                                .normalise = plot->normalise};
        status = draw_figure(&figure, output, plot->format, error);
        g_free(output);
        g_free(other_label);
        g_free(label);
    }
    run_data_release(&compared);
    run_data_release(&search);
    run_data_fini(&other_data);
    run_data_fini(&data);
    return status;
}
