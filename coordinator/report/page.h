// What the script of every picture has in common: terminal, colours, title and legend.
#ifndef SOBOX_COORDINATOR_REPORT_PAGE_H
#define SOBOX_COORDINATOR_REPORT_PAGE_H

#include "coordinator/report/figure.h"

#include <glib.h>

// All lengths in pixels of the SVG, from the edge of the page.
enum {
    PAGE_WIDTH = 960,
    PAGE_EDGE = 24, // where title and legend begin
    PAGE_LEFT = 76,
    PAGE_RIGHT = 22,
    PAGE_TOP = 84,    // title and the title of the first row of panels
    LEGEND_LINE = 26, // added to the top for each corridor
    SWATCH_WIDTH = 26,
    SWATCH_HEIGHT = 12,
    PAGE_BOTTOM = 56,
};

// The colours of up to eight curves of one kind, after Okabe and Ito, as a line of a script.
#define PAGE_COLOURS "colours = '#0072b2 #d55e00 #009e73 #cc79a7 #e69f00 #56b4e9 #000000 #999933'\n"

// The fill of what no design reaches, of a search and of the one it is compared with: two slopes,
// so that both are seen where they lie over each other.
#define PAGE_HATCH "pattern 4"
#define PAGE_HATCH_OTHER "pattern 5"

// Where the panels begin [pixels from the top].
int page_top(const struct figure *figure);

// The beginning of a script: where and how large to draw.
void page_begin(GString *script, const struct figure *figure, int height);

// The colours by name, and how axes look.
void page_style(GString *script);

// Title and legend, as labels and objects of the first panel.
void page_heading(GString *script, const struct figure *figure, int page_height);

#endif
