// A group of components as a pair of springs of the crash model.
//
//     face_x           1st      2nd component   foot     deformation 0 is first contact: the face
//       |   free way   |========|==============|         meets the first component after the free
//       0             s1       s2              length    way, the second once the first is crushed
//
// - The spring stands at the foot of its group, where the last component hands its force on to the
//   part of the car that stays whole, in the middle of the group's patch.
// - Deformation is counted from first contact for all springs, so the undeformed length reaches up
//   to the barrier's face. Where the group begins later, its curve does.
// - A discretization point lies wherever a component begins or ends, for there the curve may
//   change its course. The foot is none where two others are left: a car crushed up to there has
//   nothing left to give.
// - The force that a group can be made to carry at a point is the sum over the components that
//   stand there side by side; of two in line the one that begins there counts.
#ifndef SOBOX_WORKER_COMPONENTS_SPRING_H
#define SOBOX_WORKER_COMPONENTS_SPRING_H

#include "worker/components/group.h"
#include "worker/components/points.h"

struct spring {
    char name[SCENARIO_NAME_SIZE];
    double position[2];   // [m] x of the foot, y of the patch's middle
    double length;        // [m] from the foot to the barrier's face
    double height;        // [m] of the patch's middle above the road
    double path;          // [m] along which components stand: their lengths without free ways
    uint32_t point_count; // 2..SCENARIO_POINT_MAX
    double deformation[SCENARIO_POINT_MAX]; // [m] ascending
    struct points_choice chosen; // how the points follow a reference curve; of 0: none was given
    bool forces;                 // the table gives them
    double force_upper[SCENARIO_DIRECTION_COUNT][SCENARIO_POINT_MAX]; // [N]
};

// Makes the spring of a group. `face_x` is the x of the barrier's face at first contact [m].
// Errors: STATUS_INVALID (a component reaches beyond the face, too many ends).
enum status spring_make(struct spring *spring, const struct component_list *components,
                        const struct group_list *groups, uint32_t group, double face_x,
                        struct error *error) MUST_USE;

// Gives the spring other points, chosen on a reference curve among which its own are.
void spring_choose(struct spring *spring, const struct component_list *components,
                   const struct group_list *groups, uint32_t group, double face_x,
                   const struct points_choice *choice);

// The spring of a reference curve of which nothing but the points is known: length is NAN.
void spring_of_curve(struct spring *spring, const char *name, const struct points_choice *choice);

// The foremost x of all components: where the face is when nobody says. [m]
double spring_foremost(const struct group_list *groups);

#endif
