// Masses on bars. Each lump is a particle; the lumps of the last column are fixed points of the
// cell, a rigid body, and hand it what pulls at them. Semi-implicit Euler: velocities first, then
// places.
//
// A bar is elastic up to the force at which it collapses, then plastic at that force, until it is
// crushed to a quarter of its length, from where it is as stiff as its material. It tears when it
// is half as long again.
#include "tests/physics/lattice.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { BARS_MAX = 4 * LATTICE_NODES, CELL_COLUMN = LATTICE_COLUMNS - 1 };

static const double face_x = -2.08;          // [m]
static const double firewall_x = -0.83;      // [m]
static const double outer_y = -0.91;         // [m] the car's side
static const double inner_y = -0.21;         // [m] where the lattice ends
static const double lump_mass = 0.9;         // [kg]
static const double edge_radius = 0.15;      // [m]
static const double bar_stiffness = 2e6;     // [N/m]
static const double bar_damping = 100.0;     // [N s/m] a fortieth of the critical
static const double crushed_share = 0.25;    // of its length, where a bar bottoms out
static const double torn_share = 1.5;        // of its length, where it tears
static const double surface_stiffness = 5e6; // [N/m] a node
static const double surface_damping = 500.0; // [N s/m]
static const double slip_speed = 0.05;       // [m/s] at which friction is nearly whole

struct vector {
    double x;
    double y;
};

struct bar {
    uint32_t a;
    uint32_t b;
    double length;   // [m] as made
    double rest;     // [m] where it pulls nothing now
    double collapse; // [N]
    bool torn;
};

// The cell: its COG, velocities, and the place of everything fixed to it.
struct body {
    struct vector place;
    struct vector velocity;
    double yaw;
    double yaw_rate;
    double mass;
    double inertia;
    struct vector force; // of the step
    double moment;       // about its COG
};

struct crash {
    struct lattice_car car;
    struct vector place[LATTICE_NODES];
    struct vector velocity[LATTICE_NODES];
    struct vector force[LATTICE_NODES];
    struct vector barrier[LATTICE_NODES]; // its force on the node
    struct vector fixed[LATTICE_NODES];   // of cell nodes, from the cell's COG in its axes
    struct bar bars[BARS_MAX];
    uint32_t bar_count;
    struct body cell;
    struct vector seat; // where the car's COG was, from the cell's COG in its axes
    double elastic;     // [J] in bars and surface, of the step
};

static uint32_t node_at(uint32_t layer, uint32_t row, uint32_t column)
{
    return (layer * LATTICE_ROWS + row) * LATTICE_COLUMNS + column;
}

static bool in_cell(uint32_t node)
{
    return node % LATTICE_COLUMNS == CELL_COLUMN;
}

double lattice_height(uint32_t node)
{
    return 0.30 + 0.15 * (node / (LATTICE_COLUMNS * LATTICE_ROWS));
}

static struct vector turned(struct vector v, double yaw)
{
    return (struct vector){cos(yaw) * v.x - sin(yaw) * v.y, sin(yaw) * v.x + cos(yaw) * v.y};
}

// ---- The car ----

// Bars along the car are strong in the rows of the rail and the outer member, in the lower layers,
// and behind the soft front.
static double collapse_of(const struct lattice_car *car, uint32_t layer, uint32_t row,
                          uint32_t column)
{
    static const double by_layer[LATTICE_LAYERS] = {0.8, 1.4, 1.0, 0.8};
    static const double by_row[LATTICE_ROWS] = {1.0, 1.3, 0.7, 0.5, 0.9, 1.8, 0.5, 0.4};
    const double by_column = column < 2 ? 0.2 : column < 4 ? 0.7 : 1.0 + 0.04 * (column - 4);
    return 14e3 * car->strength * by_layer[layer] * by_row[row] * by_column;
}

static void add_bar(struct crash *crash, uint32_t a, uint32_t b, double collapse)
{
    const double length =
        hypot(crash->place[a].x - crash->place[b].x, crash->place[a].y - crash->place[b].y);
    crash->bars[crash->bar_count++] =
        (struct bar){.a = a, .b = b, .length = length, .rest = length, .collapse = collapse};
}

static void add_bars_of(struct crash *crash, uint32_t layer, uint32_t row, uint32_t column)
{
    const uint32_t here = node_at(layer, row, column);
    const double along = collapse_of(&crash->car, layer, row, column);
    const double across = 0.35 * crash->car.bracing * along;
    if (column + 1 < LATTICE_COLUMNS) {
        add_bar(crash, here, node_at(layer, row, column + 1), along);
    }
    if (row + 1 < LATTICE_ROWS && column < CELL_COLUMN) {
        add_bar(crash, here, node_at(layer, row + 1, column), across);
        add_bar(crash, here, node_at(layer, row + 1, column + 1), across);
        add_bar(crash, node_at(layer, row + 1, column), node_at(layer, row, column + 1), across);
    }
}

static void place_nodes(struct crash *crash)
{
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        const uint32_t column = node % LATTICE_COLUMNS;
        const uint32_t row = node / LATTICE_COLUMNS % LATTICE_ROWS;
        crash->place[node] = (struct vector){
            face_x + 1e-3 + (firewall_x - face_x) * column / CELL_COLUMN,
            outer_y + (inner_y - outer_y) * row / (LATTICE_ROWS - 1),
        };
        crash->velocity[node] = (struct vector){-crash->car.speed, 0.0};
    }
}

// The cell is what of mass and inertia the lumps leave over.
static void make_cell(struct crash *crash)
{
    double mass = 0.0;
    double inertia = 0.0;
    struct vector moment = {0};
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        if (!in_cell(node)) {
            const struct vector at = crash->place[node];
            mass += lump_mass;
            moment.x += lump_mass * at.x;
            moment.y += lump_mass * at.y;
            inertia += lump_mass * (at.x * at.x + at.y * at.y);
        }
    }
    struct body *cell = &crash->cell;
    cell->mass = crash->car.mass - mass;
    cell->place = (struct vector){-moment.x / cell->mass, -moment.y / cell->mass};
    cell->velocity = (struct vector){-crash->car.speed, 0.0};
    cell->inertia = crash->car.yaw_inertia - inertia -
                    cell->mass * (cell->place.x * cell->place.x + cell->place.y * cell->place.y);
    crash->seat = (struct vector){-cell->place.x, -cell->place.y};
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        crash->fixed[node] = (struct vector){crash->place[node].x - cell->place.x,
                                             crash->place[node].y - cell->place.y};
    }
}

static void crash_init(struct crash *crash, const struct lattice_car *car)
{
    memset(crash, 0, sizeof *crash);
    crash->car = *car;
    place_nodes(crash);
    make_cell(crash);
    for (uint32_t layer = 0; layer < LATTICE_LAYERS; layer++) {
        for (uint32_t row = 0; row < LATTICE_ROWS; row++) {
            for (uint32_t column = 0; column < LATTICE_COLUMNS; column++) {
                add_bars_of(crash, layer, row, column);
            }
        }
    }
}

// ---- Forces ----

// Tension of a bar, positive, after it has yielded as far as it must. Bars that are crushed take
// any pressure.
static double bar_tension(struct bar *bar, double length, double *elastic)
{
    const double shortest = crushed_share * bar->length;
    if (length > torn_share * bar->length) {
        bar->torn = true;
        return 0.0;
    }
    double tension = bar_stiffness * (length - bar->rest);
    if (fabs(tension) > bar->collapse) {
        tension = copysign(bar->collapse, tension);
        bar->rest = length - tension / bar_stiffness;
    }
    *elastic += 0.5 * tension * tension / bar_stiffness;
    if (length < shortest) {
        const double depth = shortest - length;
        *elastic += 0.5 * bar_stiffness * depth * depth;
        tension -= bar_stiffness * depth;
    }
    return tension;
}

static void pull(struct crash *crash, struct bar *bar)
{
    const struct vector *a = &crash->place[bar->a];
    const struct vector *b = &crash->place[bar->b];
    const double x = b->x - a->x;
    const double y = b->y - a->y;
    const double length = fmax(hypot(x, y), 1e-9);
    const double rate = ((crash->velocity[bar->b].x - crash->velocity[bar->a].x) * x +
                         (crash->velocity[bar->b].y - crash->velocity[bar->a].y) * y) /
                        length;
    double tension = bar_tension(bar, length, &crash->elastic);
    if (!bar->torn) {
        tension += bar_damping * rate;
    }
    crash->force[bar->a].x += tension * x / length;
    crash->force[bar->a].y += tension * y / length;
    crash->force[bar->b].x -= tension * x / length;
    crash->force[bar->b].y -= tension * y / length;
}

// How deep a place lies in the barrier, below 0 outside, and the normal of the surface there: the
// face, a quarter circle, or the side.
static double depth_at(const struct lattice_car *car, struct vector at, struct vector *normal)
{
    const struct vector centre = {face_x - edge_radius, car->edge_y - edge_radius};
    const struct vector from = {at.x - centre.x, at.y - centre.y};
    if (from.x > 0.0 && from.y > 0.0) {
        const double distance = hypot(from.x, from.y);
        *normal = (struct vector){from.x / distance, from.y / distance};
        return edge_radius - distance;
    }
    const double behind_face = face_x - at.x;
    const double behind_side = car->edge_y - at.y;
    *normal = behind_face < behind_side ? (struct vector){1.0, 0.0} : (struct vector){0.0, 1.0};
    return fmin(behind_face, behind_side);
}

static void push(struct crash *crash, uint32_t node)
{
    struct vector normal;
    const double depth = depth_at(&crash->car, crash->place[node], &normal);
    crash->barrier[node] = (struct vector){0};
    if (depth <= 0.0) {
        return;
    }
    const struct vector v = crash->velocity[node];
    const double out = v.x * normal.x + v.y * normal.y;
    const double along = v.y * normal.x - v.x * normal.y;
    const double pressure = fmax(surface_stiffness * depth - surface_damping * out, 0.0);
    const double rub = -crash->car.friction * pressure * tanh(along / slip_speed);
    crash->elastic += 0.5 * surface_stiffness * depth * depth;
    crash->barrier[node] =
        (struct vector){pressure * normal.x - rub * normal.y, pressure * normal.y + rub * normal.x};
    crash->force[node].x += crash->barrier[node].x;
    crash->force[node].y += crash->barrier[node].y;
}

static void find_forces(struct crash *crash)
{
    memset(crash->force, 0, sizeof crash->force);
    crash->elastic = 0.0;
    for (uint32_t i = 0; i < crash->bar_count; i++) {
        if (!crash->bars[i].torn) {
            pull(crash, &crash->bars[i]);
        }
    }
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        push(crash, node);
    }
}

// ---- Motion ----

static void move_lumps(struct crash *crash, double step)
{
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        if (!in_cell(node)) {
            crash->velocity[node].x += step * crash->force[node].x / lump_mass;
            crash->velocity[node].y += step * crash->force[node].y / lump_mass;
            crash->place[node].x += step * crash->velocity[node].x;
            crash->place[node].y += step * crash->velocity[node].y;
        }
    }
}

static void move_cell(struct crash *crash, double step)
{
    struct body *cell = &crash->cell;
    cell->force = (struct vector){0};
    cell->moment = 0.0;
    for (uint32_t node = CELL_COLUMN; node < LATTICE_NODES; node += LATTICE_COLUMNS) {
        const struct vector arm = {crash->place[node].x - cell->place.x,
                                   crash->place[node].y - cell->place.y};
        cell->force.x += crash->force[node].x;
        cell->force.y += crash->force[node].y;
        cell->moment += arm.x * crash->force[node].y - arm.y * crash->force[node].x;
    }
    cell->velocity.x += step * cell->force.x / cell->mass;
    cell->velocity.y += step * cell->force.y / cell->mass;
    cell->yaw_rate += step * cell->moment / cell->inertia;
    cell->place.x += step * cell->velocity.x;
    cell->place.y += step * cell->velocity.y;
    cell->yaw += step * cell->yaw_rate;
    for (uint32_t node = CELL_COLUMN; node < LATTICE_NODES; node += LATTICE_COLUMNS) {
        const struct vector arm = turned(crash->fixed[node], cell->yaw);
        crash->place[node] = (struct vector){cell->place.x + arm.x, cell->place.y + arm.y};
        crash->velocity[node] = (struct vector){cell->velocity.x - cell->yaw_rate * arm.y,
                                                cell->velocity.y + cell->yaw_rate * arm.x};
    }
}

// ---- Recording ----

static double kinetic_energy(const struct crash *crash)
{
    const struct body *cell = &crash->cell;
    double sum = 0.5 * cell->mass *
                     (cell->velocity.x * cell->velocity.x + cell->velocity.y * cell->velocity.y) +
                 0.5 * cell->inertia * cell->yaw_rate * cell->yaw_rate;
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        const struct vector v = crash->velocity[node];
        sum += in_cell(node) ? 0.0 : 0.5 * lump_mass * (v.x * v.x + v.y * v.y);
    }
    return sum;
}

// Momentum of everything, and its moment about the origin.
static void add_momentum(const struct crash *crash, double sign, double momentum[3])
{
    const struct body *cell = &crash->cell;
    momentum[0] += sign * cell->mass * cell->velocity.x;
    momentum[1] += sign * cell->mass * cell->velocity.y;
    momentum[2] +=
        sign * (cell->inertia * cell->yaw_rate +
                cell->mass * (cell->place.x * cell->velocity.y - cell->place.y * cell->velocity.x));
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        const struct vector at = crash->place[node];
        const struct vector v = crash->velocity[node];
        if (!in_cell(node)) {
            momentum[0] += sign * lump_mass * v.x;
            momentum[1] += sign * lump_mass * v.y;
            momentum[2] += sign * lump_mass * (at.x * v.y - at.y * v.x);
        }
    }
}

static void note_motion(const struct crash *crash, uint32_t at, struct lattice_record *record)
{
    const struct vector seat = turned(crash->seat, crash->cell.yaw);
    record->time[at] = 1e-3 * at;
    record->x[at] = crash->cell.place.x + seat.x;
    record->y[at] = crash->cell.place.y + seat.y;
    record->yaw[at] = crash->cell.yaw;
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        record->node_y[at][node] = crash->place[node].y;
    }
}

// Adds the step's forces to the mean of the millisecond that they belong to.
static void note_forces(const struct crash *crash, double time, double step,
                        struct lattice_record *record)
{
    const uint32_t at = (uint32_t)lround(time * 1e3);
    const double span = at == 0 || at == LATTICE_TIMES - 1 ? 0.5e-3 : 1e-3;
    for (uint32_t node = 0; node < LATTICE_NODES; node++) {
        const struct vector f = crash->barrier[node];
        const struct vector p = crash->place[node];
        record->force_x[at][node] += f.x * step / span;
        record->force_y[at][node] += f.y * step / span;
        record->impulse[0] += f.x * step;
        record->impulse[1] += f.y * step;
        record->impulse[2] += (p.x * f.y - p.y * f.x) * step;
    }
}

void lattice_run(const struct lattice_car *car, double step, struct lattice_record *record)
{
    struct crash *crash = malloc(sizeof *crash);
    const uint32_t steps = (uint32_t)lround(1e-3 / step);
    memset(record, 0, sizeof *record);
    crash_init(crash, car);
    add_momentum(crash, -1.0, record->momentum);
    const double energy_start = kinetic_energy(crash);
    double energy_before = energy_start;
    note_motion(crash, 0, record);
    for (uint32_t at = 1; at < LATTICE_TIMES; at++) {
        for (uint32_t i = 0; i < steps; i++) {
            find_forces(crash);
            note_forces(crash, (at - 1) * 1e-3 + (i + 0.5) * step, step, record);
            move_lumps(crash, step);
            move_cell(crash, step);
        }
        note_motion(crash, at, record);
        const double energy = kinetic_energy(crash) + crash->elastic;
        record->energy_gained_max = fmax(record->energy_gained_max, energy - energy_before);
        energy_before = energy;
    }
    add_momentum(crash, 1.0, record->momentum);
    record->energy_lost = energy_start - kinetic_energy(crash);
    free(crash);
}
