// The pictures and documents of a sweep.
#include "common/base/whole_file.h"
#include "common/plot/picture.h"
#include "coordinator/report/document.h"
#include "coordinator/report/overlay.h"
#include "coordinator/report/plot.h"
#include "coordinator/report/report.h"
#include "coordinator/report/rows.h"
#include "coordinator/report/volume.h"

#include <fnmatch.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

// ---- cases over each other ----

// What is drawn over each other, loaded.
struct chosen {
    struct run_data data;
    struct run_data_search *searches; // (count)
    uint32_t count;
};

static void chosen_fini(struct chosen *chosen)
{
    for (uint32_t i = 0; i < chosen->count; i++)
        run_data_release(&chosen->searches[i]);
    g_free(chosen->searches);
    run_data_fini(&chosen->data);
}

// Loads the searches of `indexes`.
static enum status chosen_load(struct chosen *chosen, const char *directory, const GArray *indexes,
                               struct error *error)
{
    *chosen = (struct chosen){.searches = g_new0(struct run_data_search, indexes->len)};
    enum status status = run_data_open(&chosen->data, directory, error);
    for (guint i = 0; i < indexes->len && status == STATUS_OK; i++) {
        status = run_data_load(&chosen->data, g_array_index(indexes, uint32_t, i),
                               &chosen->searches[chosen->count], error);
        if (status != STATUS_OK)
            break;
        run_data_find_reach(&chosen->searches[chosen->count++]);
    }
    return status;
}

static char *chosen_script(const struct chosen *chosen, const char *stem, bool normalise)
{
    const struct overlay overlay = {.title = chosen->data.run.name,
                                    .searches = chosen->searches,
                                    .count = chosen->count,
                                    .normalise = normalise,
                                    .stem = stem};
    return overlay_script(&overlay);
}

// The searches with corridors whose names match.
static enum status choose_cases(const struct rows *rows, const char *pattern, GArray *indexes,
                                struct error *error)
{
    for (uint32_t i = 0; i < rows->count; i++) {
        const struct rows_row *row = &rows->items[i];
        if (fnmatch(pattern, row->name, 0) == 0 && !isnan(row->log_volume))
            g_array_append_val(indexes, row->index);
    }
    if (indexes->len == 0)
        return error_set(error, STATUS_INVALID,
                         "--cases '%s' matches no case with corridors: expected a pattern of names "
                         "like '%s'",
                         pattern, rows->items[0].name);
    if (indexes->len > OVERLAY_MAX)
        return error_set(error, STATUS_INVALID,
                         "--cases '%s' matches %u cases: expected at most %d, whose colours can be "
                         "told apart",
                         pattern, indexes->len, OVERLAY_MAX);
    return STATUS_OK;
}

static bool all_have_springs(const struct chosen *chosen)
{
    for (uint32_t i = 0; i < chosen->count; i++)
        if (chosen->searches[i].scenario.spring_count == 0)
            return false;
    return true;
}

enum status report_draw_cases(const char *directory, const char *pattern,
                              const struct report_plot *plot, struct error *error)
{
    struct rows rows;
    struct chosen chosen = {0};
    enum status status = rows_read(&rows, directory, error);
    if (status != STATUS_OK)
        return status;
    GArray *indexes = g_array_new(FALSE, FALSE, sizeof(uint32_t));
    status = choose_cases(&rows, pattern, indexes, error);
    if (status == STATUS_OK)
        status = chosen_load(&chosen, directory, indexes, error);
    if (status == STATUS_OK && !all_have_springs(&chosen))
        status = error_set(error, STATUS_INVALID,
                           "--cases: corridors are drawn over deformation, and %s has no springs",
                           chosen.data.run.name);
    if (status == STATUS_OK) {
        const struct report_plot named = {
            .format = plot->format, .normalise = plot->normalise, .output = plot->output};
        char *output = plot_output(directory, "cases", &named);
        char *stem = picture_stem(output), *script = chosen_script(&chosen, stem, plot->normalise);
        status = picture_write(script, output, plot->format, error);
        g_free(script);
        g_free(stem);
        g_free(output);
    }
    chosen_fini(&chosen);
    g_array_unref(indexes);
    rows_fini(&rows);
    return status;
}

// ---- log-volume against axes ----

static enum status find_axis(const struct rows *rows, const char *path, uint32_t *axis,
                             struct error *error)
{
    *axis = rows_axis(rows, path);
    if (*axis < rows->axis_count)
        return STATUS_OK;
    char *axes = g_strjoinv(", ", rows->axes);
    error_set(error, STATUS_INVALID, "--against %s: expected one of the sweep's axes: %s", path,
              axes);
    g_free(axes);
    return STATUS_INVALID;
}

// "vehicle.mass" or "vehicle.mass,response".
static enum status volume_script(const struct rows *rows, const char *against, const char *stem,
                                 char **script, struct error *error)
{
    char **paths = g_strsplit(against, ",", -1);
    const guint count = g_strv_length(paths);
    uint32_t axes[2] = {0, 0};
    enum status status = STATUS_OK;
    if (count < 1 || count > 2)
        status = error_set(error, STATUS_INVALID,
                           "--against %s: expected one axis, or two with a comma between", against);
    for (guint i = 0; i < count && status == STATUS_OK; i++)
        status = find_axis(rows, paths[i], &axes[i], error);
    if (status == STATUS_OK && count == 2 && axes[0] == axes[1])
        status =
            error_set(error, STATUS_INVALID, "--against %s: expected two different axes", against);
    if (status == STATUS_OK && rows->found == 0)
        status = error_set(error, STATUS_INVALID, "--against: no case has corridors yet");
    if (status == STATUS_OK)
        *script = count == 1 ? volume_lines(rows, axes[0], stem)
                             : volume_map(rows, axes[0], axes[1], stem);
    g_strfreev(paths);
    return status;
}

enum status report_draw_volume(const char *directory, const char *against,
                               const struct report_plot *plot, struct error *error)
{
    struct rows rows;
    enum status status = rows_read(&rows, directory, error);
    if (status != STATUS_OK)
        return status;
    // Volumes are shares already.
    const struct report_plot named = {.format = plot->format, .output = plot->output};
    char *output = plot_output(directory, "volume", &named);
    char *stem = picture_stem(output), *script = NULL;
    status = volume_script(&rows, against, stem, &script, error);
    if (status == STATUS_OK)
        status = picture_write(script, output, plot->format, error);
    g_free(script);
    g_free(stem);
    g_free(output);
    rows_fini(&rows);
    return status;
}

// ---- documents ----

// A document on its way: its pictures are made one after the other.
struct making {
    struct rows rows;
    const char *directory; // of the run
    const char *path;      // of the document
    bool html;
    bool normalise;
    GArray *pictures; // of struct document_picture
};

static void picture_fini(gpointer element)
{
    struct document_picture *picture = element;
    g_free(picture->title);
    g_free(picture->svg);
    g_free(picture->file);
}

// A file beside the document, called after it: "masses-1.svg" of "masses.md".
static char *picture_path(const struct making *making)
{
    char *folder = g_path_get_dirname(making->path), *stem = picture_stem(making->path);
    char *name = g_strdup_printf("%s-%u.svg", stem, making->pictures->len + 1);
    char *path = g_build_filename(folder, name, NULL);
    g_free(name);
    g_free(stem);
    g_free(folder);
    return path;
}

// Takes over `script`.
static enum status add_picture(struct making *making, const char *title, char *script,
                               struct error *error)
{
    struct document_picture picture = {.title = g_strdup(title)};
    enum status status;
    if (making->html) {
        status = picture_inline(script, &picture.svg, error);
    } else {
        char *path = picture_path(making);
        picture.file = g_path_get_basename(path);
        status = picture_write(script, path, PICTURE_SVG, error);
        g_free(path);
    }
    g_free(script);
    if (status == STATUS_OK)
        g_array_append_val(making->pictures, picture);
    else
        picture_fini(&picture);
    return status;
}

// An axis worth a picture: it changes, is not the seed, and says what no earlier one said.
static bool worth_drawing(const struct rows *rows, uint32_t axis)
{
    uint32_t count;
    const char **values = rows_values(rows, axis, &count);
    g_free(values);
    bool worth = count > 1 && !rows_is_seed(rows, axis);
    for (uint32_t earlier = 0; earlier < axis && worth; earlier++)
        worth = !rows_follows(rows, axis, earlier);
    return worth;
}

static enum status add_volumes(struct making *making, struct error *error)
{
    const struct rows *rows = &making->rows;
    uint32_t first = UINT32_MAX, second = UINT32_MAX;
    enum status status = STATUS_OK;
    for (uint32_t a = 0; a < rows->axis_count && rows->found > 0; a++) {
        if (!worth_drawing(rows, a))
            continue;
        if (first == UINT32_MAX)
            first = a;
        else if (second == UINT32_MAX)
            second = a;
    }
    if (first != UINT32_MAX) {
        char *title = g_strdup_printf("Log-volume against %s", rows->axes[first]);
        status = add_picture(making, title, volume_lines(rows, first, "volume"), error);
        g_free(title);
    }
    if (status == STATUS_OK && second != UINT32_MAX) {
        char *title =
            g_strdup_printf("Log-volume over %s and %s", rows->axes[first], rows->axes[second]);
        status = add_picture(making, title, volume_map(rows, first, second, "map"), error);
        g_free(title);
    }
    return status;
}

// The searches whose corridors the document shows: those of --cases, else the best seed of each of
// the first combinations.
static enum status document_cases(const struct making *making, const char *pattern, GArray *indexes,
                                  struct error *error)
{
    const struct rows *rows = &making->rows;
    if (pattern != NULL)
        return choose_cases(rows, pattern, indexes, error);
    for (uint32_t group = 0; group < rows->group_count && indexes->len < OVERLAY_MAX; group++) {
        const struct rows_row *best = rows_best(rows, group);
        if (best != NULL)
            g_array_append_val(indexes, best->index);
    }
    return STATUS_OK;
}

static enum status add_corridors(struct making *making, const char *pattern, struct error *error)
{
    struct chosen chosen = {0};
    GArray *indexes = g_array_new(FALSE, FALSE, sizeof(uint32_t));
    enum status status = document_cases(making, pattern, indexes, error);
    if (status == STATUS_OK && indexes->len > 0)
        status = chosen_load(&chosen, making->directory, indexes, error);
    if (status == STATUS_OK && chosen.count > 0 && all_have_springs(&chosen))
        status = add_picture(making,
                             pattern != NULL ? "Corridors of the chosen cases"
                             : chosen.count < making->rows.group_count
                                 ? "Corridors of the first cases, the best seed of each"
                                 : "Corridors, the best seed of each case",
                             chosen_script(&chosen, "cases", making->normalise), error);
    chosen_fini(&chosen);
    g_array_unref(indexes);
    return status;
}

enum status report_document(const char *directory, const struct report_document *settings,
                            struct error *error)
{
    struct making making = {.directory = directory,
                            .path = settings->path,
                            .html = settings->html,
                            .normalise = settings->normalise};
    enum status status = rows_read(&making.rows, directory, error);
    if (status != STATUS_OK)
        return status;
    making.pictures = g_array_new(FALSE, FALSE, sizeof(struct document_picture));
    g_array_set_clear_func(making.pictures, picture_fini);
    status = add_volumes(&making, error);
    if (status == STATUS_OK)
        status = add_corridors(&making, settings->cases, error);
    if (status == STATUS_OK) {
        const struct document document = {.rows = &making.rows, .pictures = making.pictures};
        char *text = making.html ? document_html(&document) : document_markdown(&document);
        status = whole_file_write(settings->path, text, strlen(text), error);
        g_free(text);
    }
    g_array_unref(making.pictures);
    rows_fini(&making.rows);
    return status;
}
