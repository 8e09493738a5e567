// The corridors as curves that other programs read: for each spring and direction a lower, a middle
// and an upper curve of force over deformation.
#ifndef SOBOX_COORDINATOR_REPORT_CURVES_H
#define SOBOX_COORDINATOR_REPORT_CURVES_H

#include "coordinator/report/run_data.h"
#include "coordinator/report/units.h"

enum curves_format {
    CURVES_LS_DYNA,     // curves.k: *DEFINE_CURVE_TITLE
    CURVES_OPENRADIOSS, // curves.inc: /FUNCT
    CURVES_CSV,         // curves.csv
    CURVES_JSON,        // curves.json
    CURVES_FORMAT_COUNT
};

struct curves {
    const char *run_name;
    const char *version;                  // of the sobox that ran
    const struct run_data_search *search; // with corridors and springs
    const struct units *units;
    uint32_t first_id; // of LS-DYNA and OpenRadioss; the curves count on from here
};

// The format's name on the command line, and its file's name.
const char *curves_format_name(enum curves_format format);
const char *curves_file_name(enum curves_format format);

// The file's text; the caller frees it.
char *curves_text(const struct curves *curves, enum curves_format format);

#endif
