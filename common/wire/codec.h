// One name for the twelve generated encoders and decoders: the message's kind.
#ifndef SOBOX_COMMON_WIRE_CODEC_H
#define SOBOX_COMMON_WIRE_CODEC_H

#include "common/protocol/protocol.h"
#include "common/wire/wire.h"

#include "sobox_cases_t.h"
#include "sobox_design_batch_t.h"
#include "sobox_hail_t.h"
#include "sobox_outcome_batch_t.h"
#include "sobox_run_status_t.h"
#include "sobox_sample_batch_t.h"
#include "sobox_search_status_t.h"
#include "sobox_step_status_t.h"
#include "sobox_text_request_t.h"
#include "sobox_text_t.h"
#include "sobox_value_batch_t.h"
#include "sobox_worker_status_t.h"

// Kind and type of every message; in the order of enum wire_kind.
#define CODEC_LIST(X)                    \
    X(WIRE_SAMPLE_BATCH, sample_batch)   \
    X(WIRE_TEXT, text)                   \
    X(WIRE_OUTCOME_BATCH, outcome_batch) \
    X(WIRE_TEXT_REQUEST, text_request)   \
    X(WIRE_WORKER_STATUS, worker_status) \
    X(WIRE_RUN_STATUS, run_status)       \
    X(WIRE_SEARCH_STATUS, search_status) \
    X(WIRE_STEP_STATUS, step_status)     \
    X(WIRE_CASES, cases)                 \
    X(WIRE_HAIL, hail)                   \
    X(WIRE_DESIGN_BATCH, design_batch)   \
    X(WIRE_VALUE_BATCH, value_batch)

// A message of any kind. Every type begins with its header.
union codec_message {
    sobox_header_t header;
#define CODEC_MEMBER(kind, name) sobox_##name##_t name;
    CODEC_LIST(CODEC_MEMBER)
#undef CODEC_MEMBER
};

// The identity of a batch as it travels, and back. The wire's check has seen to it that no number
// of a received one is below 0.
sobox_batch_t codec_batch(const struct batch_identity *identity);
struct batch_identity codec_identity(const sobox_batch_t *batch);

// Bytes that `message` (the type of `kind`) encodes to. Its count must be in range.
size_t codec_encoded_size(enum wire_kind kind, const void *message);

// Encodes into `bytes`, which has room for `size`; false when it does not fit.
bool codec_encode(enum wire_kind kind, const void *message, uint8_t *bytes, size_t size);

// Decodes exactly `size` bytes. The generated decoders trust the count in the message, so it must
// have been checked against the size before (check.h). False when the type is another or the size
// is not used up. What it allocates goes with codec_release(), which is called in either case.
bool codec_decode(enum wire_kind kind, const uint8_t *bytes, size_t size,
                  union codec_message *message);

// Releases what codec_decode() allocated.
void codec_release(enum wire_kind kind, union codec_message *message);

// The type's fingerprint, which opens every encoded message.
int64_t codec_fingerprint(enum wire_kind kind);

#endif
