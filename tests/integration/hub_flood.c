// hub_flood ADDRESS PORT CHANNEL COUNT SIZE: connects to a hub as an LCM client and publishes COUNT
// messages of SIZE bytes that mean nothing, as fast as it can. Ends well when the hub took them
// all.
#include "common/wire/frame.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static int send_all(int hub, const uint8_t *bytes, size_t size)
{
    while (size > 0) {
        ssize_t sent = send(hub, bytes, size, MSG_NOSIGNAL);
        if (sent <= 0)
            return 1;
        bytes += sent;
        size -= (size_t)sent;
    }
    return 0;
}

int main(int argc, char **argv)
{
    struct sockaddr_in address = {.sin_family = AF_INET};
    uint8_t head[FRAME_HEAD_MAX];
    if (argc != 6 || inet_pton(AF_INET, argv[1], &address.sin_addr) != 1)
        return 2;
    address.sin_port = htons((uint16_t)atoi(argv[2]));
    size_t size = (size_t)atoi(argv[5]);
    uint8_t *data = calloc(size, 1);
    int hub = socket(AF_INET, SOCK_STREAM, 0);
    if (data == NULL || connect(hub, (const struct sockaddr *)&address, sizeof address) != 0)
        return 1;
    frame_hello(FRAME_CLIENT, head);
    if (send_all(hub, head, FRAME_HELLO_SIZE) != 0 || recv(hub, head, FRAME_HELLO_SIZE, 0) <= 0)
        return 1;
    size_t head_size = frame_head(head, FRAME_PUBLISH, argv[3], strlen(argv[3]), size);
    for (int i = atoi(argv[4]); i > 0; i--)
        if (send_all(hub, head, head_size) != 0 || send_all(hub, data, size) != 0)
            return 1;
    // What the hub has not read yet must not be thrown away with the connection.
    shutdown(hub, SHUT_WR);
    while (recv(hub, head, sizeof head, 0) > 0)
        continue;
    close(hub);
    free(data);
    return 0;
}
