// Text from anywhere made fit to be shown.
#ifndef SOBOX_COMMON_BASE_PLAIN_H
#define SOBOX_COMMON_BASE_PLAIN_H

// A copy of a text without control characters, which could steer a terminal or end a line of a
// script. The caller frees it.
char *plain_text(const char *text);

#endif
