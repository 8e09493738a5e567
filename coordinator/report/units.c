#include "coordinator/report/units.h"

#include <glib.h>
#include <string.h>

// Forces over deformations have no time in them; it stands in the names because simulations are
// known by all three.
static const struct units all[] = {
    {"N-m-s", "N", "m", 1, 1},          {"N-mm-s", "N", "mm", 1, 1e3},
    {"N-mm-ms", "N", "mm", 1, 1e3},     {"kN-m-s", "kN", "m", 1e-3, 1},
    {"kN-mm-s", "kN", "mm", 1e-3, 1e3}, {"kN-mm-ms", "kN", "mm", 1e-3, 1e3},
};

enum status units_find(const char *name, const struct units **units, struct error *error)
{
    GString *names = g_string_new(NULL);
    for (size_t i = 0; i < G_N_ELEMENTS(all); i++) {
        if (strcmp(all[i].name, name) == 0) {
            *units = &all[i];
            g_string_free(names, TRUE);
            return STATUS_OK;
        }
        g_string_append_printf(names, "%s%s", i > 0 ? ", " : "", all[i].name);
    }
    error_set(error, STATUS_INVALID, "--units %s: expected one of %s", name, names->str);
    g_string_free(names, TRUE);
    return STATUS_INVALID;
}
