#include "common/wire/url.h"

#include <arpa/inet.h>
#include <glib.h>
#include <stdio.h>
#include <string.h>

#define URL_EXAMPLE                                                                            \
    "expected memq://, udpm://ADDRESS:PORT, for instance udpm://239.255.76.67:7667?ttl=1, or " \
    "tcpq://ADDRESS:PORT of a hub"

#define HUB_EXAMPLE "tcpq://ADDRESS:PORT, for instance tcpq://192.168.1.10:7700"

// Decimal digits only: no sign, no blank, no octal.
static bool parse_number(const char *text, uint64_t lowest, uint64_t highest, uint64_t *number)
{
    return g_ascii_string_to_unsigned(text, 10, lowest, highest, number, NULL);
}

static enum status parse_option(struct url *url, const char *option, bool seen[2],
                                struct error *error)
{
    static const struct {
        const char *name;
        uint64_t lowest, highest;
    } known[2] = {{"ttl", 0, 255}, {"recv_buf_size", 4096, 1 << 30}};
    const char *equals = strchr(option, '=');
    size_t length = equals != NULL ? (size_t)(equals - option) : strlen(option);
    for (unsigned i = 0; i < 2; i++) {
        if (strlen(known[i].name) != length || memcmp(known[i].name, option, length) != 0)
            continue;
        uint64_t number = 0;
        if (seen[i])
            return error_set(error, STATUS_INVALID, "%s is given twice", known[i].name);
        if (equals == NULL || !parse_number(equals + 1, known[i].lowest, known[i].highest, &number))
            return error_set(error, STATUS_INVALID,
                             "%s: expected a number from %u to %u, found '%s'", known[i].name,
                             (unsigned)known[i].lowest, (unsigned)known[i].highest,
                             equals != NULL ? equals + 1 : "");
        seen[i] = true;
        if (i == 0)
            url->ttl = (uint8_t)number;
        else
            url->receive_buffer = (int32_t)number;
        return STATUS_OK;
    }
    return error_set(error, STATUS_INVALID, "unknown option '%s': expected ttl or recv_buf_size",
                     option);
}

static enum status parse_options(struct url *url, const char *options, struct error *error)
{
    bool seen[2] = {false, false};
    char **words = g_strsplit(options, "&", -1);
    enum status status = STATUS_OK;
    for (char **word = words; *word != NULL && status == STATUS_OK; word++)
        status = parse_option(url, *word, seen, error);
    g_strfreev(words);
    return status;
}

// `place` is ADDRESS:PORT.
static enum status parse_place(struct url *url, const char *place, struct error *error)
{
    const char *colon = strchr(place, ':');
    if (colon == NULL)
        return error_set(error, STATUS_INVALID, "the port is missing: " URL_EXAMPLE);
    size_t length = (size_t)(colon - place);
    struct in_addr address;
    if (length >= sizeof url->address)
        return error_set(error, STATUS_INVALID, "the address is no dotted number: " URL_EXAMPLE);
    memcpy(url->address, place, length);
    url->address[length] = '\0';
    if (inet_pton(AF_INET, url->address, &address) != 1)
        return error_set(error, STATUS_INVALID, "'%s' is no dotted number: " URL_EXAMPLE,
                         url->address);
    if (!IN_MULTICAST(ntohl(address.s_addr)))
        return error_set(error, STATUS_INVALID,
                         "%s is not a multicast address: expected 224.0.0.0 to 239.255.255.255",
                         url->address);
    uint64_t port = 0;
    if (!parse_number(colon + 1, 1, URL_PORT_MAX, &port))
        return error_set(error, STATUS_INVALID,
                         "port '%s': expected a number from 1 to %d (the two ports after it are "
                         "used too)",
                         colon + 1, URL_PORT_MAX);
    url->port = (uint16_t)port;
    return STATUS_OK;
}

// A hub's address is numeric, too: what LCM's own clients make of a name is this very host,
// whatever the name, so that a cluster with one of them would fall apart without a word.
static enum status parse_hub(struct url *url, const char *place, struct error *error)
{
    const char *colon = strchr(place, ':');
    struct in_addr address;
    uint64_t port = 0;
    if (strchr(place, '?') != NULL)
        return error_set(error, STATUS_INVALID, "tcpq:// has no options: expected " HUB_EXAMPLE);
    if (colon == NULL)
        return error_set(error, STATUS_INVALID, "the port is missing: expected " HUB_EXAMPLE);
    char *text = g_strndup(place, (size_t)(colon - place));
    bool dotted = inet_pton(AF_INET, text, &address) == 1 && address.s_addr != INADDR_ANY;
    g_strlcpy(url->address, dotted ? text : "", sizeof url->address);
    g_free(text);
    if (!dotted)
        return error_set(
            error, STATUS_INVALID,
            "'%.*s' is no address of a hub: expected numbers, for instance "
            "tcpq://192.168.1.10:7700 ('getent ahostsv4 NAME' tells a host's; LCM takes "
            "any name for this machine)",
            (int)(colon - place), place);
    if (IN_MULTICAST(ntohl(address.s_addr)))
        return error_set(error, STATUS_INVALID,
                         "%s is a multicast address: expected udpm:// before it, or the address of "
                         "a hub",
                         url->address);
    if (!parse_number(colon + 1, 1, UINT16_MAX, &port))
        return error_set(error, STATUS_INVALID, "port '%s': expected a number from 1 to %d",
                         colon + 1, UINT16_MAX);
    url->tcpq = true;
    url->port = (uint16_t)port;
    return STATUS_OK;
}

static enum status parse(struct url *url, const char *text, struct error *error)
{
    static const char scheme[] = "udpm://", hub_scheme[] = "tcpq://";
    *url = (struct url){.ttl = URL_TTL_DEFAULT, .receive_buffer = URL_RECEIVE_BUFFER_DEFAULT};
    if (strcmp(text, "memq://") == 0) {
        url->memq = true;
        return STATUS_OK;
    }
    if (g_str_has_prefix(text, hub_scheme))
        return parse_hub(url, text + strlen(hub_scheme), error);
    if (!g_str_has_prefix(text, scheme))
        return error_set(error, STATUS_INVALID, URL_EXAMPLE);
    char *place = g_strdup(text + strlen(scheme));
    char *options = strchr(place, '?');
    if (options != NULL)
        *options++ = '\0';
    enum status status = parse_place(url, place, error);
    if (status == STATUS_OK && options != NULL)
        status = parse_options(url, options, error);
    g_free(place);
    return status;
}

enum status url_parse(struct url *url, const char *text, struct error *error)
{
    enum status status = parse(url, text, error);
    if (status != STATUS_OK)
        error_wrap(error, "LCM URL '%s'", text);
    return status;
}

bool url_leaves_machine(const struct url *url)
{
    if (url->tcpq)
        return !g_str_has_prefix(url->address, "127.");
    return !url->memq && url->ttl > 0;
}

const char *url_lcm(const struct url *url, unsigned index, char text[URL_LCM_SIZE])
{
    if (url->memq)
        g_strlcpy(text, "memq://", URL_LCM_SIZE);
    else if (url->tcpq)
        snprintf(text, URL_LCM_SIZE, "tcpq://%s:%u", url->address, url->port);
    else
        snprintf(text, URL_LCM_SIZE, "udpm://%s:%u?ttl=%u&recv_buf_size=%d", url->address,
                 url->port + index, url->ttl, INT32_MAX);
    return text;
}

struct sockaddr_in url_socket_address(const struct url *url, unsigned index)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)(url->port + index))};
    inet_pton(AF_INET, url->address, &address.sin_addr);
    return address;
}
