#include "coordinator/report/rows.h"

#include "common/base/plain.h"
#include "coordinator/report/holding.h"
#include "coordinator/report/number.h"
#include "coordinator/report/warnings.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool rows_is_seed(const struct rows *rows, uint32_t axis)
{
    return strcmp(rows->axes[axis], "search.seed") == 0;
}

// Takes the text.
static void take_warning(struct rows *rows, uint32_t index, char *text)
{
    for (uint32_t i = 0; i < rows->warning_count; i++) {
        if (strcmp(rows->warnings[i].text, text) != 0)
            continue;
        rows->warnings[i].count++;
        g_free(text);
        return;
    }
    if (rows->warning_count < ROWS_WARNINGS_MAX)
        rows->warnings[rows->warning_count++] =
            (struct rows_warning){.text = text, .count = 1, .first = index};
    else
        g_free(text);
}

static void take(struct rows *rows, uint32_t index, const struct run_data_search *search)
{
    const struct journal_search *record = &search->record;
    const bool certified = record->finished && record->purity_samples > 0;
    rows->items[index] = (struct rows_row){
        .index = index,
        .name = plain_text(search->name),
        .status = plain_text(search->status),
        .values = g_strdupv(search->values),
        .log_volume = search->box != NULL ? search->log_volume : NAN,
        .purity_lower95 = certified ? record->purity_lower95 : NAN,
        .costliest = holding_costliest(search),
        .evaluations = search->evaluations,
        .wall_s = (double)search->wall_ns * 1e-9,
    };
    rows->done += record->finished;
    rows->found += record->finished && search->box != NULL;
    char **texts = warnings_of(search);
    for (char **text = texts; *text != NULL; text++)
        take_warning(rows, index, plain_text(*text));
    g_strfreev(texts);
}

// Numbers the combinations of values but the seed, in the order in which they appear.
static void group(struct rows *rows)
{
    GHashTable *seen = g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    for (uint32_t i = 0; i < rows->count; i++) {
        GString *key = g_string_new(NULL);
        for (uint32_t a = 0; a < rows->axis_count; a++)
            if (!rows_is_seed(rows, a))
                g_string_append_printf(key, "%s\n", rows->items[i].values[a]);
        char *text = g_string_free(key, FALSE);
        gpointer number;
        if (g_hash_table_lookup_extended(seen, text, NULL, &number)) {
            rows->items[i].group = GPOINTER_TO_UINT(number);
            g_free(text);
        } else {
            rows->items[i].group = rows->group_count++;
            g_hash_table_insert(seen, text, GUINT_TO_POINTER(rows->items[i].group));
        }
    }
    g_hash_table_destroy(seen);
}

enum status rows_read(struct rows *rows, const char *directory, struct error *error)
{
    *rows = (struct rows){0};
    struct run_data data;
    enum status status = run_data_open(&data, directory, error);
    if (status != STATUS_OK)
        return status;
    if (!run_data_is_sweep(&data)) {
        run_data_fini(&data);
        return error_set(error, STATUS_INVALID, "%s: not a sweep: it has one search and no axes",
                         directory);
    }
    rows->name = plain_text(data.run.name);
    rows->version = plain_text(data.run.version);
    rows->axes = g_strdupv(data.axes);
    rows->axis_count = g_strv_length(data.axes);
    rows->items = g_new0(struct rows_row, data.run.search_count);
    for (uint32_t i = 0; i < data.run.search_count && status == STATUS_OK; i++) {
        struct run_data_search search;
        status = run_data_load(&data, i, &search, error);
        if (status == STATUS_OK)
            take(rows, rows->count++, &search);
        run_data_release(&search);
    }
    run_data_fini(&data);
    if (status != STATUS_OK)
        rows_fini(rows);
    else
        group(rows);
    return status;
}

void rows_fini(struct rows *rows)
{
    for (uint32_t i = 0; i < rows->count; i++) {
        g_free(rows->items[i].name);
        g_free(rows->items[i].status);
        g_free(rows->items[i].costliest);
        g_strfreev(rows->items[i].values);
    }
    for (uint32_t i = 0; i < rows->warning_count; i++)
        g_free(rows->warnings[i].text);
    g_free(rows->items);
    g_strfreev(rows->axes);
    g_free(rows->name);
    g_free(rows->version);
    *rows = (struct rows){0};
}

static const char *last_key(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot != NULL ? dot + 1 : path;
}

uint32_t rows_axis(const struct rows *rows, const char *path)
{
    uint32_t found = rows->axis_count, matches = 0;
    for (uint32_t a = 0; a < rows->axis_count; a++) {
        if (strcmp(rows->axes[a], path) == 0)
            return a;
        if (strcmp(last_key(rows->axes[a]), path) == 0) {
            found = a;
            matches++;
        }
    }
    return matches == 1 ? found : rows->axis_count;
}

const char **rows_values(const struct rows *rows, uint32_t axis, uint32_t *count)
{
    GHashTable *seen = g_hash_table_new(g_str_hash, g_str_equal);
    const char **values = g_new0(const char *, rows->count + 1);
    *count = 0;
    for (uint32_t i = 0; i < rows->count; i++) {
        char *value = rows->items[i].values[axis];
        if (g_hash_table_add(seen, value))
            values[(*count)++] = value;
    }
    g_hash_table_destroy(seen);
    return values;
}

bool rows_follows(const struct rows *rows, uint32_t axis, uint32_t other)
{
    GHashTable *goes_with = g_hash_table_new(g_str_hash, g_str_equal);
    bool follows = true;
    for (uint32_t i = 0; i < rows->count && follows; i++) {
        char **values = rows->items[i].values;
        const char *known = g_hash_table_lookup(goes_with, values[other]);
        follows = known == NULL || strcmp(known, values[axis]) == 0;
        g_hash_table_insert(goes_with, values[other], values[axis]);
    }
    g_hash_table_destroy(goes_with);
    return follows;
}

const struct rows_row *rows_best(const struct rows *rows, uint32_t group_number)
{
    const struct rows_row *best = NULL;
    for (uint32_t i = 0; i < rows->count; i++) {
        const struct rows_row *row = &rows->items[i];
        if (row->group == group_number && !isnan(row->log_volume) &&
            (best == NULL || row->log_volume > best->log_volume))
            best = row;
    }
    return best;
}

static int compare(const void *a, const void *b)
{
    const double one = *(const double *)a, two = *(const double *)b;
    return (one > two) - (one < two);
}

double rows_median(double *numbers, uint32_t count)
{
    qsort(numbers, count, sizeof *numbers, compare);
    return (numbers[(count - 1) / 2] + numbers[count / 2]) / 2;
}
