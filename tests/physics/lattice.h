// A synthetic crash that shares nothing with the kinematic model: neither springs with curves, nor
// projections, nor an integrator, nor a line of code. A car is a rigid body (the passenger cell)
// with a lattice of lumps of mass in front of it, in layers one above the other; bars between the
// lumps yield, collapse and bottom out. Lumps meet a barrier with a rounded end, whose surface
// pushes along its normal and rubs with Coulomb's friction. What comes out is what a finite-element
// crash gives: forces on the barrier at places that move with the structure, and the motion of the
// cell.
//
//          barrier          lumps and bars         cell
//        =============\    o---o---o---o---o######### ..
//        =============|    |\ /|\ /|\ /|\ /|#               the outermost lumps lie on its left,
//        =============|    o---o---o---o---o#    + COG      y < 0; the car moves towards -x
//                          :               :
//                     face_x            firewall
#ifndef SOBOX_TESTS_PHYSICS_LATTICE_H
#define SOBOX_TESTS_PHYSICS_LATTICE_H

#include <stdint.h>

enum {
    LATTICE_COLUMNS = 11, // lumps along the car, the last column on the firewall
    LATTICE_ROWS = 8,     // across
    LATTICE_LAYERS = 4,   // one above the other
    LATTICE_NODES = LATTICE_COLUMNS * LATTICE_ROWS * LATTICE_LAYERS,
    LATTICE_TIMES = 151, // every millisecond from 0
};

// What differs from crash to crash.
struct lattice_car {
    const char *name;
    double mass;        // [kg] all of it
    double yaw_inertia; // [kg m2] about the COG, all of it before the crash
    double speed;       // [m/s]
    double strength;    // factor on the force at which bars along the car collapse
    double bracing;     // the same for bars across and diagonal ones
    double friction;    // of the barrier's surface
    double edge_y;      // [m] end of the barrier
};

// What was recorded. The barrier's face is at x = -2.08 m, the COG starts at the origin. Forces are
// those on the car, means over the millisecond around each time, as they keep the impulse.
struct lattice_record {
    double time[LATTICE_TIMES];                   // [s]
    double x[LATTICE_TIMES];                      // [m] of the point of the cell where the COG was
    double y[LATTICE_TIMES];                      // [m]
    double yaw[LATTICE_TIMES];                    // [rad]
    double node_y[LATTICE_TIMES][LATTICE_NODES];  // [m]
    double force_x[LATTICE_TIMES][LATTICE_NODES]; // [N]
    double force_y[LATTICE_TIMES][LATTICE_NODES]; // [N]
    double momentum[3];       // [N s, N s, N m s] that the car gained, yaw about the origin
    double impulse[3];        // [N s, N s, N m s] of the barrier on the car
    double energy_lost;       // [J] kinetic energy at the start minus that at the end
    double energy_gained_max; // [J] greatest growth of kinetic and elastic energy in a millisecond
};

// Runs a crash in steps of `step` seconds, of which a whole number must make a millisecond.
void lattice_run(const struct lattice_car *car, double step, struct lattice_record *record);

// Height of a node above the road. [m]
double lattice_height(uint32_t node);

#endif
