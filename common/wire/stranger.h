// Messages that no key of ours opens: counted, and told to the person now and then, because behind
// them is nearly always a program that was given another key, or none. Who floods the network gets
// a line each time the count has doubled, and not more than one in STRANGER_QUIET_NS.
#ifndef SOBOX_COMMON_WIRE_STRANGER_H
#define SOBOX_COMMON_WIRE_STRANGER_H

#include <stdbool.h>
#include <stdint.h>

#define STRANGER_QUIET_NS INT64_C(10000000000)

// Who they come from, from how many on the person is told, and what. A few messages of a sender
// that does not answer are those of a program that has just ended.
#define STRANGER_LIST(X)                                                                         \
    X(STRANGER_OTHER_KEY, 1,                                                                     \
      "that this program's key does not open: a program on this network has another --key-file") \
    X(STRANGER_NO_KEY, 1,                                                                        \
      "without a key: a program on this network runs without --key-file and is not listened to") \
    X(STRANGER_SEALED, 1,                                                                        \
      "sealed with a key: give this program the --key-file of those that sent them")             \
    X(STRANGER_SILENT, 10,                                                                       \
      "whose senders do not prove that they are there: recorded ones, or this machine is not "   \
      "heard by all it hears")

enum stranger {
#define STRANGER_ENUM(name, least, text) name,
    STRANGER_LIST(STRANGER_ENUM)
#undef STRANGER_ENUM
        STRANGER_COUNT
};

// What was heard of each, and told.
struct strangers {
    struct {
        uint64_t heard;
        uint64_t told; // of those, when the person was last told; 0: never
        int64_t told_ns;
    } of[STRANGER_COUNT];
};

// Counts `count` more, and says so when it is time (as a note, see common/base/log.h). Returns
// whether it did.
bool stranger_heard(struct strangers *strangers, enum stranger stranger, uint64_t count,
                    int64_t now_ns);

#endif
