// A survey on its way; for the sources of this folder only.
#ifndef SOBOX_COMMON_WIRE_SURVEY_STATE_H
#define SOBOX_COMMON_WIRE_SURVEY_STATE_H

#include "common/wire/survey.h"

struct survey {
    const struct url *url;
    const struct key *key;
    survey_teller *tell;
    void *user;
    unsigned wrong;
};

// Passes a finding on.
void survey_say(struct survey *survey, enum survey_verdict verdict, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// The part that is about a hub.
void survey_hub(struct survey *survey);

#endif
