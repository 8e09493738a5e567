// How a wire lives with LCM 1.3.1: README.md of this folder.
#include "common/wire/wire.h"

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/wire/check.h"
#include "common/wire/door.h"
#include "common/wire/guard.h"
#include "common/wire/link.h"
#include "common/wire/probe.h"
#include "common/wire/quiet.h"
#include "common/wire/source.h"
#include "common/wire/wire_state.h"

#include <assert.h>
#include <poll.h>
#include <sodium.h>
#include <string.h>

enum {
    // Messages of a kind that wait in LCM's queue; the newest beyond are lost, as on the network.
    // LCM's own 30 lose bursts; its unlimited queue could be filled without end. A tenth of a
    // second at 80,000 messages a second.
    QUEUE_CAPACITY = 8192,
    BUFFER_ADVISED = 1000000, // [bytes] below this bursts of outcomes are lost
};

#if defined(__SANITIZE_ADDRESS__) || defined(__clang__) // clang names it otherwise
// LCM loses 56 bytes for each lcm_t: the lock of lcm_handle(), which lcm_destroy() forgets.
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:lcm_handle\n";
}
#endif

struct wire_settings wire_settings_default(void)
{
    return (struct wire_settings){.url = "memq://", .mtu = WIRE_MTU_DEFAULT};
}

static struct wire_port *port_of(struct wire *wire, enum wire_kind kind)
{
    return &wire->ports[wire->url.memq ? 0 : check_kind(kind)->port];
}

// ---- Opening and closing LCM ----

static unsigned port_count(const struct wire *wire)
{
    return wire->url.memq ? 1 : WIRE_PORT_COUNT;
}

static enum status too_many_files(struct error *error)
{
    return error_set(error, STATUS_NETWORK,
                     "too many files are open in this process: LCM needs descriptors below %d",
                     GUARD_DESCRIPTORS);
}

// Keeps the kernel's drop count of a socket that goes or is asked about.
static void count_dropped(struct wire *wire, struct wire_port *port)
{
    if (port->socket < 0)
        return;
    uint32_t dropped = guard_dropped(port->socket);
    wire->counters.dropped += (uint32_t)(dropped - port->dropped_last);
    port->dropped_last = dropped;
}

static void close_port(struct wire *wire, struct wire_port *port)
{
    count_dropped(wire, port);
    if (port->lcm != NULL)
        lcm_destroy(port->lcm); // ends its thread and its subscriptions
    *port = (struct wire_port){.socket = -1};
}

static void close_ports(struct wire *wire)
{
    for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
        close_port(wire, &wire->ports[i]);
    link_close(wire->link);
    wire->link = NULL;
    wire->queued = 0;
}

static enum status open_port(struct wire *wire, unsigned index, struct error *error)
{
    char url[URL_LCM_SIZE];
    struct guard_descriptors before;
    struct quiet quiet;
    if (!guard_room())
        return too_many_files(error);
    guard_look(&before);
    quiet_start(&quiet);
    wire->ports[index].lcm = lcm_create(url_lcm(&wire->url, index, url));
    quiet_end(&quiet);
    guard_claim(&before, 0);
    if (wire->ports[index].lcm == NULL)
        return error_set(error, STATUS_NETWORK, "LCM cannot open %s: %s", url, quiet.text);
    return STATUS_OK;
}

static void on_link(void *user, const char *channel, const uint8_t *data, size_t size);

static enum status open_link(struct wire *wire, struct error *error)
{
    struct sockaddr_in hub = url_socket_address(&wire->url, 0);
    enum status status = link_open(&wire->link, &hub, on_link, wire, error);
    if (status == STATUS_OK)
        link_wait(wire->link, LINK_OPEN_WAIT_MS);
    return status;
}

static enum status open_ports(struct wire *wire, struct error *error)
{
    enum status status = STATUS_OK;
    if (wire->url.tcpq)
        return open_link(wire, error);
    if (!wire->url.memq)
        status = probe_route(&wire->url, error);
    for (unsigned i = 0; i < port_count(wire) && status == STATUS_OK; i++)
        status = open_port(wire, i, error);
    if (status != STATUS_OK)
        close_ports(wire);
    return status;
}

static void report_buffer(struct wire *wire, const struct wire_port *port)
{
    uint32_t *least = &wire->counters.buffer_size;
    if (port->buffer_size < BUFFER_ADVISED && !wire->buffer_noted)
        log_note("the kernel grants a receive buffer of %u bytes only, which may lose messages: "
                 "'sysctl -w net.core.rmem_max=%d' (root) raises its limit",
                 port->buffer_size, wire->url.receive_buffer);
    wire->buffer_noted |= port->buffer_size < BUFFER_ADVISED;
    if (*least == 0 || port->buffer_size < *least)
        *least = port->buffer_size;
}

// Makes LCM bind the port and start its thread, with nothing subscribed to, and puts the guard up.
static enum status listen_udpm(struct wire *wire, unsigned index, struct error *error)
{
    struct wire_port *port = &wire->ports[index];
    struct guard guard;
    struct quiet quiet;
    if (!guard_room())
        return too_many_files(error);
    enum status status = probe_port(&wire->url, index, error);
    if (status != STATUS_OK)
        return status;
    quiet_start(&quiet);
    guard_arm(&guard, index, (uint16_t)(wire->url.port + index), wire->url.receive_buffer);
    int descriptor = lcm_get_fileno(port->lcm); // LCM's self test: ten seconds if it fails
    port->socket = guard_disarm(&guard);
    quiet_end(&quiet);
    if (descriptor < 0)
        return error_set(error, STATUS_NETWORK, "LCM cannot listen on port %u: %s",
                         wire->url.port + index, quiet.text);
    if (port->socket < 0)
        return error_set(error, STATUS_NETWORK,
                         "the kernel refuses the filter that protects LCM on port %u",
                         wire->url.port + index);
    port->dropped_last = guard_dropped(port->socket);
    port->buffer_size = guard_buffer(port->socket);
    report_buffer(wire, port);
    return STATUS_OK;
}

static enum status listen_port(struct wire *wire, unsigned index, struct error *error)
{
    struct wire_port *port = &wire->ports[index];
    if (port->listening)
        return STATUS_OK;
    if (port->lcm == NULL)
        return error_set(error, STATUS_NETWORK, "LCM is not open");
    enum status status = wire->url.memq ? STATUS_OK : listen_udpm(wire, index, error);
    port->listening = status == STATUS_OK;
    return status;
}

// ---- Receiving ----

static void note_rejected(const struct wire *wire, enum wire_kind kind, enum check_result result)
{
    uint64_t count = wire->counters.rejected;
    if ((count & (count - 1)) == 0) // the 1st, 2nd, 4th, ...: a flood gives few lines
        log_debug("message %" G_GUINT64_FORMAT " rejected: on %s with %s", count,
                  check_kind(kind)->channel, check_result_text(result));
}

void wire_stranger(struct wire *wire, enum wire_kind kind, enum stranger stranger)
{
    wire->counters.rejected++;
    wire->counters.unopened++;
    if (!stranger_heard(&wire->strangers, stranger, 1, clock_monotonic_ns()))
        note_rejected(wire, kind, CHECK_TAG);
}

void wire_take(struct wire_slot *slot, enum check_result result, union codec_message *received)
{
    struct wire *wire = slot->wire;
    if (result == CHECK_FOREIGN) {
        wire->counters.foreign++;
        wire->counters.foreign_protocol = received->header.protocol;
        return;
    }
    if (result != CHECK_GOOD) {
        wire->counters.rejected++;
        note_rejected(wire, slot->kind, result);
        return;
    }
    wire->counters.received++;
    sequence_hear(wire->heard, (uint64_t)received->header.sender, slot->kind,
                  (uint32_t)received->header.sequence);
    slot->handler(slot->user, slot->kind, received);
    codec_release(slot->kind, received);
}

static void receive_packet(struct wire_slot *slot, const uint8_t *packet, size_t size)
{
    union codec_message message;
    if (slot->wire->key != NULL)
        door_receive(slot, packet, size);
    else if (seal_is(packet, size))
        wire_stranger(slot->wire, slot->kind, STRANGER_SEALED);
    else
        wire_take(slot, check_packet(slot->kind, packet, size, &message), &message);
}

static void receive(const lcm_recv_buf_t *received, const char *channel, void *user)
{
    (void)channel; // LCM's subscription is for the slot's channel exactly
    receive_packet(user, received->data, received->data_size);
}

// From the hub, which may send what nobody subscribed to.
static void on_link(void *user, const char *channel, const uint8_t *data, size_t size)
{
    struct wire *wire = user;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if (wire->slots[kind].handler != NULL && strcmp(channel, check_kind(kind)->channel) == 0)
            receive_packet(&wire->slots[kind], data, size);
}

static enum status subscribe(struct wire *wire, enum wire_kind kind, struct error *error)
{
    const struct check_kind *layout = check_kind(kind);
    if (wire->link != NULL) {
        link_subscribe(wire->link, layout->channel);
        return STATUS_OK;
    }
    enum status status = listen_port(wire, wire->url.memq ? 0 : layout->port, error);
    if (status != STATUS_OK)
        return status;
    lcm_subscription_t *subscription =
        lcm_subscribe(port_of(wire, kind)->lcm, layout->channel, receive, &wire->slots[kind]);
    if (subscription == NULL)
        return error_set(error, STATUS_NETWORK, "LCM cannot subscribe to %s", layout->channel);
    lcm_subscription_set_queue_capacity(subscription, QUEUE_CAPACITY);
    return STATUS_OK;
}

enum status wire_subscribe(struct wire *wire, enum wire_kind kind, wire_handler *handler,
                           void *user, struct error *error)
{
    assert(kind < WIRE_KIND_COUNT && handler != NULL && !wire->dispatching);
    struct wire_slot *slot = &wire->slots[kind];
    if (slot->handler == NULL) {
        enum status status = subscribe(wire, kind, error);
        if (status != STATUS_OK)
            return status;
    }
    slot->handler = handler;
    slot->user = user;
    slot->overheard = false;
    return STATUS_OK;
}

enum status wire_overhear(struct wire *wire, enum wire_kind kind, wire_handler *handler, void *user,
                          struct error *error)
{
    enum status status = wire_subscribe(wire, kind, handler, user, error);
    wire->slots[kind].overheard = status == STATUS_OK;
    return status;
}

size_t wire_descriptors(const struct wire *wire, int descriptors[WIRE_PORT_COUNT])
{
    size_t count = 0;
    if (wire->link != NULL)
        descriptors[count++] = link_descriptor(wire->link);
    for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
        if (wire->ports[i].listening)
            descriptors[count++] = lcm_get_fileno(wire->ports[i].lcm);
    return count;
}

// One message from each port that has some. lcm_handle() takes exactly one, and blocks when there
// is none, so it is called only when its descriptor is readable.
static size_t handle_round(struct wire *wire, size_t limit)
{
    struct pollfd ready[WIRE_PORT_COUNT];
    size_t handled = 0;
    for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
        ready[i] = (struct pollfd){
            .fd = wire->ports[i].listening ? lcm_get_fileno(wire->ports[i].lcm) : -1,
            .events = POLLIN};
    if (poll(ready, WIRE_PORT_COUNT, 0) <= 0)
        return 0;
    for (unsigned i = 0; i < WIRE_PORT_COUNT && handled < limit; i++) {
        if ((ready[i].revents & POLLIN) == 0)
            continue;
        if (wire->queued > 0)
            wire->queued--;
        if (lcm_handle(wire->ports[i].lcm) == 0)
            handled++;
    }
    return handled;
}

size_t wire_dispatch(struct wire *wire, size_t limit)
{
    assert(!wire->dispatching);
    size_t handled = 0, round = 1;
    wire->dispatching = true;
    if (wire->door != NULL)
        door_tick(wire, clock_monotonic_ns());
    if (wire->link != NULL)
        handled = link_dispatch(wire->link, limit);
    while (wire->link == NULL && handled < limit && round > 0) {
        round = handle_round(wire, limit - handled);
        handled += round;
    }
    wire->dispatching = false;
    return handled;
}

uint64_t wire_heard(const struct wire *wire)
{
    return wire->counters.received;
}

// ---- Sending ----

enum status wire_send(struct wire *wire, enum wire_kind kind, size_t size)
{
    struct wire_port *port = port_of(wire, kind);
    bool queues = wire->url.memq && wire->slots[kind].handler != NULL;
    bool full = queues && wire->queued >= QUEUE_CAPACITY;
    const char *channel = check_kind(kind)->channel;
    bool sent = wire->link != NULL
                    ? link_send(wire->link, channel, wire->packet, size)
                    : port->lcm != NULL && !full &&
                          lcm_publish(port->lcm, channel, wire->packet, (unsigned)size) == 0;
    if (!sent) {
        wire->counters.failed++;
        return STATUS_NETWORK;
    }
    wire->queued += queues;
    wire->counters.published++;
    return STATUS_OK;
}

// Room before and behind the encoded message in a packet. [bytes]
static size_t room_before(const struct wire *wire)
{
    return wire->key != NULL ? SEAL_HEAD_SIZE : 0;
}

static size_t room_both(const struct wire *wire)
{
    return wire->key != NULL ? SEAL_SIZE : TAG_SIZE;
}

enum status wire_publish(struct wire *wire, enum wire_kind kind, void *message)
{
    assert(kind < WIRE_KIND_COUNT);
    struct wire_slot *slot = &wire->slots[kind];
    sobox_header_t *header = message;
    header->protocol = WIRE_PROTOCOL;
    header->sequence = (int32_t)slot->sequence;
    header->sender = (int64_t)wire->sender;
    if (!check_fields(kind, message)) {
        log_debug("not sent: a message on %s with %s", check_kind(kind)->channel,
                  check_result_text(CHECK_FIELD));
        return STATUS_INVALID;
    }
    size_t size = codec_encoded_size(kind, message);
    if (size + room_both(wire) > wire->mtu ||
        !codec_encode(kind, message, wire->packet + room_before(wire), size))
        return STATUS_INVALID;
    if (wire->key != NULL)
        door_seal(wire, kind, size);
    else
        tag_compute(wire->packet + size, check_kind(kind)->channel, wire->packet, size);
    // A number is used up even when sending fails: receivers then count the loss that it is.
    slot->sequence++;
    return wire_send(wire, kind, size + room_both(wire));
}

size_t wire_payload_max(const struct wire *wire, enum wire_kind kind)
{
    const struct check_kind *layout = check_kind(kind);
    size_t rest = wire->mtu - layout->fixed_size - room_both(wire);
    return layout->unit == 0 ? 0 : rest - rest % layout->unit;
}

// ---- The whole ----

// The door has seen to it already.
static void on_hail(void *user, enum wire_kind kind, const void *message)
{
    (void)user;
    (void)kind;
    (void)message;
}

enum status wire_open(struct wire **opened, const struct wire_settings *settings, uint64_t sender,
                      struct error *error)
{
    assert(sender != 0);
    *opened = NULL;
    struct url url;
    enum status status = url_parse(&url, settings->url, error);
    if (status != STATUS_OK)
        return status;
    if (settings->mtu < WIRE_MTU_DEFAULT || settings->mtu > WIRE_MTU_MAX)
        return error_set(error, STATUS_INVALID, "mtu: expected %d to %d bytes, found %u",
                         WIRE_MTU_DEFAULT, WIRE_MTU_MAX, settings->mtu);
    if (sodium_init() < 0)
        return error_set(error, STATUS_FAILED, "libsodium cannot be initialised");
    struct wire *wire = g_new0(struct wire, 1);
    wire->url = url;
    wire->mtu = settings->mtu;
    wire->sender = sender;
    wire->key = settings->key;
    wire->heard = sequence_create();
    for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
        wire->ports[i].socket = -1;
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT; kind++)
        wire->slots[kind] = (struct wire_slot){.wire = wire, .kind = kind};
    status = open_ports(wire, error);
    if (status == STATUS_OK && wire->key != NULL) {
        wire->door = door_create(wire);
        status = wire_subscribe(wire, WIRE_HAIL, on_hail, NULL, error);
    }
    if (status != STATUS_OK) {
        wire_close(wire);
        return status;
    }
    *opened = wire;
    return STATUS_OK;
}

void wire_close(struct wire *wire)
{
    if (wire == NULL)
        return;
    assert(!wire->dispatching);
    wire_source_detach(wire);
    close_ports(wire);
    sequence_free(wire->heard);
    door_free(wire->door);
    sodium_memzero(wire->opened, sizeof wire->opened);
    g_free(wire);
}

enum status wire_reopen(struct wire *wire, struct error *error)
{
    assert(!wire->dispatching);
    if (wire->url.memq)
        return STATUS_OK;
    if (wire->link != NULL) {
        link_reopen(wire->link);
        return STATUS_OK;
    }
    close_ports(wire);
    wire->counters.buffer_size = 0;
    enum status status = open_ports(wire, error);
    for (enum wire_kind kind = 0; kind < WIRE_KIND_COUNT && status == STATUS_OK; kind++)
        if (wire->slots[kind].handler != NULL)
            status = subscribe(wire, kind, error);
    if (status != STATUS_OK)
        close_ports(wire);
    return status;
}

bool wire_connected(const struct wire *wire)
{
    return wire->link == NULL || link_is_up(wire->link);
}

bool wire_leaves_machine(const struct wire *wire)
{
    return url_leaves_machine(&wire->url);
}

void wire_counters(struct wire *wire, struct wire_counters *counters)
{
    for (unsigned i = 0; i < WIRE_PORT_COUNT; i++)
        count_dropped(wire, &wire->ports[i]);
    if (wire->door != NULL)
        door_tick(wire, clock_monotonic_ns());
    wire->counters.lost = sequence_lost(wire->heard);
    *counters = wire->counters;
}
