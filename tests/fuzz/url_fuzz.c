// The text of an LCM URL. What is taken means the same when it is written anew.
#include "tests/fuzz/fuzz.h"

#include "common/wire/url.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct url url;
    struct error error;
    char lcm[URL_LCM_SIZE], *text = malloc(size + 1);
    assert(text != NULL);
    memcpy(text, data, size);
    text[size] = '\0';
    if (url_parse(&url, text, &error) == STATUS_OK) {
        for (unsigned port = 0; port < 3; port++)
            assert(strlen(url_lcm(&url, port, lcm)) < URL_LCM_SIZE);
        assert(url.memq || (url.port >= 1 && url.port <= URL_PORT_MAX));
    } else {
        assert(error.status == STATUS_INVALID && error.text[0] != '\0');
    }
    free(text);
    return 0;
}
