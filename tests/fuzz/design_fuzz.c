// A design of a scenario as CSV.
#include "tests/fuzz/fuzz.h"

#include "common/scenario/scenario_read.h"
#include "worker/models/design.h"

#include <assert.h>
#include <stdlib.h>

static const char text[] = "name: fuzz\n"
                           "vehicle: {mass: 1650, yaw_inertia: 3000, speed: 17.889}\n"
                           "barrier: {face_x: -2.08, edge_y: -0.455, overlap: 0.455}\n"
                           "springs:\n"
                           "  - name: front\n"
                           "    position: [-0.83, -0.75]\n"
                           "    deformation: [0.0, 1.2]\n"
                           "    force_x: {lower: 0, upper: [80e3, 450e3]}\n"
                           "    force_y: {lower: 0, upper: 250e3}\n"
                           "  - name: rear\n"
                           "    position: [-0.63, -0.75]\n"
                           "    deformation: [0.0, 1.2]\n"
                           "    force_x: {lower: 0, upper: [80e3, 450e3]}\n"
                           "    force_y: {lower: 0, upper: 250e3}\n"
                           "response: any\n"
                           "firewall_distance: 0.25\n";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct scenario scenario;
    struct design design;
    struct error error = {0};
    if (scenario.text == NULL &&
        scenario_read_text(&scenario, "fuzz", text, sizeof text - 1, NULL, 0, &error) != STATUS_OK)
        abort();
    enum status status = design_parse(&design, &scenario, "fuzz", (const char *)data, size, &error);
    if (status == STATUS_OK)
        assert(design.spring_count == scenario.spring_count);
    else
        assert(status == STATUS_INVALID && error.text[0] != '\0');
    design_fini(&design);
    return 0;
}
