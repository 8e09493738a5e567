#include "common/base/error.h"

#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum status error_set(struct error *error, enum status status, const char *format, ...)
{
    if (error == NULL)
        return status;
    // The arguments may point into the text that is being replaced.
    char text[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    error->status = status;
    memcpy(error->text, text, sizeof text);
    return status;
}

enum status error_wrap(struct error *error, const char *format, ...)
{
    char text[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    g_strlcat(text, ": ", sizeof text);
    g_strlcat(text, error->text, sizeof text);
    memcpy(error->text, text, sizeof text);
    return error->status;
}
