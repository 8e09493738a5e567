#include "common/scenario/tree.h"

#include <assert.h>
#include <errno.h>
#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <yaml.h>

struct tree {
    struct tree_node *root;
    GStringChunk *strings; // texts and sources of all nodes
    uint32_t node_count;   // made so far: nodes that were replaced still count
};

// The parse in progress. The event parser does not recurse, and build_node() is bounded by depth.
struct builder {
    struct tree *tree;
    yaml_parser_t parser;
    const char *source;
    const char *text;
    struct error *error;
    bool failed;
};

static bool build_node(struct builder *builder, const yaml_event_t *event,
                       const struct tree_node *parent, uint32_t depth, struct tree_node **built);

// ------------------------------------------------------------------------------------------------
// Messages

// A message is one line: control characters from names and values become question marks.
static void one_line(char *text)
{
    for (; *text != '\0'; text++) {
        if ((unsigned char)*text < 0x20 || *text == 0x7f)
            *text = '?';
    }
}

static enum status error_at(struct error *error, const char *source, uint32_t line, uint32_t column,
                            const char *message)
{
    enum status status =
        error_set(error, STATUS_INVALID, "%s:%u:%u: %s", source, line, column, message);
    if (error != NULL)
        one_line(error->text);
    return status;
}

enum status tree_error(const struct tree_node *node, struct error *error, const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    char path[TREE_PATH_SIZE];
    tree_path(node, path);
    char *whole = g_strconcat(path, path[0] == '\0' ? "" : ": ", message, NULL);
    error_at(error, node->source, node->line, node->column, whole);
    g_free(whole);
    return STATUS_INVALID;
}

// Which item of its parent a node is; the parent's count for a key.
static uint32_t index_in_parent(const struct tree_node *node)
{
    uint32_t index = 0;
    while (index < node->parent->count && node->parent->items[index] != node)
        index++;
    return index;
}

const char *tree_path(const struct tree_node *node, char path[TREE_PATH_SIZE])
{
    const struct tree_node *nodes[TREE_DEPTH_MAX + 1];
    uint32_t depth = 0;
    for (; node->parent != NULL; node = node->parent) {
        assert(depth <= TREE_DEPTH_MAX);
        nodes[depth++] = node;
    }
    GString *text = g_string_new(NULL);
    while (depth-- > 0) {
        const struct tree_node *parent = nodes[depth]->parent;
        uint32_t index = index_in_parent(nodes[depth]);
        if (index == parent->count)
            break;
        if (text->len > 0)
            g_string_append_c(text, '.');
        if (parent->kind == TREE_MAPPING)
            g_string_append(text, parent->keys[index]->text);
        else
            g_string_append_printf(text, "%u", index);
    }
    g_strlcpy(path, text->str, TREE_PATH_SIZE);
    g_string_free(text, TRUE);
    return path;
}

// How many bytes of a long text to show, at most `size`, so that no character is cut.
static int shown_length(const char *text, size_t size)
{
    const char *end;
    g_utf8_validate(text, (gssize)size, &end);
    return (int)(end - text);
}

const char *tree_shown(const struct tree_node *node, char shown[TREE_SHOWN_SIZE])
{
    if (node->kind == TREE_SEQUENCE)
        snprintf(shown, TREE_SHOWN_SIZE, "a list of %u", node->count);
    else if (node->kind == TREE_MAPPING)
        g_strlcpy(shown, "a mapping", TREE_SHOWN_SIZE);
    else if (!node->quoted && strcmp(node->text, "null") == 0)
        g_strlcpy(shown, "nothing", TREE_SHOWN_SIZE);
    else if (strlen(node->text) + 3 <= TREE_SHOWN_SIZE)
        snprintf(shown, TREE_SHOWN_SIZE, node->quoted ? "'%s'" : "%s", node->text);
    else
        snprintf(shown, TREE_SHOWN_SIZE, "'%.*s...'", shown_length(node->text, TREE_SHOWN_SIZE - 6),
                 node->text);
    return shown;
}

// ------------------------------------------------------------------------------------------------
// Building

static void node_free(struct tree_node *node)
{
    if (node == NULL)
        return;
    for (uint32_t i = 0; i < node->count; i++) {
        node_free(node->items[i]);
        if (node->keys != NULL)
            node_free(node->keys[i]);
    }
    g_free(node->items);
    g_free(node->keys);
    g_free(node);
}

static struct tree_node *node_create(struct tree *tree, enum tree_kind kind, const char *source,
                                     const yaml_mark_t *mark, const struct tree_node *parent)
{
    tree->node_count++;
    struct tree_node *node = g_new0(struct tree_node, 1);
    *node = (struct tree_node){
        .kind = kind,
        .source = source,
        .line = (uint32_t)mark->line + 1,
        .column = (uint32_t)mark->column + 1,
        .parent = parent,
    };
    return node;
}

// Room grows by doubling; `count` is what is in use.
static void append(struct tree_node ***nodes, uint32_t count, struct tree_node *node)
{
    if (count == 0 || (count & (count - 1)) == 0)
        *nodes = g_renew(struct tree_node *, *nodes, count == 0 ? 1 : 2 * count);
    (*nodes)[count] = node;
}

static bool fail(struct builder *builder, const yaml_mark_t *mark, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static bool fail(struct builder *builder, const yaml_mark_t *mark, const char *format, ...)
{
    char message[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    error_at(builder->error, builder->source, (uint32_t)mark->line + 1, (uint32_t)mark->column + 1,
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

// Plain YAML has three spellings of nothing, and the canonical text needs one.
static const char *plain_text(const char *text)
{
    return text[0] == '\0' || strcmp(text, "~") == 0 ? "null" : text;
}

static bool build_scalar(struct builder *builder, const yaml_event_t *event, struct tree_node *node)
{
    const char *text = (const char *)event->data.scalar.value;
    if (strlen(text) != event->data.scalar.length)
        return fail(builder, &event->start_mark, "expected text without the character NUL");
    node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text =
        g_string_chunk_insert_const(builder->tree->strings, node->quoted ? text : plain_text(text));
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
        append(&node->items, node->count, item);
        node->count++;
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
        node_free(*key);
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
            node_free(key);
            return false;
        }
        append(&node->keys, node->count, key);
        append(&node->items, node->count, value);
        node->count++;
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
        node_create(builder->tree, kind, builder->source, &event->start_mark, parent);
    bool done = kind == TREE_SCALAR     ? build_scalar(builder, event, node)
                : kind == TREE_SEQUENCE ? build_sequence(builder, node, depth)
                                        : build_mapping(builder, node, depth);
    if (!done) {
        node_free(node);
        return false;
    }
    *built = node;
    return true;
}

// STREAM-START DOCUMENT-START node DOCUMENT-END STREAM-END, and nothing else.
static struct tree_node *build_document(struct builder *builder, const struct tree_node *parent,
                                        uint32_t depth)
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
            build_node(builder, &event, parent, depth, &root);
        }
        yaml_event_delete(&event);
    }
    if (!builder->failed && root == NULL)
        fail(builder, &(yaml_mark_t){0}, "expected a YAML document, found nothing");
    if (builder->failed) {
        node_free(root);
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

// Parses `text` into nodes that belong to `tree` and will hang below `parent` at `depth`.
static struct tree_node *parse(struct tree *tree, const char *source, const char *text, size_t size,
                               const struct tree_node *parent, uint32_t depth, struct error *error)
{
    struct builder builder = {
        .tree = tree,
        .source = g_string_chunk_insert_const(tree->strings, source),
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
    struct tree_node *root = build_document(&builder, parent, depth);
    yaml_parser_delete(&builder.parser);
    return root;
}

struct tree *tree_parse(const char *source, const char *text, size_t size, struct error *error)
{
    struct tree *tree = g_new0(struct tree, 1);
    tree->strings = g_string_chunk_new(4096);
    tree->root = parse(tree, source, text, size, NULL, 1, error);
    if (tree->root == NULL) {
        tree_free(tree);
        return NULL;
    }
    return tree;
}

// A file that cannot be read is invalid input like any other: whoever named it can name another.
static void unreadable(struct error *error, const char *path)
{
    char message[ERROR_TEXT_SIZE];
    snprintf(message, sizeof message, "expected a file that can be read: %s", g_strerror(errno));
    error_at(error, path, 1, 1, message);
}

struct tree *tree_load(const char *path, struct error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        unreadable(error, path);
        return NULL;
    }
    // One byte more than allowed tells a file that is too long, even one that never ends.
    char *text = g_malloc(TREE_TEXT_SIZE_MAX + 1);
    size_t size = fread(text, 1, TREE_TEXT_SIZE_MAX + 1, file);
    struct tree *tree = NULL;
    if (ferror(file))
        unreadable(error, path);
    else
        tree = tree_parse(path, text, size, error);
    g_free(text);
    fclose(file);
    return tree;
}

void tree_free(struct tree *tree)
{
    if (tree == NULL)
        return;
    node_free(tree->root);
    g_string_chunk_free(tree->strings);
    g_free(tree);
}

const struct tree_node *tree_root(const struct tree *tree)
{
    return tree->root;
}

// ------------------------------------------------------------------------------------------------
// Looking up and setting

static bool find_key(const struct tree_node *node, const char *key, uint32_t *index)
{
    if (node->kind != TREE_MAPPING)
        return false;
    for (uint32_t i = 0; i < node->count; i++) {
        if (strcmp(node->keys[i]->text, key) == 0) {
            *index = i;
            return true;
        }
    }
    return false;
}

const struct tree_node *tree_child(const struct tree_node *node, const char *key)
{
    uint32_t index;
    return find_key(node, key, &index) ? node->items[index] : NULL;
}

const struct tree_node *tree_spot(const struct tree_node *mapping, const char *key)
{
    const struct tree_node *node = tree_child(mapping, key);
    return node != NULL ? node : mapping;
}

// Where the assignment's steps lead: item `index` of `node`, which is there or can be appended.
struct slot {
    struct tree_node *node;
    uint32_t index;
};

static bool find_item(const struct tree_node *node, const char *step, uint32_t *index,
                      const char *source, struct error *error)
{
    guint64 number;
    if (node->count > 0 &&
        g_ascii_string_to_unsigned(step, 10, 0, node->count - 1, &number, NULL)) {
        *index = (uint32_t)number;
        return true;
    }
    char path[TREE_PATH_SIZE];
    tree_path(node, path);
    if (node->count == 0)
        error_set(error, STATUS_INVALID, "%s:1:1: %s: the list is empty: there is no item '%s'",
                  source, path, step);
    else
        error_set(error, STATUS_INVALID, "%s:1:1: %s: expected an index from 0 to %u, found '%s'",
                  source, path, node->count - 1, step);
    return false;
}

// Finds the slot of one step of the path. Keys that are missing stand behind the last one.
static bool find_slot(struct tree_node *node, const char *step, const char *source,
                      struct slot *slot, struct error *error)
{
    slot->node = node;
    step = plain_text(step);
    if (node->kind == TREE_SEQUENCE)
        return find_item(node, step, &slot->index, source, error);
    char path[TREE_PATH_SIZE], shown[TREE_SHOWN_SIZE];
    if (node->kind == TREE_SCALAR) {
        error_set(error, STATUS_INVALID, "%s:1:1: %s: expected a mapping to set '%s' in, found %s",
                  source, tree_path(node, path), step, tree_shown(node, shown));
        return false;
    }
    if (find_key(node, step, &slot->index))
        return true;
    slot->index = node->count;
    if (node->count < TREE_KEY_MAX)
        return true;
    error_set(error, STATUS_INVALID, "%s:1:1: %s: expected at most %d keys in one mapping", source,
              tree_path(node, path), TREE_KEY_MAX);
    return false;
}

// Puts `value` into the slot, in place of what is there or under a new key.
static void fill_slot(struct tree *tree, const struct slot *slot, const char *step,
                      struct tree_node *value)
{
    struct tree_node *node = slot->node;
    if (slot->index < node->count) {
        node_free(node->items[slot->index]);
        node->items[slot->index] = value;
        return;
    }
    struct tree_node *key = node_create(tree, TREE_SCALAR, value->source, &(yaml_mark_t){0}, node);
    key->text = g_string_chunk_insert_const(tree->strings, plain_text(step));
    append(&node->keys, node->count, key);
    append(&node->items, node->count, value);
    node->count++;
}

// Walks all steps but the last, making mappings on the way; `slot` receives the last one's place.
static bool walk(struct tree *tree, char **steps, const char *source, struct slot *slot,
                 struct error *error)
{
    struct tree_node *node = tree->root;
    for (; steps[1] != NULL; steps++) {
        if (!find_slot(node, steps[0], source, slot, error))
            return false;
        if (slot->index == node->count)
            fill_slot(tree, slot, steps[0],
                      node_create(tree, TREE_MAPPING, source, &(yaml_mark_t){0}, node));
        node = node->items[slot->index];
    }
    return find_slot(node, steps[0], source, slot, error);
}

static enum status set_steps(struct tree *tree, char **steps, uint32_t depth, const char *value,
                             const char *source, struct error *error)
{
    if (depth >= TREE_DEPTH_MAX || tree->node_count + 2 * depth > TREE_NODE_MAX)
        return error_set(error, STATUS_INVALID, "%s:1:1: expected at most %d levels of nesting",
                         source, TREE_DEPTH_MAX);
    // The value is parsed first, so that a broken one leaves the tree as it was.
    struct tree_node *node = parse(tree, source, value, strlen(value), NULL, depth + 1, error);
    if (node == NULL)
        return STATUS_INVALID;
    struct slot slot;
    if (!walk(tree, steps, source, &slot, error)) {
        node_free(node);
        return STATUS_INVALID;
    }
    node->parent = slot.node;
    fill_slot(tree, &slot, steps[depth - 1], node);
    return STATUS_OK;
}

// An assignment stands for itself in messages; of a long one the beginning does.
static const char *name_assignment(struct tree *tree, const char *assignment)
{
    char *source = strlen(assignment) <= TREE_SHOWN_SIZE
                       ? g_strdup_printf("--set %s", assignment)
                       : g_strdup_printf("--set %.*s...", shown_length(assignment, TREE_SHOWN_SIZE),
                                         assignment);
    one_line(source);
    const char *kept = g_string_chunk_insert_const(tree->strings, source);
    g_free(source);
    return kept;
}

enum status tree_set(struct tree *tree, const char *assignment, struct error *error)
{
    const char *equals = strchr(assignment, '=');
    if (!g_utf8_validate(assignment, -1, NULL))
        return error_set(error, STATUS_INVALID, "--set: expected UTF-8");
    const char *kept = name_assignment(tree, assignment);
    if (equals == NULL || equals == assignment || equals[1] == '\0')
        return error_set(error, STATUS_INVALID, "%s:1:1: expected KEY.PATH=VALUE", kept);

    char *path = g_strndup(assignment, (gsize)(equals - assignment));
    char **steps = g_strsplit(path, ".", -1);
    enum status status = STATUS_OK;
    for (char **step = steps; *step != NULL && status == STATUS_OK; step++) {
        if (**step == '\0')
            status = error_set(error, STATUS_INVALID,
                               "%s:1:1: expected keys with single dots in between, found '%s'",
                               kept, path);
    }
    if (status == STATUS_OK)
        status = set_steps(tree, steps, g_strv_length(steps), equals + 1, kept, error);
    if (status != STATUS_OK && error != NULL)
        one_line(error->text);
    g_strfreev(steps);
    g_free(path);
    return status;
}

// ------------------------------------------------------------------------------------------------
// Laying over

// The deepest copy would otherwise be deeper than any text that can be read.
static bool copy_fits(const struct tree_node *node, uint32_t depth, struct error *error)
{
    if (depth <= TREE_DEPTH_MAX)
        return true;
    tree_error(node, error, "expected at most %d levels of nesting", TREE_DEPTH_MAX);
    return false;
}

static struct tree_node *copy_single(const struct tree_node *node, const struct tree_node *parent)
{
    struct tree_node *copy = g_new0(struct tree_node, 1);
    *copy = *node;
    copy->parent = parent;
    copy->count = 0;
    copy->items = NULL;
    copy->keys = NULL;
    return copy;
}

static void append_entry(struct tree_node *node, struct tree_node *key, struct tree_node *value)
{
    if (key != NULL)
        append(&node->keys, node->count, key);
    append(&node->items, node->count, value);
    node->count++;
}

// A copy with everything below. Returns NULL with `error` filled.
static struct tree_node *copy_node(const struct tree_node *node, const struct tree_node *parent,
                                   uint32_t depth, struct error *error)
{
    if (!copy_fits(node, depth, error))
        return NULL;
    struct tree_node *copy = copy_single(node, parent);
    for (uint32_t i = 0; i < node->count; i++) {
        struct tree_node *item = copy_node(node->items[i], copy, depth + 1, error);
        if (item == NULL) {
            node_free(copy);
            return NULL;
        }
        append_entry(copy, node->keys != NULL ? copy_single(node->keys[i], copy) : NULL, item);
    }
    return copy;
}

// The item of a list that an override's key means: its index, or the name it has.
static bool find_named(const struct tree_node *list, const struct tree_node *key, const char *step,
                       uint32_t *index, struct error *error)
{
    guint64 number;
    if (list->count > 0 &&
        g_ascii_string_to_unsigned(step, 10, 0, list->count - 1, &number, NULL)) {
        *index = (uint32_t)number;
        return true;
    }
    for (uint32_t i = 0; i < list->count; i++) {
        const struct tree_node *name = tree_child(list->items[i], "name");
        if (name != NULL && name->kind == TREE_SCALAR && strcmp(name->text, step) == 0) {
            *index = i;
            return true;
        }
    }
    tree_error(key, error, "expected the name of an item or an index below %u, found '%s'",
               list->count, step);
    return false;
}

// Finds or makes the place that `step` names in `node`; a place that is made stands at `key`.
static bool overlay_slot(struct tree_node *node, const struct tree_node *key, const char *step,
                         struct slot *slot, struct error *error)
{
    slot->node = node;
    if (node->kind == TREE_SEQUENCE)
        return find_named(node, key, step, &slot->index, error);
    if (node->kind == TREE_SCALAR) {
        tree_error(key, error, "expected a key of a mapping, but what it is set in has none");
        return false;
    }
    if (find_key(node, step, &slot->index))
        return true;
    slot->index = node->count;
    if (node->count < TREE_KEY_MAX)
        return true;
    tree_error(key, error, "expected at most %d keys in one mapping", TREE_KEY_MAX);
    return false;
}

// Puts `value` where the slot is; a new key has the text `step`, which the tree keeps.
static void overlay_fill(const struct slot *slot, const struct tree_node *key, const char *step,
                         struct tree_node *value)
{
    struct tree_node *node = slot->node;
    if (slot->index < node->count) {
        node_free(node->items[slot->index]);
        node->items[slot->index] = value;
        return;
    }
    struct tree_node *copy = copy_single(key, node);
    copy->text = step;
    append_entry(node, copy, value);
}

static bool overlay(struct tree_node *node, const struct tree_node *overrides, uint32_t depth,
                    struct error *error);

static bool overlay_value(const struct slot *slot, const struct tree_node *key, const char *step,
                          const struct tree_node *value, uint32_t depth, struct error *error)
{
    struct tree_node *there =
        slot->index < slot->node->count ? slot->node->items[slot->index] : NULL;
    if (there != NULL && there->kind != TREE_SCALAR && value->kind == TREE_MAPPING)
        return overlay(there, value, depth, error);
    struct tree_node *copy = copy_node(value, slot->node, depth, error);
    if (copy != NULL)
        overlay_fill(slot, key, step, copy);
    return copy != NULL;
}

// Lays a mapping over `node`, which stands at `depth`.
static bool overlay(struct tree_node *node, const struct tree_node *overrides, uint32_t depth,
                    struct error *error)
{
    for (uint32_t i = 0; i < overrides->count; i++) {
        const struct tree_node *key = overrides->keys[i];
        struct slot slot;
        if (!overlay_slot(node, key, key->text, &slot, error) ||
            !overlay_value(&slot, key, key->text, overrides->items[i], depth + 1, error))
            return false;
    }
    return true;
}

// An empty mapping at the place of a key, to set what follows in the path in.
static struct tree_node *overlay_mapping(const struct tree_node *key,
                                         const struct tree_node *parent)
{
    struct tree_node *mapping = copy_single(key, parent);
    mapping->kind = TREE_MAPPING;
    mapping->text = NULL;
    mapping->quoted = false;
    return mapping;
}

// Lays one entry of the first level over the root: its key is a path.
static bool overlay_path(struct tree *tree, const struct tree_node *key,
                         const struct tree_node *value, struct error *error)
{
    char **steps = g_strsplit(key->text, ".", -1);
    struct tree_node *node = tree->root;
    uint32_t depth = 2;
    struct slot slot;
    bool found = true;
    for (uint32_t i = 0; found && steps[i] != NULL; i++, depth++) {
        const char *step = g_string_chunk_insert_const(tree->strings, steps[i]);
        found = copy_fits(key, depth, error) && overlay_slot(node, key, step, &slot, error);
        if (found && steps[i + 1] == NULL)
            found = overlay_value(&slot, key, step, value, depth, error);
        else if (found) {
            if (slot.index == node->count)
                overlay_fill(&slot, key, step, overlay_mapping(key, node));
            node = node->items[slot.index];
        }
    }
    g_strfreev(steps);
    return found;
}

// The root and what is below it, but for the keys in `without`.
static struct tree_node *copy_root(const struct tree_node *root, const char *const *without,
                                   struct error *error)
{
    struct tree_node *copy = copy_single(root, NULL);
    for (uint32_t i = 0; i < root->count; i++) {
        if (root->keys != NULL && g_strv_contains(without, root->keys[i]->text))
            continue;
        struct tree_node *item = copy_node(root->items[i], copy, 2, error);
        g_assert(item != NULL); // it is no deeper than the tree
        append_entry(copy, root->keys != NULL ? copy_single(root->keys[i], copy) : NULL, item);
    }
    return copy;
}

struct tree *tree_overlay(const struct tree *tree, const struct tree_node *overrides,
                          const char *const *without, struct error *error)
{
    struct tree *copy = g_new0(struct tree, 1);
    copy->strings = g_string_chunk_new(256); // of steps only, the nodes' texts are borrowed
    copy->node_count = tree->node_count;
    copy->root = copy_root(tree->root, without, error);
    for (uint32_t i = 0; i < overrides->count; i++) {
        if (!overlay_path(copy, overrides->keys[i], overrides->items[i], error)) {
            tree_free(copy);
            return NULL;
        }
    }
    return copy;
}

// ------------------------------------------------------------------------------------------------
// Emitting

static int write_text(void *data, unsigned char *buffer, size_t size)
{
    g_string_append_len(data, (const char *)buffer, (gssize)size);
    return 1;
}

static void emit(yaml_emitter_t *emitter, yaml_event_t *event)
{
    int emitted = yaml_emitter_emit(emitter, event);
    g_assert(emitted); // the tree is valid YAML, so only memory can fail
}

static void emit_scalar(yaml_emitter_t *emitter, const struct tree_node *node)
{
    // Where a plain scalar is not possible libyaml takes single quotes, and where those are not,
    // double ones. Quoted scalars go down the same ladder, so that the text does not change again.
    yaml_event_t event;
    yaml_scalar_event_initialize(
        &event, NULL, NULL, (const yaml_char_t *)node->text, (int)strlen(node->text), 1, 1,
        node->quoted ? YAML_SINGLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE);
    emit(emitter, &event);
}

static bool only_scalars(const struct tree_node *node)
{
    for (uint32_t i = 0; i < node->count; i++) {
        if (node->items[i]->kind != TREE_SCALAR)
            return false;
    }
    return true;
}

static void emit_node(yaml_emitter_t *emitter, const struct tree_node *node)
{
    yaml_event_t event;
    switch (node->kind) {
    case TREE_SCALAR:
        emit_scalar(emitter, node);
        break;
    case TREE_SEQUENCE:
        yaml_sequence_start_event_initialize(&event, NULL, NULL, 1,
                                             only_scalars(node) ? YAML_FLOW_SEQUENCE_STYLE
                                                                : YAML_BLOCK_SEQUENCE_STYLE);
        emit(emitter, &event);
        for (uint32_t i = 0; i < node->count; i++)
            emit_node(emitter, node->items[i]);
        yaml_sequence_end_event_initialize(&event);
        emit(emitter, &event);
        break;
    case TREE_MAPPING:
        yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, YAML_BLOCK_MAPPING_STYLE);
        emit(emitter, &event);
        for (uint32_t i = 0; i < node->count; i++) {
            emit_scalar(emitter, node->keys[i]);
            emit_node(emitter, node->items[i]);
        }
        yaml_mapping_end_event_initialize(&event);
        emit(emitter, &event);
        break;
    }
}

char *tree_emit(const struct tree *tree, size_t *size)
{
    GString *text = g_string_new(NULL);
    yaml_emitter_t emitter;
    int initialized = yaml_emitter_initialize(&emitter);
    g_assert(initialized);
    yaml_emitter_set_output(&emitter, write_text, text);
    yaml_emitter_set_encoding(&emitter, YAML_UTF8_ENCODING);
    yaml_emitter_set_unicode(&emitter, 1);
    yaml_emitter_set_width(&emitter, -1); // no line breaks but those of the structure

    yaml_event_t event;
    yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING);
    emit(&emitter, &event);
    yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1);
    emit(&emitter, &event);
    emit_node(&emitter, tree->root);
    yaml_document_end_event_initialize(&event, 1);
    emit(&emitter, &event);
    yaml_stream_end_event_initialize(&event);
    emit(&emitter, &event);
    yaml_emitter_delete(&emitter);

    *size = text->len;
    return g_string_free(text, FALSE);
}
