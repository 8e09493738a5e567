#include "common/wire/key.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <sodium.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEADER "sobox-key 1 (secret: whoever has it can take part)"

enum {
    HEX_SIZE = 2 * KEY_SIZE,
    TEXT_SIZE = sizeof HEADER - 1 + 1 + HEX_SIZE + 1, // [bytes] header, newline, digits, newline
    TEXT_SIZE_MAX = TEXT_SIZE + 8,                    // with the line ends of other systems
};

// ---- Writing ----

static bool write_all(int file, const char *text, size_t size)
{
    while (size > 0) {
        ssize_t written = write(file, text, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        text += written;
        size -= (size_t)written;
    }
    return true;
}

// The text of a fresh key, with a NUL behind it.
static void draw(char text[TEXT_SIZE + 1])
{
    uint8_t bytes[KEY_SIZE];
    char hex[HEX_SIZE + 1];
    randombytes_buf(bytes, sizeof bytes);
    sodium_bin2hex(hex, sizeof hex, bytes, sizeof bytes);
    snprintf(text, TEXT_SIZE + 1, "%s\n%s\n", HEADER, hex);
    sodium_memzero(bytes, sizeof bytes);
    sodium_memzero(hex, sizeof hex);
}

enum status key_write_new(const char *path, struct error *error)
{
    char text[TEXT_SIZE + 1];
    // O_EXCL follows no link either. The mode is there from the first moment on.
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file < 0 && errno == EEXIST)
        return error_set(error, STATUS_INVALID,
                         "%s is there already: a key is never overwritten; name another file, or "
                         "remove this one if no program uses it any more",
                         path);
    if (file < 0)
        return error_set(error, STATUS_IO, "%s: cannot make the key file: %s", path,
                         strerror(errno));
    draw(text);
    bool written = write_all(file, text, TEXT_SIZE) && fchmod(file, 0600) == 0 && fsync(file) == 0;
    int reason = errno;
    sodium_memzero(text, sizeof text);
    written = close(file) == 0 && written;
    if (written)
        return STATUS_OK;
    unlink(path);
    return error_set(error, STATUS_IO, "%s: cannot write the key: %s", path, strerror(reason));
}

// ---- Reading ----

static enum status check_file(int file, const char *path, struct error *error)
{
    struct stat about;
    if (fstat(file, &about) != 0)
        return error_set(error, STATUS_INVALID, "%s: cannot look at the key file: %s", path,
                         strerror(errno));
    if (!S_ISREG(about.st_mode))
        return error_set(error, STATUS_INVALID, "%s: expected a key file, this is none", path);
    if (about.st_uid != geteuid() && about.st_uid != 0)
        return error_set(error, STATUS_INVALID,
                         "%s: this key belongs to user %u, who can read it: expected a file of "
                         "your own (copy it and 'chmod 600' the copy)",
                         path, (unsigned)about.st_uid);
    if ((about.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        return error_set(error, STATUS_INVALID,
                         "%s: others than its owner may use this key (mode %04o): 'chmod 600 %s'; "
                         "if somebody may have read it, make a new one",
                         path, (unsigned)(about.st_mode & 07777), path);
    return STATUS_OK;
}

static enum status not_a_key(const char *path, struct error *error)
{
    return error_set(error, STATUS_INVALID,
                     "%s: not a key file: expected the line '%s' and a line of %d hexadecimal "
                     "digits, as 'sobox-coordinator --new-key FILE' writes them",
                     path, HEADER, HEX_SIZE);
}

// Reads up to `room` bytes; -1 when reading fails.
static ssize_t read_all(int file, char *text, size_t room)
{
    size_t size = 0;
    while (size < room) {
        ssize_t count = read(file, text + size, room - size);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return -1;
        if (count == 0)
            break;
        size += (size_t)count;
    }
    return (ssize_t)size;
}

// The header's line, then the digits, then nothing but blanks.
static bool parse(uint8_t bytes[KEY_SIZE], const char *text)
{
    size_t header = strlen(HEADER), size = 0;
    if (strncmp(text, HEADER, header) != 0)
        return false;
    text += header;
    text += *text == '\r';
    if (*text != '\n')
        return false;
    const char *end;
    if (sodium_hex2bin(bytes, KEY_SIZE, text + 1, strlen(text + 1), NULL, &size, &end) != 0 ||
        size != KEY_SIZE)
        return false;
    while (isspace((unsigned char)*end))
        end++;
    return *end == '\0';
}

struct key *key_create(const uint8_t bytes[KEY_SIZE])
{
    if (sodium_init() < 0)
        return NULL;
    struct key *key = sodium_malloc(sizeof *key);
    if (key == NULL)
        return NULL;
    memcpy(key->bytes, bytes, KEY_SIZE);
    sodium_mprotect_readonly(key);
    return key;
}

static enum status read_file(struct key **key, int file, const char *path, struct error *error)
{
    char text[TEXT_SIZE_MAX + 2] = "";
    uint8_t bytes[KEY_SIZE];
    ssize_t size = read_all(file, text, sizeof text - 1);
    enum status status = STATUS_OK;
    if (size < 0)
        status =
            error_set(error, STATUS_INVALID, "%s: cannot read the key: %s", path, strerror(errno));
    else if (size > TEXT_SIZE_MAX || !parse(bytes, text))
        status = not_a_key(path, error);
    else if ((*key = key_create(bytes)) == NULL)
        status = error_set(error, STATUS_FAILED, "no memory can be had for the key");
    sodium_memzero(text, sizeof text);
    sodium_memzero(bytes, sizeof bytes);
    return status;
}

enum status key_read(struct key **key, const char *path, struct error *error)
{
    *key = NULL;
    // Without waiting, should it be a pipe.
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0)
        return error_set(
            error, STATUS_INVALID, "%s: cannot read the key: %s%s", path, strerror(errno),
            errno == ENOENT ? " (make one with 'sobox-coordinator --new-key FILE')" : "");
    enum status status = check_file(file, path, error);
    if (status == STATUS_OK)
        status = read_file(key, file, path, error);
    close(file);
    return status;
}

void key_free(struct key *key)
{
    sodium_free(key); // wipes it first
}

const char *key_name(const struct key *key, char text[KEY_NAME_SIZE])
{
    static const char purpose[] = "sobox: name of a key";
    uint8_t name[crypto_generichash_BYTES_MIN];
    crypto_generichash(name, sizeof name, (const uint8_t *)purpose, sizeof purpose, key->bytes,
                       sizeof key->bytes);
    snprintf(text, KEY_NAME_SIZE, "%02x%02x-%02x%02x", name[0], name[1], name[2], name[3]);
    return text;
}
