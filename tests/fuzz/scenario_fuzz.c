// The text of a scenario, as it comes from a file or from the network. What cannot be taken is
// refused with a sentence.
#include "tests/fuzz/fuzz.h"

#include "common/scenario/scenario_read.h"

#include <assert.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct scenario scenario;
    struct error error = {0};
    enum status status =
        scenario_read_text(&scenario, "fuzz", (const char *)data, size, NULL, 0, &error);
    if (status == STATUS_OK)
        assert(scenario.design_space.count > 0);
    else
        assert(status == STATUS_INVALID && error.text[0] != '\0');
    scenario_fini(&scenario);
    return 0;
}
