// Springs as the list `springs:` of a scenario.
#ifndef SOBOX_WORKER_COMPONENTS_SPRINGS_TEXT_H
#define SOBOX_WORKER_COMPONENTS_SPRINGS_TEXT_H

#include "worker/components/spring.h"

// The YAML of the springs, one for each group, each under a comment that says what it holds.
// Springs of curves alone (`groups` NULL) have a name and points only. The caller frees it with
// g_free().
char *springs_text(const struct spring *springs, uint32_t count, const struct group_list *groups);

#endif
