#include "common/sampling/box_text.h"

#include <math.h>
#include <string.h>

static void put_bounds(GByteArray *text, const double *bounds, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &bounds[i], sizeof bits);
        bits = GUINT64_TO_LE(bits);
        g_byte_array_append(text, (const uint8_t *)&bits, sizeof bits);
    }
}

void box_text_put(GByteArray *text, const struct box *box, const struct moves *moves)
{
    put_bounds(text, box->lower, box->count);
    put_bounds(text, box->upper, box->count);
    if (moves != NULL)
        g_byte_array_append(text, moves->rows, (guint)moves_size(moves));
}

static size_t bounds_size(uint32_t variables)
{
    return 2 * sizeof(double) * (size_t)variables;
}

bool box_text_size_ok(size_t size, uint32_t variables)
{
    return variables > 0 && size >= bounds_size(variables) &&
           (size - bounds_size(variables)) % (1 + (size_t)variables) == 0;
}

static void get_bounds(const uint8_t *text, double *bounds, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, text + i * sizeof bits, sizeof bits);
        bits = GUINT64_FROM_LE(bits);
        memcpy(&bounds[i], &bits, sizeof bits);
    }
}

static const char *what_is_wrong(const struct box *box, const struct moves *moves)
{
    for (uint32_t v = 0; v < box->count; v++) {
        if (!isfinite(box->lower[v]) || !isfinite(box->upper[v]) || box->lower[v] > box->upper[v])
            return "bounds that are no interval";
    }
    for (size_t i = 0; i < moves_size(moves); i++) {
        if (i % (1 + (size_t)moves->variables) != 0 && moves->rows[i] > MOVES_LEVEL_MAX)
            return "an attack beyond the bounds";
    }
    return NULL;
}

const char *box_text_get(const uint8_t *text, size_t size, uint32_t variables, struct box *box,
                         struct moves *moves)
{
    if (!box_text_size_ok(size, variables))
        return "a size that no box has";
    const size_t rows_size = size - bounds_size(variables);
    box_init(box, variables);
    get_bounds(text, box->lower, variables);
    get_bounds(text + bounds_size(variables) / 2, box->upper, variables);
    *moves = (struct moves){.variables = variables,
                            .attacks = (uint32_t)(rows_size / (1 + (size_t)variables)),
                            .rows = g_memdup2(text + bounds_size(variables), rows_size)};
    const char *wrong = what_is_wrong(box, moves);
    if (wrong != NULL) {
        box_fini(box);
        moves_fini(moves);
    }
    return wrong;
}
