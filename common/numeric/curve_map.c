#include "common/numeric/curve_map.h"

#include <glib.h>

void curve_map_init(struct curve_map *map, uint32_t variables)
{
    *map = (struct curve_map){.variables = variables, .count = variables, .group_count = variables};
    map->curve = g_new(uint32_t, variables + 1);
    map->group = g_new(uint32_t, variables + 1);
    for (uint32_t v = 0; v < variables; v++)
        map->curve[v] = map->group[v] = v;
}

void curve_map_fini(struct curve_map *map)
{
    g_free(map->curve);
    g_free(map->group);
    *map = (struct curve_map){0};
}
