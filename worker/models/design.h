// A design of the crash model with its own curves: for every spring the forces at the points of its
// load branch and, where it has one, of its unload branch. A search only ever moves the forces at
// the scenario's points; a design from a file brings its own, for instance measured ones.
//
//     spring,branch,deformation_m,force_x_N,force_y_N
//     front,load,0.0,0,0
//     front,load,0.6,300e3,120e3
//     front,unload,0.5,0,0
//     front,unload,0.6,300e3,120e3
#ifndef SOBOX_WORKER_MODELS_DESIGN_H
#define SOBOX_WORKER_MODELS_DESIGN_H

#include "common/base/error.h"
#include "common/scenario/scenario.h"

struct design_branch {
    uint32_t point_count;                    // 0 (no such branch), or at least 2
    double *deformation;                     // [m] strictly ascending (point_count)
    double *force[SCENARIO_DIRECTION_COUNT]; // [N] (point_count) each
};

struct design_spring {
    struct design_branch load; // always there
    struct design_branch unload;
};

struct design {
    struct design_spring *springs; // (spring_count) in the scenario's order
    uint32_t spring_count;
};

enum design_place { DESIGN_CENTRE, DESIGN_LOWER, DESIGN_UPPER };

enum { DESIGN_POINT_MAX = 16384 }; // points of all branches together: what the kernel has room for

// The middle or a bound of the design space. The caller releases it with design_fini().
void design_init_place(struct design *design, const struct scenario *scenario,
                       enum design_place place);

// Reads a design from the text of a CSV file; `source` stands for the file in messages. Every
// spring of the scenario needs a load branch of at least two points; rows may stand in any order as
// long as the deformation of each branch ascends. On success the caller releases the design; else
// it is left zeroed. Errors: STATUS_INVALID.
enum status design_parse(struct design *design, const struct scenario *scenario, const char *source,
                         const char *text, size_t size, struct error *error) MUST_USE;

// A design without any point, for design_add(). The caller releases it with design_fini().
void design_init(struct design *design, const struct scenario *scenario);

// Adds a point behind the last of a branch: its deformation is the greater one.
void design_add(struct design_branch *branch, double deformation, double force_x, double force_y);

// The design as the text of a CSV file, which design_parse() reads back to the same bits. The
// caller frees it with g_free().
char *design_text(const struct design *design, const struct scenario *scenario);

// Releases a design. A zeroed struct is fine.
void design_fini(struct design *design);

#endif
