// The report of a sweep as a document for people: tables first, then pictures, in Markdown or HTML.
#ifndef SOBOX_COORDINATOR_REPORT_DOCUMENT_H
#define SOBOX_COORDINATOR_REPORT_DOCUMENT_H

#include "coordinator/report/rows.h"

// A picture of the document.
struct document_picture {
    char *title;
    char *svg;  // of HTML: the element itself
    char *file; // of Markdown: the file's name
};

struct document {
    const struct rows *rows;
    GArray *pictures; // of struct document_picture
};

// The whole text; the caller frees it.
char *document_markdown(const struct document *document);
char *document_html(const struct document *document);

#endif
