#include "monitor/terminal/screen.h"

#include "common/base/clock.h"
#include "monitor/terminal/ability.h"
#include "monitor/terminal/view.h"

#include <curses.h>
#include <glib-unix.h>
#include <langinfo.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { PAINT_MS = 250 };

struct screen {
    const struct feed *feed;
    const char *source;
    SCREEN *terminal;
    struct view_state view;
    GArray *lines; // struct view_line
    GSourceFunc quit;
    gpointer user;
    guint paint, key, resize; // GLib sources
};

static attr_t attribute_of(enum view_style style)
{
    switch (style) {
    case VIEW_TITLE:
        return A_REVERSE;
    case VIEW_HEAD:
        return A_BOLD | A_UNDERLINE;
    case VIEW_CHOSEN:
    case VIEW_PROBLEM:
        return A_BOLD;
    case VIEW_FAINT:
        return A_DIM;
    case VIEW_PLAIN:
        break;
    }
    return A_NORMAL;
}

static void paint(struct screen *screen)
{
    view_lines(&screen->view, screen->feed, screen->source, clock_monotonic_ns(), screen->lines);
    erase();
    for (guint i = 0; i < screen->lines->len; i++) {
        const struct view_line *line = &g_array_index(screen->lines, struct view_line, i);
        (void)attrset((int)attribute_of(line->style));
        if (line->style == VIEW_TITLE)
            mvhline((int)i, 0, ' ' | (chtype)attribute_of(line->style), (int)screen->view.width);
        mvaddstr((int)i, 0, line->text);
    }
    (void)attrset(A_NORMAL);
    refresh();
}

static void measure(struct screen *screen)
{
    struct winsize size;
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0)
        resizeterm(size.ws_row, size.ws_col);
    screen->view.width = (unsigned)MAX(COLS, 0);
    screen->view.height = (unsigned)MAX(LINES, 0);
}

static gboolean repaint(gpointer user)
{
    paint(user);
    return G_SOURCE_CONTINUE;
}

static gboolean resized(gpointer user)
{
    measure(user);
    paint(user);
    return G_SOURCE_CONTINUE;
}

static void press(struct screen *screen, int key)
{
    static const struct {
        int code;
        enum view_key key;
    } keys[] = {
        {KEY_UP, VIEW_KEY_UP},         {'k', VIEW_KEY_UP},
        {KEY_DOWN, VIEW_KEY_DOWN},     {'j', VIEW_KEY_DOWN},
        {KEY_LEFT, VIEW_KEY_LEFT},     {'h', VIEW_KEY_LEFT},
        {KEY_RIGHT, VIEW_KEY_RIGHT},   {'l', VIEW_KEY_RIGHT},
        {KEY_PPAGE, VIEW_KEY_PAGE_UP}, {KEY_NPAGE, VIEW_KEY_PAGE_DOWN},
        {' ', VIEW_KEY_PAGE_DOWN},     {'s', VIEW_KEY_SORT},
        {'r', VIEW_KEY_REVERSE},
    };
    for (size_t i = 0; i < G_N_ELEMENTS(keys); i++) {
        if (keys[i].code == key)
            view_press(&screen->view, screen->feed, keys[i].key);
    }
}

static gboolean pressed(gint descriptor, GIOCondition condition, gpointer user)
{
    (void)descriptor;
    struct screen *screen = user;
    if (condition & (G_IO_HUP | G_IO_ERR)) {
        screen->key = 0;
        screen->quit(screen->user);
        return G_SOURCE_REMOVE;
    }
    for (int key = getch(); key != ERR; key = getch()) {
        if (key == 'q' || key == 'Q' || key == 3)
            screen->quit(screen->user);
        else if (key == 'L' - '@') // Ctrl-L: whatever else wrote on the terminal goes
            clearok(curscr, TRUE);
        else
            press(screen, key);
    }
    paint(screen);
    return G_SOURCE_CONTINUE;
}

struct screen *screen_start(const struct feed *feed, const char *source, GSourceFunc quit,
                            gpointer user)
{
    setlocale(LC_CTYPE, "");
    if (!ability_to_paint())
        return NULL;
    SCREEN *terminal = newterm(NULL, stdout, stdin);
    if (terminal == NULL)
        return NULL;
    cbreak();
    noecho();
    curs_set(0);
    keypad(stdscr, TRUE);
    nodelay(stdscr, TRUE);
    set_escdelay(25);
    struct screen *screen = g_new0(struct screen, 1);
    *screen = (struct screen){
        .feed = feed,
        .source = source,
        .terminal = terminal,
        .view.unicode = strcmp(nl_langinfo(CODESET), "UTF-8") == 0,
        .lines = g_array_new(FALSE, FALSE, sizeof(struct view_line)),
        .quit = quit,
        .user = user,
    };
    measure(screen);
    screen->paint = g_timeout_add(PAINT_MS, repaint, screen);
    screen->key = g_unix_fd_add(STDIN_FILENO, G_IO_IN | G_IO_HUP | G_IO_ERR, pressed, screen);
    screen->resize = g_unix_signal_add(SIGWINCH, resized, screen);
    paint(screen);
    return screen;
}

void screen_stop(struct screen *screen)
{
    if (screen == NULL)
        return;
    g_source_remove(screen->paint);
    g_source_remove(screen->resize);
    if (screen->key != 0)
        g_source_remove(screen->key);
    endwin();
    delscreen(screen->terminal);
    g_array_free(screen->lines, TRUE);
    g_free(screen);
}
