#include "coordinator/report/warnings.h"

#include "common/base/plain.h"

static bool everything_good(const struct run_data_search *search)
{
    return search->space_samples > 0 && search->space_good == search->space_samples;
}

bool warnings_any(const struct run_data_search *search)
{
    return search->scenario.finding_count > 0 || everything_good(search);
}

char **warnings_of(const struct run_data_search *search)
{
    GPtrArray *texts = g_ptr_array_new();
    for (uint32_t i = 0; i < search->scenario.finding_count; i++)
        g_ptr_array_add(texts, g_strdup(search->scenario.findings[i].text));
    if (everything_good(search))
        g_ptr_array_add(
            texts, g_strdup_printf("design space: all of %u designs of it are good, so nothing but "
                                   "its own bounds limits the corridors; likely slip: bounds that "
                                   "are too narrow, a speed or a firewall_distance that is too "
                                   "small, or springs that hardly touch",
                                   search->space_samples));
    g_ptr_array_add(texts, NULL);
    return (char **)g_ptr_array_free(texts, FALSE);
}

void warnings_print(const struct run_data_search *search, FILE *out)
{
    char **texts = warnings_of(search);
    for (char **text = texts; *text != NULL; text++) {
        char *plain = plain_text(*text);
        fprintf(out, "warning      %s\n", plain);
        g_free(plain);
    }
    g_strfreev(texts);
}
