// sobox-report: plots and exports of a run folder.

#include "coordinator/report/report.h"
#include "common/base/arithmetic.h"
#include "common/base/log.h"
#include "common/base/options.h"
#include "common/base/streams.h"
#include "common/plot/picture.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

static const char program_summary[] = "Draws the corridors of a run folder with gnuplot, writes "
                                      "its exports where they are missing or\n"
                                      "old, and prints its table.";

static const char program_description[] =
    "Examples:\n"
    "  sobox-report runs/sedan-two-springs\n"
    "  sobox-report runs/sedan-two-springs --png --pdf\n"
    "  sobox-report runs/any --compare runs/rotating --out comparison.svg\n"
    "  sobox-report runs/sedan-two-springs --normalise --out public.pdf\n"
    "  sobox-report runs/sedan-two-springs --export ls-dyna --units kN-mm-ms --out curves\n"
    "  sobox-report runs/sedan-two-springs --check measured.csv --units kN-mm-ms\n"
    "  sobox-report runs/masses --html masses.html\n"
    "  sobox-report runs/masses --cases 'mass=1500,*,seed=1' --out light.svg\n"
    "  sobox-report runs/masses --against mass,response --out map.png\n"
    "\n"
    "The gnuplot script stays beside the picture, under its name, with the data in it; edit it "
    "and\n"
    "run it again by hand.\n"
    "\n"
    "Exit status: 0 done; 1 failed while running; 2 usage or invalid input; 3 a curve that was "
    "checked\n"
    "leaves its corridor.";

enum { SEARCH_NOT_GIVEN = INT_MIN };

struct options {
    char *directory;
    char *compare;
    char *out;
    char *cases;
    char *against;
    char *markdown;
    char *html;
    char *export;
    char *check;
    char *units;
    int first_id;
    int search;
    gboolean normalise;
    gboolean png;
    gboolean pdf;
    gboolean version;
};

static void options_fini(struct options *options)
{
    g_free(options->directory);
    g_free(options->compare);
    g_free(options->out);
    g_free(options->cases);
    g_free(options->against);
    g_free(options->markdown);
    g_free(options->html);
    g_free(options->export);
    g_free(options->check);
    g_free(options->units);
}

static enum status check_folder(const char *directory, struct error *error)
{
    if (!g_file_test(directory, G_FILE_TEST_IS_DIR))
        return error_set(error, STATUS_INVALID, "%s: there is no such folder", directory);
    char *journal = g_build_filename(directory, "run.db", NULL);
    bool is_run = g_file_test(journal, G_FILE_TEST_EXISTS);
    g_free(journal);
    if (is_run)
        return STATUS_OK;
    char *evaluation = g_build_filename(directory, "evaluation.json", NULL);
    const bool is_evaluation = g_file_test(evaluation, G_FILE_TEST_EXISTS);
    g_free(evaluation);
    return error_set(error, STATUS_INVALID, "%s: %s", directory,
                     is_evaluation ? "an evaluation of designs has no corridors to report: what "
                                     "came of it is in its outcomes.csv"
                                   : "not a run folder: there is no run.db in it");
}

// Options of curves that go out or come in.
static enum status check_curves(const struct options *options, struct error *error)
{
    if (options->export != NULL && options->out == NULL)
        return error_set(error, STATUS_INVALID,
                         "--export %s: expected --out with the folder to write to",
                         options->export);
    if (options->first_id < 1)
        return error_set(error, STATUS_INVALID, "--first-id %d: expected 1 or more",
                         options->first_id);
    if (options->units != NULL && options->export == NULL && options->check == NULL)
        return error_set(error, STATUS_INVALID, "--units goes with --export or --check");
    if (options->export != NULL && options->check != NULL)
        return error_set(error, STATUS_INVALID, "--export and --check go one at a time");
    return STATUS_OK;
}

static enum status options_check(const struct options *options, struct error *error)
{
    enum picture_format format;
    if (options->directory == NULL)
        return error_set(error, STATUS_INVALID,
                         "no run folder: expected sobox-report DIR (see --help)");
    if (options->search < 0 && options->search != SEARCH_NOT_GIVEN)
        return error_set(error, STATUS_INVALID, "--search %d: expected 0 or more", options->search);
    if (check_curves(options, error) != STATUS_OK)
        return STATUS_INVALID;
    if (options->out != NULL && options->export == NULL &&
        !picture_format_of(options->out, &format))
        return error_set(error, STATUS_INVALID,
                         "--out %s: expected a file name that ends in .svg, .png or .pdf",
                         options->out);
    if (options->out != NULL && (options->png || options->pdf))
        return error_set(error, STATUS_INVALID,
                         "--out goes without --png and --pdf: its ending says the format");
    if (options->out != NULL && options->cases != NULL && options->against != NULL)
        return error_set(error, STATUS_INVALID,
                         "--out takes one picture: expected it with --cases or with --against");
    enum status status = check_folder(options->directory, error);
    if (status == STATUS_OK && options->compare != NULL)
        status = check_folder(options->compare, error);
    return status;
}

static enum status options_parse(struct options *options, int argc, char **argv,
                                 struct error *error)
{
    *options = (struct options){.first_id = 1, .search = SEARCH_NOT_GIVEN};
    const GOptionEntry entries[] = {
        {"compare", 'c', 0, G_OPTION_ARG_FILENAME, &options->compare,
         "Draw the corridors of a second run over those of the first, for springs of one name, in "
         "corridors-compared.svg",
         "DIR2"},
        {"normalise", 'n', 0, G_OPTION_ARG_NONE, &options->normalise,
         "Divide forces and deformations by their greatest value, to share without their numbers: "
         "the table, and corridors-normalised.svg",
         NULL},
        {"png", 0, 0, G_OPTION_ARG_NONE, &options->png, "Draw corridors.png, too", NULL},
        {"pdf", 0, 0, G_OPTION_ARG_NONE, &options->pdf, "Draw corridors.pdf, too", NULL},
        {"out", 'o', 0, G_OPTION_ARG_FILENAME, &options->out,
         "Draw into this file only; its ending says the format", "FILE"},
        {"cases", 0, 0, G_OPTION_ARG_FILENAME, &options->cases,
         "Draw the corridors of a sweep's cases whose names match over each other, in cases.svg",
         "PATTERN"},
        {"against", 0, 0, G_OPTION_ARG_FILENAME, &options->against,
         "Draw a sweep's log-volume against an axis, or over two as a map, in volume.svg",
         "AXIS[,AXIS]"},
        {"markdown", 0, 0, G_OPTION_ARG_FILENAME, &options->markdown,
         "Write a report of a sweep, with its pictures beside it", "FILE"},
        {"html", 0, 0, G_OPTION_ARG_FILENAME, &options->html,
         "Write a report of a sweep as one file with its pictures in it", "FILE"},
        {"export", 0, 0, G_OPTION_ARG_STRING, &options->export,
         "Write lower, middle and upper curves into the folder of --out, as ls-dyna, openradioss, "
         "csv or json",
         "FORMAT"},
        {"check", 0, 0, G_OPTION_ARG_FILENAME, &options->check,
         "Say whether and where measured curves (spring,direction,deformation,force) leave their "
         "corridors",
         "CURVE.csv"},
        {"units", 0, 0, G_OPTION_ARG_STRING, &options->units,
         "Of --export and --check: N-m-s (the default), N-mm-s, N-mm-ms, kN-m-s, kN-mm-s, kN-mm-ms",
         "UNITS"},
        {"first-id", 0, 0, G_OPTION_ARG_INT, &options->first_id,
         "Number of the first curve that --export writes for a solver (default: 1)", "N"},
        {"search", 's', 0, G_OPTION_ARG_INT, &options->search,
         "Draw, export or check this search of a sweep (default: of several seeds the best, else "
         "0)",
         "N"},
        G_OPTION_ENTRY_NULL,
    };
    const struct options_program program = {
        .argument = "DIR",
        .summary = program_summary,
        .description = program_description,
        .entries = entries,
    };
    struct options_common common;
    const enum status status = options_read(&program, argc, argv, &common, error);
    options->version = common.version;
    options->directory = common.argument;
    return status;
}

// ---- exports ----

static bool older(const char *path, const GStatBuf *than)
{
    GStatBuf file;
    return g_stat(path, &file) != 0 || file.st_mtim.tv_sec < than->st_mtim.tv_sec ||
           (file.st_mtim.tv_sec == than->st_mtim.tv_sec &&
            file.st_mtim.tv_nsec < than->st_mtim.tv_nsec);
}

// Whether an export is missing or older than the journal and its log: a folder that is complete
// may be one where nothing can be written.
static bool exports_due(const char *directory)
{
    static const char *const EXPORTS[] = {"result.json", "corridors.csv",
                                          "history.csv"}; // summary.csv is written with them
    static const char *const SOURCES[] = {"run.db", "run.db-wal"};
    bool due = false;
    for (size_t s = 0; s < G_N_ELEMENTS(SOURCES); s++) {
        char *source = g_build_filename(directory, SOURCES[s], NULL);
        GStatBuf file;
        bool there = g_stat(source, &file) == 0;
        g_free(source);
        for (size_t e = 0; there && e < G_N_ELEMENTS(EXPORTS); e++) {
            char *path = g_build_filename(directory, EXPORTS[e], NULL);
            due = due || older(path, &file);
            g_free(path);
        }
    }
    return due;
}

static uint32_t search_asked_for(const struct options *options)
{
    return options->search == SEARCH_NOT_GIVEN ? REPORT_SEARCH_SHOWN : (uint32_t)options->search;
}

// ---- pictures ----

// Of a sweep its cases over each other, its volumes, or both; else the corridors of one search.
static enum status draw(const struct options *options, enum picture_format format,
                        struct error *error)
{
    const struct report_plot plot = {.format = format,
                                     .search = search_asked_for(options),
                                     .compare = options->compare,
                                     .normalise = options->normalise,
                                     .output = options->out};
    if (options->cases == NULL && options->against == NULL)
        return report_draw(options->directory, &plot, error);
    enum status status = STATUS_OK;
    if (options->cases != NULL)
        status = report_draw_cases(options->directory, options->cases, &plot, error);
    if (status == STATUS_OK && options->against != NULL)
        status = report_draw_volume(options->directory, options->against, &plot, error);
    return status;
}

static enum status write_document(const struct options *options, const char *path, bool html,
                                  struct error *error)
{
    const struct report_document document = {
        .path = path, .html = html, .cases = options->cases, .normalise = options->normalise};
    enum status status = report_document(options->directory, &document, error);
    if (status == STATUS_OK)
        printf("%-12s %s\n", "written", path);
    return status;
}

static enum status write_documents(const struct options *options, struct error *error)
{
    enum status status = STATUS_OK;
    if (options->markdown != NULL)
        status = write_document(options, options->markdown, false, error);
    if (status == STATUS_OK && options->html != NULL)
        status = write_document(options, options->html, true, error);
    return status;
}

static enum status draw_all(const struct options *options, struct error *error)
{
    enum picture_format format;
    if (options->out != NULL && picture_format_of(options->out, &format))
        return draw(options, format, error);
    enum status status = draw(options, PICTURE_SVG, error);
    if (status == STATUS_OK && options->png)
        status = draw(options, PICTURE_PNG, error);
    if (status == STATUS_OK && options->pdf)
        status = draw(options, PICTURE_PDF, error);
    return status;
}

static enum status export(const struct options *options, struct error *error) {
    const struct report_export settings = {.search = search_asked_for(options),
                                           .format = options->export,
                                           .units = options->units ? options->units : "N-m-s",
                                           .folder = options->out,
                                           .first_id = (uint32_t)options->first_id};
    char *path = NULL;
    enum status status = report_export(options->directory, &settings, &path, error);
    if (status == STATUS_OK) printf("%-12s %s\n", "written", path);
    g_free(path);
    return status;
}

static enum status check(const struct options *options, bool *inside, struct error *error)
{
    const struct report_check settings = {.search = search_asked_for(options),
                                          .path = options->check,
                                          .units = options->units ? options->units : "N-m-s"};
    return report_check(options->directory, &settings, stdout, inside, error);
}

// The table is printed last, because it lists the files, and also when no picture could be drawn.
static enum status report(const struct options *options, struct error *error)
{
    enum status status = STATUS_OK;
    if (exports_due(options->directory))
        status = report_write(options->directory, error);
    if (status != STATUS_OK)
        return status;
    if (options->markdown != NULL || options->html != NULL)
        return write_documents(options, error);
    enum status drawn = draw_all(options, error);
    if (drawn == STATUS_INVALID)
        return drawn;
    struct error unprinted = {0};
    const struct report_table table = {.normalise = options->normalise, .bounds = true};
    status = report_print(options->directory, &table, stdout, &unprinted);
    if (drawn != STATUS_OK)
        return drawn;
    if (status != STATUS_OK)
        return error_set(error, status, "%s", unprinted.text);
    if (options->out != NULL)
        printf("%-12s %s\n", "drawn", options->out);
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    streams_start();
    arithmetic_start();
    log_start("sobox-report", LOG_NORMAL);
    struct options options;
    struct error error = {0};
    enum status status = options_parse(&options, argc, argv, &error);
    if (status == STATUS_OK && options.version) {
        puts("sobox-report " SOBOX_VERSION);
        options_fini(&options);
        return EXIT_STATUS_DONE;
    }
    if (status == STATUS_OK)
        status = options_check(&options, &error);
    bool inside = true; // of the curves that were checked
    if (status == STATUS_OK && options.check != NULL)
        status = check(&options, &inside, &error);
    else if (status == STATUS_OK && options.export != NULL)
        status = export(&options, &error);
    else if (status == STATUS_OK)
        status = report(&options, &error);
    // A mistake in a file of curves stands alone on its line, so that editors find the place.
    if (status != STATUS_OK && options.check != NULL)
        log_failure(&error);
    else if (status != STATUS_OK)
        log_error("%s", error.text);
    options_fini(&options);
    return status == STATUS_OK && !inside ? EXIT_STATUS_NO_GOOD_DESIGN : (int)status_exit(status);
}
