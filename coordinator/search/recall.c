#include "coordinator/search/recall.h"

#include <glib.h>
#include <string.h>

enum {
    RECALL_CHUNK = 1024, // samples made at once
    RECALL_GOOD = 512,   // good samples that a trim may anchor on
    RECALL_BAD = 2048,   // bad samples that are looked at: more would not tell more
};

// A step as it is gone through.
struct step {
    const struct sampling *sampling;
    const struct box *box;
    const struct verdict *verdicts;
    bool known;
};

void recall_init(struct recall *recall, const struct frame *frame)
{
    *recall = (struct recall){.frame = frame};
    cloud_init(&recall->good, frame->space.count);
    cloud_init(&recall->bad, frame->space.count);
    recall->chunk = g_new(double, (size_t)frame->all.count *RECALL_CHUNK);
}

void recall_fini(struct recall *recall)
{
    cloud_fini(&recall->good);
    cloud_fini(&recall->bad);
    g_free(recall->chunk);
    *recall = (struct recall){0};
}

// Makes chosen samples of the step again and adds them to a cloud.
static void remake(const struct recall *recall, const struct step *step, const uint32_t *chosen,
                   uint32_t count, struct cloud *cloud)
{
    sampling_pick(step->sampling, step->box, chosen, count, recall->chunk, RECALL_CHUNK);
    cloud_reserve(cloud, count);
    for (uint32_t v = 0; v < cloud->variables; v++)
        memcpy(cloud->values + (size_t)v * cloud->capacity + cloud->count,
               recall->chunk + (size_t)recall->frame->variables[v] * RECALL_CHUNK,
               count * sizeof *cloud->values);
    for (uint32_t i = 0; i < count; i++)
        cloud->violation[cloud->count + i] = step->known ? step->verdicts[chosen[i]].violation : 1;
    cloud->count += count;
}

// Makes those samples of the step again that are good, or bad, until there are `most`; returns how
// many of the step had to be looked at.
static uint32_t remake_first(const struct recall *recall, const struct step *step, bool good,
                             uint32_t most, struct cloud *cloud)
{
    const uint32_t samples = step->sampling->samples;
    uint32_t chosen[RECALL_CHUNK];
    uint32_t count = 0;
    uint32_t at = 0;
    cloud_clear(cloud);
    for (; at < samples && cloud->count + count < most; at++) {
        if ((step->verdicts[at].violation == VERDICT_GOOD) != good)
            continue;
        chosen[count++] = at;
        if (count == RECALL_CHUNK) {
            remake(recall, step, chosen, count, cloud);
            count = 0;
        }
    }
    if (count > 0)
        remake(recall, step, chosen, count, cloud);
    return at;
}

void recall_step(struct recall *recall, const struct sampling *sampling, const struct box *box,
                 const struct verdict *verdicts, uint32_t good_count, bool known)
{
    const struct step step = {
        .sampling = sampling, .box = box, .verdicts = verdicts, .known = known};
    remake_first(recall, &step, true, RECALL_GOOD, &recall->good);
    // Where nothing is good yet, the least violating sample is sought among all.
    const uint32_t most = good_count > 0 ? RECALL_BAD : UINT32_MAX;
    recall->looked_at = remake_first(recall, &step, false, most, &recall->bad);
}
