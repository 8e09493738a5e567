// LCM as sobox uses it (design.md section 6): one object over memq:// inside a process, udpm://
// between processes and machines, or tcpq:// through a hub where there is no multicast, with the
// same messages and the same code.
//
//   port         channel                                       from         to
//   P   batches  SOBOX_BATCH SOBOX_DESIGNS SOBOX_TEXT          coordinator  workers
//   P+1 outcomes SOBOX_OUTCOME SOBOX_VALUES SOBOX_TEXT_REQUEST workers      coordinator
//   P+2 status   SOBOX_WORKER SOBOX_RUN SOBOX_SEARCH           all          all who watch
//
// P is the port of the URL. Three ports, because LCM 1.3.1 keeps groups apart by port only and
// every listener of a port costs each sender; a port is opened for listening only when one of its
// channels is subscribed to. With memq:// all channels share the one queue, with tcpq:// the one
// connection; the hub passes on only what is subscribed to.
//
// A received packet is borrowed bytes until proven: size within the channel's limits, fingerprint
// and protocol of this version, the tag behind the encoded message right (or, where a key is
// shared, its seal and its freshness: seal.h, fresh.h), counts that agree with the size, fields
// within the ranges their .lcm file states; only then it is decoded and handed on. Everything else
// is counted and dropped. LCM's own fragments never reach LCM: a kernel filter drops them, because
// LCM 1.3.1 can be crashed by them.
//
// Delivery is best effort: lost, doubled and reordered messages are normal and the protocol's
// business. One thread owns a wire; nothing here is called from another.
#ifndef SOBOX_COMMON_WIRE_WIRE_H
#define SOBOX_COMMON_WIRE_WIRE_H

#include "common/base/error.h"
#include "common/wire/key.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    WIRE_PROTOCOL = 4,       // version of the messages and their meaning
    WIRE_MTU_DEFAULT = 1400, // [bytes] a message with its tag fits one Ethernet frame
    WIRE_MTU_MAX = 60000,    // [bytes] above this LCM would fragment
    WIRE_PORT_COUNT = 3,
};

enum wire_kind {
    WIRE_SAMPLE_BATCH,  // sobox_sample_batch_t
    WIRE_TEXT,          // sobox_text_t
    WIRE_OUTCOME_BATCH, // sobox_outcome_batch_t
    WIRE_TEXT_REQUEST,  // sobox_text_request_t
    WIRE_WORKER_STATUS, // sobox_worker_status_t
    WIRE_RUN_STATUS,    // sobox_run_status_t
    WIRE_SEARCH_STATUS, // sobox_search_status_t
    WIRE_STEP_STATUS,   // sobox_step_status_t
    WIRE_CASES,         // sobox_cases_t
    WIRE_HAIL,          // sobox_hail_t; between the wires themselves, where a key is shared
    WIRE_DESIGN_BATCH,  // sobox_design_batch_t
    WIRE_VALUE_BATCH,   // sobox_value_batch_t
    WIRE_KIND_COUNT
};

struct wire_settings {
    // memq://, udpm://ADDRESS:PORT?ttl=N&recv_buf_size=BYTES or tcpq://ADDRESS:PORT.
    const char *url;
    uint32_t mtu; // [bytes] greatest message with its tag, WIRE_MTU_DEFAULT .. WIRE_MTU_MAX
    // Seals every message; those without it are not listened to. Borrowed until wire_close(). NULL:
    // messages travel in clear, with a checksum.
    const struct key *key;
};

// What went through, for status messages and for people.
struct wire_counters {
    uint64_t published;   // messages handed to LCM
    uint64_t failed;      // that LCM could not send
    uint64_t received;    // that passed every check
    uint64_t rejected;    // that failed one
    uint64_t unopened;    // of the rejected: that our key, or the lack of one, does not open
    uint64_t replayed;    // of the rejected: heard before, or sent before this wire was there
    uint64_t unproven;    // of the rejected: whose senders did not prove that they are there
    uint64_t foreign;     // of another protocol version (not counted as rejected)
    uint64_t lost;        // gaps in the senders' sequences
    uint64_t dropped;     // datagrams the kernel dropped: for want of buffer, or by the filter
    uint32_t buffer_size; // receive buffer the kernel granted [bytes]; least over the open ports;
                          // 0 with memq:// and tcpq://
    int32_t foreign_protocol; // version of the last foreign message
};

// A checked, decoded message: a pointer to the type that `kind` names, borrowed until the handler
// returns. Handlers may publish.
typedef void wire_handler(void *user, enum wire_kind kind, const void *message);

struct wire;

// Default settings: memq://, WIRE_MTU_DEFAULT, no key.
struct wire_settings wire_settings_default(void);

// Opens the wire. `sender` is this process's random number (not 0). Messages from the process
// itself are delivered too: over memq:// they are all there is. Complements the URL's options where
// they are missing (ttl=0, a generous recv_buf_size). A hub that is not there is waited for, with a
// note; until then publishing fails. Errors: STATUS_INVALID (URL that is not memq://,
// udpm://ADDRESS:PORT or tcpq://ADDRESS:PORT, port above 65533, not a multicast address, mtu out of
// range), STATUS_NETWORK (no multicast route: the text names the remedy; port in use by a program
// that does not share it; self test failed). With a key it listens on the status port from the
// start, and others hear it only if it is dispatched: they ask for a proof that it is there.
enum status wire_open(struct wire **wire, const struct wire_settings *settings, uint64_t sender,
                      struct error *error) MUST_USE;

// Closes it. NULL is fine.
void wire_close(struct wire *wire);

// Delivers messages of `kind` to `handler` from now on; one handler a kind. Opens the kind's port
// for listening.
// Errors: STATUS_NETWORK as wire_open().
enum status wire_subscribe(struct wire *wire, enum wire_kind kind, wire_handler *handler,
                           void *user, struct error *error) MUST_USE;

// Like wire_subscribe(), but with a key also messages of senders that have not proven that they are
// there, which may be recordings: whatever is made of them, a stranger can bring about. For workers
// among each other, which only count their kind, and whose proofs would be as many as their pairs.
// Who shows or uses what it hears subscribes; a proof is two messages, once.
enum status wire_overhear(struct wire *wire, enum wire_kind kind, wire_handler *handler, void *user,
                          struct error *error) MUST_USE;

// Sends a message: fills its header (protocol, sequence, sender; the caller sets header.run) and
// encodes it with its tag or seals it. Returns STATUS_OK when LCM took it, which proves nothing
// about delivery; STATUS_INVALID when it is larger than the mtu or a field is out of the range its
// .lcm file states; STATUS_NETWORK when LCM could not send it (with memq://: when its queue is
// full).
enum status wire_publish(struct wire *wire, enum wire_kind kind, void *message);

// File descriptors to poll for reading; fills at most WIRE_PORT_COUNT and returns how many there
// are. They change with wire_subscribe() and wire_reopen() only.
size_t wire_descriptors(const struct wire *wire, int descriptors[WIRE_PORT_COUNT]);

// Handles what has arrived, at most `limit` messages so that timers get their turn, and returns how
// many it handled. Never blocks.
size_t wire_dispatch(struct wire *wire, size_t limit);

// When the last message of any kind passed the checks on this process's listening ports, as a count
// that only grows: a process that hears nothing, not even itself, calls wire_reopen().
uint64_t wire_heard(const struct wire *wire);

// Closes LCM and opens it anew with the same subscriptions: after a route or an interface changed,
// LCM stays deaf without saying so. memq:// is left alone. After a failure the wire is silent and
// deaf (publishing gives STATUS_NETWORK) until another call succeeds. A lost hub needs no such
// call.
enum status wire_reopen(struct wire *wire, struct error *error) MUST_USE;

// Whether what is sent has somewhere to go: false while the hub of tcpq:// is away.
bool wire_connected(const struct wire *wire);

// The greatest number of payload bytes (bounds, packed verdicts, text piece, values) that a message
// of `kind` can carry within the mtu.
size_t wire_payload_max(const struct wire *wire, enum wire_kind kind);

// Whether messages can leave this machine: udpm:// with ttl above 0, tcpq:// to another machine.
bool wire_leaves_machine(const struct wire *wire);

void wire_counters(struct wire *wire, struct wire_counters *counters);

#endif
