// How the groups' patches lie on the barrier's face, seen from the front: where two of them claim
// the same place, and where nobody stands. Forces measured at such a place cannot be told apart, or
// belong to nothing that the table knows.
//
//      z ^  +---------+----+     front: from the outermost component to the end of the face, from
//        |  |   a  |##|b   |     the lowest component to the highest
//        |  +------+--+....|     ##: a and b overlap
//        |  |   c     |....|     ..: nobody stands here
//           far              edge_y -> y
#ifndef SOBOX_WORKER_COMPONENTS_FACE_H
#define SOBOX_WORKER_COMPONENTS_FACE_H

#include "worker/components/group.h"

enum { FACE_NOBODY = UINT32_MAX };

// The barrier's face at first contact.
struct face {
    double edge_y; // [m] its inner end; INFINITY: not known
    double far_y;  // [m] its outer end; -INFINITY: not known
};

struct face_place {
    double y[2];         // [m] from, to
    double z[2];         // [m]
    uint32_t one, other; // groups that overlap, or both FACE_NOBODY
};

struct face_check {
    struct face_place front;
    struct face_place *overlaps; // (overlap_count) the largest first
    uint32_t overlap_count;
    struct face_place *gaps; // (gap_count) the largest first, disjoint
    uint32_t gap_count;
    double gap_area; // [m2] of all
};

// Looks at the patches; places smaller than 1 cm2 are left out, as drawings are no nearer. The
// caller releases it.
void face_check_make(struct face_check *check, const struct group_list *groups,
                     const struct face *face);
void face_check_fini(struct face_check *check);

// How large a place is. [m2]
double face_area(const struct face_place *place);

// How much of a group's width lies beside the barrier's face. [m]
double face_beside(const struct group *group, const struct face *face);

#endif
