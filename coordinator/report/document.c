#include "coordinator/report/document.h"

#include "coordinator/report/number.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

// A document is built from a few elements, each of which knows both languages. Texts come from
// scenarios that come from anywhere: what could mean something in the language is written so that
// it does not.
struct writer {
    GString *text;
    bool html;
};

static void put_plain(struct writer *writer, const char *text)
{
    for (const char *c = text; *c != '\0'; c++) {
        if (strchr("<>&\"'", *c) != NULL)
            g_string_append_printf(writer->text, "&#%d;", *c);
        else if (!writer->html && strchr("\\`*_{}[]()#|!~", *c) != NULL)
            g_string_append_printf(writer->text, "\\%c", *c);
        else
            g_string_append_c(writer->text, *c);
    }
}

static void put_heading(struct writer *writer, int level, const char *text)
{
    if (writer->html)
        g_string_append_printf(writer->text, "<h%d>", level);
    else
        g_string_append_printf(writer->text, "%s%.*s ", level > 1 ? "\n" : "", level, "###");
    put_plain(writer, text);
    if (writer->html)
        g_string_append_printf(writer->text, "</h%d>\n", level);
    else
        g_string_append(writer->text, "\n\n");
}

static void put_paragraph(struct writer *writer, const char *text)
{
    g_string_append(writer->text, writer->html ? "<p>" : "");
    put_plain(writer, text);
    g_string_append(writer->text, writer->html ? "</p>\n" : "\n\n");
}

// A row of a table; texts to the left, numbers to the right from column `numbers` on.
static void put_row(struct writer *writer, char **cells, uint32_t numbers, bool head)
{
    g_string_append(writer->text, writer->html ? "<tr>" : "|");
    for (uint32_t i = 0; cells[i] != NULL; i++) {
        if (writer->html)
            g_string_append_printf(writer->text, "<%s%s>", head ? "th" : "td",
                                   i >= numbers ? " class=\"n\"" : "");
        else
            g_string_append_c(writer->text, ' ');
        put_plain(writer, cells[i]);
        g_string_append(writer->text, !writer->html ? " |" : head ? "</th>" : "</td>");
    }
    g_string_append(writer->text, writer->html ? "</tr>\n" : "\n");
    if (writer->html || !head)
        return;
    g_string_append_c(writer->text, '|');
    for (uint32_t i = 0; cells[i] != NULL; i++)
        g_string_append(writer->text, i >= numbers ? " ---: |" : " --- |");
    g_string_append_c(writer->text, '\n');
}

static void table_begin(struct writer *writer, GPtrArray *head, uint32_t numbers)
{
    g_string_append(writer->text, writer->html ? "<table>\n" : "");
    put_row(writer, (char **)head->pdata, numbers, true);
    g_ptr_array_unref(head);
}

static void table_row(struct writer *writer, GPtrArray *cells, uint32_t numbers)
{
    put_row(writer, (char **)cells->pdata, numbers, false);
    g_ptr_array_unref(cells);
}

static void table_end(struct writer *writer)
{
    g_string_append(writer->text, writer->html ? "</table>\n" : "\n");
}

static GPtrArray *cells_new(void)
{
    return g_ptr_array_new_null_terminated(0, g_free, TRUE);
}

static void __attribute__((format(printf, 2, 3))) cell(GPtrArray *cells, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    g_ptr_array_add(cells, g_strdup_vprintf(format, arguments));
    va_end(arguments);
}

static void cell_number(GPtrArray *cells, double number, int decimals)
{
    if (isnan(number))
        cell(cells, "-");
    else
        cell(cells, "%.*f", decimals, number);
}

// ---- what the document says ----

static void put_summary(struct writer *writer, const struct rows *rows)
{
    uint64_t designs = 0;
    double seconds = 0;
    char designs_text[NUMBER_SIZE];
    for (uint32_t i = 0; i < rows->count; i++) {
        designs += rows->items[i].evaluations;
        seconds += rows->items[i].wall_s;
    }
    char *text = g_strdup_printf(
        "%" PRIu32 " searches, %" PRIu32 " done, %" PRIu32
        " of them with corridors; %s designs simulated; the searches took %.1f s in all, side by "
        "side. The log-volume is the sum of ln(corridor width / design width): 0 is the whole "
        "design space. The purity is what the share of good designs exceeds with 95 %% "
        "confidence. Made by sobox %s.",
        rows->count, rows->done, rows->found, number_count(designs, designs_text), seconds,
        rows->version);
    put_paragraph(writer, text);
    g_free(text);
}

// Of the cases that differ in their seed alone.
struct spread {
    double best, median, worst, purity;
    uint32_t count, found;
};

static struct spread spread_of(const struct rows *rows, uint32_t group, double *scratch)
{
    struct spread spread = {.best = NAN, .median = NAN, .worst = NAN, .purity = NAN};
    for (uint32_t i = 0; i < rows->count; i++) {
        const struct rows_row *row = &rows->items[i];
        if (row->group != group)
            continue;
        spread.count++;
        if (isnan(row->log_volume))
            continue;
        scratch[spread.found++] = row->log_volume;
        spread.purity = fmin(isnan(spread.purity) ? INFINITY : spread.purity,
                             isnan(row->purity_lower95) ? 0 : row->purity_lower95);
    }
    if (spread.found > 0) {
        spread.median = rows_median(scratch, spread.found); // sorted from here on
        spread.worst = scratch[0];
        spread.best = scratch[spread.found - 1];
    }
    return spread;
}

static GPtrArray *axis_cells(const struct rows *rows, char **texts, bool seeds)
{
    GPtrArray *cells = cells_new();
    for (uint32_t a = 0; a < rows->axis_count; a++)
        if (seeds || !rows_is_seed(rows, a))
            cell(cells, "%s", texts[a]);
    return cells;
}

// A row for each combination, its seeds together.
static void put_groups(struct writer *writer, const struct rows *rows)
{
    GPtrArray *head = axis_cells(rows, rows->axes, false);
    const uint32_t numbers = head->len;
    static const char *const titles[] = {"searches", "with corridors", "log-volume, best",
                                         "median",   "least",          "purity at least"};
    for (size_t i = 0; i < G_N_ELEMENTS(titles); i++)
        cell(head, "%s", titles[i]);
    double *scratch = g_new(double, rows->count);
    table_begin(writer, head, numbers);
    uint32_t next = 0;
    for (uint32_t i = 0; i < rows->count; i++) {
        if (rows->items[i].group != next)
            continue; // groups are numbered in the order in which they appear
        const struct spread spread = spread_of(rows, next++, scratch);
        GPtrArray *cells = axis_cells(rows, rows->items[i].values, false);
        cell(cells, "%" PRIu32, spread.count);
        cell(cells, "%" PRIu32, spread.found);
        cell_number(cells, spread.best, 3);
        cell_number(cells, spread.median, 3);
        cell_number(cells, spread.worst, 3);
        cell_number(cells, floor(spread.purity * 1e4) * 1e-4, 4); // a bound is not rounded up
        table_row(writer, cells, numbers);
    }
    table_end(writer);
    g_free(scratch);
}

enum { CASES_MAX = 2000 }; // rows that a reader's browser shows without trouble

static void put_cases(struct writer *writer, const struct rows *rows)
{
    GPtrArray *head = cells_new();
    static const char *const titles[] = {"case",
                                         "status",
                                         "log-volume",
                                         "purity at least",
                                         "designs",
                                         "seconds",
                                         "costs most, relaxed by 1 %"};
    for (size_t i = 0; i < G_N_ELEMENTS(titles); i++)
        cell(head, "%s", titles[i]);
    table_begin(writer, head, 2);
    for (uint32_t i = 0; i < MIN(rows->count, CASES_MAX); i++) {
        const struct rows_row *row = &rows->items[i];
        GPtrArray *cells = cells_new();
        char designs[NUMBER_SIZE];
        cell(cells, "%s", row->name);
        cell(cells, "%s", row->status);
        cell_number(cells, row->log_volume, 3);
        cell_number(cells, floor(row->purity_lower95 * 1e4) * 1e-4, 4);
        cell(cells, "%s", number_count(row->evaluations, designs));
        cell_number(cells, row->wall_s, 2);
        cell(cells, "%s", row->costliest != NULL ? row->costliest : "-");
        table_row(writer, cells, 2);
    }
    table_end(writer);
    if (rows->count > CASES_MAX)
        put_paragraph(writer, "The other cases are in summary.csv.");
}

// What is doubtful about the cases: before anything that is shown of them.
static void put_warnings(struct writer *writer, const struct rows *rows)
{
    if (rows->warning_count == 0)
        return;
    put_heading(writer, 2, "Warnings");
    for (uint32_t i = 0; i < rows->warning_count; i++) {
        const struct rows_warning *warning = &rows->warnings[i];
        char *text =
            g_strdup_printf("%s (in %" PRIu32 " of %" PRIu32 " cases, first in %s)", warning->text,
                            warning->count, rows->count, rows->items[warning->first].name);
        put_paragraph(writer, text);
        g_free(text);
    }
}

static void put_pictures(struct writer *writer, const GArray *pictures)
{
    for (guint i = 0; i < pictures->len; i++) {
        const struct document_picture *picture =
            &g_array_index(pictures, struct document_picture, i);
        put_heading(writer, 2, picture->title);
        if (writer->html) {
            g_string_append_printf(writer->text, "<figure>%s</figure>\n", picture->svg);
            continue;
        }
        g_string_append(writer->text, "![");
        put_plain(writer, picture->title);
        g_string_append_printf(writer->text, "](%s)\n\n", picture->file);
    }
}

static void put_all(struct writer *writer, const struct document *document)
{
    const struct rows *rows = document->rows;
    put_heading(writer, 1, rows->name);
    put_summary(writer, rows);
    put_warnings(writer, rows);
    if (rows->axis_count > 0 && rows->group_count < rows->count) {
        put_heading(writer, 2, "Over the seeds");
        put_groups(writer, rows);
    }
    put_pictures(writer, document->pictures);
    put_heading(writer, 2, "Cases");
    put_cases(writer, rows);
}

char *document_markdown(const struct document *document)
{
    struct writer writer = {.text = g_string_new(NULL)};
    put_all(&writer, document);
    return g_string_free(writer.text, FALSE);
}

char *document_html(const struct document *document)
{
    struct writer writer = {.text = g_string_new(NULL), .html = true};
    g_string_append(writer.text,
                    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                    "<meta name=\"viewport\" content=\"width=device-width\">\n<title>");
    put_plain(&writer, document->rows->name);
    g_string_append(
        writer.text,
        "</title>\n<style>\n"
        "body { font: 15px/1.45 sans-serif; color: #202020; max-width: 1000px;\n"
        "       margin: 2em auto; padding: 0 1em }\n"
        "table { border-collapse: collapse; font-size: 14px }\n"
        "th, td { text-align: left; padding: 2px 12px 2px 0; border-bottom: 1px solid #ddd }\n"
        ".n { text-align: right; font-variant-numeric: tabular-nums }\n"
        "figure { margin: 0 } svg { max-width: 100%; height: auto }\n"
        "</style>\n</head>\n<body>\n");
    put_all(&writer, document);
    g_string_append(writer.text, "</body>\n</html>\n");
    return g_string_free(writer.text, FALSE);
}
