#include "common/scenario/tree.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct tree *parse(const char *text)
{
    struct error error = {0};
    struct tree *tree = tree_parse("t.yaml", text, strlen(text), &error);
    if (tree == NULL)
        fail_msg("%s", error.text);
    return tree;
}

static void assert_refused(const char *text, size_t size, const char *message)
{
    struct error error = {0};
    assert_null(tree_parse("t.yaml", text, size, &error));
    assert_int_equal(error.status, STATUS_INVALID);
    if (strncmp(error.text, message, strlen(message)) != 0)
        fail_msg("expected: %s\n found: %s", message, error.text);
}

static void assert_node(const struct tree_node *node, enum tree_kind kind, uint32_t line,
                        uint32_t column, const char *path)
{
    char found[TREE_PATH_SIZE];
    assert_non_null(node);
    assert_int_equal(node->kind, kind);
    assert_int_equal(node->line, line);
    assert_int_equal(node->column, column);
    assert_string_equal(tree_path(node, found), path);
}

// Every message that points into a file relies on these: lines and columns from 1, columns counted
// in characters, paths with keys and indexes.
static void nodes_know_where_they_stand(void **state)
{
    (void)state;
    struct tree *tree = parse("a: 1\n"
                              "b:\n"
                              "  - x: \"\xc3\xa9\xc3\xa9\"\n"
                              "  - [10, {y: \xc3\xa9, z: 3}]\n");
    const struct tree_node *root = tree_root(tree);
    assert_node(root, TREE_MAPPING, 1, 1, "");
    assert_node(tree_child(root, "a"), TREE_SCALAR, 1, 4, "a");
    const struct tree_node *b = tree_child(root, "b");
    assert_node(b, TREE_SEQUENCE, 3, 3, "b");
    assert_node(b->items[0], TREE_MAPPING, 3, 5, "b.0");
    assert_node(b->items[1]->items[1], TREE_MAPPING, 4, 10, "b.1.1");
    assert_node(tree_child(b->items[1]->items[1], "z"), TREE_SCALAR, 4, 20, "b.1.1.z");
    assert_node(b->items[0]->keys[0], TREE_SCALAR, 3, 5, "b.0");
    assert_null(tree_child(root, "c"));
    assert_null(tree_child(b, "a"));
    tree_free(tree);
}

// "1650" in quotes is a text and 1650 is a number; nothing, ~ and null are the same nothing.
static void scalars_keep_their_quotes(void **state)
{
    (void)state;
    struct tree *tree = parse("- 1650\n- '1650'\n-\n- ~\n- null\n- 'null'\n");
    const struct tree_node *root = tree_root(tree);
    char shown[TREE_SHOWN_SIZE];
    static const char *const expected[] = {"1650",    "'1650'",  "nothing",
                                           "nothing", "nothing", "'null'"};
    assert_int_equal(root->count, G_N_ELEMENTS(expected));
    for (uint32_t i = 0; i < root->count; i++)
        assert_string_equal(tree_shown(root->items[i], shown), expected[i]);
    assert_string_equal(tree_shown(root, shown), "a list of 6");
    tree_free(tree);
}

// What YAML allows and a scenario does not, each told where it stands.
static void surprises_are_refused(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"a: &x 1\n", "t.yaml:1:4: anchors and aliases"},
        {"a: 1\nb: *x\n", "t.yaml:2:4: anchors and aliases"},
        {"? *x\n: 1\n", "t.yaml:1:3: anchors and aliases"},
        {"a: !!float 1\n", "t.yaml:1:4: tags (!) are not supported"},
        {"a: !mine [1]\n", "t.yaml:1:4: tags (!) are not supported"},
        {"a: 1\n---\nb: 2\n", "t.yaml:2:1: expected one YAML document, found a second"},
        {"%YAML 1.1\n---\na: 1\n", "t.yaml:1:1: directives (%) are not supported"},
        {"a: 1\n...\n%TAG ! x\n---\n", "t.yaml:3:1: directives (%) are not supported"},
        {"\xef\xbb\xbf%TAG ! x\n---\n", "t.yaml:1:2: directives (%) are not supported"},
        {"# \xe2\x80\xa8%TAG ! x\n", "t.yaml:1:4: directives (%) are not supported"},
        {"a: 1\nb: 2\na: 3\n", "t.yaml:3:1: key 'a' is given twice"},
        {"[1, 2]: 3\n", "t.yaml:1:1: expected a plain key, found a list or a mapping"},
        {"? {a: 1}\n: 3\n", "t.yaml:1:3: expected a plain key, found a list or a mapping"},
        {"", "t.yaml:1:1: expected a YAML document, found nothing"},
        {"# only a comment\n", "t.yaml:1:1: expected a YAML document, found nothing"},
        {"a: \"\\0\"\n", "t.yaml:1:4: expected text without the character NUL"},
        {"a: [1, 2\nb: 3\n", "t.yaml:2:2: broken YAML: while parsing a flow sequence"},
        {"a: 1\n  b: 2\n", "t.yaml:2:4: broken YAML: mapping values are not allowed"},
        {"a:\n\t- 1\n", "t.yaml:2:1: broken YAML: while scanning for the next token"},
        {"a: 'open\n", "t.yaml:2:1: broken YAML: while scanning a quoted scalar"},
        {"a: 1\nb: \x01\n", "t.yaml:2:4: broken YAML: control characters are not allowed"},
        {"a: 1\nb\xc3\xa9: \xff\n", "t.yaml:2:5: expected UTF-8, found the byte 0xff"},
        {"\xff\xfe"
         "a",
         "t.yaml:1:1: expected UTF-8, found the byte 0xff"},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++)
        assert_refused(cases[i][0], strlen(cases[i][0]), cases[i][1]);
    assert_refused("a: 1\0\n", 6, "t.yaml:1:5: expected UTF-8, found the byte 0x00");
}

static char *repeated(const char *text, size_t count)
{
    GString *whole = g_string_sized_new(strlen(text) * count);
    for (size_t i = 0; i < count; i++)
        g_string_append(whole, text);
    return g_string_free(whole, FALSE);
}

// Texts that are small and would cost much: they end at a bound, soon.
static void bombs_end_at_a_bound(void **state)
{
    (void)state;
    char *deep = repeated("[", 100000);
    assert_refused(deep, strlen(deep), "t.yaml:1:33: expected at most 32 levels of nesting");
    g_free(deep);

    char *deep_mapping = repeated("{a: ", 1000);
    assert_refused(deep_mapping, strlen(deep_mapping), "t.yaml:1:126: expected at most 32 levels");
    g_free(deep_mapping);

    char *many = repeated("- 1\n", TREE_NODE_MAX);
    assert_refused(many, strlen(many), "t.yaml:131072:3: expected at most 131072 values");
    g_free(many);

    GString *keys = g_string_new(NULL);
    for (int i = 0; i <= TREE_KEY_MAX; i++)
        g_string_append_printf(keys, "k%d: 1\n", i);
    assert_refused(keys->str, keys->len, "t.yaml:257:1: expected at most 256 keys in one mapping");
    g_string_free(keys, TRUE);

    char *directives = repeated("%TAG !a! b\r", 1000);
    assert_refused(directives, strlen(directives), "t.yaml:1:1: directives (%) are not supported");
    g_free(directives);

    char *large = repeated("# comment\n", TREE_TEXT_SIZE_MAX / 10 + 1);
    assert_refused(large, strlen(large), "t.yaml:1:1: expected at most 1048576 bytes of YAML");
    g_free(large);
}

static void assert_emits(const struct tree *tree, const char *expected)
{
    size_t size;
    char *text = tree_emit(tree, &size);
    assert_string_equal(text, expected);
    assert_int_equal(size, strlen(expected));
    g_free(text);
}

static void set(struct tree *tree, const char *assignment)
{
    struct error error = {0};
    if (tree_set(tree, assignment, &error) != STATUS_OK)
        fail_msg("%s", error.text);
}

// Values are replaced in place and added where a mapping can take them, whole sections at once.
static void assignments_replace_and_add(void **state)
{
    (void)state;
    struct tree *tree = parse("a: {b: 1}\nlist: [1, {c: 2}]\n");
    set(tree, "a.b=7");
    set(tree, "a.new=[1, 2]");
    set(tree, "list.0={x: 1}");
    set(tree, "list.1.c='text=with=equals'");
    set(tree, "deep.er.still=1e3");
    set(tree, "deep.er.still=2e3");
    set(tree, "~=1");
    set(tree, "~=2");
    assert_emits(tree, "a:\n"
                       "  b: 7\n"
                       "  new: [1, 2]\n"
                       "list:\n"
                       "- x: 1\n"
                       "- c: 'text=with=equals'\n"
                       "deep:\n"
                       "  er:\n"
                       "    still: 2e3\n"
                       "null: 2\n");
    const struct tree_node *still =
        tree_child(tree_child(tree_child(tree_root(tree), "deep"), "er"), "still");
    assert_string_equal(still->source, "--set deep.er.still=2e3");
    assert_node(still, TREE_SCALAR, 1, 1, "deep.er.still");
    tree_free(tree);
}

// An item of a list is found by the name that it has, or by its index, which goes first; a path is
// resolved to indexes as far as the tree has what it leads to.
static void items_are_found_by_name(void **state)
{
    (void)state;
    struct tree *tree = parse("list: [{name: front, a: 1}, {name: '0', a: 2}, {name: rear}]\n");
    set(tree, "list.front.a=7");
    set(tree, "list.rear.new.a=3");
    set(tree, "list.0.b=4");
    assert_emits(tree, "list:\n"
                       "- name: front\n"
                       "  a: 7\n"
                       "  b: 4\n"
                       "- name: '0'\n"
                       "  a: 2\n"
                       "- name: rear\n"
                       "  new:\n"
                       "    a: 3\n");
    static const char *const paths[][2] = {{"list.rear.new.a", "list.2.new.a"},
                                           {"list.2.new.a", "list.2.new.a"},
                                           {"list.middle.a", "list.middle.a"},
                                           {"list.front.a.b.c", "list.0.a.b.c"},
                                           {"other.front", "other.front"}};
    for (size_t i = 0; i < G_N_ELEMENTS(paths); i++) {
        char *resolved = tree_resolve(tree, paths[i][0]);
        assert_string_equal(resolved, paths[i][1]);
        g_free(resolved);
    }
    tree_free(tree);
}

// A mapping replaces what is there, or changes it key by key; either way its nodes keep the places
// at which they were given.
static void mapping_replaces_or_merges(void **state)
{
    (void)state;
    static const char *const nothing[] = {NULL};
    struct error error = {0};
    struct tree *tree = parse("a: {b: 1, c: 2}\nlist: [{name: x, d: 3}]\n");
    struct tree *changes = parse("a: {c: 7}\nlist: {x: {d: 8}}\n");
    const struct tree_node *root = tree_root(changes);
    struct tree *merged = tree_copy(tree, nothing), *replaced = tree_copy(tree, nothing);
    for (uint32_t i = 0; i < root->count; i++) {
        assert_int_equal(tree_overlay(merged, root->keys[i], root->items[i], TREE_MERGE, &error),
                         STATUS_OK);
        assert_int_equal(
            tree_overlay(replaced, root->keys[i], root->items[i], TREE_REPLACE, &error), STATUS_OK);
    }
    assert_emits(merged, "a:\n  b: 1\n  c: 7\nlist:\n- name: x\n  d: 8\n");
    assert_emits(replaced, "a:\n  c: 7\nlist:\n  x:\n    d: 8\n");
    assert_emits(tree, "a:\n  b: 1\n  c: 2\nlist:\n- name: x\n  d: 3\n");
    assert_node(tree_child(tree_child(tree_root(merged), "a"), "c"), TREE_SCALAR, 1, 8, "a.c");
    tree_free(merged);
    tree_free(replaced);
    tree_free(changes);
    tree_free(tree);
}

// A text within another points at where it stands there.
static void text_within_another_keeps_its_place(void **state)
{
    (void)state;
    const struct tree_node place = {.source = "table.csv", .line = 3, .column = 5};
    struct error error = {0};
    struct tree *tree = tree_parse_at(&place, "[1, 2]", 6, &error);
    assert_node(tree_root(tree)->items[1], TREE_SCALAR, 3, 9, "1");
    assert_string_equal(tree_root(tree)->source, "table.csv");
    tree_free(tree);
    assert_null(tree_parse_at(&place, "{a: 1, a: 2}", 12, &error));
    assert_string_equal(error.text, "table.csv:3:12: key 'a' is given twice: expected it once");
}

// A wrong assignment says why and changes nothing.
static void refused_assignments_change_nothing(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"new.b..c=1", "--set new.b..c=1:1:1: expected keys with single dots in between"},
        {"a.b.c=1", "--set a.b.c=1:1:1: a.b: expected a mapping to set 'c' in, found 1"},
        {"list.2=1", "--set list.2=1:1:1: list: expected the name of an item or an index from 0 to "
                     "1, found '2'"},
        {"list.-1=1", "--set list.-1=1:1:1: list: expected the name of an item or an index from 0 "
                      "to 1, found '-1'"},
        {"list.x=1", "--set list.x=1:1:1: list: expected the name of an item or an index from 0 to "
                     "1, found 'x'"},
        {"none.0=1", "--set none.0=1:1:1: none: the list is empty: there is no item '0'"},
        {"a=&x 1", "--set a=&x 1:1:1: anchors and aliases"},
        {"a={b: 1, b: 2}", "--set a={b: 1, b: 2}:1:8: key 'b' is given twice"},
        {".a=1", "--set .a=1:1:1: expected keys with single dots in between, found '.a'"},
        {"a", "--set a:1:1: expected KEY.PATH=VALUE"},
        {"", "--set :1:1: expected KEY.PATH=VALUE"},
        {"a=\xff", "--set: expected UTF-8"},
        {"q.w.e.r.t.y.u.i.o.p.a.s.d.f.g.h.j.k.l.z.x.c.v.b.n.m.q.w.e.r.t.y=1",
         "--set q.w.e.r.t.y.u.i.o.p.a.s.d.f.g.h.j.k.l.z.x.c.v.b.n.m.q.w.e.r.t.y=...:1:1: expected "
         "at most 32 levels"},
    };
    struct tree *tree = parse("a: {b: 1}\nlist: [1, 2]\nnone: []\n");
    for (size_t i = 0; i < G_N_ELEMENTS(cases); i++) {
        struct error error = {0};
        assert_int_equal(tree_set(tree, cases[i][0], &error), STATUS_INVALID);
        if (strncmp(error.text, cases[i][1], strlen(cases[i][1])) != 0)
            fail_msg("expected: %s\n found: %s", cases[i][1], error.text);
    }
    assert_emits(tree, "a:\n  b: 1\nlist: [1, 2]\nnone: []\n");
    tree_free(tree);
}

#define LONG_KEY                                                                                  \
    "? a key that is a very long text, longer than the hundred and twenty-eight characters that " \
    "YAML allows a simple key to have on one line\n"

// The canonical text names a scenario by its hash, so it has to be a fixed point for every kind of
// scalar there is: a plain one that needs quotes where it is put, one of several lines, one whose
// key is too long for a simple key.
static void canonical_text_is_a_fixed_point(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "a: {b: [1, 2], c: []}\nd: {}\n",
        "- a, b\n- '[x'\n- \"two\\nlines\"\n- |\n  block\n  text\n- >\n  folded\n  text\n",
        "a: plain\n  over lines\nb: ' leading'\nc: 'trailing '\nd: \"tab\\there\"\n",
        "a: '# no comment'\nb: a#b\nc: '- no item'\nd: 'k: v'\ne: \"\\e bell\"\n",
        LONG_KEY ": 1\n",
        "[[1, [2, [3]]], {a: [{b: 1}]}]\n",
        "\xc3\xa9: '\xf0\x9f\x9a\x97'\nx: \"\\u2028\"\n'': ''\n",
        "just a text\n",
    };
    for (size_t i = 0; i < G_N_ELEMENTS(texts); i++) {
        struct tree *first = parse(texts[i]);
        size_t size;
        char *canonical = tree_emit(first, &size);
        struct tree *second = parse(canonical);
        assert_emits(second, canonical);
        tree_free(second);
        g_free(canonical);
        tree_free(first);
    }
}

// Names and values come from files; a message stays one line of printable text and keeps its end.
static void messages_are_one_line(void **state)
{
    (void)state;
    struct tree *tree = parse("\"a\\nb\": \"a very long text with \\r\\n in it that does not fit "
                              "into a message whole\"\n");
    const struct tree_node *node = tree_root(tree)->items[0];
    char shown[TREE_SHOWN_SIZE];
    struct error error = {0};
    tree_error(node, &error, "expected a word, found %s", tree_shown(node, shown));
    assert_string_equal(error.text,
                        "t.yaml:1:9: a?b: expected a word, found 'a very long text with ?? in it "
                        "that does not fit into a me...'");
    tree_free(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_know_where_they_stand),
        cmocka_unit_test(scalars_keep_their_quotes),
        cmocka_unit_test(surprises_are_refused),
        cmocka_unit_test(bombs_end_at_a_bound),
        cmocka_unit_test(assignments_replace_and_add),
        cmocka_unit_test(items_are_found_by_name),
        cmocka_unit_test(mapping_replaces_or_merges),
        cmocka_unit_test(text_within_another_keeps_its_place),
        cmocka_unit_test(refused_assignments_change_nothing),
        cmocka_unit_test(canonical_text_is_a_fixed_point),
        cmocka_unit_test(messages_are_one_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
