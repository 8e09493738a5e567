// What of a balance a person must hear, each with the slip that most likely made it.
//
// | compared                               | told beyond              | because
// | speed of the motion's first tenth      | 0.7 to 1.1 of the        | forces slow a car within
// the |                                        | vehicle's                | tenth; none speeds it
// up | place at t = 0 and the scenario's cog  | 0.05 m, 0.05 rad         | half a load cell's side
// | impulse in x and m dv                  | 10 % of m dv             | twice what a load cell wall
// |                                        |                          | and accelerometers miss (5
// %) | impulse in y and m dv                  | 10 % + 5 % of that in x  | no measured lateral
// closure | moment's impulse and I d(yaw rate)     | 25 % + that in x, 5 cm   | inertias are
// estimated, a cell |                                        | aside                    | knows its
// place to half its side | motion that the forces alone give      | 10 % of the travel       | a
// car is not one mass: 7 % in a |                                        | | measured full-frontal
// crash | force at the last time                 | 20 % of the greatest     | the crash is over by
// then
//
// Impossible, so that no curve is worth anything: a motion away from the barrier or a thousandth or
// a thousand times as fast as the vehicle's, a crash of more than 5 s, a travel beyond 50 m, a yaw
// beyond a full turn, an impulse below 1/50 or above 10 of m dv, forces that end as high as m dv in
// N s (they are impulses), and times of which fewer than three meet.
#ifndef SOBOX_WORKER_REDUCTION_DOUBTS_H
#define SOBOX_WORKER_REDUCTION_DOUBTS_H

#include "worker/reduction/balance.h"

enum {
    DOUBTS_MAX = 12,
    DOUBTS_TEXT_SIZE = 400, // [bytes] longer texts are cut
};

struct doubts {
    uint32_t count;
    bool impossible; // the last one says what cannot be meant
    char text[DOUBTS_MAX][DOUBTS_TEXT_SIZE];
};

// Writes what contradicts what. What cannot be meant ends the list: more would follow from it.
void doubts_find(struct doubts *doubts, const struct balance *balance,
                 const struct scenario *scenario);

#endif
