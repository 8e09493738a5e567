// A table of designs: the first line is its header, all behind it rows. What is read has a finite
// value for each variable of each design, and ids that lie in the text.
#include "tests/fuzz/fuzz.h"

#include "common/scenario/scenario_read.h"
#include "coordinator/evaluation/designs.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char yaml[] = "name: table\n"
                           "model: hypersphere\n"
                           "variables:\n"
                           "  - {name: a, lower: -1, upper: 1}\n"
                           "  - {name: b, lower: -1, upper: 1}\n"
                           "  - {name: c, lower: 0.25, upper: 0.25}\n"
                           "constraints: {distance: {max: 0}}\n";

static const struct scenario *sample(void)
{
    static struct scenario scenario;
    struct error error = {0};
    if (scenario.text == NULL &&
        scenario_read_text(&scenario, "table", yaml, strlen(yaml), NULL, 0, &error) != STATUS_OK)
        abort();
    return &scenario;
}

static void read_rows(const struct designs_layout *layout, const char *text, size_t size)
{
    struct designs designs;
    struct error error = {0};
    if (designs_read(&designs, layout, "table", 2, text, size, &error) != STATUS_OK) {
        assert(error.text[0] != '\0');
        return;
    }
    for (uint32_t i = 0; i < designs.count; i++) {
        for (uint32_t v = 0; v < layout->scenario->design_space.count; v++)
            assert(isfinite(designs.values[i * layout->scenario->design_space.count + v]));
        if (designs.ids != NULL)
            assert(designs.ids[i] >= text && designs.id_sizes[i] <= size &&
                   designs.ids[i] + designs.id_sizes[i] <= text + size);
    }
    designs_fini(&designs);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    // At the end of its own allocation, so that a sanitizer sees each byte read too far.
    char *text = malloc(size + 1);
    assert(text != NULL);
    memcpy(text, data, size);
    const char *newline = memchr(text, '\n', size);
    const size_t header = newline != NULL ? (size_t)(newline + 1 - text) : size;
    struct designs_layout layout;
    struct error error = {0};
    if (designs_layout_read(&layout, sample(), "table", 1, text, header, &error) == STATUS_OK) {
        char *rows = malloc(size - header > 0 ? size - header : 1);
        assert(rows != NULL);
        memcpy(rows, text + header, size - header);
        read_rows(&layout, rows, size - header);
        free(rows);
        designs_layout_fini(&layout);
    } else {
        assert(error.text[0] != '\0');
    }
    free(text);
    return 0;
}
