// The planar crash of a rigid vehicle against a rigid barrier through springs of given
// force-deformation curves (Heuijerjans 2016, chapter 6). Plain numbers in, plain numbers out:
// nothing here knows of scenarios, files or machines.
//
//                 y ^                        The vehicle travels towards -x. q = (x, y, yaw) is the
//                   |                        place of its COG and its turn, counter-clockwise seen
//      barrier      |    vehicle             from above. A spring sits at P1, a fixed place of the
//      ------+ edge_y  +-------------.       vehicle, and lies along the vehicle's axis; P2 is
//      where
//      ######| - - - - |              \      its line meets the barrier. Its length is |P1 P2|,
//      ######|P2======P1    o COG      |     negative once P1 has passed the face, its deformation
//      ######|         |              /      is what it lost of its undeformed length.
//      ------+         +-------------'
//         face_x  <-- speed
//
// A problem is prepared once and is then read-only and shared by all threads. What differs from
// design to design are the forces at the points of the curves. Designs come as a structure of
// arrays, one lane a design, and no number ever crosses lanes: a design's results are the same bits
// whatever its lane, its neighbours, the instruction set, the compiler or its optimization.
#ifndef SOBOX_WORKER_KINEMATICS_KINEMATICS_H
#define SOBOX_WORKER_KINEMATICS_KINEMATICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    KINEMATICS_SPRING_MAX = 64,  // so that a block's scratch stays on the stack
    KINEMATICS_VALUE_MAX = 65536 // forces of one design
};

enum kinematics_profile {
    KINEMATICS_PROFILE_FLAT,    // the face ends at edge_y
    KINEMATICS_PROFILE_ROUNDED, // a quarter circle leads from the face to the barrier's side
};

enum kinematics_integrator {
    KINEMATICS_CENTRAL_DIFFERENCE, // eq. 6.41 to 6.44: nothing acts before the first step is done
    KINEMATICS_VELOCITY_VERLET,    // the same but for a force at time 0
    KINEMATICS_RUNGE_KUTTA_4,      // loading or unloading is told from the rate of deformation
    KINEMATICS_EVENT_VERLET,       // Verlet with contacts made, lost and turned within the step
};

enum kinematics_reloading {
    // Eq. 6.45: a spring loads whenever its deformation grew over the last step. One that let go
    // and is compressed again pushes with its full force a second time.
    KINEMATICS_RELOADING_THESIS,
    // A spring loads only beyond the greatest deformation it had in contact: a structure absorbs
    // its energy once.
    KINEMATICS_RELOADING_CRUSHED,
};

// The deformations at which forces are given; in between they are linear.
struct kinematics_curve {
    const double
        *deformation;     // [m] strictly ascending (point_count), borrowed until create returns
    uint32_t point_count; // 0 (no such branch) or at least 2
};

// An axial and a lateral spring that share a place and the axial deformation.
struct kinematics_spring {
    double position[2];             // [m] P1 from the COG, in vehicle axes
    double length;                  // [m] undeformed
    struct kinematics_curve load;   // below its first point 0, beyond its last that one's force
    struct kinematics_curve unload; // the same; without it an unloading spring does not push
};

// Results that a caller does without. What is omitted is 0; it moves nothing, so no other result
// changes by a bit.
struct kinematics_omitted {
    bool energies;     // work and energy balance, which take a quarter of the time
    bool deformations; // the springs' greatest deformations
};

struct kinematics_setup {
    double mass;        // [kg] > 0
    double yaw_inertia; // [kg m2] > 0
    double speed;       // [m/s] towards the barrier
    double cog[2];      // [m] at time 0
    double face_x;      // [m]
    double edge_y;      // [m] inner end of the face, which runs from here towards -y
    double width;       // [m] of the face
    double edge_radius; // [m] of the rounded profile, 0 .. width
    enum kinematics_profile profile;
    const struct kinematics_spring *springs; // (spring_count) borrowed until create returns
    uint32_t spring_count;                   // 1 .. KINEMATICS_SPRING_MAX
    double duration;                         // [s] > 0
    double time_step;                        // [s] > 0, <= duration
    enum kinematics_integrator integrator;
    enum kinematics_reloading reloading;
    struct kinematics_omitted omitted;
};

struct kinematics_problem;

// What one design did. "The end" is the last of round(duration / time_step) steps. All of a
// design's results are NaN when its motion left the finite numbers.
enum kinematics_result {
    // [m] of spring 0 when it was last in contact, else undeformed. Event Verlet, and all schemes
    // on
    // a rounded edge, find the moment within the step at which it slipped off.
    KINEMATICS_LENGTH_LAST,
    KINEMATICS_LENGTH_MIN,        // [m] least of spring 0 in contact, else undeformed
    KINEMATICS_PILLAR_TRAVEL,     // [m] y of spring 0's P1 at the end, from its start
    KINEMATICS_PROJECTION_TRAVEL, // [m] y of spring 0's P2 at the end, from its start; where a line
                                  // misses the rounded edge, y where it crosses the plane of the
                                  // face
    KINEMATICS_YAW,               // [rad] at the end
    KINEMATICS_YAW_MAX,           // [rad] greatest |yaw|
    KINEMATICS_TRAVEL_X,          // [m] of the COG, negative: towards the barrier
    KINEMATICS_TRAVEL_Y,          // [m]
    KINEMATICS_DELTA_VX,         // [m/s] velocity at the end minus at time 0; positive: slowed down
    KINEMATICS_DELTA_VY,         // [m/s]
    KINEMATICS_ACCELERATION_MAX, // [m/s2] greatest |acceleration| of the COG in x
    KINEMATICS_ACCELERATION_MEAN, // [m/s2] mean in x over the steps with a spring in contact, else
                                  // 0
    KINEMATICS_KINETIC_ENERGY,    // [J] at the end
    // [J] that the lateral forces gave the vehicle. A lateral force follows the axial deformation
    // and pushes along the barrier as long as it acts, so it usually gives: the model has a source
    // of energy there, and a car may end faster than it came.
    KINEMATICS_LATERAL_WORK,
    // [J] kinetic energy at time 0 minus that at the end minus the work of all springs: 0 but for
    // the error of the integrator, which for the leapfrog schemes is rounding.
    KINEMATICS_ENERGY_BALANCE,
    KINEMATICS_WORK, // [J] of spring 0: what it took from the vehicle; spring i follows
};

// After the work of the springs: [m] the greatest deformation that spring `index` had in contact, 0
// when it never touched.
uint32_t kinematics_deformation_row(const struct kinematics_problem *problem, uint32_t index);

enum { KINEMATICS_RESULT_MAX = KINEMATICS_WORK + 2 * KINEMATICS_SPRING_MAX };

// Prepares a problem. The caller frees it.
struct kinematics_problem *kinematics_create(const struct kinematics_setup *setup);
void kinematics_free(struct kinematics_problem *problem);

// Forces of a design: for each spring the load branch's x forces, its y forces, the unload branch's
// x forces, its y forces. [N] in vehicle axes; positive pushes backwards (+x) and away from the
// struck side (+y).
uint32_t kinematics_value_count(const struct kinematics_problem *problem);

// KINEMATICS_WORK + 2 spring_count.
uint32_t kinematics_result_count(const struct kinematics_problem *problem);

// Evaluates `count` designs: values[value * stride + i] are the forces of design i, and
// results[result * stride + i] receives its results. Columns from `count` on are neither read nor
// written. count <= stride. Allocates nothing; takes 0.6 MB of stack.
void kinematics_evaluate(const struct kinematics_problem *problem, uint32_t count,
                         const double *values, double *results, size_t stride);

// The instruction sets for which there is a kernel, narrowest first. All give the same bits.
enum kinematics_path {
    KINEMATICS_PATH_PLAIN, // C without vectors: any machine
    KINEMATICS_PATH_AVX2,  // with FMA
    KINEMATICS_PATH_AVX512,
    KINEMATICS_PATH_COUNT
};

const char *kinematics_path_name(enum kinematics_path path);

// Whether this machine can run it.
bool kinematics_path_supported(enum kinematics_path path);

// kinematics_evaluate() on a path of the caller's choice, which the machine supports: for tests and
// benchmarks.
void kinematics_evaluate_on(enum kinematics_path path, const struct kinematics_problem *problem,
                            uint32_t count, const double *values, double *results, size_t stride);

// Columns of a recorded trajectory: those below, then KINEMATICS_SPRING_COLUMN_COUNT for each
// spring.
enum kinematics_column {
    KINEMATICS_COLUMN_TIME, // [s]
    KINEMATICS_COLUMN_X,    // [m] of the COG
    KINEMATICS_COLUMN_Y,    // [m]
    KINEMATICS_COLUMN_YAW,  // [rad]
    KINEMATICS_COLUMN_VX,   // [m/s]
    KINEMATICS_COLUMN_VY,   // [m/s]
    KINEMATICS_COLUMN_VYAW, // [rad/s]
    KINEMATICS_COLUMN_SPRING,
};
enum kinematics_spring_column {
    KINEMATICS_SPRING_LENGTH,      // [m]
    KINEMATICS_SPRING_DEFORMATION, // [m]
    KINEMATICS_SPRING_FORCE_X,     // [N] in vehicle axes
    KINEMATICS_SPRING_FORCE_Y,     // [N]
    KINEMATICS_SPRING_CONTACT,     // 0 or 1
    KINEMATICS_SPRING_COLUMN_COUNT
};

uint32_t kinematics_row_count(const struct kinematics_problem *problem); // steps + 1
uint32_t kinematics_column_count(const struct kinematics_problem *problem);

// Evaluates one design with the plain kernel, which has the same bits as the others, and notes
// every step: rows (row_count x column_count). `values` and `results` have a stride of 1.
void kinematics_record(const struct kinematics_problem *problem, const double *values,
                       double *results, double *rows);

#endif
