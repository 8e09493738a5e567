// Valid messages of every kind, and packets as they travel, for the tests of this folder.
#ifndef SOBOX_TESTS_UNIT_COMMON_WIRE_MESSAGES_H
#define SOBOX_TESTS_UNIT_COMMON_WIRE_MESSAGES_H

// cmocka needs these first.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/wire/check.h"

#include <string.h>

enum {
    MESSAGE_SENDER = 77,
    MESSAGE_BOUND_COUNT = 6,
    MESSAGE_PACKED_SIZE = 25,
    MESSAGE_PIECE_SIZE = 40,
    MESSAGE_STEP_SIZE = 2 + 3 * 14 + 2 * 32, // of 16 samples two are good
};

static double message_bounds[WIRE_MTU_MAX / 8] = {-1.0, 0.0, 5.5e3, 1.0, 0.0, 4.5e5};
static uint8_t message_bytes[WIRE_MTU_MAX] = "springs: a piece of a scenario's text";
static uint8_t message_cases[] = "mass=1500\0001500\000mass=1800\0001800";

// Fills `message` with a valid message; arrays are borrowed from the two above.
static inline void message_make(enum wire_kind kind, union codec_message *message)
{
    memset(message, 0, sizeof *message);
    switch (kind) {
    case WIRE_SAMPLE_BATCH:
        message->sample_batch = (sobox_sample_batch_t){.holder = 9,
                                                       .seed = -1,
                                                       .batch = {2, 3, 4, 1, 100, 50},
                                                       .step_samples = 200,
                                                       .sampling = 2,
                                                       .detail = 1,
                                                       .variables = MESSAGE_BOUND_COUNT / 2,
                                                       .text_size = MESSAGE_PIECE_SIZE,
                                                       .text = message_bytes};
        break;
    case WIRE_TEXT:
        message->text = (sobox_text_t){.total_size = 1000,
                                       .offset = 960,
                                       .piece_size = MESSAGE_PIECE_SIZE,
                                       .piece = message_bytes};
        break;
    case WIRE_OUTCOME_BATCH:
        message->outcome_batch = (sobox_outcome_batch_t){.batch = {2, 3, 4, 0, 100, 50},
                                                         .detail = 0,
                                                         .non_finite = 50,
                                                         .queue = 3,
                                                         .service_ns = 123456789,
                                                         .packed_size = MESSAGE_PACKED_SIZE,
                                                         .packed = message_bytes};
        break;
    case WIRE_TEXT_REQUEST:
        message->text_request = (sobox_text_request_t){.digest = {1, 2, 3}, .offset = 960};
        break;
    case WIRE_WORKER_STATUS:
        message->worker_status = (sobox_worker_status_t){.host = "höst7",
                                                         .process = 4711,
                                                         .threads = 16,
                                                         .queue = 2,
                                                         .batches = 10,
                                                         .samples = 2000,
                                                         .busy_ns = 5,
                                                         .uptime_ns = 6,
                                                         .buffer_size = 8000000};
        break;
    case WIRE_RUN_STATUS:
        message->run_status =
            (sobox_run_status_t){.name = "sedan", .state = 1, .searches = 3, .searches_done = 3};
        break;
    case WIRE_SEARCH_STATUS:
        message->search_status = (sobox_search_status_t){.phase = 4,
                                                         .status = 3,
                                                         .step = 7,
                                                         .step_count = 200,
                                                         .good_share = 1.0,
                                                         .log_volume = -7.5,
                                                         .standing = 2,
                                                         .variables = 7,
                                                         .first_variable = 4,
                                                         .bound_count = MESSAGE_BOUND_COUNT,
                                                         .bounds = message_bounds};
        break;
    case WIRE_STEP_STATUS:
        message->step_status = (sobox_step_status_t){.seed = -1,
                                                     .search = 2,
                                                     .step = 3,
                                                     .phase = 1,
                                                     .samples = 200,
                                                     .good = 150,
                                                     .count = 16,
                                                     .variables = 7,
                                                     .first_variable = 5,
                                                     .window = 2,
                                                     .packed_size = MESSAGE_STEP_SIZE,
                                                     .packed = message_bytes};
        break;
    case WIRE_CASES:
        message->cases = (sobox_cases_t){
            .first = 5, .columns = 2, .text_size = sizeof message_cases, .text = message_cases};
        break;
    case WIRE_HAIL:
        message->hail = (sobox_hail_t){
            .challenge = {1, 2}, .age_ns = 8, .asked = 9, .echo = {3, 4}, .floor = 7};
        break;
    case WIRE_DESIGN_BATCH:
        message->design_batch = (sobox_design_batch_t){.holder = 9,
                                                       .batch = {2, 3, 4, 0, 100, 3},
                                                       .value_count = MESSAGE_BOUND_COUNT,
                                                       .values = message_bounds};
        break;
    case WIRE_VALUE_BATCH:
        message->value_batch = (sobox_value_batch_t){.batch = {2, 3, 4, 0, 100, 2},
                                                     .queue = 3,
                                                     .service_ns = 123456789,
                                                     .value_count = MESSAGE_BOUND_COUNT,
                                                     .values = message_bounds};
        break;
    case WIRE_KIND_COUNT:
        fail();
    }
    message->header = (sobox_header_t){
        .protocol = WIRE_PROTOCOL, .sequence = 5, .sender = MESSAGE_SENDER, .run = 12};
}

// Puts the right tag behind the first `size - TAG_SIZE` bytes.
static inline void packet_tag(enum wire_kind kind, uint8_t *packet, size_t size)
{
    tag_compute(packet + size - TAG_SIZE, check_kind(kind)->channel, packet, size - TAG_SIZE);
}

// Encodes a message with its tag into `packet` (WIRE_MTU_MAX bytes); returns the packet's size.
static inline size_t packet_make(enum wire_kind kind, const union codec_message *message,
                                 uint8_t *packet)
{
    size_t size = codec_encoded_size(kind, message) + TAG_SIZE;
    assert_true(codec_encode(kind, message, packet, size - TAG_SIZE));
    packet_tag(kind, packet, size);
    return size;
}

// The packet of message_make().
static inline size_t packet_valid(enum wire_kind kind, uint8_t *packet)
{
    union codec_message message;
    message_make(kind, &message);
    return packet_make(kind, &message, packet);
}

// Checks a packet that lies at the end of its own allocation, so that a sanitizer sees each byte
// read too far; releases what was decoded.
static inline enum check_result packet_check(enum wire_kind kind, const uint8_t *packet,
                                             size_t size)
{
    union codec_message message;
    uint8_t *copy = malloc(size > 0 ? size : 1);
    assert_non_null(copy);
    memcpy(copy, packet, size);
    enum check_result result = check_packet(kind, copy, size, &message);
    if (result == CHECK_GOOD)
        codec_release(kind, &message);
    free(copy);
    return result;
}

#endif
