// How OpenMP's threads wait for each other between two pieces of work.
//
// By default gcc's runtime spins for a while, which is right on a machine of one's own: a wait is
// some microseconds shorter. Where anything else runs, other workers, another run, the rest of an
// office computer, it burns the very time slices that the thread it waits for would need. Measured
// on two cores: a search of 165,000 designs over one worker process took 9 to 14 s spinning and 0.6
// to 2.2 s sleeping at a load average of 10; one of 70,200 designs inside one process 0.16 to 0.27
// s spinning and 0.15 to 0.19 s sleeping at a load average of 4.
#ifndef SOBOX_COMMON_BASE_WAIT_POLICY_H
#define SOBOX_COMMON_BASE_WAIT_POLICY_H

// Lets threads sleep while they wait, unless the user has set OMP_WAIT_POLICY. The runtime reads
// that variable before main() begins and never again, so this program is started anew in its place,
// under the same process number: call it first in main(), with what main() was given. Returns when
// there is nothing to do or this cannot be done; then threads wait as they will.
void wait_policy_sleep(char **argv);

#endif
