#include "tests/cluster/network.h"

#include <glib.h>
#include <stddef.h>

void network_init(struct network *network, struct dice *dice)
{
    *network = (struct network){.dice = dice};
}

void network_fini(struct network *network)
{
    struct packet *packet;
    while ((packet = network_receive(network, INT64_MAX)) != NULL)
        network_drop(packet);
    heap_fini(&network->packets);
}

static void network_launch(struct network *network, uint32_t from, uint32_t to,
                           const struct message *message, int64_t now_ns)
{
    const struct weather *weather = &network->weather;
    int64_t leave_ns = MAX(now_ns, network->free_ns[from]) + NETWORK_SEND_NS;
    network->free_ns[from] = leave_ns;
    int64_t delay_ns = (int64_t)weather->delay_ns + dice_wait_ns(network->dice, weather->jitter_ns);
    if (dice_chance(network->dice, weather->stray))
        delay_ns += dice_wait_ns(network->dice, weather->stray_ns);
    struct packet *packet = g_new0(struct packet, 1);
    packet->from = from;
    packet->to = to;
    packet->message = *message;
    packet->message.payload = g_memdup2(message->payload, message->payload_size);
    packet->due.tie = network->sent++;
    heap_put(&network->packets, &packet->due, leave_ns + delay_ns);
}

void network_send(struct network *network, uint32_t from, uint32_t to,
                  const struct message *message, int64_t now_ns)
{
    if (network->cut_until_ns[from][0] > now_ns || network->cut_until_ns[to][1] > now_ns)
        return;
    uint32_t copies = dice_chance(network->dice, network->weather.twice) ? 2 : 1;
    for (uint32_t i = 0; i < copies; i++) {
        if (!dice_chance(network->dice, network->weather.loss))
            network_launch(network, from, to, message, now_ns);
    }
}

int64_t network_wake_ns(const struct network *network)
{
    const struct heap_entry *first = heap_first(&network->packets);
    return first != NULL ? first->key : INT64_MAX;
}

struct packet *network_receive(struct network *network, int64_t now_ns)
{
    struct heap_entry *first = heap_first(&network->packets);
    if (first == NULL || first->key > now_ns)
        return NULL;
    heap_remove(&network->packets, first);
    return (struct packet *)((char *)first - offsetof(struct packet, due));
}

void network_drop(struct packet *packet)
{
    g_free((void *)packet->message.payload);
    g_free(packet);
}
