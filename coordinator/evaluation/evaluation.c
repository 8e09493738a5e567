#include "coordinator/evaluation/evaluation.h"

#include "common/base/clock.h"
#include "common/base/whole_file.h"
#include "common/scenario/scenario_read.h"
#include "coordinator/journal/run_folder.h"

#include <errno.h>
#include <fcntl.h>
#include <glib/gstdio.h>
#include <inttypes.h>
#include <jansson.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char *path_of(const char *directory, const char *name)
{
    return g_build_filename(directory, name, NULL);
}

static enum status failure(const struct evaluation *evaluation, const char *what, int reason,
                           struct error *error)
{
    return error_set(error, STATUS_IO, "%s/outcomes.csv: cannot be %s: %s", evaluation->directory,
                     what, g_strerror(reason));
}

// ---- evaluation.json ----

// Where the table is found from any folder.
static char *designs_path(const struct evaluation *evaluation)
{
    return strcmp(evaluation->designs, "-") == 0
               ? g_strdup("-")
               : g_canonicalize_filename(evaluation->designs, NULL);
}

static enum status note(struct evaluation *evaluation, int64_t now_ns, struct error *error)
{
    char hex[DIGEST_HEX_SIZE], name[SCENARIO_OUTCOME_NAME_SIZE];
    const struct scenario *scenario = &evaluation->scenario;
    const int64_t elapsed_ns = evaluation->elapsed_ns + now_ns - evaluation->started_ns;
    json_t *outcomes = json_array();
    for (uint32_t i = 0; i < evaluation->outcomes.count; i++)
        json_array_append_new(outcomes, json_string(scenario_outcome_name(
                                            scenario, evaluation->outcomes.outcomes[i], name)));
    // A file's name may be any bytes; where it is no text it has to be given again with --resume.
    char *path = designs_path(evaluation), *designs = g_utf8_make_valid(path, -1);
    json_t *object = json_pack(
        "{s:s, s:s, s:s, s:s, s:o, s:I, s:I, s:I, s:f, s:I, s:I, s:s, s:s%}", "name",
        scenario->name, "version", SOBOX_VERSION, "state",
        protocol_run_state_name(evaluation->state), "designs", designs, "outcomes", outcomes,
        "rows", (json_int_t)evaluation->rows, "good", (json_int_t)evaluation->sums.good,
        "non_finite", (json_int_t)evaluation->sums.non_finite, "elapsed_s",
        (double)elapsed_ns / CLOCK_SECOND_NS, "bytes_read", (json_int_t)evaluation->bytes_read,
        "bytes_written", (json_int_t)evaluation->bytes_written, "digest",
        digest_hex(&evaluation->digest, hex), "scenario", scenario->text, scenario->text_size);
    g_free(designs);
    g_free(path);
    char *text = json_dumps(object, JSON_INDENT(2));
    json_decref(object);
    if (text == NULL)
        return error_set(error, STATUS_FAILED, "%s: its state is no text", evaluation->directory);
    path = path_of(evaluation->directory, "evaluation.json");
    GString *line = g_string_new(text);
    g_string_append_c(line, '\n');
    const enum status status = whole_file_write(path, line->str, line->len, error);
    g_string_free(line, TRUE);
    g_free(path);
    free(text);
    evaluation->noted_rows = evaluation->rows;
    return status;
}

static enum status damaged(const char *path, const char *what, struct error *error)
{
    return error_set(error, STATUS_INVALID, "%s: cannot be taken up again: %s", path, what);
}

static bool read_digest(const char *hex, struct digest *digest)
{
    size_t size = 0;
    return strlen(hex) == DIGEST_HEX_SIZE - 1 &&
           sodium_hex2bin(digest->bytes, DIGEST_SIZE, hex, DIGEST_HEX_SIZE - 1, NULL, &size,
                          NULL) == 0 &&
           size == DIGEST_SIZE;
}

static enum status read_outcomes(struct evaluation *evaluation, const json_t *names,
                                 struct error *error)
{
    GString *list = g_string_new(NULL);
    size_t i;
    json_t *name;
    json_array_foreach(names, i, name) g_string_append_printf(
        list, "%s%s", i > 0 ? "," : "", json_is_string(name) ? json_string_value(name) : "");
    const enum status status =
        outcomes_layout_read(&evaluation->outcomes, &evaluation->scenario, list->str, error);
    g_string_free(list, TRUE);
    return status;
}

// Fills in everything that the file tells. It was written by this program, but may have been
// changed.
static enum status take_object(struct evaluation *evaluation, json_t *object, const char *path,
                               struct error *error)
{
    const char *version = NULL, *state = NULL, *designs = NULL, *hex = NULL, *text = NULL;
    size_t text_size = 0;
    json_t *outcomes = NULL;
    json_int_t rows = -1, good = -1, non_finite = -1, read = -1, written = -1;
    double elapsed = -1;
    json_error_t reason;
    if (json_unpack_ex(object, &reason, 0,
                       "{s:s, s:s, s:s, s:o, s:I, s:I, s:I, s:F, s:I, s:I, s:s, s:s%}", "version",
                       &version, "state", &state, "designs", &designs, "outcomes", &outcomes,
                       "rows", &rows, "good", &good, "non_finite", &non_finite, "elapsed_s",
                       &elapsed, "bytes_read", &read, "bytes_written", &written, "digest", &hex,
                       "scenario", &text, &text_size) != 0)
        return damaged(path, reason.text, error);
    if (rows < 0 || good < 0 || non_finite < 0 || read < 0 || written < 0 ||
        !(elapsed >= 0 && elapsed < 1e9) || !read_digest(hex, &evaluation->digest))
        return damaged(path, "it holds a number that it cannot have", error);
    if (strcmp(version, SOBOX_VERSION) != 0)
        return error_set(error, STATUS_REFUSED,
                         "%s: begun by sobox %s, which may compute otherwise than this one (%s): "
                         "continue it with that version",
                         evaluation->directory, version, SOBOX_VERSION);
    if (strcmp(state, protocol_run_state_name(RUN_STATE_DONE)) == 0)
        return error_set(error, STATUS_REFUSED, "%s: this evaluation is done: see its outcomes.csv",
                         evaluation->directory);
    evaluation->rows = (uint64_t)rows;
    evaluation->sums = (struct outcomes_sums){(uint64_t)good, (uint64_t)non_finite};
    evaluation->bytes_read = (uint64_t)read;
    evaluation->bytes_written = (uint64_t)written;
    evaluation->elapsed_ns = (int64_t)(elapsed * CLOCK_SECOND_NS);
    evaluation->designs = g_strdup(designs);
    enum status status =
        scenario_read_text(&evaluation->scenario, path, text, text_size, NULL, 0, error);
    if (status == STATUS_OK)
        status = read_outcomes(evaluation, outcomes, error);
    return status;
}

static enum status take_file(struct evaluation *evaluation, struct error *error)
{
    char *path = path_of(evaluation->directory, "evaluation.json");
    json_error_t reason;
    json_t *object = json_load_file(path, 0, &reason);
    enum status status = object != NULL ? take_object(evaluation, object, path, error)
                                        : damaged(path, reason.text, error);
    json_decref(object);
    g_free(path);
    return status;
}

// ---- outcomes.csv ----

static enum status write_all(struct evaluation *evaluation, const char *text, size_t size,
                             struct error *error)
{
    for (size_t done = 0; done < size;) {
        const ssize_t written = write(evaluation->file, text + done, size - done);
        if (written < 0 && errno != EINTR)
            return failure(evaluation, "written", errno, error);
        done += (size_t)MAX(written, 0);
    }
    evaluation->bytes_written += size;
    return STATUS_OK;
}

static enum status open_outcomes(struct evaluation *evaluation, int flags, struct error *error)
{
    char *path = path_of(evaluation->directory, "outcomes.csv");
    evaluation->file = open(path, O_WRONLY | O_CLOEXEC | flags, 0666);
    g_free(path);
    return evaluation->file >= 0 ? STATUS_OK : failure(evaluation, "opened", errno, error);
}

static enum status cut_outcomes(struct evaluation *evaluation, struct error *error)
{
    struct stat there;
    if (fstat(evaluation->file, &there) != 0)
        return failure(evaluation, "read", errno, error);
    if ((uint64_t)there.st_size < evaluation->bytes_written)
        return error_set(error, STATUS_INVALID,
                         "%s/outcomes.csv: expected the %" PRIu64
                         " bytes that were written, found %" PRIu64
                         ": it was changed, so the evaluation must begin anew",
                         evaluation->directory, evaluation->bytes_written, (uint64_t)there.st_size);
    const off_t size = (off_t)evaluation->bytes_written;
    if (ftruncate(evaluation->file, size) != 0 || lseek(evaluation->file, size, SEEK_SET) != size)
        return failure(evaluation, "written", errno, error);
    return STATUS_OK;
}

// ---- Life ----

static enum status begin_outcomes(struct evaluation *evaluation, struct error *error)
{
    GString *header = g_string_new(NULL);
    outcomes_header(&evaluation->outcomes, header);
    enum status status = open_outcomes(evaluation, O_CREAT | O_TRUNC, error);
    if (status == STATUS_OK)
        status = write_all(evaluation, header->str, header->len, error);
    g_string_free(header, TRUE);
    if (status == STATUS_OK)
        status = note(evaluation, evaluation->started_ns, error);
    return status;
}

enum status evaluation_create(struct evaluation *evaluation, const char *directory,
                              struct scenario *scenario, const char *designs, const char *names,
                              int64_t now_ns, struct error *error)
{
    *evaluation = (struct evaluation){.file = -1, .started_ns = now_ns};
    evaluation->designs = g_strdup(designs);
    evaluation->scenario = *scenario;
    *scenario = (struct scenario){0};
    enum status status =
        outcomes_layout_read(&evaluation->outcomes, &evaluation->scenario, names, error);
    if (status == STATUS_OK) {
        char *picked = g_strdup_printf("%s-outcomes", evaluation->scenario.name);
        status = run_folder_make(directory, picked, &evaluation->directory,
                                 &evaluation->folder_made, error);
        g_free(picked);
    }
    if (status == STATUS_OK)
        status = journal_lock_take(&evaluation->lock, evaluation->directory, error);
    if (status == STATUS_OK)
        status = begin_outcomes(evaluation, error);
    if (status != STATUS_OK) {
        if (evaluation->lock.path != NULL)
            evaluation_abandon(evaluation);
        evaluation_fini(evaluation);
    }
    return status;
}

bool evaluation_present(const char *directory)
{
    char *path = path_of(directory, "evaluation.json");
    const bool present = g_file_test(path, G_FILE_TEST_EXISTS);
    g_free(path);
    return present;
}

enum status evaluation_resume(struct evaluation *evaluation, const char *directory, int64_t now_ns,
                              struct error *error)
{
    *evaluation =
        (struct evaluation){.file = -1, .directory = g_strdup(directory), .started_ns = now_ns};
    enum status status = journal_lock_take(&evaluation->lock, directory, error);
    if (status == STATUS_OK)
        status = take_file(evaluation, error);
    if (status == STATUS_OK)
        status = open_outcomes(evaluation, 0, error);
    if (status == STATUS_OK)
        status = cut_outcomes(evaluation, error);
    if (status == STATUS_OK)
        status = note(evaluation, now_ns, error);
    if (status != STATUS_OK)
        evaluation_fini(evaluation);
    return status;
}

enum status evaluation_append(struct evaluation *evaluation, const struct evaluation_piece *piece,
                              struct error *error)
{
    const enum status status = write_all(evaluation, piece->text, piece->size, error);
    if (status != STATUS_OK)
        return status;
    evaluation->rows += piece->rows;
    evaluation->sums.good += piece->sums.good;
    evaluation->sums.non_finite += piece->sums.non_finite;
    evaluation->bytes_read = piece->end;
    evaluation->digest = evaluation_digest(&evaluation->digest, &piece->digest);
    return STATUS_OK;
}

enum status evaluation_note(struct evaluation *evaluation, int64_t now_ns, struct error *error)
{
    return evaluation->rows == evaluation->noted_rows ? STATUS_OK : note(evaluation, now_ns, error);
}

enum status evaluation_end(struct evaluation *evaluation, enum run_state state, int64_t now_ns,
                           struct error *error)
{
    evaluation->state = state;
    return note(evaluation, now_ns, error);
}

struct digest evaluation_digest(const struct digest *before, const struct digest *piece)
{
    struct digest_state state;
    digest_start(&state);
    digest_bytes(&state, before->bytes, DIGEST_SIZE);
    digest_bytes(&state, piece->bytes, DIGEST_SIZE);
    return digest_end(&state);
}

void evaluation_abandon(struct evaluation *evaluation)
{
    static const char *const files[] = {"outcomes.csv", "evaluation.json"};
    for (size_t i = 0; i < G_N_ELEMENTS(files); i++) {
        char *path = path_of(evaluation->directory, files[i]);
        g_unlink(path);
        g_free(path);
    }
    journal_lock_release(&evaluation->lock);
    if (evaluation->folder_made)
        run_folder_remove(evaluation->directory);
}

void evaluation_fini(struct evaluation *evaluation)
{
    if (evaluation->file >= 0)
        close(evaluation->file);
    journal_lock_release(&evaluation->lock);
    outcomes_layout_fini(&evaluation->outcomes);
    scenario_fini(&evaluation->scenario);
    g_free(evaluation->designs);
    g_free(evaluation->directory);
    *evaluation = (struct evaluation){.file = -1};
}
