#include "coordinator/search/certificate.h"

#include "common/numeric/statistics.h"

#include <assert.h>

static const double certificate_alpha_first = 0.045;
static const double certificate_alpha_all = 0.05;

double certificate_alpha(uint32_t look)
{
    if (look == 0)
        return certificate_alpha_first;
    double left = certificate_alpha_all - certificate_alpha_first;
    for (uint32_t i = 0; i < look; i++)
        left /= 2;
    return left;
}

void certificate_look(struct certificate *certificate, uint64_t samples, uint64_t bad)
{
    assert(certificate->looks < CERTIFICATE_LOOKS);
    const double alpha = certificate_alpha(certificate->looks++);
    certificate->samples = samples;
    certificate->bad = bad;
    certificate->lower95 = statistics_share_lower(samples, bad, 1 - alpha);
}

void certificate_look_once(struct certificate *certificate, uint64_t samples, uint64_t bad)
{
    *certificate = (struct certificate){.looks = CERTIFICATE_LOOKS, .samples = samples, .bad = bad};
    certificate->lower95 = statistics_share_lower(samples, bad, 0.95);
}

int64_t certificate_bad_max(const struct certificate *certificate, uint64_t samples, double target)
{
    const double confidence = 1 - certificate_alpha(certificate->looks);
    int64_t least = -1;
    int64_t most = (int64_t)samples;
    // The bound falls as the number of bad samples rises.
    while (least < most) {
        int64_t middle = least + (most - least + 1) / 2;
        if (statistics_share_lower(samples, (uint64_t)middle, confidence) >= target)
            least = middle;
        else
            most = middle - 1;
    }
    return least;
}
