// Puts indexes in the order of their keys, in time that grows with their number alone. Keys are
// spread evenly over some thousand cells, cells are sorted by counting, and only keys that share a
// cell are compared; a crowded cell is spread again by itself.
//
// Stable: equal keys keep the order they came in, so the result is the same for whatever cells.
#ifndef SOBOX_COORDINATOR_SEARCH_RANKING_H
#define SOBOX_COORDINATOR_SEARCH_RANKING_H

#include <stdint.h>

// Sorts `order`, `count` indexes into `key`, by ascending key. All keys lie in [least, most]; the
// tighter, the faster. Needs 2 x count numbers of scratch.
void ranking_sort(uint32_t *order, uint32_t count, const double *key, double least, double most,
                  uint64_t *scratch);

#endif
