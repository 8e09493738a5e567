#include "monitor/terminal/ability.h"

#include <curses.h>
#include <term.h>
#include <unistd.h>

bool ability_to_paint(void)
{
    int error;
    if (!isatty(STDIN_FILENO) || !isatty(STDOUT_FILENO))
        return false;
    if (setupterm(NULL, STDOUT_FILENO, &error) != OK)
        return false;
    const bool able = cursor_address != NULL && clear_screen != NULL;
    del_curterm(cur_term);
    return able;
}
