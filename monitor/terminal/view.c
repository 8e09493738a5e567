#include "monitor/terminal/view.h"

#include "monitor/feed/problem.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

enum {
    PROBLEMS_MAX = 4, // lines of them; the rest are counted
    RUNS_MAX = 6,
    SPARK_MAX = 60, // columns of a spark line
    CELL_SIZE = 128,
};

static const char *const sort_names[VIEW_SORT_COUNT] = {"name", "busy", "rate", "lost"};

// ---- Text ----

static unsigned columns_of(const char *text)
{
    unsigned columns = 0;
    for (const char *c = text; *c != '\0'; c = g_utf8_next_char(c))
        columns += g_unichar_iswide(g_utf8_get_char(c)) ? 2 : 1;
    return columns;
}

// Adds a line, cut to the screen's width.
static void add_text(GArray *lines, const struct view_state *state, enum view_style style,
                     const char *text)
{
    if (lines->len >= state->height)
        return;
    struct view_line line = {.style = style};
    unsigned columns = 0;
    size_t size = 0;
    for (const char *c = text; *c != '\0'; c = g_utf8_next_char(c)) {
        const gunichar letter = g_utf8_get_char(c);
        const unsigned wide = g_unichar_iswide(letter) ? 2 : 1;
        if (columns + wide > state->width || size + 8 > sizeof line.text)
            break;
        columns += wide;
        if (letter < 0x80 || state->unicode)
            size += (size_t)g_unichar_to_utf8(letter, line.text + size);
        else
            line.text[size++] = '?';
    }
    g_array_append_val(lines, line);
}

static void __attribute__((format(printf, 4, 5)))
add(GArray *lines, const struct view_state *state, enum view_style style, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    g_autofree char *text = g_strdup_vprintf(format, arguments);
    va_end(arguments);
    add_text(lines, state, style, text);
}

// "5.39 M": three digits and a unit, so that columns stay narrow.
static const char *brief(double value, char text[CELL_SIZE])
{
    static const struct {
        double from;
        const char *name;
    } units[] = {{1e9, " G"}, {1e6, " M"}, {1e4, " k"}};
    for (size_t i = 0; i < G_N_ELEMENTS(units); i++) {
        const double unit = units[i].from == 1e4 ? 1e3 : units[i].from;
        if (value >= units[i].from) {
            const double scaled = value / unit;
            const int digits = scaled < 10 ? 2 : scaled < 100 ? 1 : 0;
            g_snprintf(text, CELL_SIZE, "%.*f%s", digits, scaled, units[i].name);
            return text;
        }
    }
    g_snprintf(text, CELL_SIZE, "%.0f", value);
    return text;
}

static const char *duration(double seconds, char text[CELL_SIZE])
{
    if (seconds < 0)
        g_strlcpy(text, "-", CELL_SIZE);
    else if (seconds < 60)
        g_snprintf(text, CELL_SIZE, "%.0f s", seconds);
    else if (seconds < 3600)
        g_snprintf(text, CELL_SIZE, "%d min %d s", (int)seconds / 60, (int)seconds % 60);
    else
        g_snprintf(text, CELL_SIZE, "%.0f h %d min", floor(seconds / 3600),
                   (int)fmod(seconds, 3600) / 60);
    return text;
}

// A table's column: negative widths stand to the left. On a narrow screen the last columns go.
struct column {
    const char *title;
    int width;
};

static void add_row(GArray *lines, const struct view_state *state, enum view_style style,
                    bool marked, const struct column *columns, size_t count,
                    const char *const *cells)
{
    g_autoptr(GString) row = g_string_new(marked ? "> " : "  ");
    unsigned used = 2;
    for (size_t i = 0; i < count; i++) {
        const unsigned width = (unsigned)ABS(columns[i].width);
        if (i > 0 && used + width > state->width)
            break;
        const unsigned filled = MIN(columns_of(cells[i]), width);
        const int blanks = (int)(width - filled);
        g_autofree char *cell =
            filled < columns_of(cells[i])
                ? g_utf8_substring(cells[i], 0, MIN(g_utf8_strlen(cells[i], -1), (glong)width))
                : g_strdup(cells[i]);
        g_string_append_printf(row, "%*s%s%*s  ", columns[i].width > 0 ? blanks : 0, "", cell,
                               columns[i].width < 0 ? blanks : 0, "");
        used += width + 2;
    }
    add_text(lines, state, style, row->str);
}

static void add_head(GArray *lines, const struct view_state *state, const struct column *columns,
                     size_t count)
{
    const char *titles[16];
    for (size_t i = 0; i < count; i++)
        titles[i] = columns[i].title;
    add_row(lines, state, VIEW_HEAD, false, columns, count, titles);
}

// ---- Spark lines ----

enum { SPARK_SIZE = 4 * SPARK_MAX + 1 }; // [bytes]

// Draws a course in `width` columns, from its least to its greatest value. `value` answers NAN
// where there is none.
static void spark_draw(char text[SPARK_SIZE], const struct history *history, unsigned width,
                       bool unicode, double (*value)(const struct history *, guint))
{
    static const char *const fine[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    static const char *const coarse[] = {"_", ".", ":", "-", "=", "+", "*", "#"};
    const guint count = history->points->len;
    double least = INFINITY, most = -INFINITY;
    for (guint i = 0; i < count; i++) {
        least = fmin(least, value(history, i));
        most = fmax(most, value(history, i));
    }
    width = MIN(MIN(width, SPARK_MAX), count);
    text[0] = '\0';
    for (unsigned column = 0; column < width; column++) {
        const guint point = width > 1 ? column * (count - 1) / (width - 1) : count - 1;
        const double height = (value(history, point) - least) / (most - least);
        const char *sign = " ";
        if (isfinite(height))
            sign = (unicode ? fine : coarse)[(int)(7 * height + 0.5)];
        else if (most == least)
            sign = unicode ? fine[3] : coarse[3];
        g_strlcat(text, sign, SPARK_SIZE);
    }
}

// The logarithm of a volume that is not known yet is -DBL_MAX.
static bool is_known(double log_volume)
{
    return fabs(log_volume) < 1e18;
}

static double step_volume(const struct history *history, guint i)
{
    const double volume = g_array_index(history->points, struct feed_step, i).log_volume;
    return is_known(volume) ? volume : NAN;
}

static double step_good(const struct history *history, guint i)
{
    return g_array_index(history->points, struct feed_step, i).good_share;
}

static double pace_rate(const struct history *history, guint i)
{
    return g_array_index(history->points, struct feed_pace, i).rate;
}

// ---- Choosing ----

// The run to show where none is chosen, or the chosen one is gone: one that is going on before one
// that is not, the one heard last before others.
static const struct feed_run *run_chosen(struct view_state *state, const struct feed *feed)
{
    const struct feed_run *best = state->has_run ? feed_run_find(feed, state->run) : NULL;
    for (guint i = 0; best == NULL || !state->has_run; i++) {
        if (i == feed->runs.entries->len)
            break;
        const struct feed_run *run = feed_run_at(feed, i);
        const bool active = feed_run_active(run);
        if (best == NULL || active > feed_run_active(best) ||
            (active == feed_run_active(best) && run->heard_ns >= best->heard_ns))
            best = run;
    }
    return best;
}

static const struct feed_search *search_chosen(const struct view_state *state,
                                               const struct feed *feed, const struct feed_run *run)
{
    if (state->has_search)
        return feed_search_find(feed, run->id, state->search);
    // The latest that goes on: those that are over are told of again and again.
    const struct feed_search *latest = NULL;
    for (const GList *link = feed->searches.heard.tail; link != NULL; link = link->prev) {
        const struct feed_search *search = link->data;
        if (search->run != run->id)
            continue;
        if (search->standing == SEARCH_STANDING_OPEN)
            return search;
        if (latest == NULL)
            latest = search;
    }
    return latest;
}

static void run_move(struct view_state *state, const struct feed *feed, int by)
{
    const struct feed_run *run = run_chosen(state, feed);
    for (guint i = 0; run != NULL && i < feed->runs.entries->len; i++) {
        if (feed_run_at(feed, i) != run)
            continue;
        const int next = CLAMP((int)i + by, 0, (int)feed->runs.entries->len - 1);
        state->has_run = true;
        state->run = feed_run_at(feed, (guint)next)->id;
        state->has_search &= next == (int)i;
        return;
    }
}

// To the nearest search of the run in that direction that was heard of.
static void search_move(struct view_state *state, const struct feed *feed, int by)
{
    const struct feed_run *run = run_chosen(state, feed);
    const struct feed_search *search = run ? search_chosen(state, feed, run) : NULL;
    if (search == NULL)
        return;
    for (int64_t index = (int64_t)search->index + by; index >= 0 && index < run->searches;
         index += by) {
        if (feed_search_find(feed, run->id, (uint32_t)index) == NULL)
            continue;
        state->has_run = state->has_search = true;
        state->run = run->id;
        state->search = (uint32_t)index;
        return;
    }
}

void view_press(struct view_state *state, const struct feed *feed, enum view_key key)
{
    const unsigned page = MAX(state->height / 2, 1);
    switch (key) {
    case VIEW_KEY_UP:
        run_move(state, feed, -1);
        break;
    case VIEW_KEY_DOWN:
        run_move(state, feed, 1);
        break;
    case VIEW_KEY_LEFT:
        search_move(state, feed, -1);
        break;
    case VIEW_KEY_RIGHT:
        search_move(state, feed, 1);
        break;
    case VIEW_KEY_PAGE_UP:
        state->scroll -= MIN(page, state->scroll);
        break;
    case VIEW_KEY_PAGE_DOWN:
        state->scroll += page; // as far as there are workers: view_lines()
        break;
    case VIEW_KEY_SORT:
        state->sort = (state->sort + 1) % VIEW_SORT_COUNT;
        break;
    case VIEW_KEY_REVERSE:
        state->reverse = !state->reverse;
        break;
    }
}

// ---- Parts of the screen ----

static void add_problems(GArray *lines, const struct view_state *state, const struct feed *feed,
                         int64_t now_ns)
{
    GArray *problems = problem_list(feed, now_ns);
    const guint shown = problems->len > PROBLEMS_MAX ? PROBLEMS_MAX - 1 : problems->len;
    for (guint i = 0; i < shown; i++)
        add(lines, state, VIEW_PROBLEM, "! %s", g_array_index(problems, struct problem, i).text);
    if (problems->len > shown)
        add(lines, state, VIEW_PROBLEM, "! and %u problems more", problems->len - shown);
    g_array_free(problems, TRUE);
}

static void add_run(GArray *lines, const struct view_state *state, const struct feed *feed,
                    const struct feed_run *run, bool marked, const struct column *columns,
                    size_t count, int64_t now_ns)
{
    char searches[CELL_SIZE], samples[CELL_SIZE], rate[CELL_SIZE], workers[CELL_SIZE];
    char left[CELL_SIZE], released[CELL_SIZE], lost[CELL_SIZE];
    const bool active = feed_run_active(run);
    const bool silent = active && now_ns - run->heard_ns > FEED_SILENCE_NS;
    g_snprintf(searches, sizeof searches, "%" PRIu32 " of %" PRIu32, run->searches_done,
               run->searches);
    g_snprintf(workers, sizeof workers, "%" PRIu32, run->workers);
    if (active && !silent)
        brief(run->rate, rate);
    else
        g_strlcpy(rate, "-", sizeof rate);
    const char *const cells[] = {
        run->name,
        silent ? "silent" : protocol_run_state_name(run->state),
        rate,
        workers,
        brief((double)run->samples, samples),
        searches,
        duration(feed_run_left_s(feed, run), left),
        brief((double)run->released, released),
        brief((double)run->lost, lost),
    };
    add_row(lines, state,
            marked              ? VIEW_CHOSEN
            : active && !silent ? VIEW_PLAIN
                                : VIEW_FAINT,
            marked, columns, count, cells);
}

static void add_runs(GArray *lines, const struct view_state *state, const struct feed *feed,
                     const struct feed_run *chosen, int64_t now_ns)
{
    static const struct column columns[] = {
        {"RUN", -22}, {"STATE", -11}, {"RATE/s", 7}, {"WORKERS", 7}, {"DESIGNS", 8},
        {"DONE", 12}, {"LEFT", 10},   {"AGAIN", 7},  {"LOST", 7},
    };
    const guint count = feed->runs.entries->len;
    if (chosen == NULL) {
        add(lines, state, VIEW_PLAIN, "  no run is heard yet");
        return;
    }
    add_head(lines, state, columns, G_N_ELEMENTS(columns));
    // The newest runs, and the chosen one wherever it stands.
    guint first = count > RUNS_MAX ? count - RUNS_MAX : 0;
    for (guint i = 0; i < first; i++) {
        if (feed_run_at(feed, i) == chosen)
            first = i;
    }
    for (guint i = first; i < count && i < first + RUNS_MAX; i++) {
        const struct feed_run *run = feed_run_at(feed, i);
        add_run(lines, state, feed, run, run == chosen, columns, G_N_ELEMENTS(columns), now_ns);
    }
}

static void add_bar(GArray *lines, const struct view_state *state, const struct feed *feed,
                    const struct feed_search *search)
{
    const char *name = feed_case_name(feed, search->run, search->index);
    const double share =
        search->step_count > 0 ? fmin((double)search->step / search->step_count, 1) : 0;
    const unsigned width = CLAMP(state->width / 4, 4, 40);
    const unsigned filled = (unsigned)(share * width + 0.5);
    g_autofree char *full = g_strnfill(filled, '#');
    g_autofree char *empty = g_strnfill(width - filled, '-');
    const char *word = feed_search_word(search);
    add(lines, state, VIEW_PLAIN,
        "  search %" PRIu32 ": %s [%s%s] step %" PRIu32 " of about %" PRIu32 "  %s", search->index,
        strcmp(word, "running") == 0 ? protocol_phase_name(search->phase) : word, full, empty,
        search->step, search->step_count, name != NULL ? name : "");
}

static void add_spark(GArray *lines, const struct view_state *state, const char *name,
                      const char *number, const struct history *history,
                      double (*value)(const struct history *, guint))
{
    const unsigned margin = 28;
    char spark[SPARK_SIZE];
    spark_draw(spark, history, state->width > margin ? state->width - margin : 4, state->unicode,
               value);
    add(lines, state, VIEW_PLAIN, "  %-13s%9s  %s", name, number, spark);
}

static void add_search(GArray *lines, const struct view_state *state, const struct feed *feed,
                       const struct feed_run *run, const struct feed_search *search)
{
    char number[CELL_SIZE] = "-";
    add(lines, state, VIEW_PLAIN, "%s", "");
    if (search == NULL) {
        add(lines, state, VIEW_PLAIN, "  no search of this run is heard yet");
    } else {
        add_bar(lines, state, feed, search);
        if (is_known(search->log_volume))
            g_snprintf(number, sizeof number, "%.2f", search->log_volume);
        add_spark(lines, state, "ln(volume)", number, &search->steps, step_volume);
        g_snprintf(number, sizeof number, "%.0f %%", 100 * search->good_share);
        add_spark(lines, state, "good share", number, &search->steps, step_good);
    }
    add_spark(lines, state, "designs/s", brief(run->rate, number), &run->pace, pace_rate);
    if (search != NULL && search->purity_lower95 > 0)
        add(lines, state, VIEW_PLAIN, "  purity        >= %.4f with 95 %% confidence",
            search->purity_lower95);
}

// ---- Workers ----

static int worker_compare(gconstpointer a, gconstpointer b, gpointer user)
{
    const struct feed_worker *left = *(const struct feed_worker *const *)a;
    const struct feed_worker *right = *(const struct feed_worker *const *)b;
    const struct view_state *state = user;
    int order = 0;
    switch (state->sort) {
    case VIEW_SORT_BUSY:
        order = (left->busy < right->busy) - (left->busy > right->busy);
        break;
    case VIEW_SORT_RATE:
        order = (left->rate < right->rate) - (left->rate > right->rate);
        break;
    case VIEW_SORT_LOST:
        order = (left->lost < right->lost) - (left->lost > right->lost);
        break;
    case VIEW_SORT_NAME:
    case VIEW_SORT_COUNT:
        break;
    }
    if (order == 0)
        order = strcmp(left->name, right->name);
    if (order == 0)
        order =
            (left->entry.key[0] > right->entry.key[0]) - (left->entry.key[0] < right->entry.key[0]);
    return state->reverse ? -order : order;
}

static void add_worker(GArray *lines, const struct view_state *state,
                       const struct feed_worker *worker, const struct column *columns, size_t count,
                       int64_t now_ns)
{
    char threads[CELL_SIZE], busy[CELL_SIZE], rate[CELL_SIZE], queue[CELL_SIZE];
    char samples[CELL_SIZE], lost[CELL_SIZE], heard[CELL_SIZE];
    const bool silent = now_ns - worker->heard_ns > worker->silence_ns;
    g_snprintf(threads, sizeof threads, "%" PRIu32, worker->threads);
    g_snprintf(busy, sizeof busy, "%.0f %%", 100 * worker->busy);
    g_snprintf(queue, sizeof queue, "%" PRIu32, worker->queue);
    if (silent)
        g_snprintf(heard, sizeof heard, "%.0f s ago", (double)(now_ns - worker->heard_ns) / 1e9);
    const char *const cells[] = {
        worker->name,
        busy,
        brief(worker->rate, rate),
        queue,
        threads,
        brief((double)worker->lost, lost),
        brief((double)worker->samples, samples),
        worker->left ? "left"
        : silent     ? heard
                     : "now",
    };
    add_row(lines, state, worker->left || silent ? VIEW_FAINT : VIEW_PLAIN, false, columns, count,
            cells);
}

static void add_workers(GArray *lines, struct view_state *state, const struct feed *feed,
                        int64_t now_ns)
{
    static const struct column columns[] = {
        {"WORKER", -22}, {"BUSY", 6}, {"RATE/s", 7},  {"QUEUE", 6},
        {"THREADS", 7},  {"LOST", 7}, {"DESIGNS", 8}, {"HEARD", 10},
    };
    const guint count = feed->workers.entries->len;
    // One line stays for the keys.
    const guint room = state->height > lines->len + 2 ? state->height - lines->len - 2 : 0;
    state->scroll = MIN(state->scroll, count > room ? count - room : 0);
    if (room == 0)
        return;
    add_head(lines, state, columns, G_N_ELEMENTS(columns));
    if (count == 0) {
        add(lines, state, VIEW_PLAIN, "  no worker is heard yet");
        return;
    }
    g_autoptr(GPtrArray) sorted = g_ptr_array_sized_new(count);
    for (guint i = 0; i < count; i++)
        g_ptr_array_add(sorted, feed->workers.entries->pdata[i]);
    g_ptr_array_sort_with_data(sorted, worker_compare, state);
    for (guint i = state->scroll; i < count && i < state->scroll + room; i++)
        add_worker(lines, state, sorted->pdata[i], columns, G_N_ELEMENTS(columns), now_ns);
}

static void add_keys(GArray *lines, const struct view_state *state, const struct feed *feed)
{
    while (lines->len + 1 < state->height)
        add(lines, state, VIEW_PLAIN, "%s", "");
    if (lines->len == state->height)
        g_array_set_size(lines, state->height - 1);
    add(lines, state, VIEW_TITLE,
        "q quit  up/down run  left/right search  s sort: %s%s  r reverse  workers: %u",
        sort_names[state->sort], state->reverse ? ", reversed" : "", feed->workers.entries->len);
}

void view_lines(struct view_state *state, const struct feed *feed, const char *source,
                int64_t now_ns, GArray *lines)
{
    g_array_set_size(lines, 0);
    if (state->width == 0 || state->height == 0)
        return;
    const struct feed_run *run = run_chosen(state, feed);
    add(lines, state, VIEW_TITLE, "sobox monitor  %s", source);
    add_problems(lines, state, feed, now_ns);
    add(lines, state, VIEW_PLAIN, "%s", "");
    add_runs(lines, state, feed, run, now_ns);
    if (run != NULL)
        add_search(lines, state, feed, run, search_chosen(state, feed, run));
    add(lines, state, VIEW_PLAIN, "%s", "");
    add_workers(lines, state, feed, now_ns);
    add_keys(lines, state, feed);
}
