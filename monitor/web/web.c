#include "monitor/web/web.h"

#include <string.h>

// A file's bytes between two symbols of the program.
#define EMBED(name, file)                                                         \
    __asm__(".section .rodata\n"                                                  \
            "web_" #name "_begin: .incbin \"" file "\"\n"                         \
            "web_" #name "_end: .byte 0\n"                                        \
            ".previous\n");                                                       \
    extern const char web_##name##_begin[] __attribute__((visibility("hidden"))); \
    extern const char web_##name##_end[] __attribute__((visibility("hidden")))

EMBED(index, WEB_FOLDER "/index.html");
EMBED(style, WEB_FOLDER "/page.css");
EMBED(figures, WEB_FOLDER "/figures.js");
EMBED(xray, WEB_FOLDER "/xray.js");
EMBED(sweep, WEB_FOLDER "/sweep.js");
EMBED(script, WEB_FOLDER "/page.js");
EMBED(chart, WEB_CHART_JS);

bool web_file(const char *path, struct web_file *file)
{
    static const struct {
        const char *path, *type, *begin, *end;
    } files[] = {
        {"/", "text/html; charset=utf-8", web_index_begin, web_index_end},
        {"/page.css", "text/css; charset=utf-8", web_style_begin, web_style_end},
        {"/figures.js", "text/javascript; charset=utf-8", web_figures_begin, web_figures_end},
        {"/xray.js", "text/javascript; charset=utf-8", web_xray_begin, web_xray_end},
        {"/sweep.js", "text/javascript; charset=utf-8", web_sweep_begin, web_sweep_end},
        {"/page.js", "text/javascript; charset=utf-8", web_script_begin, web_script_end},
        {"/chart.js", "text/javascript; charset=utf-8", web_chart_begin, web_chart_end},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (strcmp(files[i].path, path) != 0)
            continue;
        *file = (struct web_file){
            .type = files[i].type,
            .bytes = files[i].begin,
            .size = (size_t)(files[i].end - files[i].begin),
        };
        return true;
    }
    return false;
}
