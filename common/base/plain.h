// Text from anywhere made fit to be shown. Names, values and cells of files come from people and
// machines that are not known, and a terminal obeys what it is shown: an escape sequence renames
// its window, moves its cursor, hides what was said. So nothing reaches a terminal that is not
// printable: log.h passes every line through plain_text(), and who prints a name does so too.
#ifndef SOBOX_COMMON_BASE_PLAIN_H
#define SOBOX_COMMON_BASE_PLAIN_H

// A copy of a text with a question mark in place of each control character, line ends among them,
// of each character that is not shown or turns the direction of what follows, and of each byte that
// is not UTF-8. The caller frees it.
char *plain_text(const char *text);

#endif
