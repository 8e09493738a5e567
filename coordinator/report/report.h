// What a run folder shows: result.json, corridors.csv, history.csv, the table for the terminal and
// the plots, all made from run.db alone, so that they can be made again at any time, also of a run
// that is not finished.
#ifndef SOBOX_COORDINATOR_REPORT_REPORT_H
#define SOBOX_COORDINATOR_REPORT_REPORT_H

#include "common/base/error.h"
#include "common/plot/picture.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

// In place of a search's index: the best one of a run that searches with several seeds, else the
// first.
#define REPORT_SEARCH_SHOWN UINT32_MAX

struct report_plot {
    enum picture_format format;
    uint32_t search;     // index of the search to draw, or REPORT_SEARCH_SHOWN
    const char *compare; // second run folder, its first search drawn over this one, or NULL
    bool normalise; // axes divided by their greatest value (thesis eq. 5.2): nothing secret shown
    // File to write; NULL: corridors.FORMAT in the run folder. What is compared or normalised is
    // another picture and says so: corridors-compared.svg, corridors-normalised.svg.
    const char *output;
};

// Writes result.json, corridors.csv, history.csv and, of a sweep, summary.csv into the run folder;
// each is whole or absent. summary.csv has a row a search: the case, its value on each axis,
// status, log_volume, purity, evaluations, seconds, digest, and both bounds of each corridor. Of a
// search that is not finished they show the box that was sampled last, without a purity.
//
// Variables that are no spring's force stand in corridors.csv with their name as `spring`, without
// direction and deformation, their bounds in their own unit; in result.json they have neither
// spring, direction nor deformation_m.
//
// Which points of a spring's corridor designs reach (reach.h) is the last column of corridors.csv,
// yes, no or empty (of several seeds the spreads follow), and in result.json `reached` of a
// variable and `reach` of a search: null without springs or corridors, else `designs`, `kinds` with
// the number of each, and `springs` with `deformation_max_m`, `points` and `points_reached`.
//
// Of a search with search.round `round` says what the bounds were rounded to, `step`, and which
// variables were left as they are, `left`.
//
// Of a run of one scenario with several seeds corridors.csv has the best box alone, with the spread
// of each bound in the columns lower_spread_N and upper_spread_N, and result.json has `seeds`: the
// index of the best search, how many `searches` found corridors, their `log_volume` (`best`,
// `mean`, `least` and `spread`), and `variables` with `lower` and `upper`, each with its `value`
// and `spread`, the standard deviation over the searches; null where one search alone tells
// nothing.
//
// Besides what the design names, result.json has `non_finite`, the samples whose outcome was not
// finite, and `blocking_constraint` where no good design was found. What is not known is null, and
// a seed above 2^63 - 1, which JSON readers would round, is text. Errors: STATUS_IO, and those of
// journal_open().
enum status report_write(const char *directory, struct error *error) MUST_USE;

// Draws the corridors with gnuplot: a row a spring, the axial force on the left, the lateral one on
// the right, each corridor a band inside the band of its design space. Leaves the script beside the
// picture and under its name (corridors.gp) for users to edit; the script carries its data, so it
// can be given away, and with `normalise` there is no force and no deformation in it.
//
// `compare` draws the springs that the other run has under the same name; forces are normalised by
// the greatest bound of both runs then.
// Errors: STATUS_INVALID (no such search, nothing in common with the other run), STATUS_FAILED
// (gnuplot is missing or failed: the text says which), STATUS_IO, and those of journal_open().
enum status report_draw(const char *directory, const struct report_plot *plot,
                        struct error *error) MUST_USE;

// Draws the corridors of a sweep's cases whose names match `pattern` (with * ? []) over each other,
// at most eight; into cases.FORMAT (or cases-normalised.FORMAT) unless `plot` says otherwise, of
// which search and compare are not looked at. Errors: STATUS_INVALID (no sweep; none matches, or
// too many; no springs), and those of report_draw().
enum status report_draw_cases(const char *directory, const char *pattern,
                              const struct report_plot *plot, struct error *error) MUST_USE;

// Draws the log-volume of a sweep against an axis as lines ("vehicle.mass"), or two as a heat map
// ("vehicle.mass,response"), into volume.FORMAT. An axis may be named by its last key. Errors:
// STATUS_INVALID (no sweep, no such axis, no corridors yet), and those of report_draw().
enum status report_draw_volume(const char *directory, const char *against,
                               const struct report_plot *plot, struct error *error) MUST_USE;

// A sweep as a document for people.
struct report_document {
    const char *path;  // of the file to write
    bool html;         // one file with its pictures in it; else Markdown, with pictures beside it
    const char *cases; // pattern of those whose corridors are drawn, at most eight; NULL: the best
                       // seed of each case, the first eight
    bool normalise;    // of corridors
};

// Writes tables of the cases, log-volume against the axes, and corridors. Errors: STATUS_INVALID
// (no sweep; no case matches, or too many), and those of report_draw().
enum status report_document(const char *directory, const struct report_document *document,
                            struct error *error) MUST_USE;

// The corridors as curves for other programs.
struct report_export {
    uint32_t search;    // index in the run, or REPORT_SEARCH_SHOWN
    const char *format; // "ls-dyna", "openradioss", "csv" or "json"
    const char *units;  // of units.h, for instance "kN-mm-ms"
    const char *folder; // made where it is absent
    uint32_t first_id;  // number of the first curve in solvers that number them, >= 1
};

// Writes a lower, a middle and an upper curve for each spring and direction into the folder; `path`
// receives the file, to be freed. Errors: STATUS_INVALID (no such format, units or search; no
// corridors; no springs; no folder), STATUS_IO, and those of run_data_open().
enum status report_export(const char *directory, const struct report_export *export, char **path,
                          struct error *error) MUST_USE;

// A component's measured curve to be held against its corridor.
struct report_check {
    uint32_t search;   // index in the run, or REPORT_SEARCH_SHOWN
    const char *path;  // CSV: spring,direction,deformation,force; a curve's rows stand together
    const char *units; // that it is measured in
};

// Says for each curve of the file whether and where it leaves its corridor; `inside` tells whether
// none does. Errors: STATUS_INVALID (with FILE:LINE:COLUMN), STATUS_IO.
enum status report_check(const char *directory, const struct report_check *check, FILE *out,
                         bool *inside, struct error *error) MUST_USE;

// The table for people.
struct report_table {
    bool normalise; // forces, deformations and variables are shares as in the pictures, and limits
                    // of constraints are left out
    bool bounds;    // what holds each bound is shown too, and not only what holds how many
};

// Prints the corridors, what each constraint costs them, the purity with its bound, the cost and
// the files to `out`; of a sweep one line a search. Errors: STATUS_IO, and those of journal_open().
enum status report_print(const char *directory, const struct report_table *table, FILE *out,
                         struct error *error) MUST_USE;

#endif
