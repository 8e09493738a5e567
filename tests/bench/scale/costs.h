// What everything costs in the simulation: how long the coordinator's threads, a worker's threads
// and the wire are busy with it. The defaults are measured; each says by what.
#ifndef SOBOX_TESTS_BENCH_SCALE_COSTS_H
#define SOBOX_TESTS_BENCH_SCALE_COSTS_H

struct costs {
    // A worker.
    double sample_ns; // a sample on one core: kernel_bench, ten springs, from random numbers to
                      // verdicts (cluster_rates bulk_kernel_to_verdict)
    double hear_ns;   // a message for another worker: received, checked, dropped (wire_bench
                      // dispatch_us and as much again for the kernel and LCM's thread)
    double answer_ns; // from the last sample of a batch to its outcome's leaving, and from its
                      // arrival to the first sample: threads that must be woken (worker/runtime
                      // README, cores asleep)

    // The coordinator's event loop, one thread.
    double send_ns;          // a batch: encoded and given to the kernel
    double take_ns;          // an outcome or a status: dispatched, taken by the schedule. Both
                             // together are cluster_rates batch_of_200_cpu_coordinator, of which
                             // four fifths are this thread's
    double verdict_ns;       // a sample of an outcome: unpacked and stored
    double record_ns;        // a step written to the journal, and the next one asked for (perf of a
                             // sweep of 200 samples a step)
    double record_sample_ns; // a sample of it
    double open_ns;          // a search opened: read from the journal, created

    // LCM's thread in the coordinator.
    double listen_ns; // a message received: the other fifth
    double byte_ns;   // a byte of it on the coordinator's wire: 10 Gbit/s

    // The coordinator's trimming threads.
    double trim_ns;        // a step, whatever its size
    double trim_sample_ns; // a sample of it (trim_bench, 20,000 samples of 18 variables)
};

static inline struct costs costs_default(void)
{
    return (struct costs){
        .sample_ns = 1000,
        .hear_ns = 4000,
        .answer_ns = 50000,
        .send_ns = 8000,
        .take_ns = 12000,
        .verdict_ns = 2,
        .record_ns = 30000,
        .record_sample_ns = 2,
        .open_ns = 300000,
        .listen_ns = 6000,
        .byte_ns = 0.8,
        .trim_ns = 20000,
        .trim_sample_ns = 400,
    };
}

#endif
