#include "common/wire/check.h"

#include "common/numeric/verdict.h"
#include "common/protocol/protocol.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    FINGERPRINT_SIZE = 8,
    HEAD_SIZE = FINGERPRINT_SIZE + 24, // [bytes] with the header
    COUNT_SIZE = 4,
    BOUND_SIZES = 4 * 8, // [bytes] a variable: lower and upper of two boxes
};

// Elements of `unit` bytes that fit the largest message of this fixed size.
#define COUNT_MAX(fixed, unit) ((WIRE_MTU_MAX - TAG_SIZE - (fixed)) / (unit))

// The sizes restate what the .lcm files say; check_test holds them against the generated encoders.
static const struct check_kind kinds[WIRE_KIND_COUNT] = {
    [WIRE_SAMPLE_BATCH] = {"SOBOX_BATCH", 0, 118, 1, COUNT_MAX(118, 1)},
    [WIRE_TEXT] = {"SOBOX_TEXT", 0, 60, 1, COUNT_MAX(60, 1)},
    [WIRE_OUTCOME_BATCH] = {"SOBOX_OUTCOME", 1, 77, 1, COUNT_MAX(77, 1)},
    [WIRE_TEXT_REQUEST] = {"SOBOX_TEXT_REQUEST", 1, 52, 0, 0},
    [WIRE_WORKER_STATUS] = {"SOBOX_WORKER", 2, 177, 0, 0},
    [WIRE_RUN_STATUS] = {"SOBOX_RUN", 2, 193, 0, 0},
    [WIRE_SEARCH_STATUS] = {"SOBOX_SEARCH", 2, 107, 8, COUNT_MAX(107, 8)},
    [WIRE_STEP_STATUS] = {"SOBOX_STEP", 2, 95, 1, COUNT_MAX(95, 1)},
    [WIRE_CASES] = {"SOBOX_CASES", 2, 44, 1, COUNT_MAX(44, 1)},
    [WIRE_HAIL] = {"SOBOX_HAIL", 2, 88, 0, 0},
    [WIRE_DESIGN_BATCH] = {"SOBOX_DESIGNS", 0, 84, 8, COUNT_MAX(84, 8)},
    [WIRE_VALUE_BATCH] = {"SOBOX_VALUES", 1, 72, 8, COUNT_MAX(72, 8)},
};

const struct check_kind *check_kind(enum wire_kind kind)
{
    return &kinds[kind];
}

size_t check_size_min(enum wire_kind kind)
{
    return kinds[kind].fixed_size + TAG_SIZE;
}

size_t check_size_max(enum wire_kind kind)
{
    return check_size_min(kind) + kinds[kind].unit * (size_t)kinds[kind].count_max;
}

const char *check_result_text(enum check_result result)
{
    static const char *const texts[] = {
#define CHECK_TEXT(name, text) [name] = text,
        CHECK_LIST(CHECK_TEXT)
#undef CHECK_TEXT
    };
    return texts[result];
}

// Encoded integers are big-endian and unaligned.
static uint32_t read_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

static uint64_t read_u64(const uint8_t *bytes)
{
    return (uint64_t)read_u32(bytes) << 32 | read_u32(bytes + 4);
}

// ---- Fields ----

static bool counts_ok(const int64_t *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (values[i] < 0)
            return false;
    return true;
}
#define NOT_NEGATIVE(...) \
    counts_ok((const int64_t[]){__VA_ARGS__}, sizeof((int64_t[]){__VA_ARGS__}) / sizeof(int64_t))

static bool share_ok(double share)
{
    return share >= 0.0 && share <= 1.0;
}

// Names are shown on terminals and in browsers: UTF-8 without control characters.
static bool name_ok(const uint8_t *name, size_t size)
{
    const uint8_t *end = size > 0 ? memchr(name, '\0', size) : NULL;
    if (end == NULL || !g_utf8_validate((const char *)name, end - name, NULL))
        return false;
    for (const char *at = (const char *)name; *at != '\0'; at = g_utf8_next_char(at))
        if (g_unichar_iscntrl(g_utf8_get_char(at)))
            return false;
    return true;
}

// Lower bounds, then as many upper bounds; all finite, lower <= upper.
static bool bounds_ok(const double *bounds, int32_t count, int32_t count_max)
{
    if (count < 0 || count > count_max || count % 2 != 0)
        return false;
    for (int32_t i = 0; i < count / 2; i++) {
        double lower = bounds[i], upper = bounds[count / 2 + i];
        if (!isfinite(lower) || !isfinite(upper) || lower > upper)
            return false;
    }
    return true;
}

static bool batch_ok(const sobox_batch_t *m)
{
    return NOT_NEGATIVE(m->search, m->step, m->batch, m->attempt, m->first) && m->count >= 1 &&
           m->count <= PROTOCOL_BATCH_SAMPLES_MAX;
}

static bool sample_batch_ok(const sobox_sample_batch_t *m)
{
    return m->holder != 0 && batch_ok(&m->batch) &&
           m->step_samples >= (int64_t)m->batch.first + (int64_t)m->batch.count &&
           m->sampling >= 0 && m->sampling < SAMPLING_METHOD_COUNT && m->detail >= 0 &&
           m->detail < VERDICT_DETAIL_COUNT && m->variables >= 1 &&
           m->variables <= PROTOCOL_VARIABLE_MAX && m->text_size >= 0 &&
           m->text_size <= kinds[WIRE_SAMPLE_BATCH].count_max;
}

static bool outcome_batch_ok(const sobox_outcome_batch_t *m)
{
    const int32_t count = m->batch.count;
    if (!batch_ok(&m->batch) || !NOT_NEGATIVE(m->non_finite, m->queue, m->service_ns) ||
        m->non_finite > count || m->detail < 0 || m->detail >= VERDICT_DETAIL_COUNT ||
        m->packed_size < 1 || m->packed_size > kinds[WIRE_OUTCOME_BATCH].count_max)
        return false;
    // A bit a sample at least; the schedule unpacks them and looks closer.
    size_t greatest = verdict_packed_size_max((uint32_t)count, (enum verdict_detail)m->detail);
    return m->packed_size >= (count + 7) / 8 && (size_t)m->packed_size <= greatest;
}

static bool text_ok(const sobox_text_t *m)
{
    return m->total_size >= 1 && m->total_size <= PROTOCOL_TEXT_SIZE_MAX && m->piece_size >= 1 &&
           m->piece_size <= kinds[WIRE_TEXT].count_max && m->piece_size <= m->total_size &&
           m->offset >= 0 && m->offset <= m->total_size - m->piece_size;
}

static bool text_request_ok(const sobox_text_request_t *m)
{
    return m->offset >= 0 && m->offset < PROTOCOL_TEXT_SIZE_MAX;
}

static bool worker_status_ok(const sobox_worker_status_t *m)
{
    return name_ok(m->host, sizeof m->host) && m->threads >= 1 &&
           (m->leaving == 0 || m->leaving == 1) &&
           NOT_NEGATIVE(m->process, m->queue, m->batches, m->samples, m->busy_ns, m->uptime_ns,
                        m->lost, m->dropped, m->buffer_size);
}

static bool run_status_ok(const sobox_run_status_t *m)
{
    return name_ok(m->name, sizeof m->name) && m->state >= 0 && m->state < RUN_STATE_COUNT &&
           m->searches >= 1 && m->searches_done <= m->searches &&
           NOT_NEGATIVE(m->searches_done, m->workers, m->workers_refused, m->samples, m->batches,
                        m->released, m->duplicates, m->rejected, m->lost, m->elapsed_ns,
                        m->service_ns);
}

static bool search_status_ok(const sobox_search_status_t *m)
{
    return NOT_NEGATIVE(m->search, m->step, m->step_count, m->evaluations) && m->phase >= 0 &&
           m->phase < SEARCH_PHASE_COUNT && m->status >= 0 && m->status < SEARCH_STATUS_COUNT &&
           m->standing >= 0 && m->standing < SEARCH_STANDING_COUNT && m->variables >= 0 &&
           m->variables <= PROTOCOL_VARIABLE_MAX && m->first_variable >= 0 && m->bound_count >= 0 &&
           m->first_variable <= m->variables - m->bound_count / 2 && share_ok(m->good_share) &&
           share_ok(m->purity_lower95) && m->log_volume <= 0.0 &&
           bounds_ok(m->bounds, m->bound_count, kinds[WIRE_SEARCH_STATUS].count_max);
}

// Bounds and verdicts are looked at when the step is put together (monitor/feed/step.h); here, that
// their bytes are there.
static bool step_status_ok(const sobox_step_status_t *m)
{
    if (!NOT_NEGATIVE(m->search, m->step, m->good, m->count, m->first_variable) || m->phase < 0 ||
        m->phase >= SEARCH_PHASE_COUNT || m->sampling < 0 || m->sampling >= SAMPLING_METHOD_COUNT ||
        m->detail < 0 || m->detail >= VERDICT_DETAIL_COUNT || m->samples < 1 ||
        m->good > m->samples || m->count > m->samples || m->count > PROTOCOL_BATCH_SAMPLES_MAX ||
        m->variables < 1 || m->variables > PROTOCOL_VARIABLE_MAX || m->window < 1 ||
        m->window > m->variables || m->first_variable > m->variables - m->window ||
        m->packed_size > kinds[WIRE_STEP_STATUS].count_max)
        return false;
    const int64_t verdicts = (int64_t)m->packed_size - (int64_t)m->window * BOUND_SIZES;
    const size_t greatest =
        m->count > 0 ? verdict_packed_size_max((uint32_t)m->count, (enum verdict_detail)m->detail)
                     : 0;
    return verdicts >= (m->count + 7) / 8 && (size_t)verdicts <= greatest;
}

static bool cases_ok(const sobox_cases_t *m)
{
    if (m->first < -1 || m->columns < 1 || m->columns > 1 + PROTOCOL_AXIS_MAX || m->text_size < 1 ||
        m->text_size > kinds[WIRE_CASES].count_max)
        return false;
    int32_t texts = 0;
    for (int32_t at = 0; at < m->text_size; texts++) {
        if (!name_ok(m->text + at, (size_t)(m->text_size - at)))
            return false;
        at += (int32_t)strlen((const char *)m->text + at) + 1;
    }
    return texts % m->columns == 0 && (m->first >= 0 || texts == m->columns);
}

static bool hail_ok(const sobox_hail_t *m)
{
    return m->age_ns >= 0 && m->floor >= 0; // whatever the challenges, whoever is asked
}

// As many values for each design as for the next, one at least.
static bool values_ok(int32_t count, int32_t value_count, int32_t value_max)
{
    return value_count >= count && value_count <= value_max && value_count % count == 0;
}

static bool design_batch_ok(const sobox_design_batch_t *m)
{
    if (m->holder == 0 || !batch_ok(&m->batch) ||
        !values_ok(m->batch.count, m->value_count, kinds[WIRE_DESIGN_BATCH].count_max))
        return false;
    for (int32_t i = 0; i < m->value_count; i++)
        if (!isfinite(m->values[i]))
            return false;
    return true;
}

// A simulation may break down, so the values may be any.
static bool value_batch_ok(const sobox_value_batch_t *m)
{
    return batch_ok(&m->batch) && NOT_NEGATIVE(m->queue, m->service_ns) &&
           values_ok(m->batch.count, m->value_count, kinds[WIRE_VALUE_BATCH].count_max);
}

bool check_fields(enum wire_kind kind, const void *message)
{
    const sobox_header_t *header = message;
    if (header->sender == 0)
        return false;
    switch (kind) {
#define CHECK_CASE(value, name) \
    case value:                 \
        return name##_ok(message);
        CODEC_LIST(CHECK_CASE)
#undef CHECK_CASE
    case WIRE_KIND_COUNT:
        break;
    }
    return false;
}

// ---- Packets ----

static void read_header(const uint8_t *bytes, sobox_header_t *header)
{
    bytes += FINGERPRINT_SIZE;
    *header = (sobox_header_t){.protocol = (int32_t)read_u32(bytes),
                               .sequence = (int32_t)read_u32(bytes + 4),
                               .sender = (int64_t)read_u64(bytes + 8),
                               .run = (int64_t)read_u64(bytes + 16)};
}

// Whether the count in the message is the one that its size leaves room for, exactly.
static bool count_ok(const struct check_kind *layout, const uint8_t *bytes, size_t size)
{
    size_t array_size = size - layout->fixed_size;
    if (layout->unit == 0)
        return array_size == 0;
    uint32_t count = read_u32(bytes + layout->fixed_size - COUNT_SIZE);
    return count <= (uint32_t)layout->count_max && array_size == count * layout->unit;
}

// Size, protocol and type; fills the message's header.
static enum check_result check_head(enum wire_kind kind, const uint8_t *bytes, size_t size,
                                    union codec_message *message)
{
    const struct check_kind *layout = &kinds[kind];
    memset(message, 0, sizeof *message);
    if (size < HEAD_SIZE || size > WIRE_MTU_MAX)
        return CHECK_SIZE;
    read_header(bytes, &message->header);
    // Fingerprint and header stand at the same place in every version, so that another version is
    // told from damage; its sizes and types are not ours to judge.
    if (message->header.protocol != WIRE_PROTOCOL)
        return CHECK_FOREIGN;
    if (size < layout->fixed_size ||
        size > layout->fixed_size + layout->unit * (size_t)layout->count_max)
        return CHECK_SIZE;
    return (int64_t)read_u64(bytes) == codec_fingerprint(kind) ? CHECK_GOOD : CHECK_TYPE;
}

static enum check_result check_body(enum wire_kind kind, const uint8_t *bytes, size_t size,
                                    union codec_message *message)
{
    if (!count_ok(&kinds[kind], bytes, size))
        return CHECK_COUNT;
    if (codec_decode(kind, bytes, size, message) && check_fields(kind, message))
        return CHECK_GOOD;
    codec_release(kind, message);
    return CHECK_FIELD;
}

enum check_result check_packet(enum wire_kind kind, const uint8_t *bytes, size_t size,
                               union codec_message *message)
{
    if (size < TAG_SIZE || size > WIRE_MTU_MAX)
        return CHECK_SIZE;
    size -= TAG_SIZE;
    enum check_result result = check_head(kind, bytes, size, message);
    if (result != CHECK_GOOD && result != CHECK_FOREIGN)
        return result;
    if (!tag_matches(bytes + size, kinds[kind].channel, bytes, size))
        return CHECK_TAG;
    return result == CHECK_FOREIGN ? result : check_body(kind, bytes, size, message);
}

enum check_result check_encoded(enum wire_kind kind, const uint8_t *bytes, size_t size,
                                union codec_message *message)
{
    enum check_result result = check_head(kind, bytes, size, message);
    return result == CHECK_GOOD ? check_body(kind, bytes, size, message) : result;
}
