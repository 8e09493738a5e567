// A scenario of two variables that are free, a and b, and one that is fixed, c, for the tests of
// this folder; and errors as users see them.
#ifndef SOBOX_TESTS_UNIT_COORDINATOR_EVALUATION_SAMPLE_SCENARIO_H
#define SOBOX_TESTS_UNIT_COORDINATOR_EVALUATION_SAMPLE_SCENARIO_H

// cmocka needs these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/scenario/scenario_read.h"

#include <string.h>

static inline void sample_scenario(struct scenario *scenario)
{
    static const char text[] = "name: sample\n"
                               "model: hypersphere\n"
                               "variables:\n"
                               "  - {name: a, lower: -1, upper: 1}\n"
                               "  - {name: b, lower: -1, upper: 1}\n"
                               "  - {name: c, lower: 0.25, upper: 0.25}\n"
                               "constraints: {distance: {max: 0}}\n";
    struct error error = {0};
    if (scenario_read_text(scenario, "sample", text, strlen(text), NULL, 0, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

static inline void assert_complaint(const struct error *error, const char *text)
{
    if (strncmp(error->text, text, strlen(text)) != 0)
        fail_msg("expected \"%s...\", found \"%s\"", text, error->text);
}

#endif
