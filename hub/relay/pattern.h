// What a client has subscribed to: the name of a channel, or a regular expression that the whole
// name must match, as LCM's clients send them. Whoever connects can send one, so both compiling and
// matching have limits: an expression that tries too hard matches nothing.
#ifndef SOBOX_HUB_RELAY_PATTERN_H
#define SOBOX_HUB_RELAY_PATTERN_H

#include <stdbool.h>
#include <stddef.h>

// Steps that one match may take; a reasonable expression needs some tens. 100,000 are a
// millisecond.
#define PATTERN_STEPS "10000"

struct pattern;

// A pattern of `size` bytes; NULL when it is no expression. Freed with pattern_free().
struct pattern *pattern_create(const char *text, size_t size);
void pattern_free(struct pattern *pattern); // NULL is fine

// Whether it was made of this text.
bool pattern_is(const struct pattern *pattern, const char *text, size_t size);

bool pattern_matches(const struct pattern *pattern, const char *channel);

#endif
