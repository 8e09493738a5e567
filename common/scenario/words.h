// The words of a scenario file in the order of their enums, each list ending with NULL: what the
// reader accepts is what the *_name() functions answer.
#ifndef SOBOX_COMMON_SCENARIO_WORDS_H
#define SOBOX_COMMON_SCENARIO_WORDS_H

extern const char *const scenario_model_words[];
extern const char *const scenario_profile_words[];
extern const char *const scenario_integrator_words[];
extern const char *const scenario_reloading_words[];
extern const char *const scenario_response_words[];
extern const char *const scenario_sampling_words[];
extern const char *const scenario_promise_words[];

#endif
