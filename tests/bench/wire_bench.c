// What a message costs, in clear and sealed, inside a process, over loopback multicast and, given
// the URL of a hub as argument (tcpq://ADDRESS:PORT, without a key), through that. Prints CSV. Runs
// under tests/netns, so that it finds a multicast route and disturbs nobody.
//
//     transport,key,message,bytes,publish_us,dispatch_us,there_us
//
// publish_us and dispatch_us are the processor time of the one thread that publishes a burst and
// then hands it on; there_us is the time from publishing one message to its handler. Each is the
// best of some rounds. `first_status` is a status from a sender that the receiver has never heard:
// with a key the question and its answer are in there_us.
#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/check.h"
#include "common/wire/seal.h"
#include "common/wire/wire.h"

#include "sobox_outcome_batch_t.h"
#include "sobox_run_status_t.h"
#include "sobox_sample_batch_t.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define URL "udpm://239.255.76.67:7667?ttl=0"

enum {
    BURST = 50,
    ROUNDS = 200,
    SINGLES = 2000,
    OPENINGS = 20,
    BOUNDS_MAX = 140,
    PACKED_MAX = 1240
};

static double bounds[BOUNDS_MAX]; // zeros are as good as any
static uint8_t packed[PACKED_MAX];

struct bench_message {
    const char *name;
    enum wire_kind kind;
    int32_t bound_count; // of a batch
    int32_t samples;     // of an outcome
    int32_t packed_size; // [bytes] same
};

static const struct bench_message messages[] = {
    {"batch_without_box", WIRE_SAMPLE_BATCH, 0, 0, 0},
    {"batch_of_18_variables", WIRE_SAMPLE_BATCH, 36, 0, 0},
    {"outcome_of_200", WIRE_OUTCOME_BATCH, 0, 200, 25 + 3 * 50}, // a quarter is bad
    {"outcome_of_frame_size", WIRE_OUTCOME_BATCH, 0, 1600, PACKED_MAX},
};

struct bench {
    struct wire *wire;
    uint64_t handled;
};

static void count(void *user, enum wire_kind kind, const void *message)
{
    (void)kind;
    (void)message;
    ((struct bench *)user)->handled++;
}

static void stop(const struct error *error)
{
    log_failure(error);
    exit((int)status_exit(error->status));
}

static struct wire *open_wire(const char *url, const struct key *key, uint64_t sender)
{
    const struct wire_settings settings = {.url = url, .mtu = WIRE_MTU_DEFAULT, .key = key};
    struct error error = {0};
    struct wire *wire;
    if (wire_open(&wire, &settings, sender, &error) != STATUS_OK)
        stop(&error);
    return wire;
}

static void listen_to(struct bench *bench, enum wire_kind kind)
{
    struct error error = {0};
    if (wire_subscribe(bench->wire, kind, count, bench, &error) != STATUS_OK)
        stop(&error);
}

static void publish(struct wire *wire, const struct bench_message *what)
{
    sobox_sample_batch_t batch = {.holder = 1,
                                  .batch.count = 200,
                                  .step_samples = 200,
                                  .variables = 1 + what->bound_count / 2,
                                  .text_size = what->bound_count * (int32_t)sizeof *bounds,
                                  .text = (uint8_t *)bounds};
    sobox_outcome_batch_t outcome = {
        .batch.count = what->samples, .packed_size = what->packed_size, .packed = packed};
    sobox_run_status_t status = {.name = "bench", .searches = 1};
    void *message = what->kind == WIRE_SAMPLE_BATCH    ? (void *)&batch
                    : what->kind == WIRE_OUTCOME_BATCH ? (void *)&outcome
                                                       : (void *)&status;
    if (wire_publish(wire, what->kind, message) != STATUS_OK) {
        log_error("%s cannot be published", what->name);
        exit(1);
    }
}

// Dispatches until so many messages have been handled; `other` too, unless NULL.
static void await(struct bench *bench, struct wire *other, uint64_t handled)
{
    while (bench->handled < handled) {
        wire_dispatch(bench->wire, BURST);
        if (other != NULL)
            wire_dispatch(other, BURST);
    }
}

static double thread_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e6 + (double)now.tv_nsec * 1e-3;
}

static double wall_us(void)
{
    return (double)clock_monotonic_ns() * 1e-3;
}

static void keep_least(double *least, double value)
{
    if (*least == 0.0 || value < *least)
        *least = value;
}

// Waits, without using the processor, until the kernel and LCM's thread have delivered.
static void settle(struct bench *bench)
{
    int descriptors[WIRE_PORT_COUNT];
    size_t open = wire_descriptors(bench->wire, descriptors);
    struct pollfd ready[WIRE_PORT_COUNT];
    for (size_t i = 0; i < open; i++)
        ready[i] = (struct pollfd){.fd = descriptors[i], .events = POLLIN};
    poll(ready, open, 1000);
    nanosleep(&(struct timespec){.tv_nsec = 300000}, NULL);
}

static void measure(const char *transport, const char *url, const struct key *key,
                    const struct bench_message *what)
{
    struct bench bench = {.wire = open_wire(url, key, 1)};
    double publish_us = 0.0, dispatch_us = 0.0, there_us = 0.0;
    listen_to(&bench, what->kind);
    for (int round = 0; round < ROUNDS; round++) {
        uint64_t wanted = bench.handled + BURST;
        double start = thread_us();
        for (int i = 0; i < BURST; i++)
            publish(bench.wire, what);
        keep_least(&publish_us, (thread_us() - start) / BURST);
        settle(&bench);
        start = thread_us();
        await(&bench, NULL, wanted);
        keep_least(&dispatch_us, (thread_us() - start) / BURST);
    }
    double start = wall_us();
    for (int i = 0; i < SINGLES; i++) {
        publish(bench.wire, what);
        await(&bench, NULL, bench.handled + 1);
        if (i % 100 == 99) {
            keep_least(&there_us, (wall_us() - start) / 100);
            start = wall_us();
        }
    }
    size_t payload = what->kind == WIRE_SAMPLE_BATCH ? (size_t)what->bound_count * sizeof(double)
                                                     : (size_t)what->packed_size;
    size_t bytes =
        check_kind(what->kind)->fixed_size + (key != NULL ? SEAL_SIZE : TAG_SIZE) + payload;
    printf("%s,%s,%s,%zu,%.2f,%.2f,%.2f\n", transport, key != NULL ? "yes" : "no", what->name,
           bytes, publish_us, dispatch_us, there_us);
    wire_close(bench.wire);
}

static void measure_first(const char *transport, const char *url, const struct key *key)
{
    static const struct bench_message status = {.name = "first_status", .kind = WIRE_RUN_STATUS};
    double there_us = 0.0;
    for (uint64_t i = 0; i < OPENINGS; i++) {
        struct bench bench = {.wire = open_wire(url, key, 1)};
        struct wire *sender = open_wire(url, key, 2 + i);
        listen_to(&bench, WIRE_RUN_STATUS);
        double start = wall_us();
        publish(sender, &status);
        await(&bench, sender, 1);
        keep_least(&there_us, wall_us() - start);
        wire_close(sender);
        wire_close(bench.wire);
    }
    printf("%s,%s,first_status,,,,%.2f\n", transport, key != NULL ? "yes" : "no", there_us);
}

int main(int argc, char **argv)
{
    static const uint8_t bytes[KEY_SIZE] = {1, 2, 3};
    log_start("wire_bench", LOG_NORMAL);
    struct key *key = key_create(bytes);
    const struct key *keys[] = {NULL, key};
    printf("transport,key,message,bytes,publish_us,dispatch_us,there_us\n");
    for (size_t k = 0; k < 2; k++)
        for (size_t i = 0; i < sizeof messages / sizeof messages[0]; i++)
            measure("memq", "memq://", keys[k], &messages[i]);
    for (size_t k = 0; k < 2; k++) {
        for (size_t i = 0; i < sizeof messages / sizeof messages[0]; i++)
            measure("udpm", URL, keys[k], &messages[i]);
        measure_first("udpm", URL, keys[k]);
    }
    for (size_t i = 0; argc == 2 && i < sizeof messages / sizeof messages[0]; i++)
        measure("hub", argv[1], NULL, &messages[i]);
    key_free(key);
    return 0;
}
