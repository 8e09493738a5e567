// A box as it travels and as it is named: the bounds of all variables, and, where a step samples
// attacks, their rows.
//
//     lower bounds | upper bounds | rows of attacks      8 bytes a bound, IEEE, low byte first;
//                                                        1 + variables bytes a row
#ifndef SOBOX_COMMON_SAMPLING_BOX_TEXT_H
#define SOBOX_COMMON_SAMPLING_BOX_TEXT_H

#include "common/numeric/box.h"
#include "common/sampling/moves.h"

#include <glib.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Adds the text of a box to `text`; `moves` is NULL where there are no attacks.
void box_text_put(GByteArray *text, const struct box *box, const struct moves *moves);

// Whether a box of `variables` variables may have a text of so many bytes.
bool box_text_size_ok(size_t size, uint32_t variables);

// Reads the text of a box. Returns NULL, with `box` and `moves` made (the caller releases them with
// box_fini() and moves_fini(); without attacks `moves` has none), or what is wrong, with nothing
// made: a size that none has, bounds that are no interval, a level beyond MOVES_LEVEL_MAX. It
// trusts nothing it is given.
const char *box_text_get(const uint8_t *text, size_t size, uint32_t variables, struct box *box,
                         struct moves *moves);

#endif
