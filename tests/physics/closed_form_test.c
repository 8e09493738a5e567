// Crashes whose motion can be written down: the kernel against the formula.
#include "tests/physics/sedan.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { RESULTS = KINEMATICS_WORK + 2 * SEDAN_SPRING_MAX };

static const enum kinematics_integrator integrators[] = {
    KINEMATICS_CENTRAL_DIFFERENCE,
    KINEMATICS_VELOCITY_VERLET,
    KINEMATICS_RUNGE_KUTTA_4,
    KINEMATICS_EVENT_VERLET,
};

static void evaluate(const struct sedan *sedan, const double *values, double *results)
{
    struct kinematics_problem *problem = kinematics_create(&sedan->setup);
    kinematics_evaluate(problem, 1, values, results, 1);
    kinematics_free(problem);
}

// A spring on the vehicle's axis against a wide barrier: a crash along x alone.
static void head_on(struct sedan *sedan, double time_step)
{
    sedan_init(sedan, 1, 2);
    sedan->springs[0].position[1] = 0.0;
    sedan->setup.edge_y = 0.5;
    sedan->setup.time_step = time_step;
}

// A constant force F stops the car after m v^2 / 2F in m v / F and then lets go: without an unload
// branch it stands still. The first step's missing force (eq. 6.44) costs central difference a
// step.
static void constant_force_stops_the_car_after_its_stopping_distance(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
        struct sedan sedan;
        head_on(&sedan, 1e-5);
        sedan.setup.integrator = integrators[i];
        const double force = 250e3;
        const double values[4] = {force, force, 0.0, 0.0};
        double results[RESULTS];
        evaluate(&sedan, values, results);
        const double v = sedan.setup.speed;
        const double distance = sedan.setup.mass * v * v / (2.0 * force);
        const double a = force / sedan.setup.mass;
        const double slip = 2.0 * v * sedan.setup.time_step; // [m] two steps' way
        assert_true(fabs(results[KINEMATICS_TRAVEL_X] + distance) < slip);
        assert_true(fabs(results[KINEMATICS_LENGTH_MIN] - (1.25 - distance)) < slip);
        assert_true(fabs(results[KINEMATICS_DELTA_VX] - v) < 2.0 * a * sedan.setup.time_step);
        assert_true(fabs(results[KINEMATICS_ACCELERATION_MAX] - a) < 1e-9 * a);
        assert_true(results[KINEMATICS_YAW] == 0.0);
        assert_true(results[KINEMATICS_TRAVEL_Y] == 0.0);
    }
}

// Event Verlet knows when within the step the car stood, so it takes no force from then on: the car
// stands still to rounding, after the way that the closed form says, at any time step.
static void event_verlet_stops_the_car_to_rounding(void **state)
{
    (void)state;
    static const double time_steps[] = {5e-3, 1e-3, 0.7e-3};
    for (size_t i = 0; i < sizeof time_steps / sizeof *time_steps; i++) {
        struct sedan sedan;
        head_on(&sedan, time_steps[i]);
        sedan.setup.integrator = KINEMATICS_EVENT_VERLET;
        const double force = 250e3;
        const double values[4] = {force, force, 0.0, 0.0};
        double results[RESULTS];
        evaluate(&sedan, values, results);
        const double v = sedan.setup.speed;
        const double distance = sedan.setup.mass * v * v / (2.0 * force);
        const double a = force / sedan.setup.mass;
        assert_true(fabs(results[KINEMATICS_DELTA_VX] - v) < 1e-10);
        // What is made good comes up to a step late: half of a dt^2 at most.
        assert_true(fabs(results[KINEMATICS_TRAVEL_X] + distance) <
                    0.5 * a * time_steps[i] * time_steps[i]);
        assert_true(fabs(results[KINEMATICS_ACCELERATION_MAX] - a) < 1e-9 * a);
    }
}

// While a constant force acts the central difference is exact at every step, but for the force-free
// first: x_k = -v k dt + a dt^2 k (k - 1) / 2.
static void central_difference_of_a_constant_force_is_exact(void **state)
{
    (void)state;
    struct sedan sedan;
    head_on(&sedan, 1e-3);
    sedan.setup.duration = 0.060;
    const double values[4] = {200e3, 200e3, 0.0, 0.0};
    double results[RESULTS];
    evaluate(&sedan, values, results);
    const double a = 200e3 / sedan.setup.mass;
    const double expected = -sedan.setup.speed * 0.060 + a * 1e-6 * 60.0 * 59.0 / 2.0;
    assert_true(fabs(results[KINEMATICS_TRAVEL_X] - expected) < 1e-12);
}

// Runge-Kutta and Verlet let it act from time 0 on once the spring reaches past the face: parabola
// and velocity are exact.
static void constant_force_from_the_start_gives_a_parabola(void **state)
{
    (void)state;
    for (size_t i = 1; i < sizeof integrators / sizeof *integrators; i++) {
        struct sedan sedan;
        head_on(&sedan, 1e-3);
        sedan.setup.integrator = integrators[i];
        sedan.setup.duration = 0.060;
        sedan.springs[0].length += 0.01;
        const double values[4] = {200e3, 200e3, 0.0, 0.0};
        double results[RESULTS];
        evaluate(&sedan, values, results);
        const double a = 200e3 / sedan.setup.mass;
        const double t = 0.060;
        assert_true(fabs(results[KINEMATICS_TRAVEL_X] - (-sedan.setup.speed * t + a * t * t / 2)) <
                    1e-12);
        assert_true(fabs(results[KINEMATICS_DELTA_VX] - a * t) < 1e-12);
        assert_true(fabs(results[KINEMATICS_ACCELERATION_MEAN] - a) < 1e-9);
    }
}

// A linear spring k s: s(t) = v / w sin(w t) with w = sqrt(k / m), up to the turning point.
static void linear_spring_gives_a_sine(void **state)
{
    (void)state;
    static const double tolerance[] = {2e-5, 2e-5, 1e-9, 2e-5}; // [m] of the schemes at 0.2 ms
    for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
        struct sedan sedan;
        head_on(&sedan, 0.2e-3);
        sedan.setup.integrator = integrators[i];
        sedan.setup.duration = 0.060;
        const double stiffness = 300e3; // [N/m]
        const double values[4] = {0.0, 1.2 * stiffness, 0.0, 0.0};
        double results[RESULTS];
        evaluate(&sedan, values, results);
        const double w = sqrt(stiffness / sedan.setup.mass);
        const double v = sedan.setup.speed;
        const double s = v / w * sin(w * 0.060);
        assert_true(fabs(results[KINEMATICS_TRAVEL_X] + s) < tolerance[i]);
        assert_true(fabs(results[KINEMATICS_DELTA_VX] - v * (1.0 - cos(w * 0.060))) <
                    1e2 * tolerance[i]);
        assert_true(fabs(results[KINEMATICS_WORK] - stiffness * s * s / 2.0) < 1e6 * tolerance[i]);
    }
}

// The same spring with an unload branch on top of its load branch is elastic: after half a period
// the car leaves with the speed it came with.
static void elastic_spring_gives_the_speed_back(void **state)
{
    (void)state;
    struct sedan sedan;
    head_on(&sedan, 1e-4);
    sedan.setup.integrator = KINEMATICS_RUNGE_KUTTA_4;
    sedan.springs[0].unload = sedan.springs[0].load;
    sedan.setup.duration = 0.4;
    const double stiffness = 400e3;
    const double values[8] = {0.0, 1.2 * stiffness, 0.0, 0.0, 0.0, 1.2 * stiffness, 0.0, 0.0};
    double results[RESULTS];
    evaluate(&sedan, values, results);
    assert_true(fabs(results[KINEMATICS_DELTA_VX] - 2.0 * sedan.setup.speed) < 1e-3);
    assert_true(fabs(results[KINEMATICS_WORK]) < 1.0); // of 264 kJ
}

// A couple turns the car on the spot: springs at +-b with opposite axial forces give the moment
// -p_y F_x each, and no force. Its angle is M t^2 / 2I as long as the lever is that of the start;
// the spring's line keeps its distance from the COG, so that holds for the whole crash.
static void couple_turns_the_car_on_the_spot(void **state)
{
    (void)state;
    struct sedan sedan;
    sedan_init(&sedan, 2, 2);
    const double lever = 0.6;
    for (int i = 0; i < 2; i++) {
        sedan.springs[i].position[0] = -0.83;
        sedan.springs[i].position[1] = i == 0 ? -lever : lever;
        sedan.springs[i].length = 1.35; // in contact at the start
    }
    sedan.setup.edge_y = 5.0;
    sedan.setup.width = 10.0;
    sedan.setup.integrator = KINEMATICS_RUNGE_KUTTA_4;
    sedan.setup.duration = 0.040;
    const double force = 30e3;
    const double values[8] = {force, force, 0.0, 0.0, -force, -force, 0.0, 0.0};
    double results[RESULTS];
    evaluate(&sedan, values, results);
    const double expected = 2.0 * lever * force / sedan.setup.yaw_inertia * 0.040 * 0.040 / 2.0;
    assert_true(fabs(results[KINEMATICS_YAW] - expected) < 1e-12);
    assert_true(fabs(results[KINEMATICS_TRAVEL_Y]) < 1e-12);
    assert_true(fabs(results[KINEMATICS_DELTA_VX]) < 1e-12);
}

// A purely lateral force at the barrier pushes the COG by F t^2 / 2m while the yaw stays small, and
// turns the nose away: clockwise.
static void lateral_force_pushes_aside_and_turns_the_nose_away(void **state)
{
    (void)state;
    struct sedan sedan;
    sedan_init(&sedan, 1, 2);
    sedan.springs[0].length += 0.05;
    sedan.springs[0].position[1] = 0.0;
    sedan.setup.edge_y = 5.0;
    sedan.setup.width = 10.0;
    sedan.setup.integrator = KINEMATICS_RUNGE_KUTTA_4;
    sedan.setup.duration = 0.010;
    const double force = 50e3;
    const double values[4] = {0.0, 0.0, force, force};
    double results[RESULTS];
    evaluate(&sedan, values, results);
    const double pushed = force / sedan.setup.mass * 1e-4 / 2.0;
    // M = e F_y with e = x_P2 in vehicle axes: from -2.08 m on, growing by v t.
    const double turned =
        -force / sedan.setup.yaw_inertia * (2.08 * 1e-4 / 2.0 - sedan.setup.speed * 1e-6 / 6.0);
    assert_true(fabs(results[KINEMATICS_TRAVEL_Y] - pushed) < 1e-5 * pushed);
    assert_true(fabs(results[KINEMATICS_YAW] - turned) < -1e-4 * turned);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(event_verlet_stops_the_car_to_rounding),
        cmocka_unit_test(constant_force_stops_the_car_after_its_stopping_distance),
        cmocka_unit_test(central_difference_of_a_constant_force_is_exact),
        cmocka_unit_test(constant_force_from_the_start_gives_a_parabola),
        cmocka_unit_test(linear_spring_gives_a_sine),
        cmocka_unit_test(elastic_spring_gives_the_speed_back),
        cmocka_unit_test(couple_turns_the_car_on_the_spot),
        cmocka_unit_test(lateral_force_pushes_aside_and_turns_the_nose_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
