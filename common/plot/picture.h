// A picture that gnuplot draws: a script that carries its data and stays beside the picture, so
// that it can be edited, moved and given away, and the picture itself.
#ifndef SOBOX_COMMON_PLOT_PICTURE_H
#define SOBOX_COMMON_PLOT_PICTURE_H

#include "common/base/error.h"

#include <glib.h>
#include <stdbool.h>

enum picture_format { PICTURE_SVG, PICTURE_PNG, PICTURE_PDF };

// The format's name, which is the ending of its files: "svg", "png", "pdf".
const char *picture_format_name(enum picture_format format);

// The format that a file's ending asks for; false when it is none of these.
bool picture_format_of(const char *path, enum picture_format *format);

// What a script begins with.
struct picture_page {
    const char *what;  // one sentence for the script's head: what is drawn and by whom
    const char *name;  // of the picture in an SVG, a word
    const char *stem;  // of the file that the script writes when run by hand
    int width, height; // [pixels] of the SVG
};

// The beginning of a script: it draws to the file named by the gnuplot variable `output` in the
// format named by `format` ('svg', 'png', 'pdf'); without them to STEM.svg. Sets the variables
// `points`, the size of the font, and `heading`, the font of a title.
void picture_begin(GString *script, const struct picture_page *page);

// Writes the script beside `output` and under its name (STEM.gp), lets gnuplot make the picture,
// and writes that. Errors: STATUS_FAILED (gnuplot), STATUS_IO.
enum status picture_write(const char *script, const char *output, enum picture_format format,
                          struct error *error) MUST_USE;

// The picture as SVG text without the head that stands before its <svg> element, to stand in HTML.
// The caller frees it. Errors: STATUS_FAILED, STATUS_IO.
enum status picture_inline(const char *script, char **svg, struct error *error) MUST_USE;

// The name of a picture's file without folder and ending, for its script. The caller frees it.
char *picture_stem(const char *output);

#endif
