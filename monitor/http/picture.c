#include "monitor/http/picture.h"

#include "monitor/feed/problem.h"
#include "monitor/http/xray.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>

// The network may bring any double. JSON knows finite ones only, and no quantity of ours is beyond
// 1e18: -DBL_MAX, for instance, is the logarithm of a volume that is not known yet, and would make
// a chart draw an axis without end.
static json_t *number(double value)
{
    return isfinite(value) && fabs(value) < 1e18 ? json_real(value) : json_null();
}

static json_t *count(uint64_t value)
{
    return json_integer((json_int_t)value);
}

static json_t *name_of(uint64_t id)
{
    return json_sprintf("%016" PRIx64, id);
}

static json_t *at(const struct picture_view *view, int64_t moment_ns)
{
    return json_real((double)(moment_ns - view->start_ns) / 1e9);
}

// ---- Rows of the tables ----

static json_t *run_json(const struct picture_view *view, const struct feed_run *run)
{
    return json_pack(
        "{s:o, s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}",
        "id", name_of(run->id), "name", run->name, "state", protocol_run_state_name(run->state),
        "searches", count(run->searches), "searches_done", count(run->searches_done), "workers",
        count(run->workers), "workers_refused", count(run->workers_refused), "samples",
        count(run->samples), "batches", count(run->batches), "released", count(run->released),
        "duplicates", count(run->duplicates), "rejected", count(run->rejected), "lost",
        count(run->lost), "rate", number(run->rate), "elapsed_s",
        number((double)run->elapsed_ns / 1e9), "left_s", number(feed_run_left_s(view->feed, run)),
        "heard_at", at(view, run->heard_ns));
}

static json_t *search_json(const struct picture_view *view, const struct feed_search *search)
{
    return json_pack("{s:o, s:o, s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "run",
                     name_of(search->run), "search", count(search->index), "phase",
                     protocol_phase_name(search->phase), "status", feed_search_word(search), "step",
                     count(search->step), "step_count", count(search->step_count), "evaluations",
                     count(search->evaluations), "good_share", number(search->good_share),
                     "log_volume", number(search->log_volume), "purity_lower95",
                     number(search->purity_lower95), "heard_at", at(view, search->heard_ns));
}

static json_t *worker_json(const struct picture_view *view, const struct feed_worker *worker)
{
    return json_pack("{s:o, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "id",
                     name_of(worker->entry.key[0]), "name", worker->name, "threads",
                     count(worker->threads), "queue", count(worker->queue), "batches",
                     count(worker->batches), "samples", count(worker->samples), "rate",
                     number(worker->rate), "busy", number(worker->busy), "lost",
                     count(worker->lost), "dropped", count(worker->dropped), "left", worker->left,
                     "heard_at", at(view, worker->heard_ns));
}

static void add_if_any(json_t *event, const char *name, json_t *array)
{
    if (json_array_size(array) > 0)
        json_object_set_new(event, name, array);
    else
        json_decref(array);
}

static void add_tables(json_t *event, const struct picture_view *view, uint64_t since)
{
    const struct feed *feed = view->feed;
    json_t *runs = json_array(), *searches = json_array(), *workers = json_array();
    for (guint i = 0; i < feed->runs.entries->len; i++) {
        if (feed_run_at(feed, i)->changed > since)
            json_array_append_new(runs, run_json(view, feed_run_at(feed, i)));
    }
    for (guint i = 0; i < feed->searches.entries->len; i++) {
        if (feed_search_at(feed, i)->changed > since)
            json_array_append_new(searches, search_json(view, feed_search_at(feed, i)));
    }
    for (guint i = 0; i < feed->workers.entries->len; i++) {
        if (feed_worker_at(feed, i)->changed > since)
            json_array_append_new(workers, worker_json(view, feed_worker_at(feed, i)));
    }
    add_if_any(event, "runs", runs);
    add_if_any(event, "searches", searches);
    add_if_any(event, "workers", workers);
    const struct feed_own *own = &feed->own;
    json_object_set_new(event, "own",
                        json_pack("{s:o, s:o, s:o, s:o}", "received", count(own->received), "lost",
                                  count(own->lost), "dropped", count(own->dropped), "rejected",
                                  count(own->rejected)));
}

static void add_problems(json_t *event, const struct feed *feed, int64_t now_ns)
{
    GArray *problems = problem_list(feed, now_ns);
    json_t *array = json_array();
    for (guint i = 0; i < problems->len; i++) {
        const struct problem *problem = &g_array_index(problems, struct problem, i);
        json_array_append_new(
            array, json_pack("{s:s, s:o, s:s}", "kind", problem_name(problem->kind), "run",
                             problem->run != 0 ? name_of(problem->run) : json_null(), "text",
                             problem->text));
    }
    g_array_free(problems, TRUE);
    json_object_set_new(event, "problems", array);
}

// ---- What the reader has chosen ----

static json_t *variable_json(const struct scenario *scenario, uint32_t index)
{
    const struct scenario_variable *variable = &scenario->variables[index];
    json_t *object = json_pack("{s:s, s:o, s:o}", "name", variable->name, "lower",
                               number(scenario->design_space.lower[index]), "upper",
                               number(scenario->design_space.upper[index]));
    if (variable->spring < scenario->spring_count) {
        const struct scenario_spring *spring = &scenario->springs[variable->spring];
        json_object_set_new(object, "spring", count(variable->spring));
        json_object_set_new(object, "direction",
                            json_string(scenario_direction_name(variable->direction)));
        json_object_set_new(object, "deformation_m", number(spring->deformation[variable->point]));
    }
    return object;
}

static json_t *scenario_json(const struct scenario *scenario)
{
    json_t *variables = json_array(), *springs = json_array();
    for (uint32_t i = 0; i < scenario->design_space.count; i++)
        json_array_append_new(variables, variable_json(scenario, i));
    for (uint32_t i = 0; i < scenario->spring_count; i++)
        json_array_append_new(springs, json_string(scenario->springs[i].name));
    return json_pack("{s:s, s:s, s:f, s:o, s:o, s:o}", "name", scenario->name, "model",
                     scenario_model_name(scenario->model), "target_purity",
                     scenario->search.target_purity, "springs", springs, "variables", variables,
                     "constraints", xray_constraints(scenario));
}

static json_t *bounds_json(const GArray *bounds)
{
    json_t *sides[2] = {json_array(), json_array()};
    for (guint i = 0; i < bounds->len; i++)
        json_array_append_new(sides[i >= bounds->len / 2],
                              number(g_array_index(bounds, double, i)));
    return json_pack("{s:o, s:o}", "lower", sides[0], "upper", sides[1]);
}

// From which point on the reader must be told of the course: its last point may have changed.
static guint course_from(struct picture_course *told, const struct history *history)
{
    const guint from = told->rewrites == history->rewrites && told->sent > 0 ? told->sent - 1 : 0;
    told->rewrites = history->rewrites;
    told->sent = history->points->len;
    return from;
}

static json_t *steps_json(struct picture_course *told, const struct history *history)
{
    const guint from = course_from(told, history);
    json_t *points = json_array();
    for (guint i = from; i < history->points->len; i++) {
        const struct feed_step *step = &g_array_index(history->points, struct feed_step, i);
        json_array_append_new(
            points, json_pack("[o, s, o, o]", count(step->step), protocol_phase_name(step->phase),
                              number(step->good_share), number(step->log_volume)));
    }
    return json_pack("{s:o, s:o}", "from", count(from), "points", points);
}

static json_t *pace_json(struct picture_course *told, const struct history *history)
{
    const guint from = course_from(told, history);
    json_t *points = json_array();
    for (guint i = from; i < history->points->len; i++) {
        const struct feed_pace *pace = &g_array_index(history->points, struct feed_pace, i);
        json_array_append_new(points,
                              json_pack("[o, o, o, o]", number(pace->elapsed_s), number(pace->rate),
                                        number(pace->lost_share), number(pace->released)));
    }
    return json_pack("{s:o, s:o}", "from", count(from), "points", points);
}

static json_t *samples_json(const struct feed_search *search)
{
    json_t *steps = json_array();
    for (guint i = 0; i < search->album->pictures->len; i++) {
        const struct album_picture *picture = search->album->pictures->pdata[i];
        json_array_append_new(steps, json_pack("[o, s]", count(picture->sampling.step),
                                               protocol_phase_name(picture->phase)));
    }
    return json_pack("{s:o, s:o}", "changed", count(search->album_changed), "steps", steps);
}

static json_t *texts_json(json_t *array, char *const *texts)
{
    for (; *texts != NULL; texts++)
        json_array_append_new(array, json_string(*texts));
    return array;
}

static json_t *cases_json(const struct cases *cases, uint64_t since)
{
    json_t *array = json_array();
    for (guint i = 0; i < cases->entries->len; i++) {
        const struct cases_entry *one = &g_array_index(cases->entries, struct cases_entry, i);
        if (one->texts != NULL && one->changed > since)
            json_array_append_new(array, texts_json(json_pack("[o]", count(i)), one->texts));
    }
    return json_pack("{s:o, s:o}", "axes",
                     cases->axes != NULL ? texts_json(json_array(), cases->axes) : json_null(),
                     "cases", array);
}

static void add_scenario(json_t *chosen, const struct picture_view *view,
                         struct picture_cursor *cursor, const struct feed_search *search)
{
    const struct scenario *scenario = texts_find(view->texts, &search->scenario);
    // A box of another size than its design space is a lie of somebody.
    if (scenario != NULL && search->bounds->len != 0 &&
        search->bounds->len != 2 * scenario->design_space.count)
        scenario = NULL;
    else if (scenario == NULL && view->want != NULL)
        view->want(view->user, search->run, &search->scenario);
    json_object_set_new(chosen, "scenario", scenario ? scenario_json(scenario) : json_null());
    cursor->scenario_told = scenario != NULL;
}

static const struct feed_search *chosen_search(const struct picture_view *view,
                                               const struct picture_cursor *cursor)
{
    return cursor->has_search ? feed_search_find(view->feed, cursor->run, cursor->search) : NULL;
}

// When what the reader has chosen last changed; 0: it is not there.
static uint64_t chosen_version(const struct picture_view *view, const struct picture_cursor *cursor)
{
    const struct feed_run *run = cursor->has_run ? feed_run_find(view->feed, cursor->run) : NULL;
    const struct feed_search *search = chosen_search(view, cursor);
    return MAX(run ? run->changed : 0, search ? search->changed : 0);
}

static void add_chosen(json_t *event, const struct picture_view *view,
                       struct picture_cursor *cursor)
{
    const struct feed_run *run = feed_run_find(view->feed, cursor->run);
    const struct feed_search *search = chosen_search(view, cursor);
    json_t *chosen = json_pack("{s:o}", "run", name_of(cursor->run));
    if (run != NULL)
        json_object_set_new(chosen, "pace", pace_json(&cursor->pace, &run->pace));
    if (run != NULL && run->names.changed > cursor->cases_version) {
        json_object_set_new(chosen, "cases", cases_json(&run->names, cursor->cases_version));
        cursor->cases_version = run->names.changed;
    }
    if (search != NULL) {
        if (view->want_samples != NULL)
            view->want_samples(view->user, search->run, search->index);
        json_object_set_new(chosen, "search", count(search->index));
        json_object_set_new(chosen, "state", search_json(view, search));
        if (!cursor->scenario_told)
            add_scenario(chosen, view, cursor, search);
        json_object_set_new(chosen, "bounds", bounds_json(search->bounds));
        json_object_set_new(chosen, "steps", steps_json(&cursor->steps, &search->steps));
        if (search->album != NULL && search->album_changed > cursor->album_version) {
            json_object_set_new(chosen, "samples", samples_json(search));
            cursor->album_version = search->album_changed;
        }
    }
    json_object_set_new(event, "chosen", chosen);
}

// ---- Events ----

static uint64_t removed(const struct feed *feed)
{
    return feed->runs.removed + feed->searches.removed + feed->workers.removed;
}

bool picture_due(const struct picture_view *view, const struct picture_cursor *cursor,
                 int64_t now_ns)
{
    if (!cursor->started || now_ns - cursor->tables_ns >= PICTURE_TABLES_NS)
        return true;
    return now_ns - cursor->told_ns >= PICTURE_CHOSEN_NS &&
           chosen_version(view, cursor) > cursor->chosen_version;
}

static void start_anew(json_t *event, const struct picture_view *view,
                       struct picture_cursor *cursor)
{
    *cursor = (struct picture_cursor){
        .has_run = cursor->has_run,
        .has_search = cursor->has_search,
        .run = cursor->run,
        .search = cursor->search,
        .started = true,
        .removed = removed(view->feed),
        .tables_ns = INT64_MIN,
    };
    json_object_set_new(event, "reset", json_true());
    json_object_set_new(event, "monitor",
                        json_pack("{s:s, s:s, s:s}", "version", SOBOX_VERSION, "instance",
                                  view->instance, "source", view->source));
}

void picture_event(const struct picture_view *view, struct picture_cursor *cursor, int64_t now_ns,
                   GString *out)
{
    json_t *event = json_pack("{s:o}", "now", at(view, now_ns));
    // What is gone is not told of one by one: the reader begins anew, which happens seldom.
    if (!cursor->started || cursor->removed != removed(view->feed))
        start_anew(event, view, cursor);
    if (cursor->tables_ns == INT64_MIN || now_ns - cursor->tables_ns >= PICTURE_TABLES_NS) {
        add_tables(event, view, cursor->version);
        add_problems(event, view->feed, now_ns);
        cursor->version = view->feed->version;
        cursor->tables_ns = now_ns;
    }
    const uint64_t version = chosen_version(view, cursor);
    // Without its scenario the chosen search is told again: it may be known by now.
    if (version > cursor->chosen_version || (version > 0 && !cursor->scenario_told)) {
        add_chosen(event, view, cursor);
        cursor->chosen_version = version;
    }
    cursor->told_ns = now_ns;
    char *text = json_dumps(event, JSON_COMPACT | JSON_REAL_PRECISION(9));
    g_string_append(out, text);
    free(text);
    json_decref(event);
}
