// The part of a survey that is about a hub. It speaks the protocol itself, step by step, so that it
// can say which step fails.
#include "common/wire/survey_state.h"

#include "common/base/clock.h"
#include "common/wire/check.h"
#include "common/wire/frame.h"
#include "common/wire/link.h"
#include "common/wire/seal.h"

#include <errno.h>
#include <glib.h>
#include <poll.h>
#include <sodium.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    ECHOES = 20,
    INPUT_SIZE = 2 * WIRE_MTU_MAX,
    SENDERS_MAX = 1024,
    LISTEN_MS = 1500, // workers say each second that they are there [ms]
};

struct visit {
    struct survey *survey;
    int hub;
    char channel[32];          // of our own messages
    uint8_t input[INPUT_SIZE]; // what arrived
    size_t input_size;
    int64_t echoed_ns;             // when the last of our messages came back
    uint64_t senders[SENDERS_MAX]; // workers that were heard
    size_t sender_count;
    bool sealed, clear;
};

static bool wait_for(const struct visit *visit, short events, int milliseconds)
{
    struct pollfd ready = {.fd = visit->hub, .events = events};
    return poll(&ready, 1, milliseconds) > 0;
}

// ---- Reaching it ----

static void say_unreachable(struct survey *survey, int failed)
{
    const struct url *url = survey->url;
    if (failed == ECONNREFUSED)
        survey_say(survey, SURVEY_WRONG,
                   "no hub at %s:%u (connection refused): start 'sobox-hub --listen 0.0.0.0:%u' "
                   "there, or correct the URL",
                   url->address, url->port, url->port);
    else if (failed == ETIMEDOUT)
        survey_say(
            survey, SURVEY_WRONG,
            "%s:%u does not answer within %d s: the machine is off or its firewall drops TCP "
            "port %u ('nft add rule inet filter input tcp dport %u accept' there lets it in)",
            url->address, url->port, SURVEY_HUB_MS / 1000, url->port, url->port);
    else
        survey_say(survey, SURVEY_WRONG,
                   "%s:%u cannot be reached (%s): 'ip route get %s' shows which way there is",
                   url->address, url->port, g_strerror(failed), url->address);
}

static bool reach(struct visit *visit)
{
    struct sockaddr_in address = url_socket_address(visit->survey->url, 0);
    int failed = 0;
    socklen_t size = sizeof failed;
    visit->hub = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (connect(visit->hub, (const struct sockaddr *)&address, sizeof address) != 0)
        failed = errno;
    if (failed == EINPROGRESS) {
        failed = ETIMEDOUT;
        if (wait_for(visit, POLLOUT, SURVEY_HUB_MS))
            getsockopt(visit->hub, SOL_SOCKET, SO_ERROR, &failed, &size);
    }
    if (failed == 0) {
        link_tune(visit->hub);
        return true;
    }
    say_unreachable(visit->survey, failed);
    return false;
}

static bool put(struct visit *visit, const void *bytes, size_t size)
{
    // Small messages into an empty socket: they fit, or the connection is lost.
    return send(visit->hub, bytes, size, MSG_NOSIGNAL) == (ssize_t)size;
}

static bool greet(struct visit *visit)
{
    uint8_t hello[FRAME_HELLO_SIZE];
    frame_hello(FRAME_CLIENT, hello);
    bool answered = put(visit, hello, sizeof hello) && wait_for(visit, POLLIN, SURVEY_HUB_MS) &&
                    recv(visit->hub, hello, sizeof hello, 0) == sizeof hello;
    if (answered && frame_is_hello(FRAME_HUB, hello)) {
        survey_say(visit->survey, SURVEY_GOOD, "a hub answers at %s:%u",
                   visit->survey->url->address, visit->survey->url->port);
        return true;
    }
    survey_say(visit->survey, SURVEY_WRONG,
               "what listens at %s:%u %s: another program, or a hub that hangs",
               visit->survey->url->address, visit->survey->url->port,
               answered ? "does not speak LCM's protocol" : "does not say hello");
    return false;
}

// ---- Messages ----

static void note_sender(struct visit *visit, uint64_t sender)
{
    for (size_t i = 0; i < visit->sender_count; i++)
        if (visit->senders[i] == sender)
            return;
    if (visit->sender_count < SENDERS_MAX)
        visit->senders[visit->sender_count++] = sender;
}

static void take_status(struct visit *visit, const struct frame *frame)
{
    static uint8_t opened[WIRE_MTU_MAX];
    union codec_message message;
    struct seal_origin origin;
    const char *channel = check_kind(WIRE_WORKER_STATUS)->channel;
    const struct key *key = visit->survey->key;
    bool sealed = seal_is(frame->data, frame->data_size);
    visit->sealed |= sealed;
    visit->clear |= !sealed;
    if (sealed && key != NULL &&
        seal_open(opened, frame->data, frame->data_size, channel, key, &origin))
        note_sender(visit, origin.sender);
    if (!sealed && key == NULL &&
        check_packet(WIRE_WORKER_STATUS, frame->data, frame->data_size, &message) == CHECK_GOOD) {
        note_sender(visit, (uint64_t)message.header.sender);
        codec_release(WIRE_WORKER_STATUS, &message);
    }
}

// Reads what is there now; false when the connection is lost.
static bool take(struct visit *visit)
{
    struct frame frame;
    size_t place = 0;
    ssize_t got = recv(visit->hub, visit->input + visit->input_size, INPUT_SIZE - visit->input_size,
                       MSG_DONTWAIT);
    if (got <= 0)
        return got < 0 && (errno == EAGAIN || errno == EINTR);
    visit->input_size += (size_t)got;
    for (;;) {
        enum frame_result result = frame_read(FRAME_HUB, visit->input + place,
                                              visit->input_size - place, WIRE_MTU_MAX, &frame);
        if (result == FRAME_CUT)
            break;
        if (result != FRAME_WHOLE)
            return false;
        if (frame.name_size == strlen(visit->channel) &&
            memcmp(frame.name, visit->channel, frame.name_size) == 0)
            visit->echoed_ns = clock_monotonic_ns();
        else
            take_status(visit, &frame);
        place += frame.size;
    }
    memmove(visit->input, visit->input + place, visit->input_size - place);
    visit->input_size -= place;
    return true;
}

static void subscribe(struct visit *visit, const char *channel)
{
    uint8_t bytes[FRAME_HEAD_MAX];
    put(visit, bytes, frame_head(bytes, FRAME_SUBSCRIBE, channel, strlen(channel), 0));
}

// Sends a message to itself; returns how long it took, or -1. [ns]
static int64_t echo(struct visit *visit, uint64_t number)
{
    uint8_t bytes[FRAME_HEAD_MAX + SEAL_SIZE + 8] = {0}, packet[SEAL_SIZE + 8] = {0};
    const struct key *key = visit->survey->key;
    size_t size = key != NULL ? sizeof packet : 8;
    if (key != NULL) {
        struct seal_origin origin = {.sender = 1, .number = number};
        randombytes_buf(&origin.salt, sizeof origin.salt);
        seal_close(packet, 8, visit->channel, key, WIRE_PROTOCOL, &origin);
    }
    size_t head = frame_head(bytes, FRAME_PUBLISH, visit->channel, strlen(visit->channel), size);
    memcpy(bytes + head, packet, size);
    int64_t sent_ns = clock_monotonic_ns(),
            end_ns = sent_ns + SURVEY_HUB_MS / 2 * CLOCK_MILLISECOND_NS;
    visit->echoed_ns = 0;
    if (!put(visit, bytes, head + size))
        return -1;
    while (visit->echoed_ns == 0 && clock_monotonic_ns() < end_ns)
        if (wait_for(visit, POLLIN, 50) && !take(visit))
            return -1;
    return visit->echoed_ns == 0 ? -1 : visit->echoed_ns - sent_ns;
}

static int by_size(const void *a, const void *b)
{
    int64_t left = *(const int64_t *)a, right = *(const int64_t *)b;
    return (left > right) - (left < right);
}

static bool look_at_echo(struct visit *visit)
{
    int64_t took_ns[ECHOES];
    for (uint64_t i = 0; i < ECHOES; i++) {
        took_ns[i] = echo(visit, i + 1);
        if (took_ns[i] >= 0)
            continue;
        survey_say(visit->survey, SURVEY_WRONG,
                   "the hub does not pass this program's messages on: it has %s",
                   visit->survey->key == NULL
                       ? "a key; give this program the same with --key-file"
                       : "another key, or hangs; the same --key-file is needed everywhere");
        return false;
    }
    qsort(took_ns, ECHOES, sizeof took_ns[0], by_size);
    survey_say(visit->survey, SURVEY_GOOD, "messages come back through it, after %.2f ms",
               (double)took_ns[ECHOES / 2] * 1e-6);
    return true;
}

static void look_at_workers(struct visit *visit)
{
    int64_t end_ns = clock_monotonic_ns() + LISTEN_MS * CLOCK_MILLISECOND_NS;
    while (clock_monotonic_ns() < end_ns)
        if (wait_for(visit, POLLIN, 50) && !take(visit))
            break;
    const char *key = "the same --key-file is needed everywhere";
    if (visit->sealed && visit->survey->key == NULL)
        survey_say(visit->survey, SURVEY_WRONG, "workers seal their messages with a key: %s", key);
    if (visit->clear && visit->survey->key != NULL)
        survey_say(visit->survey, SURVEY_WRONG, "there are workers without a key: %s", key);
    if (visit->sender_count == 0)
        survey_say(visit->survey, SURVEY_NOTE,
                   "no worker%s is heard at the hub: start some with the same URL",
                   visit->survey->key != NULL ? " with this key" : "");
    else
        survey_say(visit->survey, SURVEY_GOOD, "%zu worker%s there", visit->sender_count,
                   visit->sender_count == 1 ? " is" : "s are");
}

void survey_hub(struct survey *survey)
{
    struct visit *visit = g_new0(struct visit, 1);
    visit->survey = survey;
    g_snprintf(visit->channel, sizeof visit->channel, "SOBOX_CHECK_%08x", randombytes_random());
    if (reach(visit) && greet(visit)) {
        subscribe(visit, visit->channel);
        subscribe(visit, check_kind(WIRE_WORKER_STATUS)->channel);
        if (look_at_echo(visit))
            look_at_workers(visit);
    }
    if (visit->hub >= 0)
        close(visit->hub);
    g_free(visit);
}
