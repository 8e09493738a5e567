// What makes two kernels the same: a digest of this program's version and of the bits that sampling
// and kinematics give on a small built-in scenario. A worker whose fingerprint differs from the
// coordinator's would give other results, so it is refused.
#ifndef SOBOX_WORKER_BATCH_FINGERPRINT_H
#define SOBOX_WORKER_BATCH_FINGERPRINT_H

#include "common/numeric/digest.h"

// Computed by running the kernel: about a millisecond.
struct digest fingerprint_compute(void);

#endif
