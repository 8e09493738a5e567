#include "monitor/http/host.h"

#include <arpa/inet.h>
#include <glib.h>
#include <stdlib.h>
#include <string.h>

// Splits "NAME:PORT", "[NAME]:PORT", "NAME" or "[NAME]"; the caller frees the name. `port` stays
// NULL where there is none.
static char *split(const char *text, const char **port)
{
    *port = NULL;
    if (text[0] == '[') {
        const char *end = strchr(text, ']');
        if (end == NULL || (end[1] != '\0' && end[1] != ':'))
            return NULL;
        if (end[1] == ':')
            *port = end + 2;
        return g_strndup(text + 1, (gsize)(end - text - 1));
    }
    const char *colon = strchr(text, ':');
    if (colon == NULL)
        return g_strdup(text);
    *port = colon + 1;
    return g_strndup(text, (gsize)(colon - text));
}

static bool port_parse(const char *text, uint16_t *port)
{
    guint64 number;
    if (!g_ascii_string_to_unsigned(text, 10, 0, UINT16_MAX, &number, NULL))
        return false;
    *port = (uint16_t)number;
    return true;
}

static bool name_parse(struct host_address *address, const char *name, uint16_t port)
{
    *address = (struct host_address){0};
    if (strcmp(name, "localhost") == 0)
        name = "127.0.0.1";
    if (inet_pton(AF_INET, name, &address->socket.v4.sin_addr) == 1) {
        address->socket.v4.sin_family = AF_INET;
        address->socket.v4.sin_port = htons(port);
        address->loopback = (ntohl(address->socket.v4.sin_addr.s_addr) >> 24) == IN_LOOPBACKNET;
        return true;
    }
    if (inet_pton(AF_INET6, name, &address->socket.v6.sin6_addr) == 1) {
        address->socket.v6.sin6_family = AF_INET6;
        address->socket.v6.sin6_port = htons(port);
        address->loopback = IN6_IS_ADDR_LOOPBACK(&address->socket.v6.sin6_addr);
        return true;
    }
    return false;
}

enum status host_parse(struct host_address *address, const char *text, struct error *error)
{
    const char *port_text;
    uint16_t port;
    g_autofree char *name = split(text, &port_text);
    if (name != NULL && port_text == NULL && port_parse(name, &port))
        return name_parse(address, "127.0.0.1", port) ? STATUS_OK : STATUS_FAILED;
    if (name == NULL || port_text == NULL || !port_parse(port_text, &port) ||
        !name_parse(address, name, port))
        return error_set(error, STATUS_INVALID,
                         "--http: expected ADDRESS:PORT, for instance 127.0.0.1:8765, found '%s'",
                         text);
    return STATUS_OK;
}

bool host_is_ours(const char *header, const char *machine)
{
    if (header == NULL || header[0] == '\0')
        return false;
    const char *port_text;
    uint16_t port = 0;
    g_autofree char *name = split(header, &port_text);
    if (name == NULL || (port_text != NULL && !port_parse(port_text, &port)))
        return false;
    struct in6_addr number;
    if (inet_pton(AF_INET, name, &number) == 1 || inet_pton(AF_INET6, name, &number) == 1)
        return true;
    if (g_ascii_strcasecmp(name, "localhost") == 0)
        return true;
    // "crash7" also as "crash7.example.com": a stranger cannot know the name, and who does and owns
    // a domain could only read what the whole network reads.
    const size_t length = strlen(machine);
    return length > 0 && g_ascii_strncasecmp(name, machine, length) == 0 && name[length] == '\0';
}
