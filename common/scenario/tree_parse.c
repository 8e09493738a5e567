#include "common/scenario/tree_node.h"

#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <yaml.h>

// The parse in progress. The event parser does not recurse, and build_node() is bounded by depth.
struct builder {
    struct tree *tree;
    yaml_parser_t parser;
    const char *source;
    uint32_t line, column; // in `source` at which the text begins, from 0
    const char *text;
    struct error *error;
    bool failed;
};

static bool build_node(struct builder *builder, const yaml_event_t *event,
                       const struct tree_node *parent, uint32_t depth, struct tree_node **built);

static bool fail(struct builder *builder, const yaml_mark_t *mark, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// The text's line and column in what it stands in, from 1.
static uint32_t line_of(const struct builder *builder, const yaml_mark_t *mark)
{
    return builder->line + (uint32_t)mark->line + 1;
}

static uint32_t column_of(const struct builder *builder, const yaml_mark_t *mark)
{
    return (mark->line == 0 ? builder->column : 0) + (uint32_t)mark->column + 1;
}

static bool fail(struct builder *builder, const yaml_mark_t *mark, const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    tree_error_at(builder->error, builder->source, line_of(builder, mark), column_of(builder, mark),
                  message);
    builder->failed = true;
    return false;
}

// Where the byte at `offset` stands.
static yaml_mark_t mark_of(const char *text, size_t offset)
{
    yaml_mark_t mark = {0};
    for (size_t i = 0; i < offset; i++) {
        if (text[i] == '\n') {
            mark.line++;
            mark.column = 0;
        } else if (((unsigned char)text[i] & 0xC0) != 0x80) {
            mark.column++; // a character's first byte
        }
    }
    return mark;
}

// What libyaml calls wrong, with the construct it was reading when it has one to name.
static bool fail_syntax(struct builder *builder)
{
    const yaml_parser_t *parser = &builder->parser;
    const char *problem = parser->problem != NULL ? parser->problem : "cannot be understood";
    if (parser->context != NULL)
        return fail(builder, &parser->problem_mark, "broken YAML: %s, %s", parser->context,
                    problem);
    // The reader runs ahead of the marks, so for a byte it does not like there is only an offset.
    yaml_mark_t mark = parser->error == YAML_READER_ERROR
                           ? mark_of(builder->text, parser->problem_offset)
                           : parser->problem_mark;
    return fail(builder, &mark, "broken YAML: %s", problem);
}

static bool next_event(struct builder *builder, yaml_event_t *event)
{
    if (yaml_parser_parse(&builder->parser, event))
        return true;
    return fail_syntax(builder);
}

static bool build_scalar(struct builder *builder, const yaml_event_t *event, struct tree_node *node)
{
    const char *text = (const char *)event->data.scalar.value;
    if (strlen(text) != event->data.scalar.length)
        return fail(builder, &event->start_mark, "expected text without the character NUL");
    node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text = g_string_chunk_insert_const(builder->tree->strings,
                                             node->quoted ? text : tree_plain_text(text));
    return true;
}

static bool build_sequence(struct builder *builder, struct tree_node *node, uint32_t depth)
{
    for (;;) {
        yaml_event_t event;
        if (!next_event(builder, &event))
            return false;
        bool end = event.type == YAML_SEQUENCE_END_EVENT;
        struct tree_node *item = NULL;
        bool built = end || build_node(builder, &event, node, depth + 1, &item);
        yaml_event_delete(&event);
        if (!built || end)
            return built;
        tree_node_append(node, NULL, item);
    }
}

static bool build_key(struct builder *builder, const yaml_event_t *event, struct tree_node *node,
                      uint32_t depth, struct tree_node **key)
{
    if (event->type != YAML_SCALAR_EVENT && event->type != YAML_ALIAS_EVENT)
        return fail(builder, &event->start_mark, "expected a plain key, found a list or a mapping");
    if (node->count == TREE_KEY_MAX)
        return fail(builder, &event->start_mark, "expected at most %d keys in one mapping",
                    TREE_KEY_MAX);
    if (!build_node(builder, event, node, depth + 1, key))
        return false;
    if (tree_child(node, (*key)->text) != NULL) {
        fail(builder, &event->start_mark, "key '%s' is given twice: expected it once",
             (*key)->text);
        tree_node_free(*key);
        return false;
    }
    return true;
}

static bool build_mapping(struct builder *builder, struct tree_node *node, uint32_t depth)
{
    for (;;) {
        yaml_event_t event;
        if (!next_event(builder, &event))
            return false;
        bool end = event.type == YAML_MAPPING_END_EVENT;
        struct tree_node *key = NULL;
        bool built = end || build_key(builder, &event, node, depth, &key);
        yaml_event_delete(&event);
        if (!built || end)
            return built;

        struct tree_node *value = NULL;
        built = next_event(builder, &event);
        if (built) {
            built = build_node(builder, &event, node, depth + 1, &value);
            yaml_event_delete(&event);
        }
        if (!built) {
            tree_node_free(key);
            return false;
        }
        tree_node_append(node, key, value);
    }
}

// Anchors and tags would let a text mean something else than it shows.
static bool refuse_decoration(struct builder *builder, const yaml_event_t *event)
{
    const yaml_char_t *anchor = NULL, *tag = NULL;
    switch (event->type) {
    case YAML_ALIAS_EVENT:
        anchor = event->data.alias.anchor;
        break;
    case YAML_SCALAR_EVENT:
        anchor = event->data.scalar.anchor;
        tag = event->data.scalar.tag;
        break;
    case YAML_SEQUENCE_START_EVENT:
        anchor = event->data.sequence_start.anchor;
        tag = event->data.sequence_start.tag;
        break;
    case YAML_MAPPING_START_EVENT:
        anchor = event->data.mapping_start.anchor;
        tag = event->data.mapping_start.tag;
        break;
    default:
        break;
    }
    if (anchor != NULL)
        return fail(builder, &event->start_mark,
                    "anchors and aliases (& and *) are not supported: expected the value itself");
    if (tag != NULL)
        return fail(builder, &event->start_mark,
                    "tags (!) are not supported: expected the value alone");
    return true;
}

// Builds the node that starts with `event`, which stays the caller's. Nothing is built on failure.
static bool build_node(struct builder *builder, const yaml_event_t *event,
                       const struct tree_node *parent, uint32_t depth, struct tree_node **built)
{
    if (!refuse_decoration(builder, event))
        return false;
    if (depth > TREE_DEPTH_MAX)
        return fail(builder, &event->start_mark, "expected at most %d levels of nesting",
                    TREE_DEPTH_MAX);
    if (builder->tree->node_count == TREE_NODE_MAX)
        return fail(builder, &event->start_mark, "expected at most %d values", TREE_NODE_MAX);

    enum tree_kind kind = event->type == YAML_SCALAR_EVENT           ? TREE_SCALAR
                          : event->type == YAML_SEQUENCE_START_EVENT ? TREE_SEQUENCE
                                                                     : TREE_MAPPING;
    struct tree_node *node =
        tree_node_create(builder->tree, kind, builder->source, line_of(builder, &event->start_mark),
                         column_of(builder, &event->start_mark), parent);
    bool done = kind == TREE_SCALAR     ? build_scalar(builder, event, node)
                : kind == TREE_SEQUENCE ? build_sequence(builder, node, depth)
                                        : build_mapping(builder, node, depth);
    if (!done) {
        tree_node_free(node);
        return false;
    }
    *built = node;
    return true;
}

// STREAM-START DOCUMENT-START node DOCUMENT-END STREAM-END, and nothing else.
static struct tree_node *build_document(struct builder *builder, uint32_t depth)
{
    struct tree_node *root = NULL;
    bool done = false;
    while (!done && !builder->failed) {
        yaml_event_t event;
        if (!next_event(builder, &event))
            break;
        switch (event.type) {
        case YAML_STREAM_START_EVENT:
        case YAML_DOCUMENT_END_EVENT:
            break;
        case YAML_DOCUMENT_START_EVENT:
            if (root != NULL)
                fail(builder, &event.start_mark, "expected one YAML document, found a second");
            break;
        case YAML_STREAM_END_EVENT:
            done = true;
            break;
        default:
            build_node(builder, &event, NULL, depth, &root);
        }
        yaml_event_delete(&event);
    }
    if (!builder->failed && root == NULL)
        fail(builder, &(yaml_mark_t){0}, "expected a YAML document, found nothing");
    if (builder->failed) {
        tree_node_free(root);
        return NULL;
    }
    return root;
}

// Whether a line begins at `offset`, after any of the line breaks that libyaml knows.
static bool line_begins(const char *text, size_t offset)
{
    static const char *const breaks[] = {
        "\n",           "\r",           "\xc2\x85",
        "\xe2\x80\xa8", "\xe2\x80\xa9", "\xef\xbb\xbf"}; // the last is a byte order mark
    if (offset == 0)
        return true;
    for (size_t i = 0; i < G_N_ELEMENTS(breaks); i++) {
        size_t length = strlen(breaks[i]);
        if (offset >= length && memcmp(text + offset - length, breaks[i], length) == 0)
            return true;
    }
    return false;
}

// Directives are of no use here, and libyaml compares each with all before it: a megabyte of them
// takes it a quarter of a minute.
static bool refuse_directives(struct builder *builder, size_t size)
{
    const char *text = builder->text;
    const char *at = memchr(text, '%', size);
    while (at != NULL && !line_begins(text, (size_t)(at - text)))
        at = memchr(at + 1, '%', size - (size_t)(at + 1 - text));
    if (at == NULL)
        return true;
    yaml_mark_t mark = mark_of(text, (size_t)(at - text));
    return fail(builder, &mark,
                "directives (%%) are not supported: expected no line that begins "
                "with '%%'");
}

struct tree_node *tree_parse_below(struct tree *tree, const struct tree_node *place,
                                   const char *text, size_t size, uint32_t depth,
                                   struct error *error)
{
    struct builder builder = {
        .tree = tree,
        .source = g_string_chunk_insert_const(tree->strings, place->source),
        .line = place->line - 1,
        .column = place->column - 1,
        .text = text,
        .error = error,
    };
    if (size > TREE_TEXT_SIZE_MAX) {
        fail(&builder, &(yaml_mark_t){0}, "expected at most %d bytes of YAML, found more",
             TREE_TEXT_SIZE_MAX);
        return NULL;
    }
    const char *end;
    if (!g_utf8_validate(text, (gssize)size, &end)) {
        yaml_mark_t mark = mark_of(text, (size_t)(end - text));
        fail(&builder, &mark, "expected UTF-8, found the byte 0x%02x", (unsigned char)*end);
        return NULL;
    }
    if (!refuse_directives(&builder, size))
        return NULL;
    int initialized = yaml_parser_initialize(&builder.parser);
    g_assert(initialized); // fails without memory only
    yaml_parser_set_encoding(&builder.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&builder.parser, (const unsigned char *)text, size);
    struct tree_node *root = build_document(&builder, depth);
    yaml_parser_delete(&builder.parser);
    return root;
}

struct tree *tree_parse_at(const struct tree_node *place, const char *text, size_t size,
                           struct error *error)
{
    struct tree *tree = g_new0(struct tree, 1);
    tree->strings = g_string_chunk_new(4096);
    tree->root = tree_parse_below(tree, place, text, size, 1, error);
    if (tree->root == NULL) {
        tree_free(tree);
        return NULL;
    }
    return tree;
}

struct tree *tree_parse(const char *source, const char *text, size_t size, struct error *error)
{
    const struct tree_node begin = {.source = source, .line = 1, .column = 1};
    return tree_parse_at(&begin, text, size, error);
}
