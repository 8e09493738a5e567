#include "common/scenario/tree_node.h"

#include <glib.h>
#include <string.h>
#include <yaml.h>

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
