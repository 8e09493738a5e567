// What must hold in every crash, however it goes: energy, symmetry, scale.
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { STRIDE = 64, VALUES = 256, RESULTS = KINEMATICS_WORK + 2 * SEDAN_SPRING_MAX };

static double values[VALUES * STRIDE];
static double results[RESULTS * STRIDE];
static double others[RESULTS * STRIDE];

static void evaluate(const struct sedan *sedan, double *to)
{
    struct kinematics_problem *problem = kinematics_create(&sedan->setup);
    kinematics_evaluate(problem, STRIDE, values, to, STRIDE);
    kinematics_free(problem);
}

static void fill(const struct sedan *sedan, uint64_t *seed)
{
    struct kinematics_problem *problem = kinematics_create(&sedan->setup);
    sedan_forces(sedan, kinematics_value_count(problem), seed, STRIDE, values, STRIDE);
    kinematics_free(problem);
}

static double lost_energy(const struct sedan *sedan, uint32_t design)
{
    const double before = 0.5 * sedan->setup.mass * sedan->setup.speed * sedan->setup.speed;
    return before - results[KINEMATICS_KINETIC_ENERGY * STRIDE + design];
}

static double absorbed_energy(const struct sedan *sedan, uint32_t design)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < sedan->setup.spring_count; i++) {
        sum += results[(KINEMATICS_WORK + i) * STRIDE + design];
    }
    return sum;
}

// The greatest difference between what the car lost and what the springs took, relative to the
// energy it came with, over random crashes.
static double energy_error(enum kinematics_integrator integrator, double time_step)
{
    uint64_t seed = 1;
    double greatest = 0.0;
    for (int crash = 0; crash < 60; crash++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        sedan.setup.integrator = integrator;
        sedan.setup.time_step = time_step;
        fill(&sedan, &seed);
        evaluate(&sedan, results);
        const double energy = 0.5 * sedan.setup.mass * sedan.setup.speed * sedan.setup.speed;
        for (uint32_t i = 0; i < STRIDE; i++) {
            const double error = lost_energy(&sedan, i) - absorbed_energy(&sedan, i);
            const double balance = results[KINEMATICS_ENERGY_BALANCE * STRIDE + i];
            assert_true(fabs(balance - error) < 1e-9 * energy);
            greatest = fmax(greatest, fabs(error) / energy);
        }
    }
    return greatest;
}

// The leapfrog schemes balance work and energy to rounding at any time step: a force that acts at
// another place or another time than it is charged for breaks that.
static void work_is_the_loss_of_kinetic_energy(void **state)
{
    (void)state;
    assert_true(energy_error(KINEMATICS_CENTRAL_DIFFERENCE, 1e-3) < 1e-11);
    assert_true(energy_error(KINEMATICS_VELOCITY_VERLET, 1e-3) < 1e-11);
    assert_true(energy_error(KINEMATICS_EVENT_VERLET, 1e-3) < 1e-11);
    assert_true(energy_error(KINEMATICS_CENTRAL_DIFFERENCE, 5e-3) < 1e-11);
    assert_true(energy_error(KINEMATICS_EVENT_VERLET, 5e-3) < 1e-11);
}

// Runge-Kutta balances them as well as it integrates: the jumps of the force at contact and release
// fall inside steps and leave an error of first order.
static void work_is_the_loss_of_kinetic_energy_for_runge_kutta(void **state)
{
    (void)state;
    const double coarse = energy_error(KINEMATICS_RUNGE_KUTTA_4, 1e-3);
    const double fine = energy_error(KINEMATICS_RUNGE_KUTTA_4, 1e-4);
    assert_true(coarse < 0.03);
    assert_true(fine < 0.25 * coarse);
}

// The model's source of energy: a lateral force follows the axial deformation and pushes along the
// barrier while it acts. A front of lateral forces alone changes the car's energy by the lateral
// work, and most cars end faster than they came; one of axial forces alone does none, and no car
// ends faster than it came.
static void lateral_work_is_what_the_lateral_forces_give(void **state)
{
    (void)state;
    uint64_t seed = 7;
    struct sedan sedan;
    sedan_init(&sedan, 2, 3);
    const double energy = 0.5 * sedan.setup.mass * sedan.setup.speed * sedan.setup.speed;
    double rows[2][STRIDE];
    int faster = 0;
    for (uint32_t direction = 0; direction < 2; direction++) {
        fill(&sedan, &seed);
        for (uint32_t value = 0; value < 12; value++) {
            for (uint32_t i = 0; i < STRIDE && value / 3 % 2 != direction; i++) {
                values[value * STRIDE + i] = 0.0;
            }
        }
        evaluate(&sedan, results);
        memcpy(rows[direction], results + KINEMATICS_LATERAL_WORK * STRIDE, sizeof rows[0]);
        for (uint32_t i = 0; i < STRIDE; i++) {
            const double absorbed = absorbed_energy(&sedan, i);
            const double lost = lost_energy(&sedan, i);
            if (direction == 0) {
                assert_true(rows[0][i] == 0.0 && absorbed > 0.0 && lost > 0.0);
            } else {
                assert_true(fabs(rows[1][i] + absorbed) < 1e-11 * energy);
                faster += lost < 0.0;
            }
        }
    }
    print_message("%d of %d cars end faster than they came\n", faster, STRIDE);
    assert_true(faster > STRIDE / 2);
}

// Mass, inertia and forces times two: the same motion to the bit, twice the energy.
static void doubling_mass_and_force_changes_no_motion(void **state)
{
    (void)state;
    uint64_t seed = 2;
    for (int crash = 0; crash < 30; crash++) {
        struct sedan sedan;
        sedan_randomize(&sedan, &seed);
        fill(&sedan, &seed);
        evaluate(&sedan, results);
        sedan.setup.mass *= 2.0;
        sedan.setup.yaw_inertia *= 2.0;
        for (int i = 0; i < VALUES * STRIDE; i++) {
            values[i] *= 2.0;
        }
        evaluate(&sedan, others);
        for (uint32_t i = 0; i < STRIDE; i++) {
            for (uint32_t result = 0; result < KINEMATICS_KINETIC_ENERGY; result++) {
                assert_true(results[result * STRIDE + i] == others[result * STRIDE + i]);
            }
            for (uint32_t result = KINEMATICS_KINETIC_ENERGY;
                 result < KINEMATICS_WORK + sedan.setup.spring_count; result++) {
                if (result == KINEMATICS_ENERGY_BALANCE) {
                    continue; // rounding
                }
                assert_true(2.0 * results[result * STRIDE + i] == others[result * STRIDE + i]);
            }
        }
    }
}

// Everything in y mirrored: the mirrored crash. The barrier's face runs towards -y from its edge,
// so it is made wide enough for both sides.
static void mirrored_crash_is_the_mirrored_result(void **state)
{
    (void)state;
    uint64_t seed = 3;
    struct sedan sedan;
    sedan_init(&sedan, 4, 5);
    sedan.setup.edge_y = 50.0;
    sedan.setup.width = 100.0;
    fill(&sedan, &seed);
    evaluate(&sedan, results);
    for (uint32_t i = 0; i < 4; i++) {
        sedan.springs[i].position[1] = -sedan.springs[i].position[1];
        for (uint32_t value = 5; value < 10; value++) { // the lateral forces of the spring
            for (uint32_t design = 0; design < STRIDE; design++) {
                values[(10 * i + value) * STRIDE + design] *= -1.0;
            }
        }
    }
    evaluate(&sedan, others);
    static const double sign[KINEMATICS_WORK] = {
        [KINEMATICS_LENGTH_LAST] = 1.0,
        [KINEMATICS_LENGTH_MIN] = 1.0,
        [KINEMATICS_PILLAR_TRAVEL] = -1.0,
        [KINEMATICS_PROJECTION_TRAVEL] = -1.0,
        [KINEMATICS_YAW] = -1.0,
        [KINEMATICS_YAW_MAX] = 1.0,
        [KINEMATICS_TRAVEL_X] = 1.0,
        [KINEMATICS_TRAVEL_Y] = -1.0,
        [KINEMATICS_DELTA_VX] = 1.0,
        [KINEMATICS_DELTA_VY] = -1.0,
        [KINEMATICS_ACCELERATION_MAX] = 1.0,
        [KINEMATICS_ACCELERATION_MEAN] = 1.0,
        [KINEMATICS_KINETIC_ENERGY] = 1.0,
        [KINEMATICS_LATERAL_WORK] = 1.0,
        [KINEMATICS_ENERGY_BALANCE] = 1.0,
    };
    for (uint32_t result = 0; result < KINEMATICS_WORK; result++) {
        for (uint32_t i = 0; i < STRIDE; i++) {
            assert_true(results[result * STRIDE + i] == sign[result] * others[result * STRIDE + i]);
        }
    }
}

// The whole scene moved: nothing but rounding changes.
static void moved_scene_gives_the_same_crash(void **state)
{
    (void)state;
    uint64_t seed = 4;
    struct sedan sedan;
    sedan_init(&sedan, 3, 5);
    fill(&sedan, &seed);
    evaluate(&sedan, results);
    sedan.setup.cog[0] += 10.0;
    sedan.setup.face_x += 10.0;
    sedan.setup.cog[1] -= 3.0;
    sedan.setup.edge_y -= 3.0;
    evaluate(&sedan, others);
    for (uint32_t result = 0; result < KINEMATICS_DELTA_VX; result++) {
        for (uint32_t i = 0; i < STRIDE; i++) {
            assert_true(fabs(results[result * STRIDE + i] - others[result * STRIDE + i]) < 1e-11);
        }
    }
}

// Two springs at one place are one spring with the sum of their forces.
static void springs_at_one_place_add_up(void **state)
{
    (void)state;
    uint64_t seed = 5;
    struct sedan sedan;
    sedan_init(&sedan, 2, 5);
    sedan.springs[1] = sedan.springs[0];
    fill(&sedan, &seed);
    evaluate(&sedan, results);
    sedan.setup.spring_count = 1;
    for (uint32_t value = 0; value < 10; value++) {
        for (uint32_t i = 0; i < STRIDE; i++) {
            values[value * STRIDE + i] += values[(10 + value) * STRIDE + i];
        }
    }
    evaluate(&sedan, others);
    for (uint32_t result = 0; result < KINEMATICS_DELTA_VX; result++) {
        for (uint32_t i = 0; i < STRIDE; i++) {
            assert_true(fabs(results[result * STRIDE + i] - others[result * STRIDE + i]) < 1e-11);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(work_is_the_loss_of_kinetic_energy),
        cmocka_unit_test(work_is_the_loss_of_kinetic_energy_for_runge_kutta),
        cmocka_unit_test(lateral_work_is_what_the_lateral_forces_give),
        cmocka_unit_test(doubling_mass_and_force_changes_no_motion),
        cmocka_unit_test(mirrored_crash_is_the_mirrored_result),
        cmocka_unit_test(moved_scene_gives_the_same_crash),
        cmocka_unit_test(springs_at_one_place_add_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
