#include "monitor/feed/album.h"

#include <math.h>
#include <string.h>

enum { CONSTRAINTS_MAX = 256 }; // that a verdict's byte can name

static void picture_free(gpointer user)
{
    struct album_picture *picture = user;
    if (picture == NULL)
        return;
    g_free(picture->verdicts);
    box_fini(&picture->sampled);
    box_fini(&picture->box);
    g_free(picture);
}

void album_init(struct album *album)
{
    *album = (struct album){
        .pictures = g_ptr_array_new_with_free_func(picture_free),
        .stride = 1,
    };
}

void album_fini(struct album *album)
{
    if (album->pictures != NULL)
        g_ptr_array_free(album->pictures, TRUE);
    picture_free(album->pending);
    *album = (struct album){0};
}

// ---- Putting a picture together ----

struct album_picture *album_picture(uint32_t count, uint32_t variables)
{
    struct album_picture *picture = g_new0(struct album_picture, 1);
    picture->count = count;
    picture->verdicts = g_new0(struct verdict, count);
    box_init(&picture->sampled, variables);
    box_init(&picture->box, variables);
    return picture;
}

static size_t verdicts_size(const sobox_step_status_t *message)
{
    return (size_t)message->packed_size - (size_t)message->window * 4 * sizeof(double);
}

// A new picture of the message's step with its verdicts, whose bounds are all unknown (NaN); NULL
// when the verdicts do not unpack.
static struct album_picture *picture_begin(const sobox_step_status_t *message)
{
    const uint32_t variables = (uint32_t)message->variables;
    struct album_picture *picture = album_picture((uint32_t)message->count, variables);
    picture->sampling = (struct sampling){
        .seed = (uint64_t)message->seed,
        .step = (uint32_t)message->step,
        .samples = (uint32_t)message->samples,
        .method = (enum sampling_method)message->sampling,
    };
    picture->phase = (enum search_phase)message->phase;
    picture->detail = (enum verdict_detail)message->detail;
    picture->good = (uint32_t)message->good;
    memcpy(picture->scenario.bytes, message->scenario, DIGEST_SIZE);
    for (uint32_t i = 0; i < variables; i++)
        picture->sampled.lower[i] = NAN;
    if (message->count == 0 ||
        verdict_unpack(picture->verdicts, picture->count, picture->detail, CONSTRAINTS_MAX,
                       message->packed, verdicts_size(message)))
        return picture;
    picture_free(picture);
    return NULL;
}

static const uint8_t *take_doubles(const uint8_t *at, double *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, at, sizeof bits);
        bits = GUINT64_FROM_LE(bits);
        memcpy(&values[i], &bits, sizeof bits);
        at += sizeof bits;
    }
    return at;
}

static bool is_sound(const struct box *box, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        if (!isfinite(box->lower[i]) || !isfinite(box->upper[i]) || box->lower[i] > box->upper[i])
            return false;
    }
    return true;
}

// Puts the window's bounds into the pending picture. False when they are no bounds.
static bool take_window(struct album *album, const sobox_step_status_t *message)
{
    struct album_picture *picture = album->pending;
    const uint32_t first = (uint32_t)message->first_variable, count = (uint32_t)message->window;
    for (uint32_t i = first; i < first + count; i++)
        album->missing -= isnan(picture->sampled.lower[i]) ? 1 : 0;
    const uint8_t *at = message->packed + verdicts_size(message);
    at = take_doubles(at, picture->sampled.lower + first, count);
    at = take_doubles(at, picture->sampled.upper + first, count);
    at = take_doubles(at, picture->box.lower + first, count);
    take_doubles(at, picture->box.upper + first, count);
    return is_sound(&picture->sampled, first, count) && is_sound(&picture->box, first, count);
}

static void pending_drop(struct album *album)
{
    picture_free(album->pending);
    album->pending = NULL;
}

static bool is_pending(const struct album *album, const sobox_step_status_t *message)
{
    const struct album_picture *pending = album->pending;
    return pending != NULL && pending->sampling.step == (uint32_t)message->step &&
           pending->sampling.seed == (uint64_t)message->seed &&
           pending->sampled.count == (uint32_t)message->variables;
}

// ---- The album ----

static guint capacity(const struct album_picture *picture)
{
    const gsize size = sizeof *picture + picture->count * sizeof(struct verdict) +
                       picture->sampled.count * 4 * sizeof(double);
    return (guint)CLAMP(ALBUM_SIZE_MAX / size, 2, ALBUM_PICTURE_MAX);
}

static struct album_picture *last_of(const struct album *album)
{
    return album->pictures->len > 0 ? album->pictures->pdata[album->pictures->len - 1] : NULL;
}

// Keeps every second one of the pictures that stay, and from now on half as many.
static void thin_out(struct album *album)
{
    album->stride *= 2;
    for (guint i = album->pictures->len; i > 0; i--) {
        const struct album_picture *picture = album->pictures->pdata[i - 1];
        if (picture->ordinal % album->stride != 0)
            g_ptr_array_remove_index(album->pictures, i - 1);
    }
}

// A coordinator that was started anew may stand some steps before: what was after goes. The newest
// picture is always there; it stays if its turn is right.
void album_add(struct album *album, struct album_picture *picture)
{
    const struct album_picture *last;
    while ((last = last_of(album)) != NULL && last->sampling.step >= picture->sampling.step) {
        album->added = last->ordinal;
        g_ptr_array_set_size(album->pictures, (gint)album->pictures->len - 1);
    }
    if (last != NULL && last->ordinal % album->stride != 0)
        g_ptr_array_set_size(album->pictures, (gint)album->pictures->len - 1);
    if (album->pictures->len >= capacity(picture))
        thin_out(album);
    picture->ordinal = album->added++;
    g_ptr_array_add(album->pictures, picture);
}

bool album_hear(struct album *album, const sobox_step_status_t *message)
{
    if (!is_pending(album, message)) {
        pending_drop(album);
        // The verdicts come with the first part: without it the rest tells nothing. Pictures are of
        // points: where a curve stands takes the scenario's springs.
        if (message->count == 0 || !sampling_of_points((enum sampling_method)message->sampling))
            return false;
        album->pending = picture_begin(message);
        album->missing = (uint32_t)message->variables;
    }
    if (album->pending == NULL)
        return false;
    if (!take_window(album, message)) {
        pending_drop(album);
        return false;
    }
    if (album->missing > 0)
        return false;
    album_add(album, g_steal_pointer(&album->pending));
    return true;
}

const struct album_picture *album_find(const struct album *album, uint32_t step)
{
    for (guint i = album->pictures->len; i > 0; i--) {
        const struct album_picture *picture = album->pictures->pdata[i - 1];
        if (picture->sampling.step <= step)
            return picture;
    }
    return NULL;
}
