// The texts that workers may ask for by their digest: scenarios, and boxes too large to travel with
// each batch. What one worker asked for, all hear, so the same piece is not sent again at once.
#ifndef SOBOX_COORDINATOR_RUNTIME_TEXTS_H
#define SOBOX_COORDINATOR_RUNTIME_TEXTS_H

#include "common/numeric/digest.h"

#include <stddef.h>
#include <stdint.h>

struct texts;

struct texts *texts_create(void);
void texts_free(struct texts *texts);

// Offers a text; `bytes` is borrowed until texts_remove() or texts_free(). The same digest may be
// offered several times and is then to be removed as often.
void texts_add(struct texts *texts, const struct digest *digest, const void *bytes, size_t size);
void texts_remove(struct texts *texts, const struct digest *digest);

// The text with this digest, if it is to be sent now from `offset` on: NULL when there is none,
// when `offset` is beyond its end, or when it was sent from there less than `repeat_ns` ago.
const uint8_t *texts_ask(struct texts *texts, const struct digest *digest, size_t offset,
                         int64_t now_ns, int64_t repeat_ns, size_t *size);

#endif
